//! Slabs in which shadow maps are drawn.

use std::f64::consts::TAU;

use glam::DVec3;
use light::{EndMode, Light, Tube, bend, slabs};
use proptest::prelude::*;

use crate::lights::{bent, point_at};

proptest! {
    /// Every point of the tube lies in the slab of its t: between the end planes and in the box. Slack 1e-12 for points
    /// on the edge.
    #[test]
    fn slabs_cover_the_tube((_, tube) in bent(0.9), share in 0.0..1.0_f64, angle in 0.0..TAU) {
        prop_assume!(tube.r_kappa_max().iter().all(|&k| k < 0.97));
        let t = share * tube.n as f64;
        let q = point_at(&tube, t, angle.cos(), angle.sin());
        let all = slabs(&tube, tube.n as f64, 0.0);
        let slab = all.iter().rev().find(|s| s.t_start <= t).expect("slabs start at 0");
        let c = &slab.slab_curve;
        prop_assert!((q - c.b0).dot(c.d0) > -1e-12 && (c.b2 - q).dot(c.d1) > -1e-12);
        let p = q - c.bounds.center;
        prop_assert!((0..3).all(|k| p.dot(c.bounds.axes[k]).abs() < c.bounds.half[k] + 1e-12));
        prop_assert!((slab.t_start + slab.t_span - t) > -1e-12);
    }
}

/// A straight light has one slab for each segment. An extended one reaches as far as requested.
#[test]
fn straight_and_extended() {
    let tube = Tube::new(&bend(&Light::spot(), 2).expect("valid")).expect("valid");
    assert_eq!(tube.end_mode(), EndMode::Extend);
    let all = slabs(&tube, 50.0, 0.01);
    assert_eq!(all.len(), 3);
    assert!((all[2].t_start + all[2].t_span - 50.0).abs() < 0.5);
}

/// Slabs overlap, but not past a cusp, where the curve turns back: such a slab would contain all that lies beyond it.
#[test]
fn no_overlap_past_coincident_points() {
    let points = [0.0, -1.0, -1.0, -2.0].map(|z| DVec3::new(0.0, 0.0, z)).to_vec();
    let tube = Tube::new(&Light::bendy(points, vec![0.1; 4])).expect("valid");
    for slab in slabs(&tube, 2.0, 1e-3) {
        let c = &slab.slab_curve;
        assert!(c.d0.z <= 0.0 && c.d1.z <= 0.0, "from t = {} on it runs back", slab.t_start);
    }
}
