//! Frame of the cross-section (light model, section 2). `bendylights-studies stress` tests that it is orthonormal.

use glam::DVec3;
use light::parameters::FRAME;
use light::{FrameMode, Light, Tube};
use proptest::prelude::*;

use crate::lights::bent;

proptest! {
    /// The frame does not rotate about the tangent: `v_hat' . w_hat = 0`. A central difference over h = 1e-5 leaves h^2
    /// times third derivatives and 1e-16 / h of rounding. A frame that twists (the "up" one) shows 1e-3 and more.
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
        // Deliberate fault that the check must detect: the comparison must notice a frame that follows "up", unless the
        // curve's plane contains it.
        let plane_holds_up = tube.segments[0].curve.n_hat.dot(twisting.up).abs() < 0.1;
        prop_assert!(plane_holds_up || turn(&twisting).abs() > 1e-6 || turn(&twisting) == 0.0);
    }
}

/// `v_hat` agrees on both sides of a joint.
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

/// A light that points along "up" starts from another axis instead of an error.
#[test]
fn up_along_the_light() {
    let points = (0..3).map(|i| DVec3::new(0.0, -f64::from(i), 0.0)).collect();
    let tube = Tube::new(&Light::bendy(points, vec![1.0; 3])).expect("valid");
    let (v_hat, w_hat) = tube.cross_section(&tube.segments[0].curve, DVec3::NEG_Y);
    assert!(v_hat.is_finite() && w_hat.dot(DVec3::NEG_Y).abs() < 1e-15);
}
