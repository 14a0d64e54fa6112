//! A spotlight made into a BendyLight stays the same light (light model, sections 1 and 6).

use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, CONE_ANGLE, CUT_OFF, CUT_ON, DECAY, DECAY_START, END_MODE, FAR_EDGE, HEIGHT, INTENSITY, NEAR_EDGE, RANGE,
    ROTATION, TRANSLATION, UP, WIDTH,
};
use light::{
    CheckedLight, Cone, Decay, EndMode, Light, LightError, Omni, Transform, Tube, as_spotlight, bend, bend_with_length,
    straighten,
};

use crate::support::{bent_tube, irradiance_at, long_tube, profile, root_at, tube_of};

/// Returns a placement whose rotation is normalized.
fn transform() -> Transform {
    let rotation = DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68).normalize();
    Transform { translation: DVec3::new(3.0, -2.0, 5.0), rotation, scale: 2.5 }
}

/// For any number of segments, t is the share of the range, the radius is that of the cone, and the irradiance is the
/// spotlight's.
#[test]
fn a_bent_light_equals_its_spotlight() {
    let transform = Transform {
        translation: DVec3::new(3.0, -2.0, 5.0),
        rotation: DQuat::from_xyzw(0.1, 0.7, -0.2, 0.68),
        scale: 2.5,
    };
    let spot =
        Light::spot().with_transform(transform).with(INTENSITY, 60.0).with(CONE_ANGLE, 35.0).with(RANGE, Some(12.0));
    let slope = 35_f64.to_radians().tan();
    for segments in [1, 2, 3, 7] {
        let tube = bent_tube(&spot, segments);
        for local in [DVec3::new(0.1, 0.3, -1.0), DVec3::new(-1.0, 0.5, -4.0), DVec3::new(0.0, -0.01, -4.7)] {
            let world = transform.world_from_local(local);
            let depth = -local.z * transform.scale;
            let point = tube.locate(world).point.expect("inside");
            assert!((point.t / segments as f64 - depth / 12.0).abs() < 1e-14);
            assert!((point.radius - depth * slope).abs() < 1e-13);
            let rho = local.truncate().length() / (-local.z * slope);
            let expected = 60.0 * tube.light_profile.profile.at(rho * rho) / (local.length() * transform.scale).powi(2);
            assert!((irradiance_at(&tube, world).x / expected - 1.0).abs() < 1e-13);
        }
        let beyond = transform.world_from_local(DVec3::new(0.0, 0.0, -4.81));
        assert_eq!(tube.locate(beyond).point, None, "it ends at its range");
    }
}

/// Without a range the light has no end and stays the same cone.
#[test]
fn a_light_without_range_has_no_end() {
    let spot = Light::spot().with(CONE_ANGLE, 20.0).with(DECAY, Decay::InverseSquare);
    let tube = bent_tube(&spot, 3);
    for depth in [0.5, 1.0, 7.0, 1e6] {
        let q = DVec3::new(0.1, 0.2, -1.0) * depth;
        let point = tube.locate(q).point.expect("inside");
        assert!((point.t / (3.0 * depth) - 1.0).abs() < 1e-14);
        assert!((point.radius / (depth * 20_f64.to_radians().tan()) - 1.0).abs() < 1e-14);
        assert!((point.direction - (-q).normalize()).length() < 1e-15);
        let rho = (0.1_f64 * 0.1 + 0.2 * 0.2).sqrt() / 20_f64.to_radians().tan();
        let expected = tube.light_profile.profile.at(rho * rho) / q.length_squared();
        assert!((irradiance_at(&tube, q).x / expected - 1.0).abs() < 1e-13);
    }
}

/// The profile is 1 up to the inner angle, 0 at the edge, a step without softness, and never rises outwards.
#[test]
fn profile_falls_from_one_to_zero() {
    let soft = profile(25.0, 0.2);
    let inner = 20_f64.to_radians().tan() / 25_f64.to_radians().tan();
    assert_eq!((soft.at(0.0), soft.at((inner - 1e-9).powi(2))), (1.0, 1.0));
    assert!(soft.at(1.0_f64).abs() < 1e-15 && soft.at(0.81) > 0.0);
    assert!((0..100).all(|k| soft.at(f64::from(k) / 100.0) >= soft.at(f64::from(k + 1) / 100.0)));
    assert_eq!(profile(25.0, 0.0).at(0.999), 1.0);
}

