//! Views: requests for a picture.

use std::ops::RangeInclusive;
use std::str::FromStr;

use thiserror::Error;

use crate::Camera;

/// Request for a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    pub camera: Camera,
    /// In pixels, at least 1.
    pub width: u32,
    /// In pixels, at least 1.
    pub height: u32,
    /// Samples a pixel, at least 1. With 1 the sample is at the pixel's centre. Only [`Aov::Beauty`] and
    /// [`Aov::Visibility`] allow more: an average of the others over an edge means nothing.
    pub samples: u32,
    pub aov: Aov,
    /// Index of the light that a per-light AOV shows.
    pub light: usize,
    /// Factor of the scene's fill in the beauty, within [`View::FILL_RANGE`]: 0 for the lights alone, 1 for the scene's
    /// own fill.
    pub fill: f64,
    /// Exposure of the beauty on a screen or in a PNG, in stops, within [`View::EXPOSURE_RANGE`]. The radiance is
    /// multiplied by 2 to this power before tone mapping. The values of an [`Aov`] do not depend on it.
    pub exposure: f64,
    /// Scale of shadow maps. The reference has no maps and ignores it.
    pub shadow_map: MapScale,
    pub slot: ViewSlot,
}

impl View {
    /// Range of [`View::fill`]. A million times a scene's fill is far from the largest radiance that f32 holds.
    pub const FILL_RANGE: RangeInclusive<f64> = 0.0..=1e6;

    /// Range of [`View::exposure`], in stops. From starlight to the sun in the sky are 32.
    pub const EXPOSURE_RANGE: RangeInclusive<f64> = -32.0..=32.0;

    /// Makes a beauty view from `camera` of that width and height in pixels, with one sample at each pixel's centre.
    pub fn beauty(camera: Camera, [width, height]: [u32; 2]) -> Self {
        let (aov, shadow_map, slot) = (Aov::Beauty, MapScale::Full, ViewSlot::default());
        Self { camera, width, height, samples: 1, aov, light: 0, fill: 1.0, exposure: 0.0, shadow_map, slot }
    }
}

/// Resolution of shadow maps relative to the renderer's settings. A finer scale is smaller in the order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MapScale {
    /// All texels.
    #[default]
    Full,
    /// Half the texels a side, a quarter in all. This is enough while something moves.
    ///
    /// A map of a bent light may use simplified casters, which deviate from the surface by at most two of its texels.
    /// They are made once a few such maps were drawn. If a full map is cached, it is used instead.
    Half,
}

impl MapScale {
    /// Returns the divisor of the number of texels a side.
    pub fn divisor(self) -> u16 {
        match self {
            Self::Full => 1,
            Self::Half => 2,
        }
    }
}

/// Identifies a viewer. The renderer keeps the latest results of each viewer apart, so that viewers with different
/// cameras do not evict each other's caches. Callers may choose any number. A single viewer uses the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ViewSlot(pub u64);

/// Quantity that a picture shows. Alpha is 1 at a surface (for a light's own quantities, a surface inside the light)
/// and 0 elsewhere, with the other channels 0 too. With several samples a pixel alpha is the share of samples at a
/// surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Aov {
    /// Linear radiance under all lights, plus [`View::fill`] times the fill.
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
    /// 1 if lit by the light, 0 in its shadow.
    Visibility,
    /// Drawing of the light's shadow map instead of the camera's view: the triangles of the map, as the light sees
    /// them. v grows to the right and w upwards, from -1 to 1 over the picture's shorter side. Red is t. Green is 1 on
    /// an edge and 0 elsewhere.
    Wireframe,
}

impl Aov {
    /// Names, in the order of the variants.
    pub const NAMES: [&str; 9] =
        ["beauty", "depth", "normal", "position", "t", "vw", "direction", "visibility", "wireframe"];

    /// Returns the name. For an AOV of the lighting passes it is also the shader's entry point, without its prefix
    /// `fs_`.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Returns true if the quantity belongs to one light.
    pub fn is_per_light(self) -> bool {
        matches!(self, Self::T | Self::Vw | Self::Direction | Self::Visibility | Self::Wireframe)
    }

    /// Returns true if an average over the pixel is meaningful.
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

/// Error for a name that is not an AOV.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{0}` is not an AOV: choose one of {names}", names = Aov::NAMES.join(", "))]
pub struct UnknownAov(String);
