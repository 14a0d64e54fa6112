//! Commands and their parameters in JSON.

use document::{CameraId, FeatureDrag, ParameterTarget, PinId};
use drag::Viewport;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::{LightId, ParameterOwner, Setting};
use schemars::JsonSchema;
use serde::de::DeserializeSeed;
use serde::{Deserialize, Serialize};

use crate::document::{Quat, Vec3};
use crate::error::excerpt;
use crate::parameter::{ValueSeed, unknown};
use crate::words::json_wording;
use crate::{Camera, DragKind, DragRadii, Light, LightParameter, Pin, PointParameter, Projection, Refused};

/// [`document::Command`] in JSON; `type` says which (SPEC, section 2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum Command {
    /// Replaces geometry, cameras and lights by those of a scene.
    LoadScene {
        /// `"demo:NAME"` or `"sha256:HEX"`.
        scene: String,
        /// What people call it; by default what it was uploaded as, or what its file calls it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
    },
    /// Adds a light.
    AddLight {
        /// The light.
        light: Light,
    },
    /// Removes a light.
    RemoveLight {
        /// Its id.
        light: u64,
    },
    /// Places a whole light.
    PlaceLight {
        /// Its id.
        light: u64,
        /// World position of its source; stays by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        translation: Option<Vec3>,
        /// Light-local to world axes; stays by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rotation: Option<Quat>,
        /// World units per light-local unit; stays by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<f64>,
    },
    /// Sets what an address names: `/lights/3/coneAngle`, `/lights/3/points/2/position`, `/cameras/1/projection`.
    Set {
        /// The address.
        target: String,
        /// The value, as the parameter's other commands take it.
        value: serde_json::Value,
    },
    /// Sets one parameter of a light.
    SetLight {
        /// Its id.
        light: u64,
        /// The parameter.
        parameter: LightParameter,
    },
    /// Sets one parameter of a control point.
    SetPoint {
        /// Its light's id.
        light: u64,
        /// Its index.
        point: usize,
        /// The parameter.
        parameter: PointParameter,
    },
    /// Drags a control point: it goes as near to a position as it can without the tube folding.
    DragPoint {
        /// Its light's id.
        light: u64,
        /// Its index, 1 or more.
        point: usize,
        /// Where it is to go, in light-local space.
        position: Vec3,
        /// What becomes of radii, not `solve`; they stay by default.
        #[serde(default)]
        radii: DragRadii,
    },
    /// Drags a shadow, a hotspot, a highlight or the brightest side of a surface to another place of a picture; the document's
    /// pins of the light stay.
    DragFeature {
        /// The light's id.
        light: u64,
        /// What is dragged.
        kind: DragKind,
        /// The control points that take part; without them the light moves as a whole.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        points: Option<Vec<usize>>,
        /// What becomes of radii; they stay by default.
        #[serde(default)]
        radii: DragRadii,
        /// Who looks.
        camera: Camera,
        /// Width and height of the picture, in pixels.
        size: [u32; 2],
        /// Where the feature is taken, in pixels from the picture's top left corner; a pixel's centre is at .5.
        from: [f64; 2],
        /// Where it goes.
        to: [f64; 2],
        /// Whether the source may not go through a surface.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        source_outside: bool,
    },
    /// Adds a pin.
    AddPin {
        /// What it holds, and of which light.
        pin: Pin,
    },
    /// Removes a pin.
    RemovePin {
        /// Id of one of the document's.
        pin: u64,
    },
    /// Makes a pin hard or soft.
    SetPin {
        /// Id of one of the document's.
        pin: u64,
        /// Whether it stays whatever is asked, or as far as that lets it.
        hard: bool,
    },
    /// Adds a control point.
    InsertPoint {
        /// The light's id.
        light: u64,
        /// The index that the new point gets, 1 to the number of points.
        point: usize,
        /// Light-local position. By default the point there becomes two, and the curve stays nearly as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        position: Option<Vec3>,
        /// Light-local radius; between its neighbours' by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        radius: Option<f64>,
        /// Linear RGB; between its neighbours' by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        color: Option<Vec3>,
        /// Between its neighbours' by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        intensity: Option<f64>,
    },
    /// Removes a control point.
    RemovePoint {
        /// The light's id.
        light: u64,
        /// Its index, 1 or more.
        point: usize,
    },
    /// Makes a straight light a BendyLight under the same id. One that was a spotlight lights every point as it did.
    BendLight {
        /// Its id.
        light: u64,
        /// Quadratic segments: two control points fewer than it gets. 3 by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        segments: Option<usize>,
        /// How far its control points reach along its axis, in world units, where it has no range of its own; by default to
        /// where its axis meets the scene.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range: Option<f64>,
        /// Half angle of the cone that an omni or directional light is given, in degrees; 45 by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        cone_angle: Option<f64>,
        /// World position at which such a light then shines, the scene's middle by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        toward: Option<Vec3>,
    },
    /// Makes a BendyLight a spotlight under the same id, from its source to its last control point.
    StraightenLight {
        /// Its id.
        light: u64,
    },
    /// Adds a camera.
    AddCamera {
        /// The camera.
        camera: Camera,
    },
    /// Removes a camera.
    RemoveCamera {
        /// Its id.
        camera: u64,
    },
    /// Places a camera.
    PlaceCamera {
        /// Its id.
        camera: u64,
        /// World position of the eye; stays by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        translation: Option<Vec3>,
        /// Camera to world axes; stays by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rotation: Option<Quat>,
    },
    /// Sets one parameter of a camera.
    SetCamera {
        /// Its id.
        camera: u64,
        /// The parameter.
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
    /// Camera to world axes.
    Rotation(Quat),
    /// How it projects.
    Projection(Projection),
}

