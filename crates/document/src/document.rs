//! Document: lights, cameras, pins and the scene that they belong to.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use light::{CheckedLight, ControlPoint, LightId, LightInstance};
use scene::Camera;
use sha2::{Digest, Sha256};

use crate::{LightPin, PinId};

/// Identifies a camera for the life of its session. It is never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CameraId(pub u64);

/// Identifies a numbering of a light's control points. Each insertion or removal gives a new one, and an undo restores
/// the earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PointNumbering(pub u64);

/// SHA-256 of an asset's bytes, as `sha256sum` prints it; written `sha256:` and 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AssetHash(pub [u8; 32]);

/// Reference to the scene of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRef {
    /// Hash of the scene's bytes.
    pub asset: AssetHash,
    /// Label for people. It is not part of the identity or the hash.
    pub name: String,
}

/// Light, with the number that identifies the present numbering of its control points.
#[derive(Clone, Debug)]
pub struct NumberedLight {
    pub layout: PointNumbering,
    pub light: Arc<CheckedLight>,
}

impl PartialEq for NumberedLight {
    fn eq(&self, other: &Self) -> bool {
        self.layout == other.layout && (Arc::ptr_eq(&self.light, &other.light) || self.light == other.light)
    }
}

/// Content that an edit log describes: lights, cameras, pins, and a reference to a scene. The scene's geometry is
/// elsewhere. Only [`Document::apply`] changes it, so that ids stay unique.
#[derive(Clone, Debug, Default)]
pub struct Document {
    pub(crate) scene: Option<SceneRef>,
    pub(crate) lights: BTreeMap<LightId, NumberedLight>,
    pub(crate) cameras: BTreeMap<CameraId, Camera>,
    pub(crate) pins: BTreeMap<PinId, LightPin>,
    /// Largest number ever used as an id or a point numbering. It is not part of the document's content: an undo of an
    /// addition restores the content, but not the number.
    last_number: u64,
}

/// Lights and cameras that a scene file contains besides its geometry.
#[derive(Clone, Debug, Default)]
pub struct SceneContents {
    /// In world space.
    pub lights: Vec<Arc<CheckedLight>>,
    /// In world space.
    pub cameras: Vec<Camera>,
}

impl Document {
    /// Returns the scene; `None` before one is loaded.
    pub fn scene(&self) -> Option<&SceneRef> {
        self.scene.as_ref()
    }

    /// Returns the lights, in the order of their ids.
    pub fn lights(&self) -> &BTreeMap<LightId, NumberedLight> {
        &self.lights
    }

    /// Returns the lights for a renderer, in the order of their ids.
    pub fn light_instances(&self) -> Vec<LightInstance> {
        let instance =
            |(id, placed): (&LightId, &NumberedLight)| LightInstance { id: *id, light: Arc::clone(&placed.light) };
        self.lights.iter().map(instance).collect()
    }

    /// Returns the cameras, in the order of their ids.
    pub fn cameras(&self) -> &BTreeMap<CameraId, Camera> {
        &self.cameras
    }

    /// Returns the pins, in the order of their ids. Pins of absent lights have no effect.
    pub fn pins(&self) -> &BTreeMap<PinId, LightPin> {
        &self.pins
    }

    /// Returns the next number for an id or a point numbering. It is used up once an object has it.
    pub(crate) fn next_number(&self) -> u64 {
        self.last_number.saturating_add(1)
    }

    pub(crate) fn take_number(&mut self, number: u64) {
        self.last_number = self.last_number.max(number);
    }

    /// Restores a document from its stored content. `last_number` is the largest number ever used; ids and numberings
    /// in the content count too.
    pub fn restore(
        scene: Option<SceneRef>,
        lights: BTreeMap<LightId, NumberedLight>,
        cameras: BTreeMap<CameraId, Camera>,
        pins: BTreeMap<PinId, LightPin>,
        last_number: u64,
    ) -> Self {
        let numbers = lights.iter().flat_map(|(id, light)| [id.0, light.layout.0]);
        let numbers = numbers.chain(cameras.keys().map(|id| id.0)).chain(pins.keys().map(|id| id.0));
        let last_number = numbers.fold(last_number, u64::max);
        Self { scene, lights, cameras, pins, last_number }
    }

    /// Returns the largest number ever used as an id or a point numbering, as [`Document::restore`] needs it.
    pub fn last_number(&self) -> u64 {
        self.last_number
    }

    /// Replaces a light by its state during a drag. An absent light is ignored.
    pub fn set_live_light(&mut self, id: LightId, placed: &NumberedLight) {
        if let Some(shown) = self.lights.get_mut(&id) {
            *shown = placed.clone();
        }
    }

    /// Adds a light that a drag in progress would add, under the next free id: drags of several clients may each add one.
    pub fn add_live_light(&mut self, placed: &NumberedLight) {
        let number = self.next_number();
        self.take_number(number);
        self.lights.insert(LightId(number), placed.clone());
    }
}

/// Control points of a BendyLight, which are renumbered together.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlPoints {
    pub layout: PointNumbering,
    /// In order, the source first.
    pub points: Vec<ControlPoint>,
}

impl fmt::Display for CameraId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl AssetHash {
    /// Computes the hash of an asset's bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// Returns the hash as 64 hexadecimal digits without the prefix.
    pub fn hex(&self) -> String {
        const_hex::const_encode::<32, false>(&self.0).as_str().into()
    }
}

impl fmt::Display for AssetHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sha256:{}", self.hex())
    }
}

impl fmt::Debug for AssetHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Error for text that is not `sha256:` and 64 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an asset's name is `sha256:` and 64 hexadecimal digits: copy it from where the asset was made known")]
pub struct InvalidAssetHash;

impl FromStr for AssetHash {
    type Err = InvalidAssetHash;

    fn from_str(text: &str) -> Result<Self, InvalidAssetHash> {
        let hash = text.strip_prefix("sha256:").and_then(|digits| const_hex::decode_to_array(digits).ok()).map(Self);
        // Only as it is written: no capital digits, no `0x`.
        hash.filter(|hash| hash.to_string() == text).ok_or(InvalidAssetHash)
    }
}
