//! Direction of arriving light (light model, section 3). `bendylights-studies stress` tests that "tube" does not jump
//! at joints.

use std::f64::consts::TAU;

use glam::DVec3;
use light::parameters::{CONE_ANGLE, DIRECTION, FRAME, RANGE};
use light::{DirectionMode, FrameMode, Light, Tube, bend};
use proptest::prelude::*;

use crate::lights::{bent, point_at};

proptest! {
    /// "path" is the tangent of the curve of constant (v, w), in both frames. The central difference over h = 1e-6 has
    /// an error of about h^2 times third derivatives, amplified where the curve of constant (v, w) is slow: 1e-6 of an
    /// angle if its speed is over a tenth.
    #[test]
    fn path_is_the_tangent((light, _) in bent(0.7), at in 0.02..0.98_f64, angle in 0.0..TAU, up in any::<bool>()) {
        let frame = if up { FrameMode::Up } else { FrameMode::RotationMinimizing };
        let light = light.with(DIRECTION, DirectionMode::Path).with(FRAME, frame);
        let tube = Tube::new(&light).expect("the same shape is valid");
        let (v, w, h) = (0.8 * angle.cos(), 0.8 * angle.sin(), 1e-6);
        let steep = tube.segments[0].curve.u_hat(at).dot(tube.up).abs() > 0.98;
        let along = (point_at(&tube, at + h, v, w) - point_at(&tube, at - h, v, w)) / (2.0 * h);
        prop_assume!(along.length() > 0.1 && !(up && steep));
        let q = point_at(&tube, at, v, w);
        let root = tube.nearest_root(q).expect("inside");
        prop_assume!((root.u - at).abs() < 1e-9 && root.segment == 0);
        let direction = tube.direction_at(&root);
        prop_assert!((direction + along.normalize()).length() < 1e-6);
    }
}

/// On a cone both directions point at the apex. 50-digit results do not differ from it.
#[test]
fn cone_points_at_its_apex() {
    let spot = Light::spot().with(CONE_ANGLE, 40.0).with(RANGE, Some(3.0));
    for direction in [DirectionMode::Tube, DirectionMode::Path] {
        let light = bend(&spot, 3).expect("valid").with(DIRECTION, direction);
        let tube = Tube::new(&light).expect("valid");
        for q in [DVec3::new(0.3, -0.2, -1.0), DVec3::new(1.0, 1.0, -2.9), DVec3::new(0.0, 0.0, -0.01)] {
            let point = tube.locate(q).point.expect("inside");
            assert!((point.direction - (-q).normalize()).length() < 8.0 * f64::EPSILON);
        }
    }
}
