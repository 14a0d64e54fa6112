//! Commands on whole lights.

use document::{Change, Command, EditError, LightParameter, MAX_LIGHTS, MAX_NAME_BYTES};
use glam::{DQuat, DVec3};
use light::LightId;
use light::{Decay, Direction, EndMode, Frame};

use crate::support::{BENDY, SPOT, bendy, bendy_of, content, done, edited, refused, spot, spot_of};

/// Rules: DOC-1, CMD-3
#[test]
fn lights_come_and_go() {
    let mut document = edited();
    let changes = done(&mut document, &Command::AddLight(Box::new(spot())));
    let id = LightId(5);
    assert!(matches!(&changes[..], [Change::Light { light: LightId(5), old: None, new: Some(_) }]));
    assert_eq!(document.lights()[&id].light, spot());
    done(&mut document, &Command::RemoveLight(id));
    assert!(!document.lights().contains_key(&id));
    assert_eq!(refused(&document, &Command::RemoveLight(id)), EditError::NoLight(id));
    assert_eq!(content(&document), content(&edited()));
}

/// Rules: REC-2
#[test]
fn placing_a_light_changes_what_is_given_and_no_more() {
    let mut document = edited();
    let (translation, rotation) = (DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_x(0.5));
    let place =
        |translation, rotation, scale| Command::PlaceLight { light: BENDY, translation, rotation, scale };
    let changes = done(&mut document, &place(Some(translation), None, Some(2.0)));
    assert_eq!(changes.len(), 2, "a change each, so that each can be taken back alone");
    let transform = bendy_of(&document, BENDY).transform;
    assert_eq!(
        (transform.translation, transform.rotation, transform.scale),
        (translation, DQuat::IDENTITY, 2.0)
    );
    done(&mut document, &place(None, Some(rotation), None));
    assert_eq!(bendy_of(&document, BENDY).transform.rotation, rotation);
    assert_eq!(bendy_of(&document, BENDY).transform.translation, translation);
    assert_eq!(bendy_of(&document, BENDY).points, bendy_of(&edited(), BENDY).points);
}

/// Rules: CMD-4
#[test]
fn what_is_so_already_is_no_change() {
    let mut document = edited();
    let none = [DVec3::ZERO, DVec3::new(-0.0, 0.0, -0.0)].map(|translation| Command::PlaceLight {
        light: BENDY,
        translation: Some(translation),
        rotation: Some(DQuat::IDENTITY),
        scale: None,
    });
    for command in &none {
        assert_eq!(done(&mut document, command), []);
    }
}

/// Rules: CMD-1
#[test]
fn every_parameter_of_a_light_can_be_set() {
    use LightParameter as P;
    let (vector, rotation) = (DVec3::new(0.5, 0.25, 0.125), DQuat::from_rotation_y(1.0));
    let mut document = edited();
    let mut set = |light, parameter: &P| {
        let parameter = parameter.clone();
        assert_eq!(done(&mut document, &Command::SetLight { light, parameter }).len(), 1);
    };
    let both = [
        P::Name("rim".into()),
        P::Translation(vector),
        P::Rotation(rotation),
        P::Scale(3.0),
        P::ConeAngle(40.0),
        P::ConeSoftness(0.75),
        P::Decay(Decay::Linear),
    ];
    for parameter in &both {
        set(BENDY, parameter);
        set(SPOT, parameter);
    }
    for parameter in
        [P::Up(vector), P::Frame(Frame::Up), P::Direction(Direction::Path), P::EndMode(EndMode::Extend)]
    {
        set(BENDY, &parameter);
    }
    for parameter in [P::Color(vector), P::Intensity(7.0), P::Range(Some(9.0))] {
        set(SPOT, &parameter);
    }
    let (bendy, spot) = (bendy_of(&document, BENDY), spot_of(&document, SPOT));
    for transform in [bendy.transform, spot.transform] {
        assert_eq!((transform.translation, transform.rotation, transform.scale), (vector, rotation, 3.0));
    }
    assert_eq!((bendy.cone_angle, bendy.cone_softness, bendy.decay), (40.0, 0.75, Decay::Linear));
    assert_eq!((spot.cone_angle, spot.cone_softness, spot.decay), (40.0, 0.75, Decay::Linear));
    assert_eq!((bendy.up, bendy.frame), (vector, Frame::Up));
    assert_eq!((bendy.direction, bendy.end_mode), (Direction::Path, EndMode::Extend));
    assert_eq!((spot.color, spot.intensity, spot.range), (vector, 7.0, Some(9.0)));
    assert!(document.lights().values().all(|placed| placed.light.name == "rim"));
}

/// Rules: CMD-1
#[test]
fn a_parameter_of_the_other_kind_is_refused() {
    let document = edited();
    let of_spot = Command::SetLight { light: BENDY, parameter: LightParameter::Range(None) };
    let error = refused(&document, &of_spot);
    assert_eq!(error, EditError::WrongKind { light: "“key”".into(), kind: "BendyLight", what: "range" });
    let of_bendy = Command::SetLight { light: SPOT, parameter: LightParameter::Frame(Frame::Up) };
    let error = refused(&document, &of_bendy);
    assert_eq!(error, EditError::WrongKind { light: "“lamp”".into(), kind: "spotlight", what: "frame" });
}

/// Rules: CMD-1, CMD-2
#[test]
fn numbers_without_a_meaning_are_refused() {
    use LightParameter as P;
    let document = edited();
    for parameter in [
        P::Scale(0.0),
        P::Scale(f64::NAN),
        P::ConeAngle(90.0),
        P::ConeSoftness(-0.1),
        P::Translation(DVec3::INFINITY),
        P::Rotation(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ] {
        for light in [BENDY, SPOT] {
            let error = refused(&document, &Command::SetLight { light, parameter: parameter.clone() });
            assert!(matches!(error, EditError::InvalidLight { .. }), "{parameter:?}: {error}");
        }
    }
    let long = LightParameter::Name("x".repeat(MAX_NAME_BYTES + 1));
    let error = refused(&document, &Command::SetLight { light: SPOT, parameter: long });
    assert!(matches!(error, EditError::TooMany { .. }));
}

/// Rules: CMD-1
#[test]
fn a_document_has_room_for_so_many_lights() {
    let mut document = edited();
    for _ in document.lights().len()..MAX_LIGHTS {
        done(&mut document, &Command::AddLight(Box::new(bendy())));
    }
    let error = refused(&document, &Command::AddLight(Box::new(bendy())));
    assert_eq!(error, EditError::TooMany { what: "lights", limit: MAX_LIGHTS });
    done(&mut document, &Command::RemoveLight(BENDY));
    done(&mut document, &Command::AddLight(Box::new(bendy())));
}
