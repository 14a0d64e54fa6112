//! Lights of all shapes give a point the same light coordinates, and the same profile follows from them.

use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, DECAY, HEIGHT, RANGE, ROTATION, TRANSLATION, WIDTH};
use light::{Cone, Decay, Light, LightCoords, Omni, Parallel, Transform};

use crate::support::{bent_tube, profile, root_at};

fn spot(cone_angle: f64) -> Light {
    let rotation = DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68);
    let transform = Transform { translation: DVec3::new(3.0, -2.0, 5.0), rotation, scale: 2.5 };
    let spot = Light::spot().with_transform(transform).with(CONE_ANGLE, cone_angle);
    spot.with(RANGE, Some(12.0)).with(DECAY, Decay::InverseSquare)
}

/// Positions of size 10 round by some 1e-15 of that, which is large in radii of a narrow cone.
#[test]
fn a_cone_and_its_tube_give_the_same_light_coordinates() {
    for cone_angle in [0.01, 1.0, 35.0, 80.0] {
        let spot = spot(cone_angle);
        let cone = Cone::new(&spot).expect("valid");
        let tube = bent_tube(&spot, 3);
        let tan_outer = cone_angle.to_radians().tan();
        for (v, w, depth) in [(0.0, 0.0, 1.0), (0.3, -0.5, 4.0), (-0.6, 0.79, 11.9)] {
            let local = DVec3::new(v * tan_outer, w * tan_outer, -1.0) * depth;
            let from_source = spot.transform().rotation.normalize() * local;
            let straight = cone.locate(from_source).expect("inside");
            let world = spot.transform().translation + from_source;
            let root = root_at(&tube, world).expect("inside");
            let bent = tube.coords_at(&root);
            let apart = |a: &LightCoords, b: &LightCoords| {
                let across = (a.v - b.v).abs() + (a.w - b.w).abs();
                across * tan_outer + (a.t - b.t).abs() + (a.s - b.s).abs() + a.direction.distance(b.direction)
            };
            let bent_as_share = LightCoords { t: bent.t / 3.0, ..bent };
            assert!(apart(&straight, &bent_as_share) < 1e-13, "{cone_angle}: {straight:?} {bent:?}");
            assert!(((straight.v + v).abs() + (straight.w - w).abs()) * tan_outer < 1e-13, "{straight:?}");
            // Deliberate fault that the check must detect: t that is not a share.
            assert!(apart(&straight, &bent) > 1e-3);
            let (one, other) = (cone.irradiance(&straight), tube.irradiance(&root));
            assert!((one - other).length() <= 1e-10 / tan_outer.min(1.0) * one.length(), "{one} {other}");
        }
    }
}

/// Each face of the cube about an omni light is the square in a spotlight of 45 degrees with the same direction.
#[test]
fn faces_of_an_omni_light_are_spotlights_of_45_degrees() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let placed = spot(45.0);
    let omni = Omni::new(&Light::omni().with_transform(placed.transform()).with(RANGE, Some(8.0))).expect("valid");
    let looks = [
        DQuat::IDENTITY,
        DQuat::from_rotation_y(FRAC_PI_2),
        DQuat::from_rotation_y(PI),
        DQuat::from_rotation_y(-FRAC_PI_2),
        DQuat::from_rotation_x(FRAC_PI_2),
        DQuat::from_rotation_x(-FRAC_PI_2),
    ];
    for look in looks {
        let turned = placed.transform().rotation.normalize() * look;
        let cone = Cone::new(&placed.clone().with(ROTATION, turned).with(RANGE, None)).expect("valid");
        for (v, w, depth) in [(0.0, 0.0, 1.0), (0.3, -0.5, 4.0), (-0.6, 0.79, 5.0)] {
            let from_source = turned * (DVec3::new(v, w, -1.0) * depth);
            let (one, other) = (omni.locate(from_source).expect("inside"), cone.locate(from_source).expect("inside"));
            let apart = (one.v - other.v).abs() + (one.w - other.w).abs() + (one.s - other.s).abs();
            assert!(apart < 1e-14 && one.direction.distance(other.direction) < 1e-15, "{one:?} {other:?}");
            assert_eq!(one.t, from_source.length() / 8.0);
        }
    }
    assert!(omni.locate(DVec3::X * 8.0).is_some() && omni.locate(DVec3::X * 8.1).is_none(), "a sphere");
    assert!(omni.locate(DVec3::ZERO).is_none());
}

/// A directional light has the light coordinates of a spotlight far away, except for the distance.
#[test]
fn a_directional_light_is_a_spotlight_far_away() {
    let distance = 1e9;
    let rotation = DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68).normalize();
    let middle = DVec3::new(3.0, -2.0, 5.0);
    let sun = Light::directional().with(ROTATION, rotation).with(TRANSLATION, middle);
    let window = Parallel::new(&sun.clone().with(WIDTH, Some(4.0)).with(HEIGHT, Some(4.0))).expect("valid");
    let far = Light::spot()
        .with(ROTATION, rotation)
        .with(TRANSLATION, middle - rotation * DVec3::NEG_Z * distance)
        .with(CONE_ANGLE, (2.0 / distance).atan().to_degrees());
    let cone = Cone::new(&far).expect("valid");
    for (x, y, along) in [(0.0, 0.0, 0.0), (0.7, -1.1, 3.0), (-1.2, 1.5, -40.0)] {
        let position = middle + rotation * DVec3::new(x, y, along);
        let one = window.locate(position).expect("inside");
        let other = cone.locate(position - cone.translation).expect("inside");
        // Rays of the spotlight meet at an angle of 2 / distance. Positions of its size round by 1e-7 of a radius.
        let apart = (one.v - other.v).abs() + (one.w - other.w).abs() + one.direction.distance(other.direction);
        assert!(apart < 1e-6, "{one:?} {other:?}");
        assert_eq!((one.t, one.s), (0.0, 0.0));
    }
    for (x, y, inside) in [(1.99, 1.99, true), (2.01, 0.0, false), (0.0, -2.01, false)] {
        assert_eq!(window.locate(middle + rotation * DVec3::new(x, y, 7.0)).is_some(), inside);
    }
    // An unbounded side contains everything, wherever the light is.
    let endless = Parallel::new(&sun.with(TRANSLATION, DVec3::splat(1e300))).expect("valid");
    let coords = endless.locate(DVec3::new(1e9, -4.0, 1e5)).expect("everywhere");
    assert_eq!((coords.v, coords.w), (0.0, 0.0));
}

/// The test is by tangents: with small angles `1 - cos` is half the angle's square. So half-way from the inner to the
/// outer square the curve is at one half, in a cone of any size.
#[test]
fn the_profile_does_not_depend_on_the_cone_angle() {
    for cone_angle in [1e-100, 1e-9, 1e-6, 1e-3] {
        let narrow = profile(cone_angle, 0.2);
        let half_way = f64::midpoint(0.64, 1.0);
        assert!((narrow.at(half_way) - 0.5).abs() < 1e-9, "{cone_angle}: {}", narrow.at(half_way));
        assert_eq!((narrow.at(0.63), narrow.at(1.0)), (1.0, 0.0));
        // Deliberate fault that the check must detect: the cosines themselves, which cancel.
        let (outer, inner) = (cone_angle.to_radians().cos(), (0.8 * cone_angle).to_radians().cos());
        let angle = (half_way.sqrt() * cone_angle.to_radians()).cos();
        let cancelled = (angle - outer) / (inner - outer);
        assert!((cancelled - 0.5).abs() > 1e-9 || cancelled.is_nan(), "{cone_angle}: {cancelled}");
    }
}
