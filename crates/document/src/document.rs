//! What a session edits: lights, cameras, and which scene they light.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use light::{CheckedLight, ControlPoint, LightId, LightInstance};
use scene::Camera;
use sha2::{Digest, Sha256};

use crate::{LightPin, PinId};

/// Identifies a camera for as long as a session lives. Never used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CameraId(pub u64);

/// Names one numbering of a light's control points: another one after each insertion or removal, the earlier
/// one again when that is undone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PointNumbering(pub u64);

/// SHA-256 of an asset's bytes, what `sha256sum` prints; written `sha256:` and 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AssetHash(pub [u8; 32]);

/// The scene of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneRef {
    /// Its bytes.
    pub asset: AssetHash,
    /// What people call it; a label, part of neither identity nor hash.
    pub name: String,
}

/// A light and how its control points are numbered.
#[derive(Clone, Debug)]
pub struct NumberedLight {
    /// The numbering.
    pub layout: PointNumbering,
    /// The light, which can be evaluated.
    pub light: Arc<CheckedLight>,
}

impl PartialEq for NumberedLight {
    fn eq(&self, other: &Self) -> bool {
        self.layout == other.layout && (Arc::ptr_eq(&self.light, &other.light) || self.light == other.light)
    }
}

/// Everything that an edit log describes: lights, cameras, pins, and the name of a scene, whose geometry lies elsewhere. It
/// changes by [`Document::apply`] alone, so that ids stay unique.
#[derive(Clone, Debug, Default)]
pub struct Document {
    pub(crate) scene: Option<SceneRef>,
    pub(crate) lights: BTreeMap<LightId, NumberedLight>,
    pub(crate) cameras: BTreeMap<CameraId, Camera>,
    pub(crate) pins: BTreeMap<PinId, LightPin>,
    /// The largest number given out as an id or a layout. Not part of the document's content: undoing an
    /// addition gives the content back, but not the number.
    last_number: u64,
}

/// What comes with a scene besides its geometry.
#[derive(Clone, Debug, Default)]
pub struct SceneContents {
    /// Lights, placed in the world.
    pub lights: Vec<Arc<CheckedLight>>,
    /// Cameras, placed in the world.
    pub cameras: Vec<Camera>,
}

impl Document {
    /// Which scene it is; `None` before one is loaded.
    pub fn scene(&self) -> Option<&SceneRef> {
        self.scene.as_ref()
    }

    /// The lights, in the order of their ids.
    pub fn lights(&self) -> &BTreeMap<LightId, NumberedLight> {
        &self.lights
    }

    /// The lights as a renderer takes them, in the order of their ids.
    pub fn light_instances(&self) -> Vec<LightInstance> {
        let instance = |(id, placed): (&LightId, &NumberedLight)| LightInstance {
            id: *id,
            light: Arc::clone(&placed.light),
        };
        self.lights.iter().map(instance).collect()
    }

    /// The cameras, in the order of their ids.
    pub fn cameras(&self) -> &BTreeMap<CameraId, Camera> {
        &self.cameras
    }

    /// The pins, in the order of their ids; those of lights that are not there hold nothing.
    pub fn pins(&self) -> &BTreeMap<PinId, LightPin> {
        &self.pins
    }

    /// The next number for an id or a layout. It is taken once something carries it.
    pub(crate) fn next_number(&self) -> u64 {
        self.last_number.saturating_add(1)
    }

    pub(crate) fn take_number(&mut self, number: u64) {
        self.last_number = self.last_number.max(number);
    }

    /// A document as it was written down, with all that [`Document::apply`] made of it. `last_number` is the
    /// largest number ever given out; the ids and layouts here count too.
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

    /// The largest number ever given out as an id or a layout; what [`Document::restore`] needs.
    pub fn last_number(&self) -> u64 {
        self.last_number
    }

    /// The same document with a light as it is while it is dragged. Nothing changes where it is not there.
    pub fn set_live_light(&mut self, id: LightId, placed: &NumberedLight) {
        if let Some(shown) = self.lights.get_mut(&id) {
            *shown = placed.clone();
        }
    }
}

/// The control points of a BendyLight: what is renumbered as one.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlPoints {
    /// Their numbering.
    pub layout: PointNumbering,
    /// The source first.
    pub points: Vec<ControlPoint>,
}

impl fmt::Display for CameraId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl AssetHash {
    /// Of an asset's bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// The 64 digits alone.
    pub fn hex(&self) -> String {
        self.to_string().split_off("sha256:".len())
    }
}

impl fmt::Display for AssetHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("sha256:")?;
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for AssetHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Text that is not `sha256:` and 64 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "an asset's name is `sha256:` and 64 hexadecimal digits: copy it from where the asset was made known"
)]
pub struct InvalidAssetHash;

impl FromStr for AssetHash {
    type Err = InvalidAssetHash;

    fn from_str(text: &str) -> Result<Self, InvalidAssetHash> {
        let digits = text.strip_prefix("sha256:").map(str::as_bytes).filter(|d| d.len() == 64);
        let digits = digits.ok_or(InvalidAssetHash)?;
        let value = |digit: u8| char::from(digit).to_digit(16).filter(|_| !digit.is_ascii_uppercase());
        let mut bytes = [0; 32];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            let (high, low) = value(pair[0]).zip(value(pair[1])).ok_or(InvalidAssetHash)?;
            *byte = (high * 16 + low) as u8;
        }
        Ok(Self(bytes))
    }
}