/// Within its new cone a light without a cone keeps its brightness up to the edge, and a directional light keeps its
/// window at the target.
#[test]
fn light_within_a_new_cone_keeps_its_brightness() {
    let sun = Light::directional().with(INTENSITY, 3.0).with(WIDTH, Some(1.0)).with(HEIGHT, Some(0.5));
    let toward = DVec3::new(0.0, 0.0, -2.0);
    let tube = long_tube(&as_spotlight(&sun, 10.0, Some(toward), 20.0).expect("valid"), 20.0);
    let lit = |x: f64, y: f64| irradiance_at(&tube, DVec3::new(x, y, toward.z)).x;
    for (x, y) in [(0.0, 0.0), (0.49, 0.24), (-0.49, 0.24), (0.49, -0.24)] {
        assert!((lit(x, y) - 3.0).abs() < 1e-12, "{x} {y}: {}", lit(x, y));
    }
    for (x, y) in [(0.51, 0.0), (0.0, 0.26), (-0.6, 0.6)] {
        assert_eq!(lit(x, y), 0.0, "{x} {y}");
    }
    // Deliberate fault that the check must detect: a turned window.
    assert_eq!(lit(0.24, 0.49), 0.0);

    let bulb = Light::omni().with(INTENSITY, 9.0).with(DECAY, Decay::None);
    for toward in [DVec3::X * 4.0, DVec3::X * 1e300] {
        let tube = long_tube(&as_spotlight(&bulb, 45.0, Some(toward), 4.0).expect("valid"), 4.0);
        let lit = |angle: f64| {
            let direction = DVec3::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0);
            irradiance_at(&tube, direction * 3.0).x
        };
        assert!([0.0, 20.0, 44.9].into_iter().all(|angle| (lit(angle) - 9.0).abs() < 1e-12));
        assert_eq!(lit(45.1), 0.0);
    }
}

/// Within its cone a bent omni light has the same irradiance as before, whatever its range, cuts and decay. Its ends
/// are spheres, not planes.
#[test]
fn a_bent_omni_light_ends_where_it_ended() {
    let (source, toward) = (DVec3::new(0.3, -0.7, 2.0), DVec3::new(1.0, 0.4, -1.0));
    let plain = Light::omni().with(TRANSLATION, source).with(INTENSITY, 7.0).with(DECAY, Decay::None);
    let lights = [
        plain.clone().with(RANGE, Some(3.0)),
        plain.clone().with(RANGE, Some(3.0)).with(DECAY, Decay::InverseSquare),
        plain.clone().with(CUT_ON, Some(1.5)).with(NEAR_EDGE, 0.6),
        plain.clone().with(CUT_OFF, Some(2.0)).with(FAR_EDGE, 0.9),
        plain.clone().with(CUT_OFF, Some(2.0)).with(FAR_EDGE, 0.9).with(RANGE, Some(2.9)),
        plain.clone().with(CUT_OFF, Some(3.5)).with(FAR_EDGE, 0.9).with(RANGE, Some(3.1)),
        plain.clone().with(CUT_ON, Some(0.5)).with(DECAY, Decay::Linear).with(DECAY_START, 1.2),
    ];
    let planar = bent_tube(&Light::spot().with(TRANSLATION, source).with(RANGE, Some(3.0)), 3);
    for light in &lights {
        let omni = Omni::new(light).expect("valid");
        let spot = as_spotlight(light, 40.0, Some(toward), 3.0).expect("it has one end");
        let bent = long_tube(&spot, 3.0);
        let axis = (toward - source).normalize();
        let (right, up) = axis.any_orthonormal_pair();
        let (mut lit, mut dark) = (0, 0);
        for k in 0..900 {
            let (angle, slope) = (f64::from(k) * 2.4, 0.83 * (f64::from(k % 30) / 30.0));
            let direction = (axis + (right * angle.cos() + up * angle.sin()) * slope).normalize();
            let s = 0.05 + 4.2 * f64::from(k / 30) / 30.0;
            let expected = omni.locate(direction * s).map_or(DVec3::ZERO, |coords| omni.irradiance(&coords));
            let found = irradiance_at(&bent, source + direction * s);
            assert!((found - expected).length() <= 1e-9 * (1.0 + expected.length()), "{s}: {found} {expected}");
            (lit, dark) = (lit + usize::from(expected.x > 0.0), dark + usize::from(expected.x == 0.0));
        }
        assert!(lit > 100 && dark > 50, "{lit} lit, {dark} dark");
    }
    // Deliberate fault that the check must detect: a plane at the range, as of a spotlight.
    let beyond = source + (DVec3::NEG_Z + DVec3::X * 0.4).normalize() * 3.1;
    let omni = Omni::new(&lights[0]).expect("valid");
    assert!(planar.locate(beyond).point.is_some());
    assert!(omni.locate(beyond - source).is_none());
    let fading = plain.with(CUT_OFF, Some(2.0)).with(FAR_EDGE, 0.9).with(RANGE, Some(2.5));
    let refused = as_spotlight(&fading, 40.0, Some(toward), 3.0);
    assert_eq!(refused, Err(LightError::RangeInFarEdge { range: 2.5, cut_off: 2.0 }));
}

