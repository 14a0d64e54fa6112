//! Path length: the quadrature against the closed form.

use glam::DVec3;
use light::parameters::{CONE_SOFTNESS, DECAY};
use light::{Decay, Light, Tube};

/// Returns the arc length of the parabola `(2 d x, x^2)`-like segment by its closed form, valid if the segment is well
/// bent.
fn closed_form(d0: DVec3, a: DVec3, u: f64) -> f64 {
    let (aa, da) = (a.dot(a), d0.dot(a));
    // |d|^2 = aa (x^2 + c), x = u + da / aa, c = |d0 x a|^2 / aa^2.
    let c = d0.cross(a).length_squared() / (aa * aa);
    let part = |x: f64| x * (x * x + c).sqrt() + c * (x / c.sqrt()).asinh();
    aa.sqrt() * (part(u + da / aa) - part(da / aa))
}

/// Returns the path length that follows from an inverse-square irradiance on the centre curve.
fn distance(tube: &Tube<f64>, u: f64) -> f64 {
    let root = tube.nearest_root(tube.segments[0].curve.position(u)).expect("on the curve");
    (1.0 / tube.irradiance(&root).x).sqrt() / tube.placement.world_per_tube
}

/// Relative error over all hairpins. The legs are `width` apart, so each turns by `atan(2 / width)`. The error is 5e-10
/// up to 60 degrees, 5e-8 up to 75, and nowhere above 5.7e-5, the maximum of the eight-point rule's error over
/// `sqrt(x^2 + c^2)` on `[0, 1]`.
#[test]
fn quadrature_meets_the_closed_form() {
    for step in 0..100 {
        let width = 10_f64.powf(f64::from(step) / 20.0 - 4.0);
        let turn = (2.0 / width).atan().to_degrees();
        let bound = if turn <= 60.0 {
            5e-10
        } else if turn <= 75.0 {
            5e-8
        } else {
            5.7e-5
        };
        let points = vec![DVec3::ZERO, DVec3::new(width / 2.0, 0.0, -1.0), DVec3::new(width, 0.0, 0.0)];
        let mut light = Light::bendy(points, vec![1e-10; 3]);
        light.set(DECAY.to(Decay::InverseSquare));
        light.set(CONE_SOFTNESS.to(0.0));
        let tube = Tube::new(&light).expect("thin enough not to fold");
        let (d0, a) = (tube.segments[0].curve.d0, tube.segments[0].curve.a);
        for u in [0.3, 0.5, 0.7, 1.0] {
            let error = (distance(&tube, u) / closed_form(d0, a, u) - 1.0).abs();
            assert!(error < bound, "width {width}, u {u}: {error:e}");
        }
    }
}
