//! Points back into the tube (light model, sections 3 and 5).

use std::f64::consts::TAU;

use bendy::{BendyLight, Tube};
use glam::DVec3;
use proptest::prelude::*;

use crate::lights::{bent, point_at, unit_cube};

/// Half the squared distance's derivative along a segment.
fn f(tube: &Tube<f64>, i: usize, u: f64, q: DVec3) -> f64 {
    -tube.segments[i].offset(q, u).dot(tube.segments[i].d(u))
}

/// Every in-tube increasing root by brute force: sign changes of `f` on a fine grid, bisected.
fn roots_by_bisection(tube: &Tube<f64>, q: DVec3) -> Vec<f64> {
    const STEPS: usize = 2000;
    let mut roots = Vec::new();
    for i in 0..tube.n {
        for k in 0..STEPS {
            let (mut low, mut high) = (k as f64 / STEPS as f64, (k + 1) as f64 / STEPS as f64);
            if !(f(tube, i, low, q) < 0.0 && f(tube, i, high, q) >= 0.0) {
                continue;
            }
            for _ in 0..50 {
                let middle = f64::midpoint(low, high);
                if f(tube, i, middle, q) < 0.0 { low = middle } else { high = middle }
            }
            let (segment, u) = (&tube.segments[i], high);
            if segment.offset(q, u).length() <= segment.radius(u) {
                roots.push(i as f64 + u);
            }
        }
    }
    roots
}

proptest! {
    /// A point made from (t, v, w) is found again. `R kappa < 0.9` and `|P'| >= 0.1 L` keep cond below 200
    /// for points of the unit-size tube; 16 eps cond and the rounding of the point itself, eps L, give 1e-12.
    #[test]
    fn round_trip((_, tube) in bent(0.6), t in 0.0..1.0_f64, angle in 0.0..TAU, rho in 0.0..0.99_f64) {
        prop_assume!(tube.r_kappa_max().iter().all(|&k| k < 0.9));
        let t = t * tube.n as f64;
        let (v, w) = (rho * angle.cos(), rho * angle.sin());
        let world = tube.placement.world_from_tube(point_at(&tube, t, v, w));
        let location = tube.locate(world);
        prop_assume!(location.roots.len() == 1);
        let point = location.point.expect("a point of the tube lies in it");
        prop_assert!((point.t - t).abs() < 1e-12, "{} for {t}", point.t);
        prop_assert!((point.v - v).abs() < 1e-11 && (point.w - w).abs() < 1e-11);
        // The planted fault: a sign error in w is seen wherever w is not tiny.
        prop_assert!(w.abs() < 1e-11 || (point.w + w).abs() > 1e-11);
    }

    /// No wrong root and none missed, against bisection, in f64 and f32; points within rounding of the tube's
    /// edge are left out.
    #[test]
    fn same_roots_as_bisection((_, tube) in bent(1.2), q in unit_cube()) {
        let q = (q * DVec3::new(1.0, 1.0, 0.6)) - DVec3::Z * 0.5;
        let expected = roots_by_bisection(&tube, q);
        let near_edge = |t: f64| {
            let i = (t as usize).min(tube.n - 1);
            let (s, u) = (&tube.segments[i], t - i as f64);
            (s.offset(q, u).length() / s.radius(u) - 1.0).abs() < 1e-4
        };
        prop_assume!(!expected.iter().any(|&t| near_edge(t)));
        let world = tube.placement.world_from_tube(q);
        let f32_tube = Tube::<f32>::from(&tube);
        for (roots, bound) in [(tube.locate(world).roots, 1e-9), (f32_tube.locate(world).roots, 2e-3)] {
            prop_assert!(roots.len() == expected.len(), "{roots:?} for {expected:?}");
            for (root, wanted) in roots.iter().zip(&expected) {
                prop_assert!((root - wanted).abs() < bound, "{roots:?} for {expected:?}");
            }
        }
    }

    /// Nothing is ever NaN, however wild the curve: hairpins, coincident points, huge and tiny lights, points
    /// far away.
    #[test]
    fn always_finite(
        knots in prop::collection::vec((unit_cube(), 0.0..0.3_f64), 3..7),
        scale in -8..8_i32, far in -6..6_i32, q in unit_cube(), copy in any::<bool>(),
    ) {
        let scale = 10_f64.powi(scale);
        let start = knots[0].0;
        let mut points: Vec<DVec3> = knots.iter().map(|k| (k.0 - start) * scale).collect();
        if copy {
            points[2] = points[1];
        }
        let Ok(tube) = Tube::new(&BendyLight::new(points, knots.iter().map(|k| k.1 * scale).collect())) else {
            return Ok(());
        };
        let world = q * scale * 10_f64.powi(far);
        for location in [tube.locate(world), Tube::<f32>::from(&tube).locate(world)] {
            prop_assert!(location.roots.iter().all(|t| (0.0..=tube.n as f64).contains(t)));
            if let Some(point) = location.point {
                prop_assert!((point.direction.length() - 1.0).abs() < 1e-5);
                prop_assert!(point.v.is_finite() && point.w.is_finite() && point.radius >= 0.0);
            }
        }
    }
}

/// Points exactly on a joint's plane lie in the lower segment, once.
#[test]
fn joints_count_once() {
    let points = (0..5).map(|i| DVec3::new(0.0, 0.0, -f64::from(i))).collect();
    let tube = Tube::new(&BendyLight::new(points, vec![0.5; 5])).expect("valid");
    let location = tube.locate(DVec3::new(0.1, 0.2, -1.5));
    assert_eq!(location.roots, [1.0]);
    assert_eq!(location.point.map(|p| (p.segment, p.u)), Some((0, 1.0)));
}

/// At a cone's apex the radius is zero: the apex is inside with v = w = 0, its neighbours behind and beside
/// are not.
#[test]
fn apex() {
    let points = (0..3).map(|i| DVec3::new(0.0, 0.0, -f64::from(i))).collect();
    let tube = Tube::new(&BendyLight::new(points, vec![0.0, 0.5, 1.0])).expect("valid");
    let apex = tube.locate(DVec3::ZERO).point.expect("the source lies in its light");
    assert_eq!((apex.t, apex.v, apex.w, apex.direction), (0.0, 0.0, 0.0, DVec3::Z));
    assert_eq!(tube.locate(DVec3::new(1e-9, 0.0, 0.0)).point, None);
    assert_eq!(tube.locate(DVec3::new(0.0, 0.0, 1e-9)).point, None);
}
