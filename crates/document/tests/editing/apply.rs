//! Application of changes: all or none, and only from their old values.

use document::{CameraParameter, Change, Command, ControlPoints, EditError, PointNumbering, SceneRef};
use glam::DVec3;
use light::parameters::{
    CONE_ANGLE, DECAY, FRAME, INTENSITY, NAME, POINT_INTENSITY, POSITION, RADIUS, RANGE, ROTATION,
};
use light::{FrameMode, LightId, Parameter, Value};

use crate::support::{
    BENDY, EYE, ROOM, SPOT, checked, content, done, edit, eye, light_change, light_of, point_change, sample, spot,
};

fn radius(layout: u64, point: usize, old: f64, new: f64) -> Change {
    point_change(layout, point, RADIUS, old, new)
}

/// Rules: REC-3
#[test]
fn a_change_from_another_value_is_refused() {
    let document = sample();
    let placed = &document.lights()[&BENDY];
    let points = ControlPoints { layout: placed.layout, points: placed.light.light().points().to_vec() };
    let mut other = points.clone();
    other.points.iter_mut().for_each(|point| point.radius = 0.2);
    let room = || Some(SceneRef { asset: ROOM, name: "room".into() });
    let name = |name: &str| CameraParameter::Name(name.into());
    let changes = |sound: bool| {
        [
            Change::Scene { old: if sound { None } else { room() }, new: room() },
            Change::Light { light: BENDY, old: sound.then(|| placed.clone()), new: None },
            light_change(SPOT, CONE_ANGLE, if sound { 25.0 } else { 26.0 }, 30.0),
            radius(if sound { placed.layout.0 } else { 99 }, 1, 0.25, 0.3),
            radius(placed.layout.0, 1, if sound { 0.25 } else { 0.26 }, 0.3),
            radius(placed.layout.0, if sound { 1 } else { 5 }, 0.25, 0.3),
            Change::ControlPoints {
                light: BENDY,
                old: if sound { points.clone() } else { other.clone() },
                new: ControlPoints { layout: PointNumbering(9), ..other.clone() },
            },
            Change::Camera { camera: EYE, old: sound.then(eye), new: None },
            Change::CameraParameter { camera: EYE, old: name(if sound { "eye" } else { "nose" }), new: name("ear") },
        ]
    };
    for (sound, unsound) in changes(true).into_iter().zip(changes(false)) {
        let mut after = document.clone();
        let error = after.apply(&[unsound]).expect_err("the document holds another value");
        assert!(matches!(error, EditError::Conflict(_)), "{error}");
        assert_eq!(content(&after), content(&document));
        assert!(document.holds_old_value_of(&sound));
        after.apply(std::slice::from_ref(&sound)).expect("from the value it holds");
        assert!(!after.holds_old_value_of(&sound), "{sound:?}");
    }
}

/// Rules: REC-3
#[test]
fn changes_are_made_all_or_none() {
    let mut document = sample();
    let before = content(&document);
    let sound = radius(1, 1, 0.25, 0.3);
    let fold = radius(1, 2, 0.375, 20.0);
    for second in [radius(1, 2, 9.0, 0.3), fold] {
        document.apply(&[sound.clone(), second]).expect_err("the second");
        assert_eq!(content(&document), before);
    }
    document.apply(&[sound]).expect("the first alone");
}

/// Two changes that fold one by one but not together: only the result has to be valid.
///
/// Rules: CMD-2
#[test]
fn the_state_between_two_changes_need_not_be_valid() {
    let mut document = sample();
    let moved = |old: DVec3, new: DVec3| point_change(1, 2, POSITION, old, new);
    let (here, aside) = (DVec3::new(0.25, 0.0, -2.0), DVec3::new(6.0, 0.0, -1.0));
    document.apply(&[moved(here, aside)]).expect_err("it folds");
    document.apply(&[moved(here, aside), moved(aside, here)]).expect("nothing is left of it");
}

