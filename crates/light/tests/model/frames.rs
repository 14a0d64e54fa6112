//! The cross-section's frame (light model, section 2). That it is orthonormal is held by `bendylights-studies stress`.

use glam::DVec3;
use light::parameters::FRAME;
use light::{FrameMode, Light, Tube};
use proptest::prelude::*;

use crate::lights::bent;

proptest! {
    /// No rotation about the tangent: `v_hat' . w_hat = 0`. A central difference over h = 1e-5 leaves h^2
    /// times third derivatives and 1e-16 / h of rounding; a frame that twists (the "up" one) shows 1e-3 and
    /// more.
    #[test]
    fn rotation_minimizing((light, tube) in bent(1.0), at in 0.01..0.99_f64) {
        let h = 1e-5;
        let turn = |tube: &Tube<f64>| {
            let segment = &tube.segments[0].curve;
            let v_hat = |u: f64| tube.cross_section(segment, segment.u_hat(u));
            ((v_hat(at + h).0 - v_hat(at - h).0) / (2.0 * h)).dot(v_hat(at).1)
        };
        prop_assert!(turn(&tube).abs() < 1e-6);
        let twisting = Tube::new(&light.with(FRAME, FrameMode::Up)).expect("the same shape is valid");
        prop_assume!(tube.r_kappa_max()[0] > 0.05);
        // The planted fault: the comparison would see a frame that follows "up", unless the curve's plane
        // holds it.
        let plane_holds_up = tube.segments[0].curve.n_hat.dot(twisting.up).abs() < 0.1;
        prop_assert!(plane_holds_up || turn(&twisting).abs() > 1e-6 || turn(&twisting) == 0.0);
    }
}

/// The frame goes on over joints: `v_hat` from both sides agrees.
#[test]
fn carried_over_joints() {
    let points = [(0., 0., 0.), (0., 0., -1.), (1., 0., -2.), (1., 1., -3.), (0., 1., -4.)];
    let points = points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
    let tube = Tube::new(&Light::bendy(points, vec![0.2; 5])).expect("valid");
    for pair in tube.segments.windows(2) {
        let [one, next] = [&pair[0].curve, &pair[1].curve];
        let before = tube.cross_section(one, one.u_hat(1.0)).0;
        let after = tube.cross_section(next, next.u_hat(0.0)).0;
        assert!((before - after).length() < 16.0 * f64::EPSILON);
        assert_eq!((one.b2, one.d1), (next.b0, next.d0), "joints are bit-equal");
    }
}

/// A light whose source looks along "up" starts from another axis instead of failing.
#[test]
fn up_along_the_light() {
    let points = (0..3).map(|i| DVec3::new(0.0, -f64::from(i), 0.0)).collect();
    let tube = Tube::new(&Light::bendy(points, vec![1.0; 3])).expect("valid");
    let (v_hat, w_hat) = tube.cross_section(&tube.segments[0].curve, DVec3::NEG_Y);
    assert!(v_hat.is_finite() && w_hat.dot(DVec3::NEG_Y).abs() < 1e-15);
}
