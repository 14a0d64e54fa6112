//! Making changes: all or none, and only from where they start.

use document::{
    CameraParameter, Change, Command, ControlPoints, EditError, Layout, LightParameter, PointParameter,
    SceneRef, changes_of,
};
use glam::DVec3;
use light::LightId;

use crate::support::{BENDY, EYE, ROOM, SPOT, content, done, edited, eye, find_scene, spot};

fn radius(layout: u64, point: usize, old: f64, new: f64) -> Change {
    let (old, new) = (PointParameter::Radius(old), PointParameter::Radius(new));
    Change::Point { light: BENDY, layout: Layout(layout), point, old, new }
}

/// Rules: REC-3
#[test]
fn a_change_from_another_value_is_refused() {
    let document = edited();
    let placed = &document.lights()[&BENDY];
    let points = ControlPoints::of(placed).expect("a BendyLight");
    let other = ControlPoints { radii: vec![0.2; 5], ..points.clone() };
    let angle = |old, new| {
        let (old, new) = (LightParameter::ConeAngle(old), LightParameter::ConeAngle(new));
        Change::LightParameter { light: SPOT, old, new }
    };
    let room = || Some(SceneRef { asset: ROOM, name: "room".into() });
    let name = |name: &str| CameraParameter::Name(name.into());
    let changes = |sound: bool| {
        [
            Change::Scene { old: if sound { None } else { room() }, new: room() },
            Change::Light { light: BENDY, old: sound.then(|| Box::new(placed.clone())), new: None },
            angle(if sound { 25.0 } else { 26.0 }, 30.0),
            radius(if sound { placed.layout.0 } else { 99 }, 1, 0.25, 0.3),
            radius(placed.layout.0, 1, if sound { 0.25 } else { 0.26 }, 0.3),
            radius(placed.layout.0, if sound { 1 } else { 5 }, 0.25, 0.3),
            Change::ControlPoints {
                light: BENDY,
                old: if sound { points.clone() } else { other.clone() },
                new: ControlPoints { layout: Layout(9), ..other.clone() },
            },
            Change::Camera { camera: EYE, old: sound.then(eye), new: None },
            Change::CameraParameter {
                camera: EYE,
                old: name(if sound { "eye" } else { "nose" }),
                new: name("ear"),
            },
        ]
    };
    for (sound, unsound) in changes(true).into_iter().zip(changes(false)) {
        let mut after = document.clone();
        let error = after.apply(&[unsound], &find_scene).expect_err("the document holds another value");
        assert!(matches!(error, EditError::Conflict(_)), "{error}");
        assert_eq!(content(&after), content(&document));
        assert!(document.holds_old_of(&sound));
        after.apply(std::slice::from_ref(&sound), &find_scene).expect("from the value it holds");
        assert!(!after.holds_old_of(&sound), "{sound:?}");
    }
}

/// Rules: REC-3
#[test]
fn changes_are_made_all_or_none() {
    let mut document = edited();
    let before = content(&document);
    let sound = radius(1, 1, 0.25, 0.3);
    let fold = radius(1, 2, 0.375, 20.0);
    for second in [radius(1, 2, 9.0, 0.3), fold] {
        document.apply(&[sound.clone(), second], &find_scene).expect_err("the second");
        assert_eq!(content(&document), before);
    }
    document.apply(&[sound], &find_scene).expect("the first alone");
}

/// Two that fold one by one but not together: validity is of the outcome.
///
/// Rules: CMD-2
#[test]
fn what_lies_between_two_changes_need_not_be_valid() {
    let mut document = edited();
    let moved = |old: DVec3, new: DVec3| {
        let (old, new) = (PointParameter::Position(old), PointParameter::Position(new));
        Change::Point { light: BENDY, layout: Layout(1), point: 2, old, new }
    };
    let (here, aside) = (DVec3::new(0.25, 0.0, -2.0), DVec3::new(6.0, 0.0, -1.0));
    document.apply(&[moved(here, aside)], &find_scene).expect_err("it folds");
    document.apply(&[moved(here, aside), moved(aside, here)], &find_scene).expect("nothing is left of it");
}

/// A change made up by hand, from a radius to a position, has an old value that the document holds.
///
/// Rules: REC-3
#[test]
fn both_values_of_a_change_are_of_one_property() {
    let mut document = edited();
    let layout = document.lights()[&BENDY].layout;
    let (old, new) = (PointParameter::Radius(0.25), PointParameter::Intensity(3.0));
    let mixed = [
        Change::Point { light: BENDY, layout, point: 1, old, new },
        Change::LightParameter {
            light: SPOT,
            old: LightParameter::ConeAngle(25.0),
            new: LightParameter::ConeSoftness(0.5),
        },
        Change::CameraParameter {
            camera: EYE,
            old: CameraParameter::Name("eye".into()),
            new: CameraParameter::Translation(DVec3::ONE),
        },
    ];
    for change in mixed {
        assert!(document.holds_old_of(&change));
        let error = document.apply(&[change], &find_scene).expect_err("two properties");
        assert!(matches!(error, EditError::Conflict(_)), "{error}");
    }
}

/// Rules: REC-2
#[test]
fn one_persons_change_can_be_taken_back_under_anothers() {
    let mut document = edited();
    let mine =
        done(&mut document, &Command::SetLight { light: SPOT, parameter: LightParameter::ConeAngle(40.0) });
    done(&mut document, &Command::SetLight { light: SPOT, parameter: LightParameter::Intensity(9.0) });
    document.apply(&[mine[0].inverse()], &find_scene).expect("nobody else touched the angle");
    let mut theirs = edited();
    done(&mut theirs, &Command::SetLight { light: SPOT, parameter: LightParameter::Intensity(9.0) });
    assert_eq!(content(&document), content(&theirs));
}

/// Rules: FRAME-7
#[test]
fn names_and_cameras_change_no_picture() {
    let shows = |command: &Command| {
        let changes = changes_of(&edited(), command, &find_scene).expect("a valid command");
        assert!(!changes.is_empty());
        changes.iter().any(Change::changes_picture)
    };
    let set = |parameter| Command::SetLight { light: SPOT, parameter };
    assert!(!shows(&set(LightParameter::Name("rim".into()))));
    assert!(!shows(&Command::AddCamera(eye())));
    assert!(!shows(&Command::RemoveCamera(EYE)));
    let parameter = CameraParameter::Translation(DVec3::ONE);
    assert!(!shows(&Command::SetCamera { camera: EYE, parameter }));
    assert!(shows(&set(LightParameter::Intensity(2.0))));
    assert!(shows(&Command::RemoveLight(LightId(1))));
    assert!(shows(&Command::AddLight(Box::new(spot()))));
    assert!(shows(&Command::LoadScene { asset: ROOM, name: "room".into() }));
    assert!(shows(&Command::RemovePoint { light: BENDY, point: 2 }));
    let parameter = PointParameter::Intensity(3.0);
    assert!(shows(&Command::SetPoint { light: BENDY, point: 1, parameter }));
}