impl TryFrom<Command> for document::Command {
    type Error = Refused;

    /// What can be said without a document: lights that are added are valid, and a scene is named by its bytes (the server
    /// has put a hash in place of a demo's name).
    fn try_from(wire: Command) -> Result<Self, Refused> {
        let vector = |v: Option<Vec3>| v.map(DVec3::from);
        let rotation = |q: Option<Quat>| q.map(DQuat::from_array);
        Ok(match wire {
            Command::LoadScene { scene, name } => {
                Self::LoadScene { asset: scene.parse()?, name: name.unwrap_or(scene) }
            }
            Command::AddLight { light } => Self::AddLight(Arc::new(light.try_into()?)),
            Command::RemoveLight { light } => Self::RemoveLight(LightId(light)),
            Command::PlaceLight { light, translation, rotation: r, scale } => Self::PlaceLight {
                light: LightId(light),
                translation: vector(translation),
                rotation: rotation(r),
                scale,
            },
            Command::Set { target, value } => set(&target, &value)?,
            Command::SetLight { light, parameter } => {
                Self::SetLight { light: LightId(light), setting: parameter.into() }
            }
            Command::SetPoint { light, point, parameter } => {
                Self::SetPoint { light: LightId(light), point, setting: parameter.into() }
            }
            Command::DragPoint { light, point, position, radii } => Self::DragPoint {
                light: LightId(light),
                point,
                position: position.into(),
                radii_follow: radii_follow(radii)?,
            },
            Command::DragFeature { light, kind, points, radii, camera, size, from, to, source_outside } => {
                Self::DragFeature {
                    light: LightId(light),
                    drag: Box::new(FeatureDrag {
                        feature: kind.into(),
                        points,
                        radii: radii.into(),
                        view: Viewport { camera: camera.into(), size },
                        from: from.into(),
                        to: to.into(),
                        source_outside,
                    }),
                }
            }
            Command::AddPin { pin } => Self::AddPin(pin.into()),
            Command::RemovePin { pin } => Self::RemovePin(PinId(pin)),
            Command::SetPin { pin, hard } => Self::SetPin { pin: PinId(pin), is_hard: hard },
            Command::InsertPoint { light, point, position, radius, color, intensity } => Self::InsertPoint {
                light: LightId(light),
                point,
                position: vector(position),
                radius,
                color: vector(color),
                intensity,
            },
            Command::RemovePoint { light, point } => Self::RemovePoint { light: LightId(light), point },
            Command::BendLight { light, segments, range, cone_angle, toward } => Self::BendLight {
                light: LightId(light),
                segments: segments.unwrap_or(document::DEFAULT_BEND_SEGMENTS),
                range,
                cone_angle,
                toward: vector(toward),
            },
            Command::StraightenLight { light } => Self::StraightenLight(LightId(light)),
            Command::AddCamera { camera } => Self::AddCamera(camera.into()),
            Command::RemoveCamera { camera } => Self::RemoveCamera(CameraId(camera)),
            Command::PlaceCamera { camera, translation, rotation: r } => Self::PlaceCamera {
                camera: CameraId(camera),
                translation: vector(translation),
                rotation: rotation(r),
            },
            Command::SetCamera { camera, parameter } => {
                Self::SetCamera { camera: CameraId(camera), parameter: parameter.into() }
            }
        })
    }
}

