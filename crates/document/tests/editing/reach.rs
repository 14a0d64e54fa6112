//! What no picture can show is not committed; what was committed before still applies.

use document::{Change, Command, EditError, LightParameter, changes_of};
use glam::DVec3;
use light::{LightKind, OutOfReach};

use crate::support::{BENDY, ROOM, SPOT, bendy, edited, find_scene, spot};

fn place(light: light::LightId, x: f64) -> Command {
    let translation = Some(DVec3::new(x, 0.0, 0.0));
    Command::PlaceLight { light, translation, rotation: None, scale: None }
}

#[test]
fn commands_refuse_lights_out_of_reach() {
    let document = edited();
    let scaled = |scale| Command::SetLight { light: BENDY, parameter: LightParameter::Scale(scale) };
    let mut far = spot();
    if let LightKind::Spot(spot) = &mut far.kind {
        spot.transform.translation.y = 1e300;
    }
    for command in [
        place(SPOT, 1.1e15),
        place(SPOT, 3.4e38),
        place(BENDY, -3.4e38),
        place(BENDY, 1e300),
        scaled(1e16),
        Command::AddLight(Box::new(far)),
    ] {
        let error = changes_of(&document, &command, &find_scene).expect_err("no picture can show it");
        assert!(matches!(error, EditError::OutOfReach(_)), "{command:?}: {error}");
        let sentence = error.to_string();
        assert!(sentence.contains("1e15") && sentence.contains('`'), "{sentence}");
    }
    for command in [place(SPOT, 1e14), place(BENDY, 1e10), scaled(1e3)] {
        changes_of(&document, &command, &find_scene).expect("near enough");
    }
}

/// An old log can hold such a light: it applies, and the light can be brought back step by step.
#[test]
fn records_of_lights_out_of_reach_apply() {
    let mut document = edited();
    let old = LightParameter::Translation(DVec3::ZERO);
    let new = LightParameter::Translation(DVec3::splat(3.4e38));
    document
        .apply(&[Change::LightParameter { light: SPOT, old, new }], &find_scene)
        .expect("as it was recorded");
    let left_out = document.reach().left_out(document.lights().values().map(|placed| &placed.light));
    assert!(matches!(&left_out[..], [OutOfReach::Far { name, .. }] if name == "lamp"), "{left_out:?}");
    let rename = Command::SetLight { light: SPOT, parameter: LightParameter::Name("far away".into()) };
    changes_of(&document, &rename, &find_scene).expect("it is no farther than before");
    changes_of(&document, &place(SPOT, 1e20), &find_scene).expect("nearer than before");
    // Another light is held to the bound all the same.
    changes_of(&document, &place(BENDY, 1e20), &find_scene).expect_err("no picture can show it");
}

/// A scene brings its lights as they are; a picture leaves out what it cannot show.
#[test]
fn scenes_load_with_their_lights() {
    let mut far = bendy();
    if let LightKind::Bendy(bendy) = &mut far.kind {
        bendy.transform.translation.z = 1e40;
    }
    let scene = std::sync::Arc::new(scene::Scene { lights: vec![far, spot()], ..scene::Scene::default() });
    let find = |_: &document::AssetHash| Some(std::sync::Arc::clone(&scene));
    let load = Command::LoadScene { asset: ROOM, name: "far".into() };
    let mut document = document::Document::default();
    let changes = changes_of(&document, &load, &find).expect("it loads");
    document.apply(&changes, &find).expect("it applies");
    assert_eq!(document.lights().len(), 2);
    let left_out = document.reach().left_out(document.lights().values().map(|placed| &placed.light));
    assert_eq!(left_out.len(), 1);
}
