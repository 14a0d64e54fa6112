//! Hash of the document: it covers all content and nothing else.

use std::collections::BTreeMap;

use document::{CameraParameter, Command, Document, DocumentHash};
use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, INTENSITY, NAME, POINT_COLOR, POINT_INTENSITY,
    POSITION, RADIUS, RANGE, ROTATION, SCALE, TRANSLATION, UP,
};
use light::{Decay, DirectionMode, EndMode, FrameMode, LightId, Setting};
use scene::Projection;

use crate::support::{BENDY, EYE, PLAN, ROOM, ROOM_AGAIN, SPOT, checked, done, eye, light_of, sample, spot};

pub type Hash = fn(&Document) -> DocumentHash;

/// Current hash, and that of formats 1 and 2.
pub const HASHES: [Hash; 2] = [Document::hash, |document| document.hash_of_format(2)];

fn after(command: &Command) -> Document {
    let mut document = sample();
    done(&mut document, command);
    document
}

/// Returns a command for each field of a light.
fn light_edits() -> Vec<Command> {
    let (vector, rotation) = (DVec3::new(0.5, 0.25, 0.125), DQuat::from_rotation_y(1.0));
    let both = [
        NAME.to("rim".into()),
        TRANSLATION.to(DVec3::X),
        TRANSLATION.to(DVec3::Y),
        TRANSLATION.to(DVec3::Z),
        ROTATION.to(rotation),
        SCALE.to(3.0),
        CONE_ANGLE.to(40.0),
        CONE_SOFTNESS.to(0.75),
        DECAY.to(Decay::Linear),
    ];
    let mut edits = Vec::new();
    for light in [BENDY, SPOT] {
        edits.extend(both.iter().map(|setting| Command::SetLight {
            light,
            setting: setting.clone(),
            ignore_pins: false,
        }));
    }
    let of_bendy =
        [UP.to(vector), FRAME.to(FrameMode::Up), DIRECTION.to(DirectionMode::Path), END_MODE.to(EndMode::Extend)];
    edits.extend(of_bendy.map(|setting| Command::SetLight { light: BENDY, setting, ignore_pins: false }));
    let of_spot = [COLOR.to(vector), INTENSITY.to(7.0), RANGE.to(Some(9.0)), RANGE.to(Some(8.0))];
    edits.extend(of_spot.map(|setting| Command::SetLight { light: SPOT, setting, ignore_pins: false }));
    edits.push(Command::SetLight { light: SPOT, setting: DECAY.to(Decay::None), ignore_pins: false });
    for point in 0..5 {
        let values = [
            RADIUS.to(0.3),
            POINT_COLOR.to(vector),
            POINT_INTENSITY.to(3.0),
            POSITION.to(DVec3::new(0.125, 0.0, -(point as f64))),
        ];
        let allowed = if point == 0 { &values[..3] } else { &values[..] };
        let edit =
            |setting: &Setting| Command::SetPoint { light: BENDY, point, setting: setting.clone(), ignore_pins: false };
        edits.extend(allowed.iter().map(edit));
    }
    edits
}

/// Returns a command for each field of a camera, and for additions and removals.
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
    edits.push(Command::AddLight(checked(spot())));
    edits.push(Command::AddCamera(eye()));
    edits.extend([2, 3].map(|point| Command::RemovePoint { light: BENDY, point, ignore_pins: false }));
    edits.extend([ROOM, ROOM_AGAIN].map(|asset| Command::LoadScene { asset, name: String::new() }));
    edits
}

/// Asserts that the hashes of the named `documents` and of `plain` are all different.
pub fn all_differ(hash: Hash, plain: &Document, documents: &[(String, Document)]) {
    let mut seen = BTreeMap::from([(hash(plain).to_string(), "nothing")]);
    for (what, document) in documents {
        if let Some(other) = seen.insert(hash(document).to_string(), what) {
            panic!("the same hash after {what} as after {other}");
        }
    }
}

/// Rules: DOC-4
#[test]
fn every_field_counts() {
    let edits = [light_edits(), other_edits()].concat();
    assert!(edits.len() > 60);
    let documents: Vec<_> = edits.iter().map(|command| (format!("{command:?}"), after(command))).collect();
    for hash in HASHES {
        all_differ(hash, &sample(), &documents);
    }
}

/// Rules: DOC-4
#[test]
fn numbers_count_where_the_rest_is_the_same() {
    let mut renumbered = sample();
    let (position, radius, color, intensity) = (Some(DVec3::new(0.125, 0.0, -1.5)), None, None, None);
    done(
        &mut renumbered,
        &Command::InsertPoint { light: BENDY, point: 2, position, radius, color, intensity, ignore_pins: false },
    );
    done(&mut renumbered, &Command::RemovePoint { light: BENDY, point: 2, ignore_pins: false });
    assert_eq!(light_of(&renumbered, BENDY), light_of(&sample(), BENDY));
    for hash in HASHES {
        assert_ne!(hash(&renumbered), hash(&sample()), "its layout is another");
    }

    let with_ids = |ids: [u64; 2]| {
        let lights = sample().lights().clone().into_values().zip(ids);
        let lights = lights.map(|(placed, id)| (LightId(id), placed)).collect();
        Document::restore(None, lights, BTreeMap::new(), BTreeMap::new(), 0)
    };
    for hash in HASHES {
        assert_ne!(hash(&with_ids([1, 2])), hash(&with_ids([1, 3])));
    }
}

/// Rules: DOC-4
#[test]
fn labels_and_freed_numbers_leave_the_hash() {
    let more_numbers =
        Document::restore(None, sample().lights().clone(), sample().cameras().clone(), BTreeMap::new(), 99);
    for hash in HASHES {
        let set = |x: f64| {
            let setting = TRANSLATION.to(DVec3::new(x, 1.0, x));
            hash(&after(&Command::SetLight { light: SPOT, setting, ignore_pins: false }))
        };
        assert_eq!(set(0.0), set(-0.0));
        assert_ne!(set(0.0), set(f64::MIN_POSITIVE), "but the smallest number is not 0");
        let load = |name: &str| hash(&after(&Command::LoadScene { asset: ROOM, name: name.into() }));
        assert_eq!(load("room"), load("the same room by another name"));
        assert_eq!(hash(&more_numbers), hash(&sample()), "numbers given out and free again");
    }
}

/// Hashes from the time when the first logs of each format were written. If this fails, those logs no longer replay:
/// give the hash a new version instead.
///
/// Rules: DOC-4
#[test]
fn the_hash_is_the_same_for_good() {
    // Hashes of formats 1 and 2, then of 3; that of an empty document first.
    let walked = [
        "ec407543169a9f67a67aba9433163b0f2eade4e9ec50e57a9ab2e8730dd944bd",
        "c1440d73969f631976e8eef96e229b50d97180b6084c233a8df2444b9262f6d3",
    ];
    let by_rows = [
        "3195b0a1a469905805246db0a0658108b9d3d9a2b748b6625b93fd277cf407a8",
        "5c53891eb2ef8b449cb1a0337b9aa3bf370929917589c75395096b1e25b44d24",
    ];
    for (format, expected) in [(1, walked), (2, walked), (3, by_rows)] {
        let hashes = [Document::default(), sample()].map(|it| it.hash_of_format(format).to_string());
        assert_eq!(hashes, expected, "format {format}");
    }
    assert_eq!(sample().hash(), sample().hash_of_format(3), "the hash of today");
}
