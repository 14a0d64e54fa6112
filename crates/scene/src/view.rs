//! What a picture is asked to show.

use std::ops::RangeInclusive;
use std::str::FromStr;

use thiserror::Error;

use crate::Camera;

/// A picture to make.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Where from.
    pub camera: Camera,
    /// Pixels, at least 1.
    pub width: u32,
    /// Pixels, at least 1.
    pub height: u32,
    /// Samples a pixel, at least 1; with 1 the sample is the pixel's centre. Only [`Aov::Beauty`] and
    /// [`Aov::Visibility`] take more than one: the others would mean nothing if averaged over an edge.
    pub samples: u32,
    /// Which quantity.
    pub aov: Aov,
    /// Index of the light that the quantities of a light are of.
    pub light: usize,
    /// How much of the scene's fill the beauty has: a factor from 0, the lights alone, 1, as the scene has it, and more; within [`View::FILL_RANGE`].
    pub fill: f64,
    /// Stops by which the beauty is brightened for a screen or a PNG: its radiance times 2 to this, before tone mapping, within
    /// [`View::EXPOSURE_RANGE`]. Values themselves, as [`Aov`] has them, know nothing of it.
    pub exposure: f64,
    /// How fine shadow maps have to be; the reference, which has none, knows nothing of it.
    pub shadow_map: MapScale,
    /// Whose picture it is.
    pub slot: ViewSlot,
}

impl View {
    /// What [`View::fill`] may be. A million times a scene's fill is far from the largest radiance that f32 holds.
    pub const FILL_RANGE: RangeInclusive<f64> = 0.0..=1e6;

    /// What [`View::exposure`] may be, in stops. From starlight to the sun in the sky are 32.
    pub const EXPOSURE_RANGE: RangeInclusive<f64> = -32.0..=32.0;

    /// The lit scene as `camera` sees it in a picture of that width and height, with a sample at each pixel's centre.
    pub fn beauty(camera: Camera, [width, height]: [u32; 2]) -> Self {
        let (aov, shadow_map, slot) = (Aov::Beauty, MapScale::Full, ViewSlot::default());
        Self { camera, width, height, samples: 1, aov, light: 0, fill: 1.0, exposure: 0.0, shadow_map, slot }
    }
}

/// How many texels a side a shadow map has, of those that the renderer's settings say. The finer is the smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MapScale {
    /// All of them.
    #[default]
    Full,
    /// Half, so a quarter of the texels, enough while something moves. Of a bent light it may be of fewer triangles, which stray
    /// from the surface by two of its texels at most; those are made once a few such maps were drawn. A map that is there in full is
    /// used as it is.
    Half,
}

impl MapScale {
    /// By how much the texels of a side are divided.
    pub fn divisor(self) -> u16 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}

/// Names a viewer: for each the renderer keeps what it last drew, so that viewers with cameras of their own
/// do not undo each other's work. Any number will do; one viewer alone has the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ViewSlot(pub u64);

/// A quantity to show. Alpha is 1 where there is a surface (for a light's own quantities: one inside the
/// light) and 0 elsewhere, with the other channels 0 too; with several samples a pixel it is the share of
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Aov {
    /// Linear radiance under all lights and [`View::fill`] times the fill.
    #[default]
    Beauty,
    /// Distance along the view axis, in world units.
    Depth,
    /// Unit shading normal in world space, towards the viewer.
    Normal,
    /// World position.
    Position,
    /// Position along the light: 0 to the number of segments, or the share of the range of a spotlight.
    T,
    /// Position across the light: v in red, w in green; 1 is the edge.
    Vw,
    /// Unit vector in world space from the surface towards the arriving light.
    Direction,
    /// 1 lit by the light, 0 in its shadow.
    Visibility,
    /// A drawing of the light's shadow map, not of the camera's view: the triangles that it is made of, as the light
    /// sees them. v grows to the right and w upwards, from -1 to 1 over the picture's shorter side. t in red, 1 on an
    /// edge and 0 between in green.
    Wireframe,
}

impl Aov {
    /// The names, in the order of the variants.
    pub const NAMES: [&str; 9] =
        ["beauty", "depth", "normal", "position", "t", "vw", "direction", "visibility", "wireframe"];

    /// The name; of what lighting passes draw, also that of the shader's entry point after `fs_`.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Whether it belongs to one light.
    pub fn is_per_light(self) -> bool {
        matches!(self, Self::T | Self::Vw | Self::Direction | Self::Visibility | Self::Wireframe)
    }

    /// Whether an average over the pixel means something.
    pub fn can_be_multisampled(self) -> bool {
        matches!(self, Self::Beauty | Self::Visibility)
    }
}

impl FromStr for Aov {
    type Err = UnknownAov;

    fn from_str(name: &str) -> Result<Self, UnknownAov> {
        use Aov::{Beauty, Depth, Direction, Normal, Position, T, Visibility, Vw, Wireframe};
        [Beauty, Depth, Normal, Position, T, Vw, Direction, Visibility, Wireframe]
            .into_iter()
            .find(|aov| aov.name() == name)
            .ok_or_else(|| UnknownAov(name.into()))
    }
}

/// A name that is no AOV.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{0}` is not an AOV: choose one of {names}", names = Aov::NAMES.join(", "))]
pub struct UnknownAov(String);
