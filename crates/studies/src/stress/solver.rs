//! Compares roots with a brute-force search, on the exact numbers that the solver gets.

use glam::DVec3;
use light::{Light, Real, Transform, Tube};
use proptest::prelude::*;
use serde::Serialize;

use super::light::{LightLimits, as_file, lights, placement};
use super::place::{PointSpec, eps, places};
use super::runner::{Check, CheckTally};

/// A light and points in the world.
#[derive(Clone, Debug, Serialize)]
pub struct RootCase {
    #[serde(serialize_with = "as_file")]
    pub light: Light,
    pub points: Vec<[f64; 3]>,
}

impl RootCase {
    /// Makes a case of a placed light, and of points given by their coordinates in it.
    pub fn new(light: Light, transform: Transform, places: &[PointSpec]) -> Self {
        let light = light.with_transform(transform);
        let tube = Tube::new(&light).expect("a placement makes no light invalid");
        let in_world = |place: &PointSpec| tube.placement.world_from_tube(place.in_tube_space(&tube)).to_array();
        Self { points: places.iter().map(in_world).collect(), light }
    }
}

/// Generates lights at any position in the world, and points of every kind.
pub fn cases() -> impl Strategy<Value = RootCase> {
    let lights = lights(LightLimits { segments: 12, fold: 1.0, pinched: true, flipping: true });
    let places = prop::collection::vec(places(), 1..16);
    (lights, placement(), places).prop_map(|(light, transform, places)| RootCase::new(light, transform, &places))
}

/// Checks each point, in f64 and f32.
pub fn check(case: &RootCase, tally: &mut CheckTally) -> Check {
    let tube = Tube::new(&case.light).expect("cases are valid");
    let single = Tube::<f32>::from(&tube);
    for &point in &case.points {
        let q = tube.placement.tube_from_world(point.into());
        roots_are_right(&tube, q, 4.0, tally)?;
        roots_are_right(&single, q.as_vec3(), 300.0, tally)?;
    }
    Ok(())
}

/// Numbers of a segment in f64, converted from the precision of the solver.
struct Curve {
    b0: DVec3,
    d0: DVec3,
    a: DVec3,
    radius: [f64; 3],
    /// `|d0| + |d1|`.
    length: f64,
}

impl Curve {
    fn new<F: Real>(s: &light::Curve<F>) -> Self {
        let [b0, d0, d1, a] = [s.b0, s.d0, s.d1, s.a].map(F::vec_f64);
        Self { b0, d0, a, radius: [s.r0, s.e0, s.ar].map(F::f64), length: d0.length() + d1.length() }
    }

    fn d(&self, u: f64) -> DVec3 {
        self.d0 + self.a * u
    }

    fn offset(&self, q: DVec3, u: f64) -> DVec3 {
        (q - self.b0) - (self.d0 * 2.0 + self.a * u) * u
    }

    /// Returns half the derivative of the squared distance. It rises through zero at a nearest point.
    fn f(&self, q: DVec3, u: f64) -> f64 {
        -self.offset(q, u).dot(self.d(u))
    }

    fn radius(&self, u: f64) -> f64 {
        self.radius[0] + u * (2.0 * self.radius[1] + u * self.radius[2])
    }

    /// Returns the rounding error of `f = 0` over eps: the light model's backward error, and the rounding of the point
    /// and the joints at their own size.
    fn noise(&self, q: DVec3, u: f64) -> f64 {
        let (r, d) = (self.offset(q, u).length(), self.d(u).length());
        (r + (q - self.b0).length() + self.b0.length() + self.length) * d + r * self.length
    }
}

/// Number of steps of the brute-force search along a segment.
const STEPS: usize = 512;

fn roots_are_right<F: Real>(tube: &Tube<F>, q: F::Vec3, k: f64, tally: &mut CheckTally) -> Check {
    let tolerance = k * eps::<F>();
    let mut roots = Vec::new();
    let mut odd = None;
    tube.for_each_root(q, |root| {
        let place = tube.tube_point(&root);
        let unit = (place.direction.length() - 1.0).abs() < 1e-5;
        odd = odd.or((!(unit && place.v.is_finite() && place.w.is_finite())).then_some(place));
        roots.push((root.segment, root.u.f64()));
    });
    tally.holds(odd.is_none(), || format!("a place is not made of numbers: {odd:?}"))?;
    if tally.is_planted
        && let Some(root) = roots.first_mut()
    {
        root.1 = if root.1 < 0.5 { root.1 + 1e-3 } else { root.1 - 1e-3 };
    }
    let q = F::vec_f64(q);
    let width = 8 * size_of::<F>();
    for &(i, u) in &roots {
        let curve = Curve::new(&tube.segments[i].curve);
        tally.holds((0.0..=1.0).contains(&u) || i == tube.n && u > 0.0, || format!("u = {u} is no parameter"))?;
        let bound = tolerance * curve.noise(q, u);
        tally.within(format_args!("f at the f{width} root u = {u:?} of segment {i}"), curve.f(q, u).abs(), bound)?;
        let falls = [1e-2, 1e-4].iter().any(|&step| {
            let (before, after) = (u - step, u + step);
            i < tube.n
                && before >= 0.0
                && after <= 1.0
                && curve.f(q, before) > 2.0 * bound
                && curve.f(q, after) < -2.0 * bound
        });
        tally.holds(!falls, || {
            format!("the f{width} root u = {u:?} of segment {i} is a farthest point, not a nearest")
        })?;
    }
    for (i, segment) in tube.segments[..tube.n].iter().enumerate() {
        let curve = Curve::new(&segment.curve);
        for (low, high) in crossings(&curve, q, tolerance) {
            let slack = F::JOINT_MERGE.f64();
            let found = roots.iter().any(|&(j, u)| {
                let t = (j as f64 - i as f64) + u;
                low - slack <= t && t <= high + slack
            });
            tally
                .holds(found, || format!("the f{width} solver misses the root of segment {i} in {low:?}..{high:?}"))?;
        }
    }
    Ok(())
}

/// Returns the parameter ranges in which `f` rises from clearly below zero to clearly above, well inside the tube.
fn crossings(curve: &Curve, q: DVec3, tolerance: f64) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    let mut below = None;
    for step in 0..=STEPS {
        let u = step as f64 / STEPS as f64;
        let (f, noise) = (curve.f(q, u), tolerance * curve.noise(q, u));
        if f < -noise {
            below = Some(u);
        } else if f > noise
            && let Some(low) = below.take()
            && inside(curve, q, low, u, tolerance)
        {
            out.push((low, u));
        }
    }
    out
}

/// True if the root in the range is inside the tube by more than rounding.
fn inside(curve: &Curve, q: DVec3, mut low: f64, mut high: f64, tolerance: f64) -> bool {
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if curve.f(q, middle) < 0.0 { low = middle } else { high = middle }
    }
    let radius = curve.radius(high);
    let margin = 1e-3 * radius + tolerance * (q.length() + curve.b0.length() + curve.length);
    curve.offset(q, high).length() < radius - margin
}
