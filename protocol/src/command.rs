//! Commands and their parameters in JSON.

use document::CameraId;
use glam::{DQuat, DVec3};
use light::LightId;
use light::{Decay, Direction, EndMode, Frame};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::document::{Quat, Vec3};
use crate::light::{DecayName, DirectionName, EndModeName, FrameName};
use crate::{Camera, Light, Projection, Refused};

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

/// [`document::LightParameter`] in JSON: an object with one field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum LightParameter {
    /// Name for people.
    Name(String),
    /// World position of the source.
    Translation(Vec3),
    /// Light-local to world axes.
    Rotation(Quat),
    /// World units per light-local unit.
    Scale(f64),
    /// Half angle in degrees.
    ConeAngle(f64),
    /// Share of the cone angle over which the profile falls to zero.
    ConeSoftness(f64),
    /// Fall-off with distance.
    Decay(
        #[serde(with = "DecayName")]
        #[schemars(with = "DecayName")]
        Decay,
    ),
    /// Of a bendy light.
    Up(Vec3),
    /// Of a bendy light.
    Frame(
        #[serde(with = "FrameName")]
        #[schemars(with = "FrameName")]
        Frame,
    ),
    /// Of a bendy light.
    Direction(
        #[serde(with = "DirectionName")]
        #[schemars(with = "DirectionName")]
        Direction,
    ),
    /// Of a bendy light.
    EndMode(
        #[serde(with = "EndModeName")]
        #[schemars(with = "EndModeName")]
        EndMode,
    ),
    /// Of a spotlight: linear RGB.
    Color(Vec3),
    /// Of a spotlight.
    Intensity(f64),
    /// Of a spotlight; `null` is endless.
    Range(Option<f64>),
}

/// [`document::PointParameter`] in JSON: an object with one field.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum PointParameter {
    /// Light-local position.
    Position(Vec3),
    /// Light-local radius.
    Radius(f64),
    /// Linear RGB.
    Color(Vec3),
    /// Intensity.
    Intensity(f64),
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
            Command::AddLight { light } => Self::AddLight(Box::new(light.try_into()?)),
            Command::RemoveLight { light } => Self::RemoveLight(LightId(light)),
            Command::PlaceLight { light, translation, rotation: r, scale } => Self::PlaceLight {
                light: LightId(light),
                translation: vector(translation),
                rotation: rotation(r),
                scale,
            },
            Command::SetLight { light, parameter } => {
                Self::SetLight { light: LightId(light), parameter: parameter.into() }
            }
            Command::SetPoint { light, point, parameter } => {
                Self::SetPoint { light: LightId(light), point, parameter: parameter.into() }
            }
            Command::InsertPoint { light, point, position, radius, color, intensity } => Self::InsertPoint {
                light: LightId(light),
                point,
                position: vector(position),
                radius,
                color: vector(color),
                intensity,
            },
            Command::RemovePoint { light, point } => Self::RemovePoint { light: LightId(light), point },
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
            C::SetLight { light, parameter } => {
                Self::SetLight { light: light.0, parameter: parameter.clone().into() }
            }
            C::SetPoint { light, point, parameter } => {
                Self::SetPoint { light: light.0, point: *point, parameter: (*parameter).into() }
            }
            C::InsertPoint { light, point, position, radius, color, intensity } => Self::InsertPoint {
                light: light.0,
                point: *point,
                position: vector(position),
                radius: *radius,
                color: vector(color),
                intensity: *intensity,
            },
            C::RemovePoint { light, point } => Self::RemovePoint { light: light.0, point: *point },
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

/// The two directions of a parameter enum whose variants carry the same in both shapes, up to `$into` and `$from`.
macro_rules! convert {
    ($name:ident { $($variant:ident: $into:expr, $from:expr;)* }) => {
        impl From<$name> for document::$name {
            fn from(wire: $name) -> Self {
                match wire {
                    $($name::$variant(value) => Self::$variant($into(value)),)*
                }
            }
        }

        impl From<document::$name> for $name {
            fn from(parameter: document::$name) -> Self {
                match parameter {
                    $(document::$name::$variant(value) => Self::$variant($from(value)),)*
                }
            }
        }
    };
}

/// Variants whose value is the same in both shapes.
fn same<T>(value: T) -> T {
    value
}

fn array(vector: DVec3) -> Vec3 {
    vector.to_array()
}

fn quat(rotation: DQuat) -> Quat {
    rotation.to_array()
}

convert!(LightParameter {
    Name: same, same;
    Translation: DVec3::from, array;
    Rotation: DQuat::from_array, quat;
    Scale: same, same;
    ConeAngle: same, same;
    ConeSoftness: same, same;
    Decay: same, same;
    Up: DVec3::from, array;
    Frame: same, same;
    Direction: same, same;
    EndMode: same, same;
    Color: DVec3::from, array;
    Intensity: same, same;
    Range: same, same;
});
convert!(PointParameter {
    Position: DVec3::from, array;
    Radius: same, same;
    Color: DVec3::from, array;
    Intensity: same, same;
});
convert!(CameraParameter {
    Name: same, same;
    Translation: DVec3::from, array;
    Rotation: DQuat::from_array, quat;
    Projection: scene::Projection::from, Projection::from;
});
