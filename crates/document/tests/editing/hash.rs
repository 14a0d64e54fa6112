//! The document's hash: of everything that counts, of nothing else.

use std::collections::BTreeMap;

use document::{CameraParameter, Command, Document, DocumentHash, LightParameter, PointParameter};
use glam::{DQuat, DVec3};
use light::{Decay, Direction, EndMode, Frame};
use scene::Projection;

use crate::support::{BENDY, EYE, PLAN, ROOM, ROOM_AGAIN, SPOT, done, edited, eye, spot};

fn after(command: &Command) -> DocumentHash {
    let mut document = edited();
    done(&mut document, command);
    document.hash()
}

/// A command for each field of a light.
fn light_edits() -> Vec<Command> {
    use LightParameter as P;
    let (vector, rotation) = (DVec3::new(0.5, 0.25, 0.125), DQuat::from_rotation_y(1.0));
    let both = [
        P::Name("rim".into()),
        P::Translation(DVec3::X),
        P::Translation(DVec3::Y),
        P::Translation(DVec3::Z),
        P::Rotation(rotation),
        P::Scale(3.0),
        P::ConeAngle(40.0),
        P::ConeSoftness(0.75),
        P::Decay(Decay::Linear),
    ];
    let mut edits = Vec::new();
    for light in [BENDY, SPOT] {
        edits.extend(both.iter().map(|parameter| Command::SetLight { light, parameter: parameter.clone() }));
    }
    let of_bendy =
        [P::Up(vector), P::Frame(Frame::Up), P::Direction(Direction::Path), P::EndMode(EndMode::Extend)];
    edits.extend(of_bendy.map(|parameter| Command::SetLight { light: BENDY, parameter }));
    let of_spot = [P::Color(vector), P::Intensity(7.0), P::Range(Some(9.0)), P::Range(Some(8.0))];
    edits.extend(of_spot.map(|parameter| Command::SetLight { light: SPOT, parameter }));
    edits.push(Command::SetLight { light: SPOT, parameter: P::Decay(Decay::None) });
    for point in 0..5 {
        let values = [
            PointParameter::Radius(0.3),
            PointParameter::Color(vector),
            PointParameter::Intensity(3.0),
            PointParameter::Position(DVec3::new(0.125, 0.0, -(point as f64))),
        ];
        let allowed = if point == 0 { &values[..3] } else { &values[..] };
        edits.extend(allowed.iter().map(|&parameter| Command::SetPoint { light: BENDY, point, parameter }));
    }
    edits
}

/// A command for each field of a camera, and for what comes and goes.
fn other_edits() -> Vec<Command> {
    let perspective = |yfov, znear, zfar| Projection::Perspective { yfov, aspect_ratio: None, znear, zfar };
    let orthographic = |ymag, znear, zfar| Projection::Orthographic { ymag, aspect_ratio: None, znear, zfar };
    let mut edits: Vec<Command> = [
        (EYE, perspective(0.5, 0.125, None)),
        (EYE, perspective(0.75, 0.25, None)),
        (EYE, perspective(0.75, 0.125, Some(9.0))),
        (EYE, orthographic(2.0, 0.0, 10.0)),
        (PLAN, orthographic(3.0, 0.0, 10.0)),
        (PLAN, orthographic(2.0, 1.0, 10.0)),
        (PLAN, orthographic(2.0, 0.0, 11.0)),
        (EYE, Projection::Perspective { yfov: 0.75, aspect_ratio: Some(1.5), znear: 0.125, zfar: None }),
        (EYE, Projection::Perspective { yfov: 0.75, aspect_ratio: Some(2.0), znear: 0.125, zfar: None }),
        (PLAN, Projection::Orthographic { ymag: 2.0, aspect_ratio: Some(1.5), znear: 0.0, zfar: 10.0 }),
    ]
    .map(|(camera, projection)| {
        let parameter = CameraParameter::Projection(projection);
        Command::SetCamera { camera, parameter }
    })
    .into();
    for camera in [EYE, PLAN] {
        let parameters = [
            CameraParameter::Name("side".into()),
            CameraParameter::Translation(DVec3::ONE),
            CameraParameter::Rotation(DQuat::from_rotation_y(1.0)),
        ];
        edits.extend(parameters.map(|parameter| Command::SetCamera { camera, parameter }));
        edits.push(Command::RemoveCamera(camera));
    }
    edits.extend([BENDY, SPOT].map(Command::RemoveLight));
    edits.push(Command::AddLight(Box::new(spot())));
    edits.push(Command::AddCamera(eye()));
    edits.extend([2, 3].map(|point| Command::RemovePoint { light: BENDY, point }));
    edits.extend([ROOM, ROOM_AGAIN].map(|asset| Command::LoadScene { asset, name: String::new() }));
    edits
}

/// Rules: DOC-4
#[test]
fn every_field_counts() {
    let mut seen = BTreeMap::from([(edited().hash().to_string(), "the document as it was".to_owned())]);
    let edits = [light_edits(), other_edits()].concat();
    assert!(edits.len() > 60);
    for command in edits {
        let what = format!("{command:?}");
        if let Some(other) = seen.insert(after(&command).to_string(), what.clone()) {
            panic!("the same hash after {what} as after {other}");
        }
    }
}

/// Rules: DOC-4
#[test]
fn numbers_count_where_the_rest_is_the_same() {
    let mut renumbered = edited();
    let insert = Command::InsertPoint {
        light: BENDY,
        point: 2,
        position: Some(DVec3::new(0.125, 0.0, -1.5)),
        radius: None,
        color: None,
        intensity: None,
    };
    done(&mut renumbered, &insert);
    done(&mut renumbered, &Command::RemovePoint { light: BENDY, point: 2 });
    assert_eq!(renumbered.lights()[&BENDY].light, edited().lights()[&BENDY].light);
    assert_ne!(renumbered.hash(), edited().hash(), "its layout is another");

    let with_ids = |ids: [u64; 2]| {
        let lights = edited().lights().clone().into_values().zip(ids);
        let lights = lights.map(|(placed, id)| (light::LightId(id), placed)).collect();
        Document::restore(None, lights, BTreeMap::new(), 0).hash()
    };
    assert_ne!(with_ids([1, 2]), with_ids([1, 3]));
}

/// Rules: DOC-4
#[test]
fn what_does_not_count() {
    let set = |x: f64| {
        let parameter = LightParameter::Translation(DVec3::new(x, 1.0, x));
        after(&Command::SetLight { light: SPOT, parameter })
    };
    assert_eq!(set(0.0), set(-0.0));
    assert_ne!(set(0.0), set(f64::MIN_POSITIVE), "but the smallest number is not 0");
    let load = |name: &str| after(&Command::LoadScene { asset: ROOM, name: name.into() });
    assert_eq!(load("room"), load("the same room by another name"));
    let more_numbers = Document::restore(None, edited().lights().clone(), edited().cameras().clone(), 99);
    assert_eq!(more_numbers.hash(), edited().hash(), "numbers given out and free again");
}

/// The hash as it was when the first logs were written. Where this fails, those logs no longer replay: give the walk a
/// new version instead.
///
/// Rules: DOC-4
#[test]
fn the_hash_is_the_same_for_good() {
    let shown = |document: &Document| document.hash().to_string();
    assert_eq!(
        shown(&Document::default()),
        "ec407543169a9f67a67aba9433163b0f2eade4e9ec50e57a9ab2e8730dd944bd"
    );
    assert_eq!(shown(&edited()), "c1440d73969f631976e8eef96e229b50d97180b6084c233a8df2444b9262f6d3");
}
