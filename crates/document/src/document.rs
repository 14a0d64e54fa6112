//! What a session edits: a scene, and the lights and cameras placed in it.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use sha2::{Digest, Sha256};

use light::{Light, LightId, LightKind, Reach};
use scene::{Camera, Scene};

/// Identifies a camera for as long as a session lives. Never used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CameraId(pub u64);

/// Names one numbering of a light's control points: another one after each insertion or removal, the earlier
/// one again when that is undone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Layout(pub u64);

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
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLight {
    /// The numbering.
    pub layout: Layout,
    /// The light.
    pub light: Light,
}

/// Everything that an edit log describes. It changes by [`Document::apply`] alone, so that ids stay unique.
///
/// Cloning is cheap: geometry is shared.
#[derive(Clone, Debug, Default)]
pub struct Document {
    scene_ref: Option<SceneRef>,
    scene: Arc<Scene>,
    /// The scene's, once somebody asked.
    reach: Arc<OnceLock<Reach>>,
    lights: BTreeMap<LightId, PlacedLight>,
    cameras: BTreeMap<CameraId, Camera>,
    /// The largest number given out as an id or a layout. Not part of the document's content: undoing an
    /// addition gives the content back, but not the number.
    last_number: u64,
}

impl Document {
    /// Which scene it is; `None` before one is loaded.
    pub fn scene_ref(&self) -> Option<&SceneRef> {
        self.scene_ref.as_ref()
    }

    /// Geometry, materials and fill. Its own cameras and lights were copied when it was loaded and mean nothing
    /// since.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The box that lights are measured against. The first time after a scene was loaded it looks at all vertices.
    pub fn reach(&self) -> Reach {
        *self.reach.get_or_init(|| Reach::from(&*self.scene))
    }

    /// The lights, in the order of their ids.
    pub fn lights(&self) -> &BTreeMap<LightId, PlacedLight> {
        &self.lights
    }

    /// The cameras, in the order of their ids.
    pub fn cameras(&self) -> &BTreeMap<CameraId, Camera> {
        &self.cameras
    }

    /// The next number for an id or a layout. It is taken once something carries it.
    pub(crate) fn next_number(&self) -> u64 {
        self.last_number.saturating_add(1)
    }

    pub(crate) fn take_number(&mut self, number: u64) {
        self.last_number = self.last_number.max(number);
    }

    pub(crate) fn set_scene(&mut self, scene_ref: Option<SceneRef>, scene: Arc<Scene>) {
        (self.scene_ref, self.scene, self.reach) = (scene_ref, scene, Arc::default());
    }

    pub(crate) fn lights_mut(&mut self) -> &mut BTreeMap<LightId, PlacedLight> {
        &mut self.lights
    }

    pub(crate) fn cameras_mut(&mut self) -> &mut BTreeMap<CameraId, Camera> {
        &mut self.cameras
    }

    /// A document as it was written down, with all that [`Document::apply`] made of it. `last_number` is the
    /// largest number ever given out; the ids and layouts here count too.
    pub fn restore(
        scene: Option<(SceneRef, Arc<Scene>)>,
        lights: BTreeMap<LightId, PlacedLight>,
        cameras: BTreeMap<CameraId, Camera>,
        last_number: u64,
    ) -> Self {
        let (scene_ref, scene) = scene.map_or_else(Default::default, |(r, s)| (Some(r), s));
        let numbers = lights.iter().flat_map(|(id, light)| [id.0, light.layout.0]);
        let last_number = numbers.chain(cameras.keys().map(|id| id.0)).fold(last_number, u64::max);
        Self { scene_ref, scene, reach: Arc::default(), lights, cameras, last_number }
    }

    /// The largest number ever given out as an id or a layout; what [`Document::restore`] needs.
    pub fn last_number(&self) -> u64 {
        self.last_number
    }
}

/// The control points of a BendyLight with all they carry: what is renumbered as one.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlPoints {
    /// Their numbering.
    pub layout: Layout,
    /// Positions, light-local.
    pub points: Vec<DVec3>,
    /// Radii, light-local.
    pub radii: Vec<f64>,
    /// Colours, linear RGB.
    pub colors: Vec<DVec3>,
    /// Intensities.
    pub intensities: Vec<f64>,
}

impl ControlPoints {
    /// Those of `placed`; `None` for a spotlight, which has none.
    pub fn of(placed: &PlacedLight) -> Option<Self> {
        let LightKind::Bendy(bendy) = &placed.light.kind else { return None };
        Some(Self {
            layout: placed.layout,
            points: bendy.points.clone(),
            radii: bendy.radii.clone(),
            colors: bendy.colors.clone(),
            intensities: bendy.intensities.clone(),
        })
    }
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
pub struct NotAnAssetHash;

impl FromStr for AssetHash {
    type Err = NotAnAssetHash;

    fn from_str(text: &str) -> Result<Self, NotAnAssetHash> {
        let digits = text.strip_prefix("sha256:").map(str::as_bytes).filter(|d| d.len() == 64);
        let digits = digits.ok_or(NotAnAssetHash)?;
        let value = |digit: u8| char::from(digit).to_digit(16).filter(|_| !digit.is_ascii_uppercase());
        let mut bytes = [0; 32];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            let (high, low) = value(pair[0]).zip(value(pair[1])).ok_or(NotAnAssetHash)?;
            *byte = (high * 16 + low) as u8;
        }
        Ok(Self(bytes))
    }
}