/// A bent spotlight is the same spotlight when straightened, to the last bit. If its control points have moved, it
/// shines from its source to its last control point and has the tube's width there.
#[test]
fn straightening_undoes_bending() {
    let transform = transform();
    for (range, segments) in [(None, 1), (Some(12.0), 3), (None, 5)] {
        let spot =
            Light::spot().with_transform(transform).with(CONE_ANGLE, 10.0).with(RANGE, range).with(INTENSITY, 60.0);
        let bent = bend_with_length(&spot, segments, 10.0).expect("valid");
        assert_eq!(straighten(&bent).expect("valid"), spot);
        let last = bent.points()[segments + 1];
        let offset = DVec3::new(0.3, 0.6, 0.0);
        let moved = bent.clone().map_points(|_, point| {
            point.position += offset * (point.position.z / last.position.z).powi(2);
            point.intensity = 0.5;
        });
        let end = last.position + offset;
        let straight = straighten(&moved).expect("valid");
        let aim = straight.get(ROTATION) * DVec3::NEG_Z;
        assert!((aim - transform.rotation * end.normalize()).length() < 1e-14);
        let slope = straight.get(CONE_ANGLE).to_radians().tan();
        assert!((slope * end.length() - last.radius).abs() < 1e-12 && straight.get(INTENSITY) == 30.0);
        let expected = range.map(|_| end.length() * transform.scale);
        assert_eq!(straight.get(RANGE), expected);
        // `up` stays up: across the axis, the light's own +Y has no part to its side.
        let up = straight.get(ROTATION) * DVec3::Y;
        assert!((up.dot(transform.rotation * DVec3::Y) > 0.9) && (up.dot(aim).abs() < 1e-14));
        // Deliberate fault that the check must detect: the original direction.
        assert!((aim - transform.rotation * DVec3::NEG_Z).length() > 0.1);
    }
    assert_eq!(straighten(&Light::spot()), Err(LightError::NotBent));
}

/// Returns the spotlight that the renderer draws instead of the light.
fn equivalent_spotlight(light: &Light) -> Option<Light> {
    let checked = CheckedLight::new(light.clone()).expect("valid");
    checked.equivalent_spotlight().map(|spot| spot.light().clone())
}

