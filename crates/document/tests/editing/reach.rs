//! Lights that no picture can show are not committed. Earlier records with such lights still apply.

use document::{Command, CommandContext, CommandResult, Document, EditError, SceneContents, execute_command};
use glam::DVec3;
use light::parameters::{NAME, SCALE, TRANSLATION, WIDTH};
use light::{Light, LightId, SceneBounds, UndrawableLight};

use crate::support::{self, BENDY, ROOM, SPOT, bendy, checked, edit, light_change, sample, spot};

fn left_out(document: &Document) -> Vec<UndrawableLight> {
    SceneBounds::default().undrawable_of(document.lights().values().map(|placed| &*placed.light))
}

fn place(light: LightId, x: f64) -> Command {
    support::place(light, DVec3::new(x, 0.0, 0.0))
}

#[test]
fn commands_refuse_lights_out_of_reach() {
    let document = sample();
    let scaled = |scale| Command::SetLight { light: BENDY, setting: SCALE.to(scale), ignore_pins: false };
    let far = spot().with(TRANSLATION, DVec3::Y * 1e300);
    for command in [
        place(SPOT, 1.1e15),
        place(SPOT, 3.4e38),
        place(BENDY, -3.4e38),
        place(BENDY, 1e300),
        scaled(1e16),
        Command::AddLight(checked(far)),
    ] {
        let error = edit(&document, &command).expect_err("no picture can show it");
        assert!(matches!(error, EditError::Undrawable(_)), "{command:?}: {error}");
        let sentence = error.to_string();
        assert!(sentence.contains("1e15") && sentence.contains('`'), "{sentence}");
    }
    for command in [place(SPOT, 1e14), place(BENDY, 1e10), scaled(1e3)] {
        edit(&document, &command).expect("near enough");
    }
}

/// An old log can contain such a light. Its record applies, and the light can be brought back in steps.
#[test]
fn records_of_lights_out_of_reach_apply() {
    let mut document = sample();
    let carried = light_change(SPOT, TRANSLATION, DVec3::ZERO, DVec3::splat(3.4e38));
    document.apply(&[carried]).expect("as it was recorded");
    let left_out = left_out(&document);
    assert!(matches!(&left_out[..], [UndrawableLight::TooFar { name, .. }] if name == "lamp"), "{left_out:?}");
    let rename = Command::SetLight { light: SPOT, setting: NAME.to("far away".into()), ignore_pins: false };
    edit(&document, &rename).expect("it is no farther than before");
    edit(&document, &place(SPOT, 1e20)).expect("nearer than before");
    // Another light still has to be within the bound.
    edit(&document, &place(BENDY, 1e20)).expect_err("no picture can show it");
}

/// The distance from the scene's bounds counts, which the caller gives.
#[test]
fn lights_are_measured_against_the_scene() {
    let document = sample();
    let reach = SceneBounds { center: DVec3::X * 9e14, half_extent: DVec3::splat(1e13) };
    let context = CommandContext { scene_bounds: reach, ..CommandContext::default() };
    let there = |x| execute_command(&document, &place(SPOT, x), context);
    there(1.1e15).expect("near that scene");
    edit(&document, &place(SPOT, 1.1e15)).expect_err("far from one about the origin");
    let error = there(-2e14).expect_err("far from that scene");
    assert!(matches!(error, EditError::Undrawable(_)), "{error}");
    edit(&document, &place(SPOT, -2e14)).expect("near one about the origin");
}

/// A directional light has no position, but its window has: it may be too far away across the light, or too narrow.
#[test]
fn only_a_directional_lights_window_is_out_of_reach() {
    let reach = SceneBounds { center: DVec3::ZERO, half_extent: DVec3::splat(10.0) };
    let check = |sun: Light| reach.check(&checked(sun));
    let sun = || Light::directional().with(TRANSLATION, DVec3::new(1e40, 3.0, 1e300));
    check(sun()).expect("everywhere");
    assert!(matches!(check(sun().with(WIDTH, Some(2.0))), Err(UndrawableLight::TooFar { .. })));
    let along = Light::directional().with(TRANSLATION, DVec3::Z * 1e300);
    check(along.clone().with(WIDTH, Some(2.0))).expect("it shines along Z");
    assert!(matches!(check(along.with(WIDTH, Some(1e-20))), Err(UndrawableLight::TooSmall { .. })));
}

/// A scene brings its lights unchecked. A picture leaves out lights that it cannot show.
#[test]
fn scenes_load_with_their_lights() {
    let far = bendy().with(TRANSLATION, DVec3::Z * 1e40);
    let scene = SceneContents { lights: vec![checked(far), checked(spot())], cameras: Vec::new() };
    let load = Command::LoadScene { asset: ROOM, name: "far".into() };
    let mut document = Document::default();
    let context = CommandContext { loaded: Some(&scene), ..CommandContext::default() };
    let CommandResult { changes, .. } = execute_command(&document, &load, context).expect("it loads");
    document.apply(&changes).expect("it applies");
    assert_eq!(document.lights().len(), 2);
    assert_eq!(left_out(&document).len(), 1);
}
