//! Lights to test with.

use glam::DVec3;
use light::{Light, Tube};
use proptest::prelude::*;

/// Generates a vector with each component in `[-1, 1]`.
pub fn unit_cube() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// Generates a valid light of 1 to 6 segments that wanders along -Z, bends by `bend` and tapers freely.
pub fn bent(bend: f64) -> impl Strategy<Value = (Light, Tube<f64>)> {
    prop::collection::vec((unit_cube(), 0.05..0.5_f64), 3..=8).prop_filter_map("folds", move |knots| {
        let start = knots[0].0 * bend;
        let points: Vec<DVec3> =
            knots.iter().enumerate().map(|(i, (offset, _))| *offset * bend - start - DVec3::Z * i as f64).collect();
        let light = Light::bendy(points, knots.iter().map(|k| k.1).collect());
        Tube::new(&light).ok().map(|tube| (light, tube))
    })
}

/// Returns the tube-space point at `(t, v, w)`: `P + R (v v_hat + w w_hat)`.
pub fn point_at(tube: &Tube<f64>, t: f64, v: f64, w: f64) -> DVec3 {
    let i = (t.floor() as usize).min(tube.n - 1);
    let (segment, u) = (&tube.segments[i].curve, t - i as f64);
    let (v_hat, w_hat) = tube.cross_section(segment, segment.u_hat(u));
    segment.position(u) + (v_hat * v + w_hat * w) * segment.radius(u)
}
