//! Sample document, and helpers for the two results of a command.

use std::sync::Arc;

use document::{
    AssetHash, CameraId, Change, Command, CommandContext, CommandResult, Document, EditError, PointNumbering,
    SceneContents,
};
use glam::{DQuat, DVec3};
use light::parameters::NAME;
use light::{CheckedLight, Light, LightId, ParameterKey, Setting, ValueType};
use scene::{Camera, Projection};

/// Scene with a BendyLight and a camera.
pub const ROOM: AssetHash = AssetHash([1; 32]);
/// Scene with a spotlight and no camera.
pub const YARD: AssetHash = AssetHash([2; 32]);
/// Scene with the content of [`ROOM`] in other bytes.
pub const ROOM_AGAIN: AssetHash = AssetHash([3; 32]);

/// BendyLight of [`sample`].
pub const BENDY: LightId = LightId(1);
/// Spotlight of [`sample`].
pub const SPOT: LightId = LightId(2);
/// Perspective camera of [`sample`].
pub const EYE: CameraId = CameraId(3);
/// Orthographic camera of [`sample`].
pub const PLAN: CameraId = CameraId(4);

/// Returns the contents of the scenes above.
pub fn find_scene(asset: AssetHash) -> Option<SceneContents> {
    match asset {
        ROOM | ROOM_AGAIN => Some(SceneContents { lights: vec![checked(bendy())], cameras: vec![eye()] }),
        YARD => Some(SceneContents { lights: vec![checked(spot())], cameras: Vec::new() }),
        _ => None,
    }
}

/// Checks a light that must be valid, as documents and commands hold it.
pub fn checked(light: Light) -> Arc<CheckedLight> {
    Arc::new(CheckedLight::new(light).expect("a valid light"))
}

/// Returns a BendyLight with five control points in a gentle bend. All values differ, so that none can replace another.
pub fn bendy() -> Light {
    let points = vec![
        DVec3::ZERO,
        DVec3::new(0.0, 0.0, -1.0),
        DVec3::new(0.25, 0.0, -2.0),
        DVec3::new(0.5, 0.125, -3.0),
        DVec3::new(1.0, 0.25, -4.0),
    ];
    let light = Light::bendy(points, vec![0.125, 0.25, 0.375, 0.5, 0.625]).with(NAME, "key".into());
    light.map_points(|i, point| {
        point.color = DVec3::new(1.0, 0.5, 0.1 * i as f64);
        point.intensity = [1.0, 2.0, 4.0, 8.0, 16.0][i];
    })
}

pub fn spot() -> Light {
    Light::spot().with(NAME, "lamp".into())
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

/// Returns a document without a scene, with two lights and two cameras.
pub fn sample() -> Document {
    let mut document = Document::default();
    done(&mut document, &Command::AddLight(checked(bendy())));
    done(&mut document, &Command::AddLight(checked(spot())));
    done(&mut document, &Command::AddCamera(eye()));
    done(&mut document, &Command::AddCamera(plan()));
    document
}

/// Applies a command, with the scenes above and no geometry.
pub fn edit(document: &Document, command: &Command) -> Result<CommandResult, EditError> {
    let loaded = if let Command::LoadScene { asset, .. } = command { find_scene(*asset) } else { None };
    let context = CommandContext { loaded: loaded.as_ref(), ..CommandContext::default() };
    document::execute_command(document, command, context)
}

/// Executes a command that must be valid.
pub fn done(document: &mut Document, command: &Command) -> Vec<Change> {
    let CommandResult { changes, document: after, .. } = edit(document, command).expect("a valid command");
    document.apply(&changes).expect("changes just made");
    assert_eq!(
        (document.hash(), document.last_number()),
        (after.hash(), after.last_number()),
        "the changes lead to the document after them"
    );
    changes
}

/// Reverts changes just made.
pub fn take_back(document: &mut Document, changes: &[Change]) {
    document.apply(&Change::inverses(changes)).expect("what was done can be taken back");
}

/// Returns the command that sets a parameter of one of [`BENDY`]'s control points.
pub fn set_point(point: usize, setting: Setting) -> Command {
    Command::SetPoint { light: BENDY, point, setting, ignore_pins: false }
}

/// Returns the command that inserts a control point of [`BENDY`] with default values.
pub fn insert(point: usize) -> Command {
    Command::InsertPoint {
        light: BENDY,
        point,
        position: None,
        radius: None,
        color: None,
        intensity: None,
        ignore_pins: false,
    }
}

/// Returns the command that places a light at a position.
pub fn place(light: LightId, position: DVec3) -> Command {
    Command::PlaceLight { light, translation: Some(position), rotation: None, scale: None, ignore_pins: false }
}

/// Returns the error of a command that must be refused.
pub fn refused(document: &Document, command: &Command) -> EditError {
    edit(document, command).expect_err("a command to refuse")
}

/// Returns the change of a light's parameter.
pub fn light_change<T: ValueType>(light: LightId, key: ParameterKey<T>, old: T, new: T) -> Change {
    let (old, new) = (old.into_value(), new.into_value());
    Change::LightParameter { light, parameter: key.row(), old, new }
}

/// Returns the change of a parameter of one of [`BENDY`]'s control points.
pub fn point_change<T: ValueType>(layout: u64, point: usize, key: ParameterKey<T>, old: T, new: T) -> Change {
    let (old, new) = (old.into_value(), new.into_value());
    Change::Point { light: BENDY, layout: PointNumbering(layout), point, parameter: key.row(), old, new }
}

/// Returns the content of the document as text: all of it, more than its hash covers.
pub fn content(document: &Document) -> String {
    let lights = document.lights().iter().map(|(id, placed)| (id, placed.layout, placed.light.light()));
    format!("{:?} {:?} {:?}", document.scene(), lights.collect::<Vec<_>>(), document.cameras())
}

/// Returns the light of a document.
pub fn light_of(document: &Document, id: LightId) -> &Light {
    document.lights()[&id].light.light()
}

/// Returns true if every light can be evaluated and has the digests of its values, and every camera makes a picture.
pub fn is_valid(document: &Document) -> bool {
    let is_checked = |carried: &CheckedLight| {
        CheckedLight::new(carried.light().clone()).is_ok_and(|again| again.revisions() == carried.revisions())
    };
    document.lights().values().all(|placed| is_checked(&placed.light))
        && document.cameras().values().all(|camera| camera.check().is_ok())
}
