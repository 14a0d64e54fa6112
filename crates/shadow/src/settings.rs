//! Settings of shadow maps: their resolution, lookup and casters.

use light::MAX_EXTENT;
use relight::ShadowFilter;
use scene::MapScale;
use thiserror::Error;

/// Margin around casters in texels, so that the filter reads only texels that are drawn.
pub(crate) const MARGIN_TEXELS: f64 = 2.0;
/// Smallest fitted share of a face, or of the scene for parallel rays. Neither axis is fitted to less than a quarter of
/// the other. Finer texels are below the rounding error of positions.
pub(crate) const SMALLEST_SHARE: f64 = 1.0 / 128.0;
pub(crate) const SMALLEST_RATIO: f64 = 0.25;

/// Settings of shadow maps and their lookup, for every light of a renderer.
///
/// The defaults are chosen from the curves of `bendylights bench shadow`; large film frames need finer maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSettings {
    /// Texels along each side of a map, from [`Self::MIN_RESOLUTION`] to the device's limit.
    pub resolution: u32,
    /// Largest distance, in texels, of an edge's image in a bent map from the line drawn for it. `None` splits no edge:
    /// triangles are only cut where the tube turns by 15 degrees.
    pub edge_error_texels: Option<f32>,
    /// Blending of the texels around a point.
    pub filter: ShadowFilter,
    /// Largest distance of casters from the scene's surface, in world units, finite and from 0 up. A larger error gives
    /// maps of fewer triangles. It also moves the start of a shadow farther from its caster, most where light grazes. 0
    /// is the surface itself.
    ///
    /// Only triangles without an alpha test are simplified. A connected component at least 833 times as large as the
    /// error stays unchanged, because f32 does not resolve so little.
    pub mesh_error: f64,
    /// True to draw a straight BendyLight ([`light::CheckedLight::equivalent_spotlight`]) as the equal spotlight. Then
    /// bending a spotlight changes no pixel and costs nothing. The code for bent lights is slower. It serves as a
    /// comparison, because the two share no code.
    pub straighten: bool,
    /// Work to skip because no picture depends on it.
    pub culling: Culling,
}

/// Work to skip because no picture depends on it. All of it is skipped by default; tests compare with pictures that
/// skip nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub struct Culling {
    /// Skips clusters of triangles beside a light.
    pub clusters: bool,
    /// Skips back faces of closed components, seen from the light.
    pub backs: bool,
    /// Skips floors and walls that close a scene and that a bent light only leaves through.
    pub sides: bool,
    /// Skips lights out of view, and pixels out of a light's reach.
    pub pixels: bool,
}

impl Culling {
    /// Skips everything that no picture depends on.
    pub const ALL: Self = Self { clusters: true, backs: true, sides: true, pixels: true };
    /// Skips nothing.
    pub const NONE: Self = Self { clusters: false, backs: false, sides: false, pixels: false };
}

impl Default for Culling {
    fn default() -> Self {
        Self::ALL
    }
}

/// Size of a shadow map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSize {
    /// Texels along each side of a face.
    pub side: u32,
    /// Number of faces, one per layer.
    pub layers: u32,
}

impl MapSize {
    pub fn bytes(self) -> u64 {
        4 * u64::from(self.side).pow(2) * u64::from(self.layers)
    }
}

/// Settings that permit no map, with what to change.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("shadows cannot be made so: {0}")]
pub struct InvalidSettings(pub &'static str);

impl ShadowSettings {
    /// Returns the size of a map with that number of faces. Each of several faces, a quarter turn wide, has half the
    /// texels a side. They are then as wide as those of one face of 60 degrees to each side: 0.11 degrees.
    pub fn map_size(&self, faces: usize) -> MapSize {
        let side = if faces == 1 { self.resolution } else { (self.resolution / 2).max(Self::MIN_RESOLUTION) };
        MapSize { side, layers: faces as u32 }
    }

    /// Returns the settings with maps of another scale.
    #[must_use]
    pub fn scaled(self, scale: MapScale) -> Self {
        let resolution = (self.resolution / u32::from(scale.divisor())).max(Self::MIN_RESOLUTION);
        Self { resolution: resolution.min(self.resolution), ..self }
    }

    /// Smallest resolution: the margin around a spotlight's cone needs a few texels.
    pub const MIN_RESOLUTION: u32 = 16;

    /// Default edge error. The error is measured at the middle of an edge and may be a fifth larger elsewhere (light
    /// model, section 4): this keeps all of it within half a texel.
    const EDGE_ERROR_TEXELS: f32 = 0.4;

    /// Returns an error for settings that permit no map. The limits of devices do not count.
    pub fn check(&self) -> Result<(), InvalidSettings> {
        if self.resolution < Self::MIN_RESOLUTION {
            return Err(InvalidSettings("their maps have fewer than 16 texels a side; give them more"));
        }
        let fine = |texels: f32| texels.is_nan() || texels < Self::MIN_EDGE_ERROR_TEXELS;
        if self.edge_error_texels.is_some_and(fine) {
            return Err(InvalidSettings("their edges are held to less than 0.05 texels; allow more"));
        }
        if !(self.mesh_error >= 0.0 && self.mesh_error.is_finite()) {
            return Err(InvalidSettings("their mesh error is no finite length from 0 up; give it in world units"));
        }
        Ok(())
    }

    /// Smallest edge error; below it, rounding in f32 decides the splits.
    const MIN_EDGE_ERROR_TEXELS: f32 = 0.05;

    /// Returns the mesh error as lookups read it, at most the extent of a scene: a larger one has the same effect.
    pub(crate) fn mesh_error_in_f32(&self) -> f32 {
        self.mesh_error.min(2.0 * MAX_EXTENT) as f32
    }

    /// Returns the error in texels above which an edge of a bent map is split.
    pub fn split_above_texels(&self) -> f32 {
        self.edge_error_texels.unwrap_or(f32::MAX)
    }

    /// Returns the distance, in texels, by which a receiver may be behind a bent map's surface and still be lit: the
    /// map's own error, and a quarter more, because an adjacent facet that rises a little out of the receiver's plane
    /// is no occluder. A smaller edge error does not make facets flatter: with less tolerance, facets shadowed each
    /// other.
    pub fn bent_tolerance_texels(&self) -> f32 {
        0.25 + 1.25 * self.edge_error_texels.unwrap_or(0.0).max(Self::EDGE_ERROR_TEXELS)
    }
}

impl Default for ShadowSettings {
    fn default() -> Self {
        Self {
            resolution: 2048,
            edge_error_texels: Some(Self::EDGE_ERROR_TEXELS),
            filter: ShadowFilter::default(),
            mesh_error: 0.0,
            straighten: true,
            culling: Culling::ALL,
        }
    }
}
