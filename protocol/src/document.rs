//! A document in JSON.

use std::sync::Arc;

use document::{AssetHash, CameraId, InvalidAssetHash, PinId, PointNumbering};
use glam::{DQuat, DVec3};
use light::SceneBounds;
use light::{CheckedLight, LightId};
use scene::PosedScene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{DocumentPin, Light, Refused};

/// A vector or a colour: `[x, y, z]`, `[r, g, b]`.
pub type Vec3 = [f64; 3];
/// A quaternion: `[x, y, z, w]`.
pub type Quat = [f64; 4];

/// [`document::Document`] in JSON, lists in the order of ids.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Document {
    /// Its scene; `null` before one is loaded.
    pub scene: Option<SceneRef>,
    /// Its lights.
    pub lights: Vec<DocumentLight>,
    /// Its cameras.
    pub cameras: Vec<DocumentCamera>,
    /// Its pins; left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<DocumentPin>,
}

/// The JSON of a value that holds an empty document: what stands before that document's own and what behind. So the text of a
/// large document, which is made once, stands in what is sent to many.
pub fn json_around_document(value: &impl Serialize) -> (String, String) {
    let text = |value: &dyn Fn() -> serde_json::Result<String>| value().expect("plain data with string keys");
    let mut before = text(&|| serde_json::to_string(value));
    // Within a string every quotation mark has a backslash before it, so this is found where it is meant.
    let empty = text(&|| serde_json::to_string(&Document::default()));
    let at = before.find(&format!("\":{empty}")).expect("a field that is an empty document") + 2;
    let after = before[at + empty.len()..].to_owned();
    before.truncate(at);
    (before, after)
}

/// [`document::SceneRef`] in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SceneRef {
    /// `sha256:` and 64 hexadecimal digits.
    pub asset: String,
    /// What people call it.
    pub name: String,
}

/// A light of a document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DocumentLight {
    /// Its id.
    pub id: u64,
    /// Numbering of its control points.
    pub layout: u64,
    /// The light.
    pub light: Light,
}

/// A camera of a document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DocumentCamera {
    /// Its id.
    pub id: u64,
    /// The camera.
    pub camera: Camera,
}

/// [`scene::Camera`] in JSON. Looks along its local -Z with +Y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Camera {
    /// Name for people; empty by default.
    #[serde(default)]
    pub name: String,
    /// World position of the eye.
    pub translation: Vec3,
    /// Camera to world axes.
    pub rotation: Quat,
    /// How it projects.
    pub projection: Projection,
}

/// [`scene::Projection`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// Full vertical angle of view, radians.
        yfov: f64,
        /// Width over height of what it frames, all of which is in the picture; the picture's own by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aspect_ratio: Option<f64>,
        /// Distance of the near plane, more than 0.
        znear: f64,
        /// Distance of the far plane; endless by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        zfar: Option<f64>,
    },
    /// Orthographic.
    Orthographic {
        /// Half the height of the view.
        ymag: f64,
        /// Width over height of what it frames, all of which is in the picture; the picture's own by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aspect_ratio: Option<f64>,
        /// Distance of the near plane, 0 or more.
        znear: f64,
        /// Distance of the far plane.
        zfar: f64,
    },
}

/// Corners of the box around a scene, in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// Of a scene; a box of side 2 around the origin where it has no geometry.
    pub fn of(posed: &PosedScene) -> Self {
        let SceneBounds { center: middle, half_extent } = posed.bounds();
        let half = if posed.positions.is_empty() { DVec3::ONE } else { half_extent };
        let (min, max) = (middle - half, middle + half);
        Self { min: min.to_array(), max: max.to_array() }
    }
}

impl From<&document::Document> for Document {
    fn from(document: &document::Document) -> Self {
        let lights = document.lights().iter().map(|(id, placed)| DocumentLight {
            id: id.0,
            layout: placed.layout.0,
            light: Light::from(&*placed.light),
        });
        let cameras = document.cameras().iter();
        Self {
            scene: document.scene().map(SceneRef::from),
            lights: lights.collect(),
            cameras: cameras.map(|(id, camera)| DocumentCamera { id: id.0, camera: camera.into() }).collect(),
            pins: document.pins().iter().map(|(id, pin)| (*id, pin).into()).collect(),
        }
    }
}

impl Document {
    /// The domain's document; `last_number` as in [`document::Document::restore`].
    pub fn into_domain(self, last_number: u64) -> Result<document::Document, Refused> {
        let scene = self.scene.map(document::SceneRef::try_from).transpose()?;
        let placed = |wire: DocumentLight| {
            let light = Arc::new(CheckedLight::try_from(wire.light)?);
            Ok((LightId(wire.id), document::NumberedLight { layout: PointNumbering(wire.layout), light }))
        };
        let lights = self.lights.into_iter().map(placed).collect::<Result<_, Refused>>()?;
        let cameras = self.cameras.into_iter().map(|wire| (CameraId(wire.id), wire.camera.into())).collect();
        let pins = self.pins.into_iter().map(|wire| (PinId(wire.id), wire.pin.into())).collect();
        Ok(document::Document::restore(scene, lights, cameras, pins, last_number))
    }
}

impl From<&document::SceneRef> for SceneRef {
    fn from(scene: &document::SceneRef) -> Self {
        Self { asset: scene.asset.to_string(), name: scene.name.clone() }
    }
}

impl TryFrom<SceneRef> for document::SceneRef {
    type Error = InvalidAssetHash;

    fn try_from(wire: SceneRef) -> Result<Self, InvalidAssetHash> {
        Ok(Self { asset: wire.asset.parse::<AssetHash>()?, name: wire.name })
    }
}

impl From<&scene::Camera> for Camera {
    fn from(camera: &scene::Camera) -> Self {
        Self {
            name: camera.name.clone(),
            translation: camera.translation.to_array(),
            rotation: camera.rotation.to_array(),
            projection: camera.projection.into(),
        }
    }
}

impl From<Camera> for scene::Camera {
    /// Not checked: [`scene::Camera::check`] says whether it makes a picture.
    fn from(wire: Camera) -> Self {
        Self {
            name: wire.name,
            translation: wire.translation.into(),
            rotation: DQuat::from_array(wire.rotation),
            projection: wire.projection.into(),
        }
    }
}

impl From<scene::Projection> for Projection {
    fn from(projection: scene::Projection) -> Self {
        match projection {
            scene::Projection::Perspective { yfov, aspect_ratio, znear, zfar } => {
                Self::Perspective { yfov, aspect_ratio, znear, zfar }
            }
            scene::Projection::Orthographic { ymag, aspect_ratio, znear, zfar } => {
                Self::Orthographic { ymag, aspect_ratio, znear, zfar }
            }
        }
    }
}

impl From<Projection> for scene::Projection {
    fn from(wire: Projection) -> Self {
        match wire {
            Projection::Perspective { yfov, aspect_ratio, znear, zfar } => {
                Self::Perspective { yfov, aspect_ratio, znear, zfar }
            }
            Projection::Orthographic { ymag, aspect_ratio, znear, zfar } => {
                Self::Orthographic { ymag, aspect_ratio, znear, zfar }
            }
        }
    }
}
