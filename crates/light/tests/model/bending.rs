//! A spotlight made into a BendyLight stays the same light (light model, sections 1 and 6).

use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, DECAY, INTENSITY, RANGE, ROTATION};
use light::{Decay, Light, LightError, Transform, Tube, bend, bend_to, straighten};

use crate::support::profile;

/// t is the share of the range, the radius that of the cone, the irradiance the spotlight's, for any number
/// of segments.
#[test]
fn equal_to_its_spotlight() {
    let transform = Transform {
        translation: DVec3::new(3.0, -2.0, 5.0),
        rotation: DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68),
        scale: 2.5,
    };
    let spot =
        Light::spot().placed(transform).with(INTENSITY, 60.0).with(CONE_ANGLE, 35.0).with(RANGE, Some(12.0));
    let slope = 35_f64.to_radians().tan();
    for segments in [1, 2, 3, 7] {
        let light = bend(&spot, segments).expect("valid");
        let tube = Tube::new(&light).expect("valid");
        for local in [DVec3::new(0.1, 0.3, -1.0), DVec3::new(-1.0, 0.5, -4.0), DVec3::new(0.0, -0.01, -4.7)] {
            let world = transform.world_from_local(local);
            let depth = -local.z * transform.scale;
            let point = tube.locate(world).point.expect("inside");
            assert!((point.t / segments as f64 - depth / 12.0).abs() < 1e-14);
            assert!((point.radius - depth * slope).abs() < 1e-13);
            let root = tube.nearest_root(tube.placement.tube_from_world(world)).expect("inside");
            let rho = local.truncate().length() / (-local.z * slope);
            let expected =
                60.0 * tube.light_filter.profile.at(rho * rho) / (local.length() * transform.scale).powi(2);
            assert!((tube.irradiance(&root).x / expected - 1.0).abs() < 1e-13);
        }
        let beyond = transform.world_from_local(DVec3::new(0.0, 0.0, -4.81));
        assert_eq!(tube.locate(beyond).point, None, "it ends at its range");
    }
}

/// Without a range it goes on for ever, still the same cone.
#[test]
fn endless_without_range() {
    let spot = Light::spot().with(CONE_ANGLE, 20.0).with(DECAY, Decay::InverseSquare);
    let tube = Tube::new(&bend(&spot, 3).expect("valid")).expect("valid");
    for depth in [0.5, 1.0, 7.0, 1e6] {
        let q = DVec3::new(0.1, 0.2, -1.0) * depth;
        let point = tube.locate(q).point.expect("inside");
        assert!((point.t / (3.0 * depth) - 1.0).abs() < 1e-14);
        assert!((point.radius / (depth * 20_f64.to_radians().tan()) - 1.0).abs() < 1e-14);
        assert!((point.direction - (-q).normalize()).length() < 1e-15);
        let root = tube.nearest_root(tube.placement.tube_from_world(q)).expect("inside");
        let rho = (0.1_f64 * 0.1 + 0.2 * 0.2).sqrt() / 20_f64.to_radians().tan();
        let expected = tube.light_filter.profile.at(rho * rho) / q.length_squared();
        assert!((tube.irradiance(&root).x / expected - 1.0).abs() < 1e-13);
    }
}

/// The profile is 1 up to the inner angle, 0 at the edge, a step without softness, and never rises outwards.
#[test]
fn profile_falls_from_one_to_zero() {
    let soft = profile(25.0, 0.2);
    let inner = 20_f64.to_radians().tan() / 25_f64.to_radians().tan();
    assert_eq!((soft.at(0.0), soft.at((inner - 1e-9).powi(2))), (1.0, 1.0));
    assert!(soft.at(1.0).abs() < 1e-15 && soft.at(0.81) > 0.0);
    assert!((0..100).all(|k| soft.at(f64::from(k) / 100.0) >= soft.at(f64::from(k + 1) / 100.0)));
    assert_eq!(profile(25.0, 0.0).at(0.999), 1.0);
}

/// Straightened, a bent spotlight is that spotlight to the last bit; one whose control points have moved shines from its
/// source to its last control point, as wide there as its tube.
#[test]
fn straightening_takes_bending_back() {
    let rotation = DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68).normalize();
    let transform = Transform { translation: DVec3::new(3.0, -2.0, 5.0), rotation, scale: 2.5 };
    for (range, segments) in [(None, 1), (Some(12.0), 3), (None, 5)] {
        let spot =
            Light::spot().placed(transform).with(CONE_ANGLE, 10.0).with(RANGE, range).with(INTENSITY, 60.0);
        let bent = bend_to(&spot, segments, 10.0).expect("valid");
        assert_eq!(straighten(&bent).expect("valid"), spot);
        let last = bent.points()[segments + 1];
        let offset = DVec3::new(0.3, 0.6, 0.0);
        let moved = bent.clone().with_points(|_, point| {
            point.position += offset * (point.position.z / last.position.z).powi(2);
            point.intensity = 0.5;
        });
        let end = last.position + offset;
        let straight = straighten(&moved).expect("valid");
        let aim = straight.get(ROTATION) * DVec3::NEG_Z;
        assert!((aim - rotation * end.normalize()).length() < 1e-14);
        let slope = straight.get(CONE_ANGLE).to_radians().tan();
        assert!((slope * end.length() - last.radius).abs() < 1e-12 && straight.get(INTENSITY) == 30.0);
        let expected = range.map(|_| end.length() * transform.scale);
        assert_eq!(straight.get(RANGE), expected);
        // `up` stays up: across the axis, the light's own +Y has no part to its side.
        let up = straight.get(ROTATION) * DVec3::Y;
        assert!((up.dot(rotation * DVec3::Y) > 0.9) && (up.dot(aim).abs() < 1e-14));
        // The planted fault: the light as it was aimed.
        assert!((aim - rotation * DVec3::NEG_Z).length() > 0.1);
    }
    assert_eq!(straighten(&Light::spot()), Err(LightError::NotBent));
}
