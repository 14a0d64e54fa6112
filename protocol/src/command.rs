//! Commands and camera parameters in JSON.

use document::{CameraId, ParameterTarget, PinId};
use std::sync::Arc;

use glam::DQuat;
use light::{LightId, ParameterOwner, Setting};
use schemars::JsonSchema;
use serde::de::DeserializeSeed;
use serde::{Deserialize, Serialize};

use crate::error::excerpt;
use crate::parameter::{ValueSeed, unknown};
use crate::vector::{Quat, Vec3};
use crate::words::json_wording;
use crate::{Camera, Drag, DragRadii, Light, LightParameter, Pin, PointParameter, Projection, Refused};

/// [`document::Command`] in JSON. `type` selects the variant (SPEC, section 2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum Command {
    /// Replaces geometry, cameras and lights by those of a scene.
    LoadScene {
        /// Scene: `"demo:NAME"` or `"sha256:HEX"`.
        scene: String,
        /// Name for people. Default: the name from the upload, or the name in the file.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
    },
    /// Adds a light.
    AddLight { light: Light },
    /// Removes a light.
    RemoveLight {
        /// Id of the light.
        light: u64,
    },
    /// Places a light as a whole, or as near to the place as its hard pins allow.
    PlaceLight {
        /// Id of the light.
        light: u64,
        /// World position of the source. Default: no change.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        translation: Option<Vec3>,
        /// Rotation from light-local to world axes. Default: no change.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rotation: Option<Quat>,
        /// World units per light-local unit. Default: no change.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<f64>,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Sets the parameter at an address: `/lights/3/coneAngle`, `/lights/3/points/2/position`,
    /// `/cameras/1/projection`.
    Set {
        /// Address of the parameter.
        target: String,
        /// Value, in the form that the other commands of the parameter take.
        value: serde_json::Value,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Sets one parameter of a light.
    SetLight {
        /// Id of the light.
        light: u64,
        parameter: LightParameter,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Sets one parameter of a control point.
    SetPoint {
        /// Id of the light.
        light: u64,
        /// Index of the control point.
        point: usize,
        parameter: PointParameter,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Moves a control point as near to a position as is possible without a fold of the tube and without breaking a hard
    /// pin.
    DragPoint {
        /// Id of the light.
        light: u64,
        /// Index of the control point, 1 or more.
        point: usize,
        /// Target in light-local space.
        position: Vec3,
        /// Mode of the radii: `keep` (the default) or `follow`, not `solve`.
        #[serde(default)]
        radii: DragRadii,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Drags a shadow, a hotspot, a highlight or the brightest side of a surface to another position in a picture. The
    /// drag keeps the document's pins of the light.
    DragFeature(Box<Drag<u64, Camera>>),
    /// Adds a pin.
    AddPin { pin: Pin },
    /// Removes a pin.
    RemovePin {
        /// Id of the pin in the document.
        pin: u64,
    },
    /// Makes a pin hard or soft.
    SetPin {
        /// Id of the pin in the document.
        pin: u64,
        /// True if every edit keeps the pin. False if only drags of features keep it, as far as they can.
        hard: bool,
    },
    /// Adds a control point.
    InsertPoint {
        /// Id of the light.
        light: u64,
        /// Index of the new point, 1 to the number of points.
        point: usize,
        /// Light-local position. Default: the point at this index is split into two, and the curve hardly
        /// changes.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        position: Option<Vec3>,
        /// Light-local radius. Default: a value between those of the neighbours.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        radius: Option<f64>,
        /// Color in linear RGB. Default: a value between those of the neighbours.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        color: Option<Vec3>,
        /// Intensity. Default: a value between those of the neighbours.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        intensity: Option<f64>,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Removes a control point.
    RemovePoint {
        /// Id of the light.
        light: u64,
        /// Index of the control point, 1 or more.
        point: usize,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Turns a straight light into a BendyLight with the same id. A former spotlight lights every point as
    /// before.
    BendLight {
        /// Id of the light.
        light: u64,
        /// Number of quadratic segments, two less than the number of control points. Default: 3.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        segments: Option<usize>,
        /// Length of the new light along its axis in world units, if the light has no range of its own.
        /// Default: the distance at which the axis meets the scene.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range: Option<f64>,
        /// Half angle of the cone for an omni or directional light, in degrees. Default: 45.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        cone_angle: Option<f64>,
        /// World position at which a former omni or directional light shines. Default: the centre of the scene.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        toward: Option<Vec3>,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Turns a BendyLight into a spotlight with the same id, from its source to its last control point.
    StraightenLight {
        /// Id of the light.
        light: u64,
        /// True if the command may break hard pins.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        ignore_pins: bool,
    },
    /// Adds a camera.
    AddCamera { camera: Camera },
    /// Removes a camera.
    RemoveCamera {
        /// Id of the camera.
        camera: u64,
    },
    /// Places a camera.
    PlaceCamera {
        /// Id of the camera.
        camera: u64,
        /// World position of the eye. Default: no change.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        translation: Option<Vec3>,
        /// Rotation from camera to world axes. Default: no change.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rotation: Option<Quat>,
    },
    /// Sets one parameter of a camera.
    SetCamera {
        /// Id of the camera.
        camera: u64,
        parameter: CameraParameter,
    },
}

/// [`document::CameraParameter`] in JSON: an object with one field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum CameraParameter {
    /// Name for people.
    Name(String),
    /// World position of the eye.
    Translation(Vec3),
    /// Rotation from camera to world axes.
    Rotation(Quat),
    /// Projection.
    Projection(Projection),
}

impl TryFrom<Command> for document::Command {
    type Error = Refused;

    /// Checks all that needs no document: added lights must be valid, and a scene must be named by its hash.
    /// The server has replaced the name of a demo by its hash before.
    fn try_from(wire: Command) -> Result<Self, Refused> {
        Ok(match wire {
            Command::LoadScene { scene, name } => {
                Self::LoadScene { asset: scene.parse()?, name: name.unwrap_or(scene) }
            }
            Command::AddLight { light } => Self::AddLight(Arc::new(light.try_into()?)),
            Command::RemoveLight { light } => Self::RemoveLight(LightId(light)),
            Command::PlaceLight { light, translation, rotation, scale, ignore_pins } => Self::PlaceLight {
                light: LightId(light),
                translation: translation.map(Into::into),
                rotation: rotation.map(DQuat::from_array),
                scale,
                ignore_pins,
            },
            Command::Set { target, value, ignore_pins } => set(&target, &value, ignore_pins)?,
            Command::SetLight { light, parameter, ignore_pins } => {
                Self::SetLight { light: LightId(light), setting: parameter.into(), ignore_pins }
            }
            Command::SetPoint { light, point, parameter, ignore_pins } => {
                Self::SetPoint { light: LightId(light), point, setting: parameter.into(), ignore_pins }
            }
            Command::DragPoint { light, point, position, radii, ignore_pins } => Self::DragPoint {
                light: LightId(light),
                point,
                position: position.into(),
                radii_follow: radii_follow(radii)?,
                ignore_pins,
            },
            Command::DragFeature(drag) => {
                if drag.pins.is_some() {
                    return Err(Refused::DragPins);
                }
                if drag.alternatives {
                    return Err(Refused::DragAlternatives);
                }
                let light = LightId(drag.light);
                Self::DragFeature { light, drag: Box::new(drag.to_domain(drag.camera.clone().into(), |_| true)) }
            }
            Command::AddPin { pin } => Self::AddPin(pin.into()),
            Command::RemovePin { pin } => Self::RemovePin(PinId(pin)),
            Command::SetPin { pin, hard } => Self::SetPin { pin: PinId(pin), is_hard: hard },
            Command::InsertPoint { light, point, position, radius, color, intensity, ignore_pins } => {
                Self::InsertPoint {
                    light: LightId(light),
                    point,
                    position: position.map(Into::into),
                    radius,
                    color: color.map(Into::into),
                    intensity,
                    ignore_pins,
                }
            }
            Command::RemovePoint { light, point, ignore_pins } => {
                Self::RemovePoint { light: LightId(light), point, ignore_pins }
            }
            Command::BendLight { light, segments, range, cone_angle, toward, ignore_pins } => Self::BendLight {
                light: LightId(light),
                segments: segments.unwrap_or(document::DEFAULT_BEND_SEGMENTS),
                range,
                cone_angle,
                toward: toward.map(Into::into),
                ignore_pins,
            },
            Command::StraightenLight { light, ignore_pins } => {
                Self::StraightenLight { light: LightId(light), ignore_pins }
            }
            Command::AddCamera { camera } => Self::AddCamera(camera.into()),
            Command::RemoveCamera { camera } => Self::RemoveCamera(CameraId(camera)),
            Command::PlaceCamera { camera, translation, rotation } => Self::PlaceCamera {
                camera: CameraId(camera),
                translation: translation.map(Into::into),
                rotation: rotation.map(DQuat::from_array),
            },
            Command::SetCamera { camera, parameter } => {
                Self::SetCamera { camera: CameraId(camera), parameter: parameter.into() }
            }
        })
    }
}

/// Returns true if radii follow a dragged control point.
fn radii_follow(radii: DragRadii) -> Result<bool, Refused> {
    match radii {
        DragRadii::Keep => Ok(false),
        DragRadii::Follow => Ok(true),
        DragRadii::Solve => Err(Refused::SolvedRadii),
    }
}

/// Returns the command that sets the parameter at `address`. For a value of the wrong type the error says which
/// type the parameter takes.
fn set(address: &str, value: &serde_json::Value, ignore_pins: bool) -> Result<document::Command, Refused> {
    let refused = |why: String| Refused::Address(format!("`{}` cannot be set: {why}", excerpt(address)));
    let (target, name) = ParameterTarget::from_address(address).ok_or_else(|| {
        refused("write an address as /lights/ID/NAME, /lights/ID/points/INDEX/NAME or /cameras/ID/NAME".into())
    })?;
    let rows = match target {
        ParameterTarget::Light(_) => LightParameter::rows(),
        ParameterTarget::Point(..) => PointParameter::rows(),
        ParameterTarget::Camera(_) => {
            document::parameters().filter(|row| row.for_owner(ParameterOwner::Camera).is_some()).collect()
        }
    };
    let names = || rows.iter().map(|row| row.name);
    let row = rows.iter().copied().find(|row| row.name == name);
    let row = row
        .ok_or_else(|| refused(json_wording(&unknown::<serde_json::Error>("parameter", name, names()).to_string())))?;
    let other_type = || refused(format!("`{name}` must be {}", row.kind));
    let setting = || match ValueSeed(row).deserialize(value) {
        Ok(value) => Ok(Setting { parameter: row, value }),
        Err(_) => Err(other_type()),
    };
    Ok(match target {
        ParameterTarget::Light(light) => document::Command::SetLight { light, setting: setting()?, ignore_pins },
        ParameterTarget::Point(light, point) => {
            document::Command::SetPoint { light, point, setting: setting()?, ignore_pins }
        }
        ParameterTarget::Camera(camera) => {
            let parameter = CameraParameter::deserialize(serde_json::json!({ (name): value }));
            let parameter = parameter.map_err(|_| other_type())?.into();
            document::Command::SetCamera { camera, parameter }
        }
    })
}

impl From<&document::Command> for Command {
    fn from(command: &document::Command) -> Self {
        use document::Command as C;
        match command {
            C::LoadScene { asset, name } => Self::LoadScene { scene: asset.to_string(), name: Some(name.clone()) },
            C::AddLight(light) => Self::AddLight { light: Light::from(&**light) },
            C::RemoveLight(light) => Self::RemoveLight { light: light.0 },
            C::PlaceLight { light, translation, rotation, scale, ignore_pins } => Self::PlaceLight {
                light: light.0,
                translation: translation.map(Into::into),
                rotation: rotation.map(Into::into),
                scale: *scale,
                ignore_pins: *ignore_pins,
            },
            C::SetLight { light, setting, ignore_pins } => {
                Self::SetLight { light: light.0, parameter: setting.clone().into(), ignore_pins: *ignore_pins }
            }
            C::SetPoint { light, point, setting, ignore_pins } => Self::SetPoint {
                light: light.0,
                point: *point,
                parameter: setting.clone().into(),
                ignore_pins: *ignore_pins,
            },
            C::DragPoint { light, point, position, radii_follow, ignore_pins } => Self::DragPoint {
                light: light.0,
                point: *point,
                position: position.to_array(),
                radii: if *radii_follow { DragRadii::Follow } else { DragRadii::Keep },
                ignore_pins: *ignore_pins,
            },
            C::DragFeature { light, drag } => {
                Self::DragFeature(Box::new(Drag::new(light.0, (&drag.view.camera).into(), drag)))
            }
            C::AddPin(pin) => Self::AddPin { pin: pin.into() },
            C::RemovePin(pin) => Self::RemovePin { pin: pin.0 },
            C::SetPin { pin, is_hard } => Self::SetPin { pin: pin.0, hard: *is_hard },
            C::InsertPoint { light, point, position, radius, color, intensity, ignore_pins } => Self::InsertPoint {
                light: light.0,
                point: *point,
                position: position.map(Into::into),
                radius: *radius,
                color: color.map(Into::into),
                intensity: *intensity,
                ignore_pins: *ignore_pins,
            },
            C::RemovePoint { light, point, ignore_pins } => {
                Self::RemovePoint { light: light.0, point: *point, ignore_pins: *ignore_pins }
            }
            C::BendLight { light, segments, range, cone_angle, toward, ignore_pins } => Self::BendLight {
                light: light.0,
                segments: Some(*segments),
                range: *range,
                cone_angle: *cone_angle,
                toward: toward.map(Into::into),
                ignore_pins: *ignore_pins,
            },
            C::StraightenLight { light, ignore_pins } => {
                Self::StraightenLight { light: light.0, ignore_pins: *ignore_pins }
            }
            C::AddCamera(camera) => Self::AddCamera { camera: camera.into() },
            C::RemoveCamera(camera) => Self::RemoveCamera { camera: camera.0 },
            C::PlaceCamera { camera, translation, rotation } => Self::PlaceCamera {
                camera: camera.0,
                translation: translation.map(Into::into),
                rotation: rotation.map(Into::into),
            },
            C::SetCamera { camera, parameter } => {
                Self::SetCamera { camera: camera.0, parameter: parameter.clone().into() }
            }
        }
    }
}

impl From<CameraParameter> for document::CameraParameter {
    fn from(wire: CameraParameter) -> Self {
        match wire {
            CameraParameter::Name(name) => Self::Name(name),
            CameraParameter::Translation(translation) => Self::Translation(translation.into()),
            CameraParameter::Rotation(rotation) => Self::Rotation(DQuat::from_array(rotation)),
            CameraParameter::Projection(projection) => Self::Projection(projection.into()),
        }
    }
}

impl From<document::CameraParameter> for CameraParameter {
    fn from(parameter: document::CameraParameter) -> Self {
        use document::CameraParameter as P;
        match parameter {
            P::Name(name) => Self::Name(name),
            P::Translation(translation) => Self::Translation(translation.to_array()),
            P::Rotation(rotation) => Self::Rotation(rotation.to_array()),
            P::Projection(projection) => Self::Projection(projection.into()),
        }
    }
}
