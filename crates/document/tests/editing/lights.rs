//! Commands on whole lights.

use document::{Change, Command, EditError, MAX_LIGHTS};
use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, INTENSITY, NAME, RANGE, ROTATION, SCALE,
    TRANSLATION, UP,
};
use light::{Decay, DirectionMode, EndMode, FrameMode, LightId, MAX_NAME_BYTES, Setting, Transform};

use crate::support::{BENDY, SPOT, bendy, checked, content, done, light_of, refused, sample, spot};

/// Rules: DOC-1, CMD-3
#[test]
fn lights_come_and_go() {
    let mut document = sample();
    let changes = done(&mut document, &Command::AddLight(checked(spot())));
    let id = LightId(5);
    assert!(matches!(&changes[..], [Change::Light { light: LightId(5), old: None, new: Some(_) }]));
    assert_eq!(*light_of(&document, id), spot());
    done(&mut document, &Command::RemoveLight(id));
    assert!(!document.lights().contains_key(&id));
    assert_eq!(refused(&document, &Command::RemoveLight(id)), EditError::NoLight(id));
    assert_eq!(content(&document), content(&sample()));
}

/// Rules: REC-2
#[test]
fn placing_a_light_changes_what_is_given_and_no_more() {
    let mut document = sample();
    let (translation, rotation) = (DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_x(0.5));
    let place = |translation, rotation, scale| Command::PlaceLight {
        light: BENDY,
        translation,
        rotation,
        scale,
        ignore_pins: false,
    };
    let changes = done(&mut document, &place(Some(translation), None, Some(2.0)));
    assert_eq!(changes.len(), 2, "a change each, so that each can be taken back alone");
    let there = Transform { translation, rotation: DQuat::IDENTITY, scale: 2.0 };
    assert_eq!(light_of(&document, BENDY).transform(), there);
    done(&mut document, &place(None, Some(rotation), None));
    assert_eq!(light_of(&document, BENDY).transform(), Transform { rotation, ..there });
    assert_eq!(light_of(&document, BENDY).points(), light_of(&sample(), BENDY).points());
}

/// Rules: CMD-4
#[test]
fn a_present_value_is_no_change() {
    let mut document = sample();
    let none = [DVec3::ZERO, DVec3::new(-0.0, 0.0, -0.0)].map(|translation| Command::PlaceLight {
        light: BENDY,
        translation: Some(translation),
        rotation: Some(DQuat::IDENTITY),
        scale: None,
        ignore_pins: false,
    });
    for command in &none {
        assert_eq!(done(&mut document, command), []);
    }
}

/// Rules: CMD-1
#[test]
fn every_parameter_of_a_light_can_be_set() {
    let (vector, rotation) = (DVec3::new(0.5, 0.25, 0.125), DQuat::from_rotation_y(1.0));
    let mut document = sample();
    let mut set = |light, setting: &Setting| {
        let setting = setting.clone();
        assert_eq!(done(&mut document, &Command::SetLight { light, setting, ignore_pins: false }).len(), 1);
    };
    let both = [
        NAME.to("rim".into()),
        TRANSLATION.to(vector),
        ROTATION.to(rotation),
        SCALE.to(3.0),
        CONE_ANGLE.to(40.0),
        CONE_SOFTNESS.to(0.75),
        DECAY.to(Decay::Linear),
    ];
    for setting in &both {
        set(BENDY, setting);
        set(SPOT, setting);
    }
    for setting in
        [UP.to(vector), FRAME.to(FrameMode::Up), DIRECTION.to(DirectionMode::Path), END_MODE.to(EndMode::Extend)]
    {
        set(BENDY, &setting);
    }
    for setting in [COLOR.to(vector), INTENSITY.to(7.0), RANGE.to(Some(9.0))] {
        set(SPOT, &setting);
    }
    let (bendy, spot) = (light_of(&document, BENDY), light_of(&document, SPOT));
    for light in [bendy, spot] {
        assert_eq!(light.name(), "rim");
        assert_eq!(light.transform(), Transform { translation: vector, rotation, scale: 3.0 });
        assert_eq!((light.get(CONE_ANGLE), light.get(CONE_SOFTNESS)), (40.0, 0.75));
        assert_eq!(light.get(DECAY), Decay::Linear);
    }
    assert_eq!((bendy.get(UP), bendy.get(FRAME)), (vector, FrameMode::Up));
    assert_eq!((bendy.get(DIRECTION), bendy.get(END_MODE)), (DirectionMode::Path, EndMode::Extend));
    assert_eq!((spot.get(COLOR), spot.get(INTENSITY), spot.get(RANGE)), (vector, 7.0, Some(9.0)));
}

/// Rules: CMD-1
#[test]
fn a_parameter_of_the_other_kind_is_refused() {
    let document = sample();
    let of_spot = Command::SetLight { light: BENDY, setting: RANGE.to(None), ignore_pins: false };
    let error = refused(&document, &of_spot);
    assert_eq!(error, EditError::WrongKind { light: "“key”".into(), kind: "BendyLight", what: "range" });
    let of_bendy = Command::SetLight { light: SPOT, setting: FRAME.to(FrameMode::Up), ignore_pins: false };
    let error = refused(&document, &of_bendy);
    assert_eq!(error, EditError::WrongKind { light: "“lamp”".into(), kind: "spotlight", what: "frame" });
}

/// Rules: CMD-1, CMD-2
#[test]
fn numbers_without_a_meaning_are_refused() {
    let document = sample();
    for setting in [
        SCALE.to(0.0),
        SCALE.to(f64::NAN),
        CONE_ANGLE.to(90.0),
        CONE_SOFTNESS.to(-0.1),
        TRANSLATION.to(DVec3::INFINITY),
        ROTATION.to(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ] {
        for light in [BENDY, SPOT] {
            let error = refused(&document, &Command::SetLight { light, setting: setting.clone(), ignore_pins: false });
            assert!(matches!(error, EditError::InvalidLight { .. }), "{setting:?}: {error}");
        }
    }
    let long = NAME.to("x".repeat(MAX_NAME_BYTES + 1));
    let error = refused(&document, &Command::SetLight { light: SPOT, setting: long, ignore_pins: false });
    let sentence = format!("“{}…”: `name` has more than 256 bytes: shorten it", "x".repeat(40));
    assert_eq!(error.to_string(), sentence);
}

/// Rules: CMD-1
#[test]
fn a_document_has_room_for_so_many_lights() {
    let mut document = sample();
    for _ in document.lights().len()..MAX_LIGHTS {
        done(&mut document, &Command::AddLight(checked(bendy())));
    }
    let error = refused(&document, &Command::AddLight(checked(bendy())));
    assert_eq!(error, EditError::TooMany { what: "lights", limit: MAX_LIGHTS });
    done(&mut document, &Command::RemoveLight(BENDY));
    done(&mut document, &Command::AddLight(checked(bendy())));
}
