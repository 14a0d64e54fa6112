//! Coordinates of points in straight lights.

use glam::{DMat3, DQuat, DVec3, Mat4};
use light::parameters::{CONE_ANGLE, HEIGHT, RANGE, ROTATION, WIDTH};
use light::{CheckedLight, Light, LightCoords, LightRays};

use super::super::receiver::StraightShape;
use super::super::{Located, RelitDirectional, RelitOmni, RelitSpot};
use super::{OMNI_MAP, SPOT_MAP, SUN_MAP};
use crate::lanes::{F32s, LANES, Vec3s};
use crate::transform::Affine3s;

/// Error of coordinates: some ulps of numbers of up to 10.
const TOLERANCE: f64 = 1e-5;

/// Makes a rotation about an axis that is none of the coordinate axes.
fn turned() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.8)
}

fn light_from_scene(source: DVec3) -> Mat4 {
    let rotation = DMat3::from_quat(turned()).transpose();
    glam::DAffine3 { matrix3: rotation, translation: -(rotation * source) }.as_affine3a().into()
}

/// Makes unordered positions around the origin, up to 5 away.
fn positions() -> Vec<[DVec3; LANES]> {
    let number = |k: usize, factor: f64| ((k as f64 * factor).fract() - 0.5) * 10.0;
    let one = |k: usize| DVec3::new(number(k, 0.618_034), number(k, 0.754_878), number(k, 0.569_84));
    (0..200).map(|group| std::array::from_fn(|lane| one(group * LANES + lane + 1).as_vec3().as_dvec3())).collect()
}

fn in_lanes(points: &[DVec3; LANES]) -> Vec3s {
    let axis = |k: usize| F32s(points.map(|p| p[k] as f32));
    Vec3s { x: axis(0), y: axis(1), z: axis(2) }
}

/// Compares coordinates with those of the light model, except at positions so near to its edge that rounding decides.
/// Returns the number of positions inside.
fn assert_located(locate: impl Fn(Vec3s) -> Located, expected: impl Fn(DVec3) -> Option<LightCoords>) -> usize {
    let mut inside = 0;
    for points in positions() {
        let located = locate(in_lanes(&points));
        for (lane, point) in points.iter().enumerate() {
            let nearby = [1.0 + TOLERANCE, 1.0 - TOLERANCE].map(|scale| expected(*point * scale).is_some());
            let Some(coords) = expected(*point) else {
                assert!(!located.inside.lane(lane) || nearby.contains(&true), "{point} is outside");
                continue;
            };
            assert!(located.inside.lane(lane) || nearby.contains(&false), "{point} is inside");
            let close = |a: f32, b: f64, size: f64| (f64::from(a) - b).abs() <= TOLERANCE * size;
            // Coordinates on a cube's face move as the position does, divided by its distance.
            assert!(close(located.v.0[lane], coords.v, 10.0) && close(located.w.0[lane], coords.w, 10.0), "{point}");
            assert!(close(located.s.0[lane], coords.s, 10.0), "{point}");
            assert!((located.to_light.lane(lane).as_dvec3() - coords.direction).length() <= TOLERANCE, "{point}");
            inside += 1;
        }
    }
    inside
}

#[test]
fn lights_are_where_the_light_model_has_them() {
    let checked = |light: Light| CheckedLight::new(light.with(ROTATION, turned())).expect("a light");
    let source = DVec3::new(0.3, -0.7, 0.4);

    let spot = checked(Light::spot().with(CONE_ANGLE, 50.0).with(RANGE, Some(3.5)));
    let LightRays::Cone(cone) = spot.rays() else { panic!("a cone") };
    let tan = cone.tan_outer as f32;
    let of = |tan| RelitSpot::new(light_from_scene(source), cone.light_profile.clone(), tan, Some(3.5), SPOT_MAP);
    let lanes = of(tan);
    assert!(assert_located(|p| lanes.locate(p), |p| cone.locate(p - source)) > 50);

    let omni = checked(Light::omni().with(RANGE, Some(4.0)));
    let LightRays::Omni(omni) = omni.rays() else { panic!("an omni light") };
    let lanes = RelitOmni::new(light_from_scene(source), omni.light_profile.clone(), Some(4.0), OMNI_MAP);
    assert!(assert_located(|p| lanes.locate(p), |p| omni.locate(p - source)) > 300);

    let sun = checked(Light::directional().with(WIDTH, Some(4.0)).with(HEIGHT, Some(6.0)));
    let LightRays::Parallel(parallel) = sun.rays() else { panic!("a directional light") };
    let (frame, window) = (light_from_scene(DVec3::ZERO), [0.5, 1.0 / 3.0, 0.0, 0.0]);
    let lanes = RelitDirectional::new(frame, parallel.light_profile.clone(), window, SUN_MAP);
    assert!(assert_located(|p| lanes.locate(p), |p| parallel.locate(p)) > 300);

    // Deliberate fault that the check must detect: a cone wider by a hundredth.
    let wider = of(tan * 1.01);
    let found = positions().iter().any(|points| {
        let located = wider.locate(in_lanes(points));
        (0..LANES).any(|lane| {
            cone.locate(points[lane] - source)
                .is_some_and(|coords| (f64::from(located.v.0[lane]) - coords.v).abs() > 10.0 * TOLERANCE)
        })
    });
    assert!(found, "a wider cone goes unseen");
}

#[test]
fn vectors_go_to_light_space_and_back() {
    let transform = Affine3s::splat(light_from_scene(DVec3::new(3.0, 2.0, 1.0)));
    for points in positions().iter().take(10) {
        let there = in_lanes(points);
        let back = transform.transposed_vector(transform.vector(there));
        for (lane, point) in points.iter().enumerate() {
            assert!((back.lane(lane).as_dvec3() - *point).length() < TOLERANCE * 10.0);
        }
    }
}
