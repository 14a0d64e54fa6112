//! Commands on cameras.

use document::{CameraId, CameraParameter, Change, Command, Document, EditError, MAX_CAMERAS};
use glam::{DQuat, DVec3};
use light::MAX_NAME_BYTES;
use scene::Projection;

use crate::support::{EYE, PLAN, done, eye, plan, refused, sample};

fn set(parameter: CameraParameter) -> Command {
    Command::SetCamera { camera: EYE, parameter }
}

/// Rules: DOC-1, DOC-3, CMD-3
#[test]
fn cameras_come_and_go_and_are_placed() {
    let mut document = sample();
    done(&mut document, &Command::AddCamera(plan()));
    assert_eq!(document.cameras()[&CameraId(5)], plan());
    let (translation, rotation) = (DVec3::new(4.0, 5.0, 6.0), DQuat::from_rotation_y(0.25));
    let place = Command::PlaceCamera { camera: EYE, translation: Some(translation), rotation: Some(rotation) };
    assert_eq!(done(&mut document, &place).len(), 2);
    let expected = scene::Camera { translation, rotation, ..eye() };
    assert_eq!(document.cameras()[&EYE], expected);
    let stay = Command::PlaceCamera { camera: EYE, translation: None, rotation: Some(rotation) };
    assert_eq!(done(&mut document, &stay), []);
    done(&mut document, &Command::RemoveCamera(EYE));
    assert_eq!(refused(&document, &place), EditError::NoCamera(EYE));
    assert_eq!(refused(&document, &Command::RemoveCamera(EYE)), EditError::NoCamera(EYE));
    assert_eq!(document.cameras().len(), 2);
}

/// Rules: DOC-3
#[test]
fn every_parameter_of_a_camera_can_be_set() {
    let mut document = sample();
    let (translation, rotation) = (DVec3::new(4.0, 5.0, 6.0), DQuat::from_rotation_y(0.25));
    let projection = Projection::Orthographic { ymag: 1.0, aspect_ratio: None, znear: 0.5, zfar: 2.0 };
    for parameter in [
        CameraParameter::Name("side".into()),
        CameraParameter::Translation(translation),
        CameraParameter::Rotation(rotation),
        CameraParameter::Projection(projection),
    ] {
        let changes = done(&mut document, &set(parameter));
        assert!(matches!(changes[..], [Change::CameraParameter { camera: EYE, .. }]));
    }
    let expected = scene::Camera { name: "side".into(), translation, rotation, projection };
    assert_eq!((&document.cameras()[&EYE], &document.cameras()[&PLAN]), (&expected, &plan()));
}

/// Rules: CMD-1, DOC-3
#[test]
fn cameras_that_make_no_picture_are_refused() {
    let document = sample();
    let perspective = |yfov, znear, zfar| Projection::Perspective { yfov, aspect_ratio: None, znear, zfar };
    let orthographic = |ymag, znear, zfar| Projection::Orthographic { ymag, aspect_ratio: None, znear, zfar };
    for projection in [
        perspective(0.0, 0.1, None),
        perspective(4.0, 0.1, None),
        perspective(0.5, 0.0, None),
        perspective(0.5, 1.0, Some(1.0)),
        perspective(0.5, 1.0, Some(f64::INFINITY)),
        orthographic(0.0, 0.0, 1.0),
        orthographic(1.0, -0.1, 1.0),
        orthographic(1.0, 2.0, 1.0),
        orthographic(f64::NAN, 0.0, 1.0),
        Projection::Perspective { yfov: 0.5, aspect_ratio: Some(0.0), znear: 0.1, zfar: None },
        Projection::Orthographic { ymag: 1.0, aspect_ratio: Some(f64::INFINITY), znear: 0.0, zfar: 1.0 },
    ] {
        let error = refused(&document, &set(CameraParameter::Projection(projection)));
        assert!(matches!(error, EditError::InvalidCamera(_)), "{projection:?}: {error}");
        let new = scene::Camera { projection, ..eye() };
        assert!(matches!(refused(&document, &Command::AddCamera(new)), EditError::InvalidCamera(_)));
    }
    let long = CameraParameter::Rotation(DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0));
    assert!(matches!(refused(&document, &set(long)), EditError::InvalidCamera(_)));
    let far = CameraParameter::Translation(DVec3::NAN);
    assert!(matches!(refused(&document, &set(far)), EditError::InvalidCamera(_)));
    let name = CameraParameter::Name("x".repeat(MAX_NAME_BYTES + 1));
    let error = refused(&document, &set(name));
    assert_eq!(error.to_string(), "`name` has more than 256 bytes: shorten it");
}

/// Rules: CMD-1
#[test]
fn a_document_has_room_for_so_many_cameras() {
    let mut document = Document::default();
    for _ in 0..MAX_CAMERAS {
        done(&mut document, &Command::AddCamera(eye()));
    }
    let error = refused(&document, &Command::AddCamera(eye()));
    assert_eq!(error, EditError::TooMany { what: "cameras", limit: MAX_CAMERAS });
}
