//! A document in JSON.

use std::sync::Arc;

use document::{AssetHash, CameraId, InvalidAssetHash, PinId, PointNumbering};
use glam::{DQuat, DVec3};
use light::SceneBounds;
use light::{CheckedLight, LightId};
use scene::PosedScene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conversion::same_variants;
use crate::vector::{Quat, Vec3};
use crate::{DocumentPin, Light, Refused};

/// [`document::Document`] in JSON. Lists are sorted by id.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Document {
    /// Scene; `null` before one is loaded.
    pub scene: Option<SceneRef>,
    pub lights: Vec<DocumentLight>,
    pub cameras: Vec<DocumentCamera>,
    /// Pins; left out if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<DocumentPin>,
}

/// Serializes a value that holds an empty document, and returns the JSON before and after that document.
///
/// The server serializes a large document once and puts its text into the messages to many clients.
pub fn json_around_document(value: &impl Serialize) -> (String, String) {
    let text = |value: &dyn Fn() -> serde_json::Result<String>| value().expect("plain data with string keys");
    let mut before = text(&|| serde_json::to_string(value));
    // Within a JSON string every quotation mark is escaped, so the search finds only the field.
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
    /// Name for people.
    pub name: String,
}

/// Light of a document, with its id.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DocumentLight {
    pub id: u64,
    /// Numbering of the control points: a number that changes when they are renumbered (DOC-2).
    pub layout: u64,
    pub light: Light,
}

/// Camera of a document, with its id.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DocumentCamera {
    pub id: u64,
    pub camera: Camera,
}

/// [`scene::Camera`] in JSON. It looks along its local -Z, with +Y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Camera {
    /// Name for people. Default: empty.
    #[serde(default)]
    pub name: String,
    /// World position of the eye.
    pub translation: Vec3,
    /// Rotation from camera to world axes.
    pub rotation: Quat,
    pub projection: Projection,
}

/// [`scene::Projection`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum Projection {
    /// Perspective projection.
    Perspective {
        /// Full vertical field of view in radians.
        yfov: f64,
        /// Width over height of the frame, all of which the picture shows. Default: that of the picture.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aspect_ratio: Option<f64>,
        /// Distance of the near plane, more than 0.
        znear: f64,
        /// Distance of the far plane. Default: infinite.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        zfar: Option<f64>,
    },
    /// Orthographic projection.
    Orthographic {
        /// Half the height of the frame in world units.
        ymag: f64,
        /// Width over height of the frame, all of which the picture shows. Default: that of the picture.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aspect_ratio: Option<f64>,
        /// Distance of the near plane, 0 or more.
        znear: f64,
        /// Distance of the far plane.
        zfar: f64,
    },
}

/// Bounding box of a scene in world space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl Bounds {
    /// Returns the bounds of a scene, or a box of side 2 around the origin if the scene has no geometry.
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
    /// Converts to the domain. `last_number` as in [`document::Document::restore`].
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
    /// Converts without a check. [`scene::Camera::check`] tells if the camera makes a picture.
    fn from(wire: Camera) -> Self {
        Self {
            name: wire.name,
            translation: wire.translation.into(),
            rotation: DQuat::from_array(wire.rotation),
            projection: wire.projection.into(),
        }
    }
}

same_variants!(scene::Projection = Projection {
    Perspective { yfov, aspect_ratio, znear, zfar },
    Orthographic { ymag, aspect_ratio, znear, zfar }
});
