//! Tests of a scene's lights: all lights of its file, with the look that glTF specifies, or a default key if it
//! has none.

use assets::LoadedScene;
use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, ROTATION};
use light::{CrossFalloff, Light, LightShape, SceneBounds};
use scene::{DEFAULT_ASPECT, framing_camera};

/// Loads a file whose mesh 0 is one triangle, 2 units wide in the plane z = 0, with more `members`.
fn triangle(members: &str) -> LoadedScene {
    let file = format!(
        r#"{{"asset": {{"version": "2.0"}}, {members},
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [-1, -1, 0], "max": [1, 1, 0]}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"byteLength": 36,
            "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}}]}}"#
    );
    assets::load_bytes(file.as_bytes()).expect("a sound file")
}

/// Loads a file with one light on a node.
fn with_light(light: &str) -> LoadedScene {
    triangle(&format!(
        r#""extensions": {{"KHR_lights_punctual": {{"lights": [{light}]}}}},
        "nodes": [{{"mesh": 0, "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}]"#
    ))
}

/// The penumbra equals the one that `KHR_lights_punctual` recommends, for every cone.
#[test]
fn the_penumbra_of_a_spotlight_is_the_one_that_gltf_recommends() {
    for (inner, outer) in [(0.35_f64, 0.436_f64), (0.0, 1.047), (0.087, 0.174), (1.2, 1.5)] {
        let cone = format!(r#""innerConeAngle": {inner}, "outerConeAngle": {outer}"#);
        let loaded = with_light(&format!(r#"{{"type": "spot", "spot": {{{cone}}}}}"#));
        let spot = loaded.contents.lights[0].light();
        // The reader stores the angles in single precision.
        let (inner, outer) = (f64::from(inner as f32), f64::from(outer as f32));
        assert_eq!(spot.get(CONE_ANGLE), outer.to_degrees());
        let softness = 1.0 - inner / outer;
        let default = Light::spot().with(CONE_ANGLE, outer.to_degrees()).with(CONE_SOFTNESS, softness);
        let (penumbra, planted) = (CrossFalloff::of(spot), CrossFalloff::of(&default));
        let scale = 1.0 / (libm::cos(inner) - libm::cos(outer));
        let (mut most, mut most_planted) = (0.0_f64, 0.0_f64);
        for k in 0..=10_000 {
            let angle = outer * f64::from(k) / 10_000.0;
            let attenuation = (scale * (libm::cos(angle) - libm::cos(outer))).clamp(0.0, 1.0);
            let recommended = attenuation * attenuation;
            let rho = libm::tan(angle) / libm::tan(outer);
            most = most.max((penumbra.at(rho * rho) - recommended).abs());
            most_planted = most_planted.max((planted.at(rho * rho) - recommended).abs());
        }
        // The recommended formula subtracts cosines near 1. Its error is a rounding of each, over their
        // difference, and the square doubles it.
        assert!(most < 8.0 * f64::EPSILON * scale, "{inner} {outer}: {most}");
        // Deliberate fault that the check must detect: a light with the default profile is brighter by up to 2 s^2 (1 -
        // s), most at s = 2/3.
        assert!((most_planted - 8.0 / 27.0).abs() < 1e-6, "{inner} {outer}: {most_planted}");
    }
}

/// An unlit scene gets one light from beside the camera, so that it can be seen at first. A note names the
/// light, and it can be removed. A scene with a light, or without geometry, gets none.
#[test]
fn a_scene_without_lights_gets_a_key() {
    let file = triangle(r#""nodes": [{"mesh": 0}]"#);
    assert!(file.contents.lights.is_empty() && file.notes.is_empty(), "for who brings lights");
    let reach = SceneBounds::from(&file.scene);
    let lit = file.with_default_light();
    let [key] = &lit.contents.lights[..] else { panic!("{:?}", lit.contents.lights) };
    assert_eq!((key.light().shape(), key.light().name()), (&LightShape::Directional, "default key"));
    assert_eq!(lit.notes.len(), 1);
    assert!(lit.notes[0].ends_with("can be removed: default key"), "{:?}", lit.notes);
    let from_beside = |key: &Light, camera: DQuat| {
        let direction = camera.normalize().inverse() * (key.get(ROTATION) * DVec3::NEG_Z);
        // Forwards, down and to the right.
        direction.z < -0.7 && direction.y < -0.3 && direction.x > 0.1
    };
    let framing = framing_camera(&reach, DEFAULT_ASPECT).rotation;
    assert!(from_beside(key.light(), framing));
    // Deliberate fault that the check must detect: the light of another camera.
    let down = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    assert!(!from_beside(key.light(), down));

    // The file's own camera, which looks down, has priority.
    let camera = r#""cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]"#;
    let at = r#""camera": 0, "translation": [0, 9, 0], "rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476]"#;
    let lit = triangle(&format!(r#"{camera}, "nodes": [{{"mesh": 0}}, {{{at}}}]"#)).with_default_light();
    assert!(from_beside(lit.contents.lights[0].light(), down));

    // A second call adds nothing.
    assert_eq!(lit.clone().with_default_light().contents.lights.len(), 1);
    let lamp = with_light(r#"{"type": "point"}"#).with_default_light();
    assert_eq!((lamp.contents.lights.len(), lamp.contents.lights[0].light().shape()), (1, &LightShape::Omni));
    assert!(lamp.notes.is_empty(), "{:?}", lamp.notes);
    let nothing = triangle(r#""nodes": [{}]"#).with_default_light();
    assert!(nothing.contents.lights.is_empty() && nothing.notes.is_empty(), "{:?}", nothing.notes);
}
