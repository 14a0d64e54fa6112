//! Lights of both shapes give a point the same place, and what follows from it is the same function.

use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, DECAY, RANGE};
use light::{Cone, Decay, Light, Place, Profile, Transform, Tube, bend};

fn spot(cone_angle: f64) -> Light {
    let rotation = DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68);
    let transform = Transform { translation: DVec3::new(3.0, -2.0, 5.0), rotation, scale: 2.5 };
    let spot = Light::spot().placed(transform).with(CONE_ANGLE, cone_angle);
    spot.with(RANGE, Some(12.0)).with(DECAY, Decay::InverseSquare)
}

/// Positions of size 10 round by some 1e-15 of that, which is large in radii of a narrow cone.
#[test]
fn a_cone_and_its_tube_give_the_same_place() {
    for cone_angle in [0.01, 1.0, 35.0, 80.0] {
        let spot = spot(cone_angle);
        let cone = Cone::new(&spot).expect("valid");
        let tube = Tube::new(&bend(&spot, 3).expect("valid")).expect("valid");
        let tan_outer = cone_angle.to_radians().tan();
        for (v, w, depth) in [(0.0, 0.0, 1.0), (0.3, -0.5, 4.0), (-0.6, 0.79, 11.9)] {
            let local = DVec3::new(v * tan_outer, w * tan_outer, -1.0) * depth;
            let from_source = spot.transform().rotation.normalize() * local;
            let straight = cone.locate(from_source).expect("inside");
            let world = spot.transform().translation + from_source;
            let root = tube.nearest_root(tube.placement.tube_from_world(world)).expect("inside");
            let bent = tube.place_at(&root);
            let apart = |a: &Place, b: &Place| {
                let across = (a.v - b.v).abs() + (a.w - b.w).abs();
                across * tan_outer + (a.t - b.t).abs() + (a.s - b.s).abs() + a.direction.distance(b.direction)
            };
            let bent_as_share = Place { t: bent.t / 3.0, ..bent };
            assert!(apart(&straight, &bent_as_share) < 1e-13, "{cone_angle}: {straight:?} {bent:?}");
            assert!(((straight.v + v).abs() + (straight.w - w).abs()) * tan_outer < 1e-13, "{straight:?}");
            // The planted fault: t not as a share.
            assert!(apart(&straight, &bent) > 1e-3);
            let (one, other) = (cone.irradiance(&straight), tube.irradiance(&root));
            assert!((one - other).length() <= 1e-10 / tan_outer.min(1.0) * one.length(), "{one} {other}");
        }
    }
}

/// By tangents: with small angles `1 - cos` is half the angle's square, so half way from the inner to the outer square
/// the curve is at one half, in a cone of any size.
#[test]
fn the_profile_of_a_narrow_cone_is_that_of_any() {
    for cone_angle in [1e-100, 1e-9, 1e-6, 1e-3] {
        let profile = Profile::new(cone_angle, 0.2);
        let half_way = f64::midpoint(0.64, 1.0);
        assert!((profile.at(half_way) - 0.5).abs() < 1e-9, "{cone_angle}: {}", profile.at(half_way));
        assert_eq!((profile.at(0.63), profile.at(1.0)), (1.0, 0.0));
        // The planted fault: the cosines themselves, which cancel.
        let (outer, inner) = (cone_angle.to_radians().cos(), (0.8 * cone_angle).to_radians().cos());
        let angle = (half_way.sqrt() * cone_angle.to_radians()).cos();
        let cancelled = (angle - outer) / (inner - outer);
        assert!((cancelled - 0.5).abs() > 1e-9 || cancelled.is_nan(), "{cone_angle}: {cancelled}");
    }
}