/// Whether radii follow a control point that is dragged.
fn radii_follow(radii: DragRadii) -> Result<bool, Refused> {
    match radii {
        DragRadii::Keep => Ok(false),
        DragRadii::Follow => Ok(true),
        DragRadii::Solve => Err(Refused::SolvedRadii),
    }
}

/// The command that sets what an address names. A refusal says what the parameter takes, whatever came instead.
fn set(address: &str, value: &serde_json::Value) -> Result<document::Command, Refused> {
    let refused = |why: String| Refused::Address(format!("`{}` cannot be set: {why}", excerpt(address)));
    let (target, name) = ParameterTarget::from_address(address).ok_or_else(|| {
        refused(
            "write an address as /lights/ID/NAME, /lights/ID/points/INDEX/NAME or /cameras/ID/NAME".into(),
        )
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
    let row = row.ok_or_else(|| {
        refused(json_wording(&unknown::<serde_json::Error>("parameter", name, names()).to_string()))
    })?;
    let other_type = || refused(format!("`{name}` must be {}", row.kind));
    let setting = || match ValueSeed(row).deserialize(value) {
        Ok(value) => Ok(Setting { parameter: row, value }),
        Err(_) => Err(other_type()),
    };
    Ok(match target {
        ParameterTarget::Light(light) => document::Command::SetLight { light, setting: setting()? },
        ParameterTarget::Point(light, point) => {
            document::Command::SetPoint { light, point, setting: setting()? }
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
        let vector = |v: &Option<DVec3>| v.map(|v| v.to_array());
        let rotation = |q: &Option<DQuat>| q.map(|q| q.to_array());
        match command {
            C::LoadScene { asset, name } => {
                Self::LoadScene { scene: asset.to_string(), name: Some(name.clone()) }
            }
            C::AddLight(light) => Self::AddLight { light: Light::from(&**light) },
            C::RemoveLight(light) => Self::RemoveLight { light: light.0 },
            C::PlaceLight { light, translation, rotation: r, scale } => Self::PlaceLight {
                light: light.0,
                translation: vector(translation),
                rotation: rotation(r),
                scale: *scale,
            },
            C::SetLight { light, setting } => {
                Self::SetLight { light: light.0, parameter: setting.clone().into() }
            }
            C::SetPoint { light, point, setting } => {
                Self::SetPoint { light: light.0, point: *point, parameter: setting.clone().into() }
            }
            C::DragPoint { light, point, position, radii_follow } => Self::DragPoint {
                light: light.0,
                point: *point,
                position: position.to_array(),
                radii: if *radii_follow { DragRadii::Follow } else { DragRadii::Keep },
            },
            C::DragFeature { light, drag } => Self::DragFeature {
                light: light.0,
                kind: drag.feature.into(),
                points: drag.points.clone(),
                radii: drag.radii.into(),
                camera: (&drag.view.camera).into(),
                size: drag.view.size,
                from: drag.from.to_array(),
                to: drag.to.to_array(),
                source_outside: drag.source_outside,
            },
            C::AddPin(pin) => Self::AddPin { pin: pin.into() },
            C::RemovePin(pin) => Self::RemovePin { pin: pin.0 },
            C::SetPin { pin, is_hard } => Self::SetPin { pin: pin.0, hard: *is_hard },
            C::InsertPoint { light, point, position, radius, color, intensity } => Self::InsertPoint {
                light: light.0,
                point: *point,
                position: vector(position),
                radius: *radius,
                color: vector(color),
                intensity: *intensity,
            },
            C::RemovePoint { light, point } => Self::RemovePoint { light: light.0, point: *point },
            C::BendLight { light, segments, range, cone_angle, toward } => Self::BendLight {
                light: light.0,
                segments: Some(*segments),
                range: *range,
                cone_angle: *cone_angle,
                toward: vector(toward),
            },
            C::StraightenLight(light) => Self::StraightenLight { light: light.0 },
            C::AddCamera(camera) => Self::AddCamera { camera: camera.into() },
            C::RemoveCamera(camera) => Self::RemoveCamera { camera: camera.0 },
            C::PlaceCamera { camera, translation, rotation: r } => Self::PlaceCamera {
                camera: camera.0,
                translation: vector(translation),
                rotation: rotation(r),
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