/// Changes written by hand, as from a radius to a position, with old values that the document holds.
///
/// Rules: REC-3
#[test]
fn both_values_of_a_change_are_of_one_property() {
    let mut document = sample();
    let layout = document.lights()[&BENDY].layout;
    let of_spot = |parameter: &'static Parameter, new: Value| {
        let old = light_of(&sample(), SPOT).value(parameter).expect("a spotlight has it").clone();
        Change::LightParameter { light: SPOT, parameter, old, new }
    };
    let radius = |new| {
        let old = Value::Number(0.25);
        Change::Point { light: BENDY, layout, point: 1, parameter: RADIUS.row(), old, new }
    };
    let mixed = [
        radius(Value::Vector(DVec3::ONE)),
        radius(Value::Absent),
        of_spot(CONE_ANGLE.row(), Value::Text("wide".into())),
        of_spot(CONE_ANGLE.row(), Value::Absent),
        of_spot(RANGE.row(), Value::Text("far".into())),
        of_spot(DECAY.row(), Value::Choice(FrameMode::Up.name())),
        of_spot(ROTATION.row(), Value::Vector(DVec3::ONE)),
        of_spot(NAME.row(), Value::Number(1.0)),
        Change::CameraParameter {
            camera: EYE,
            old: CameraParameter::Name("eye".into()),
            new: CameraParameter::Translation(DVec3::ONE),
        },
    ];
    for change in mixed {
        assert!(document.holds_old_value_of(&change));
        let error = document.apply(&[change]).expect_err("two properties");
        assert!(matches!(error, EditError::Conflict(_)), "{error}");
    }
}

/// Changes written by hand, of properties that the light or control point does not have.
///
/// Rules: REC-3
#[test]
fn a_change_is_of_what_is_there() {
    let mut document = sample();
    let (frame, up) = (FrameMode::RotationMinimizing, FrameMode::Up);
    let other = [
        light_change(SPOT, FRAME, frame, up),
        light_change(BENDY, RANGE, None, Some(1.0)),
        light_change(BENDY, RADIUS, 0.125, 0.25),
        light_change(LightId(9), CONE_ANGLE, 25.0, 30.0),
        point_change(1, 1, FRAME, frame, up),
        point_change(1, 1, CONE_ANGLE, 25.0, 30.0),
    ];
    for change in other {
        assert!(!document.holds_old_value_of(&change));
        let error = document.apply(&[change]).expect_err("nothing has it");
        assert!(matches!(error, EditError::Conflict(_)), "{error}");
    }
    let angle = light_change(SPOT, CONE_ANGLE, 25.0, 30.0);
    document.apply(&[angle]).expect("a spotlight has a cone angle");
}

/// Rules: REC-2
#[test]
fn one_persons_change_can_be_taken_back_under_anothers() {
    let mut document = sample();
    let mine =
        done(&mut document, &Command::SetLight { light: SPOT, setting: CONE_ANGLE.to(40.0), ignore_pins: false });
    done(&mut document, &Command::SetLight { light: SPOT, setting: INTENSITY.to(9.0), ignore_pins: false });
    document.apply(&[mine[0].inverse()]).expect("nobody else touched the angle");
    let mut theirs = sample();
    done(&mut theirs, &Command::SetLight { light: SPOT, setting: INTENSITY.to(9.0), ignore_pins: false });
    assert_eq!(content(&document), content(&theirs));
}

/// Rules: FRAME-7
#[test]
fn names_and_cameras_change_no_picture() {
    let shows = |command: &Command| {
        let changes = edit(&sample(), command).expect("a valid command").changes;
        assert!(!changes.is_empty());
        changes.iter().any(Change::changes_picture)
    };
    let set = |setting| Command::SetLight { light: SPOT, setting, ignore_pins: false };
    assert!(!shows(&set(NAME.to("rim".into()))));
    assert!(!shows(&Command::AddCamera(eye())));
    assert!(!shows(&Command::RemoveCamera(EYE)));
    let parameter = CameraParameter::Translation(DVec3::ONE);
    assert!(!shows(&Command::SetCamera { camera: EYE, parameter }));
    assert!(shows(&set(INTENSITY.to(2.0))));
    assert!(shows(&Command::RemoveLight(LightId(1))));
    assert!(shows(&Command::AddLight(checked(spot()))));
    assert!(shows(&Command::LoadScene { asset: ROOM, name: "room".into() }));
    assert!(shows(&Command::RemovePoint { light: BENDY, point: 2, ignore_pins: false }));
    let setting = POINT_INTENSITY.to(3.0);
    assert!(shows(&Command::SetPoint { light: BENDY, point: 1, setting, ignore_pins: false }));
}