/// A BendyLight whose tube is a cone is the spotlight from which it was bent, however its control points are spread. It
/// is none as soon as any of its values is not that cone's.
#[test]
fn a_bendy_light_is_a_spotlight_while_it_is_straight() {
    let transform = transform();
    for (range, cone_angle, segments) in [(None, 1.0, 1), (Some(12.0), 25.0, 3), (None, 60.0, 7)] {
        let spot = Light::spot().with_transform(transform).with(CONE_ANGLE, cone_angle).with(RANGE, range);
        let bent = bend_with_length(&spot, segments, 10.0).expect("valid");
        assert_eq!(equivalent_spotlight(&bent).expect("straight"), spot);
        assert_eq!(equivalent_spotlight(&spot), None, "it is no BendyLight");
        let is_bent = |what: &str, light: Light| assert_eq!(equivalent_spotlight(&light), None, "{segments}: {what}");
        let last = segments + 1;
        let with_last = |change: fn(&mut light::ControlPoint)| bent.clone().map_point(last, change);
        is_bent("moved by a hair", with_last(|point| point.position.x += 1e-6));
        is_bent("wider by a hair", with_last(|point| point.radius *= 1.0 + 1e-6));
        is_bent("dimmer at its end", with_last(|point| point.intensity = 0.5));
        is_bent("redder at its end", with_last(|point| point.color.y = 0.5));
        is_bent("with a radius at its source", bent.clone().map_points(|k, point| point.radius += f64::from(k == 0)));
        is_bent("with the profile of another angle", bent.clone().with(CONE_ANGLE, 0.99 * cone_angle));
        is_bent("with up along it", bent.clone().with(UP, DVec3::Z));
    }

    // Unevenly spread points, along another axis than -Z, all of one colour; extended or cut.
    let axis = DVec3::new(1.0, 2.0, 2.0) / 3.0;
    let at = [0.0, 0.1, 2.0, 2.5, 9.0];
    let slope = 25_f64.to_radians().tan();
    let points = at.map(|along| axis * along).to_vec();
    let light = Light::bendy(points, at.map(|along| slope * along).to_vec())
        .with(COLOR, DVec3::new(0.5, 1.0, 2.0))
        .map_points(|_, point| (point.color, point.intensity) = (DVec3::new(1.0, 0.5, 0.25), 3.0));
    for (end_mode, range) in [(EndMode::Cut, Some(9.0)), (EndMode::Extend, None)] {
        let light = light.clone().with(END_MODE, end_mode);
        let spot = equivalent_spotlight(&light).expect("straight");
        assert_eq!((spot.get(RANGE), spot.get(INTENSITY)), (range, 3.0));
        assert_eq!(spot.get(COLOR), DVec3::splat(0.5));
        // Both lights agree at every point, except for roundings.
        let tube = tube_of(&light);
        let cone = Cone::new(&spot).expect("valid");
        for point in [DVec3::new(1.0, 2.0, 2.1), DVec3::new(0.1, 0.2, 0.1), DVec3::new(2.0, 4.9, 5.0)] {
            let root = root_at(&tube, point).expect("inside");
            let (bent, straight) = (tube.coords_at(&root), cone.locate(point).expect("inside"));
            assert!(
                (bent.v - straight.v).abs() < 1e-12 && (bent.w - straight.w).abs() < 1e-12,
                "{bent:?} {straight:?}"
            );
            assert!((bent.s - straight.s).abs() < 1e-12 && (bent.direction - straight.direction).length() < 1e-12);
            assert!((tube.irradiance(&root) - cone.irradiance(&straight)).length() < 1e-12);
        }
    }
    // Deliberate fault that the check must detect: control points that turn back.
    let turning = light.map_point(2, |point| {
        point.position *= 1.5;
        point.radius *= 1.5;
    });
    assert_eq!(CheckedLight::new(turning).ok().and_then(|light| light.equivalent_spotlight().cloned()), None);
}

/// `with_points` gives the same bits as a new preparation of the whole light, and also a tube that folds.
#[test]
fn with_points_equals_a_new_tube() {
    let spot = Light::spot().with(RANGE, Some(7.0)).with(CONE_ANGLE, 4.0);
    let decaying = bend(&spot, 4).expect("valid").with(DECAY_START, 0.5).with(DECAY, Decay::InverseSquare);
    for light in [decaying.clone(), decaying.with(END_MODE, EndMode::Extend)] {
        let tube = tube_of(&light);
        for (index, by) in [(1, 0.1), (3, 0.4), (5, 9.0)] {
            let moved = light.clone().map_point(index, |point| point.position += DVec3::new(0.2, 0.1, -1.0) * by);
            let other = tube.with_points(&light, moved.points()).expect("valid");
            assert_eq!(format!("{other:?}"), format!("{:?}", tube_of(&moved)));
            assert_ne!(format!("{other:?}"), format!("{tube:?}"));
        }
        let wide = light.clone().map_points(|_, point| point.radius = 50.0).map_point(2, |p| p.position.x += 1.0);
        assert!(matches!(Tube::new(&wide), Err(LightError::Fold { .. })));
        tube.with_points(&light, wide.points()).expect("a tube that folds");
    }
}
