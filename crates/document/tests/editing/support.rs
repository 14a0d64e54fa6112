//! A document to edit, and the two things that can come of a command.

use std::sync::Arc;

use document::{AssetHash, CameraId, Change, Command, Document, EditError, changes_of};
use glam::{DQuat, DVec3};
use light::{BendyLight, SpotLight, Tube};
use light::{Light, LightId, LightKind};
use scene::{Camera, Projection, Scene};

/// A scene with a BendyLight and a camera.
pub const ROOM: AssetHash = AssetHash([1; 32]);
/// A scene with a spotlight, and no camera.
pub const YARD: AssetHash = AssetHash([2; 32]);
/// [`ROOM`] in other bytes.
pub const ROOM_AGAIN: AssetHash = AssetHash([3; 32]);

/// The BendyLight of [`edited`].
pub const BENDY: LightId = LightId(1);
/// The spotlight of [`edited`].
pub const SPOT: LightId = LightId(2);
/// The camera of [`edited`] with perspective.
pub const EYE: CameraId = CameraId(3);
/// The orthographic camera of [`edited`].
pub const PLAN: CameraId = CameraId(4);

/// Finds the scenes above.
pub fn find_scene(asset: &AssetHash) -> Option<Arc<Scene>> {
    let scene = match *asset {
        ROOM | ROOM_AGAIN => Scene { lights: vec![bendy()], cameras: vec![eye()], ..Scene::default() },
        YARD => Scene { lights: vec![spot()], ..Scene::default() },
        _ => return None,
    };
    Some(Arc::new(scene))
}

/// Five control points in a gentle bend; no two values alike, so that none can stand for another.
pub fn bendy() -> Light {
    let points = vec![
        DVec3::ZERO,
        DVec3::new(0.0, 0.0, -1.0),
        DVec3::new(0.25, 0.0, -2.0),
        DVec3::new(0.5, 0.125, -3.0),
        DVec3::new(1.0, 0.25, -4.0),
    ];
    let mut light = BendyLight::new(points, vec![0.125, 0.25, 0.375, 0.5, 0.625]);
    light.colors = (0..5).map(|i| DVec3::new(1.0, 0.5, 0.1 * f64::from(i))).collect();
    light.intensities = vec![1.0, 2.0, 4.0, 8.0, 16.0];
    Light { name: "key".into(), kind: LightKind::Bendy(light) }
}

pub fn spot() -> Light {
    Light { name: "lamp".into(), kind: LightKind::Spot(SpotLight::default()) }
}

pub fn eye() -> Camera {
    let projection = Projection::Perspective { yfov: 0.75, aspect_ratio: None, znear: 0.125, zfar: None };
    let (translation, rotation) = (DVec3::new(0.0, 1.0, 5.0), DQuat::IDENTITY);
    Camera { name: "eye".into(), translation, rotation, projection }
}

pub fn plan() -> Camera {
    let projection = Projection::Orthographic { ymag: 2.0, aspect_ratio: None, znear: 0.0, zfar: 10.0 };
    Camera { name: "plan".into(), projection, ..eye() }
}

/// A document without a scene, with two lights and two cameras.
pub fn edited() -> Document {
    let mut document = Document::default();
    done(&mut document, &Command::AddLight(Box::new(bendy())));
    done(&mut document, &Command::AddLight(Box::new(spot())));
    done(&mut document, &Command::AddCamera(eye()));
    done(&mut document, &Command::AddCamera(plan()));
    document
}

/// Carries out a command that must be valid.
pub fn done(document: &mut Document, command: &Command) -> Vec<Change> {
    let changes = changes_of(document, command, &find_scene).expect("a valid command");
    document.apply(&changes, &find_scene).expect("changes just made");
    changes
}

/// Why a command is refused, which must leave everything as it was.
pub fn refused(document: &Document, command: &Command) -> EditError {
    changes_of(document, command, &find_scene).expect_err("a command to refuse")
}

/// What the document holds, as text: all of it, more than its hash says.
pub fn content(document: &Document) -> String {
    format!("{:?} {:?} {:?}", document.scene_ref(), document.lights(), document.cameras())
}

pub fn bendy_of(document: &Document, id: LightId) -> &BendyLight {
    match &document.lights()[&id].light.kind {
        LightKind::Bendy(bendy) => bendy,
        LightKind::Spot(_) => panic!("a spotlight"),
    }
}

pub fn spot_of(document: &Document, id: LightId) -> &SpotLight {
    match &document.lights()[&id].light.kind {
        LightKind::Spot(spot) => spot,
        LightKind::Bendy(_) => panic!("a BendyLight"),
    }
}

/// Whether every light can be evaluated and every camera makes a picture.
pub fn is_valid(document: &Document) -> bool {
    let lights = document.lights().values().all(|placed| match &placed.light.kind {
        LightKind::Bendy(bendy) => Tube::<f64>::new(bendy).is_ok(),
        LightKind::Spot(spot) => light::check_spot(spot).is_ok(),
    });
    lights && document.cameras().values().all(|camera| camera.check().is_ok())
}
