//! Number of checks of a light: one, where a change is made.

use std::sync::Arc;

use document::{CameraParameter, Change, Command, CommandContext, Document, execute_command};
use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, NAME, POSITION, RADIUS};
use light::{CheckedLight, Setting};

use crate::support::{
    BENDY, EYE, ROOM, SPOT, bendy, checked, edit, eye, find_scene, insert, light_change, light_of, plan, point_change,
    sample, set_point, spot, take_back,
};

/// Counts the checks that `work` makes.
fn checks<T>(work: impl FnOnce() -> T) -> u64 {
    let before = CheckedLight::check_count();
    work();
    CheckedLight::check_count() - before
}

/// Counts the checks of a command that must be valid.
fn checks_of(command: &Command) -> u64 {
    let document = sample();
    checks(|| edit(&document, command).expect("a valid command"))
}

fn set(setting: Setting) -> Command {
    Command::SetLight { light: SPOT, setting, ignore_pins: false }
}

fn place(translation: DVec3) -> Command {
    let (rotation, scale) = (Some(DQuat::from_rotation_y(0.5)), Some(2.0));
    Command::PlaceLight { light: BENDY, translation: Some(translation), rotation, scale, ignore_pins: false }
}

#[test]
fn an_edit_of_a_light_checks_it_once() {
    for command in [
        set(CONE_ANGLE.to(40.0)),
        set(NAME.to("rim".into())),
        place(DVec3::ONE),
        set_point(1, RADIUS.to(0.3)),
        insert(2),
        insert(5),
        Command::RemovePoint { light: BENDY, point: 2, ignore_pins: false },
    ] {
        assert_eq!(checks_of(&command), 1, "{command:?}");
    }
}

/// Lights of a command or a scene were checked when they were read.
#[test]
fn whole_lights_are_not_checked_again() {
    let added = Command::AddLight(checked(spot()));
    let unchanged = set(CONE_ANGLE.to(light_of(&sample(), SPOT).get(CONE_ANGLE)));
    for command in [
        added,
        Command::RemoveLight(BENDY),
        unchanged,
        Command::AddCamera(plan()),
        Command::RemoveCamera(EYE),
        Command::PlaceCamera { camera: EYE, translation: Some(DVec3::ONE), rotation: None },
        Command::SetCamera { camera: EYE, parameter: CameraParameter::Name("side".into()) },
    ] {
        assert_eq!(checks_of(&command), 0, "{command:?}");
    }
    let (scene, command) = (find_scene(ROOM), Command::LoadScene { asset: ROOM, name: "room".into() });
    let context = CommandContext { loaded: scene.as_ref(), ..CommandContext::default() };
    let load = || execute_command(&Document::default(), &command, context).expect("it loads");
    assert_eq!(checks(load), 0);
}

/// Undo and replay apply changes like these.
#[test]
fn changes_check_each_light_once() {
    let several = [
        light_change(SPOT, CONE_ANGLE, 25.0, 40.0),
        point_change(1, 1, RADIUS, 0.25, 0.3),
        point_change(1, 2, RADIUS, 0.375, 0.3),
        light_change(BENDY, NAME, "key".into(), "rim".into()),
        Change::Camera { camera: EYE, old: Some(eye()), new: None },
    ];
    let mut document = sample();
    assert_eq!(checks(|| document.apply(&several).expect("valid changes")), 2);
    assert_eq!(checks(|| take_back(&mut document, &several)), 2);
    let removed =
        [several[0].clone(), Change::Light { light: BENDY, old: document.lights().get(&BENDY).cloned(), new: None }];
    assert_eq!(checks(|| document.apply(&removed).expect("valid changes")), 1, "what goes is not checked");
}

/// The other lights are shared.
#[test]
fn untouched_lights_are_shared() {
    let before = sample();
    let after = edit(&before, &set(CONE_ANGLE.to(40.0))).expect("a valid command").document;
    let is_shared = |id| Arc::ptr_eq(&before.lights()[&id].light, &after.lights()[&id].light);
    assert!(is_shared(BENDY) && !is_shared(SPOT));
}

/// Refused lights are counted too.
#[test]
fn a_check_by_hand_is_counted() {
    assert_eq!(checks(|| checked(bendy())), 1);
    let fold = || CheckedLight::new(bendy().map_points(|_, point| point.radius = 20.0)).expect_err("it folds");
    assert_eq!(checks(fold), 1);
    let command = set_point(3, POSITION.to(DVec3::NEG_X * 3.0));
    let document = sample();
    assert_eq!(checks(|| edit(&document, &command).expect_err("it folds")), 1);
}
