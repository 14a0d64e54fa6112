//! What of shadows can be chosen: how fine their maps are and how they are looked up.

use relight::ShadowFilter;
use scene::MapScale;

use crate::RenderError;

/// How shadow maps are made and looked up, for every light of a renderer.
///
/// The defaults are chosen from the curves of `bendylights bench shadow`; large film frames need finer maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowSettings {
    /// Texels along each side of a map, from [`Self::MIN_RESOLUTION`] to what the device holds.
    pub resolution: u32,
    /// Largest distance, in texels, of an edge's image in a bent map from the line drawn for it. `None` splits
    /// no edge: triangles are only cut where the tube turns by 15 degrees.
    pub edge_error_texels: Option<f32>,
    /// How texels around a point are blended.
    pub filter: ShadowFilter,
    /// How far what casts shadows may stray from the scene's surface, in world units, finite and from 0 up:
    /// the more, the fewer triangles a map is made of, and the farther from its caster a shadow begins, where
    /// light grazes farther still. 0 is the surface itself.
    ///
    /// Only triangles without an alpha test are simplified, and of those no connected part 833 times as large
    /// and more: single precision does not resolve so little.
    pub mesh_error: f64,
    /// Whether a BendyLight that is still straight ([`light::CheckedLight::equivalent_spotlight`]) is drawn as the spotlight that
    /// it is: then bending a spotlight changes no pixel, and costs nothing. Its own way is slower, and what it is
    /// compared by: the two share no code.
    pub straighten: bool,
    /// What is not drawn, since no picture depends on it.
    pub culling: Culling,
}

/// What is not drawn, since no picture depends on it: all of that, but where something is compared with being drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of its own")]
pub struct Culling {
    /// Clusters of triangles that lie beside a light.
    pub clusters: bool,
    /// The backs of closed surfaces, as light has them.
    pub backs: bool,
    /// Floors and walls that close a scene and that a bent light only leaves through.
    pub sides: bool,
    /// Lights that no pixel sees, and pixels around what a light can reach.
    pub pixels: bool,
}

impl Culling {
    /// Draws nothing in vain.
    pub const ALL: Self = Self { clusters: true, backs: true, sides: true, pixels: true };
    /// Draws all.
    pub const NONE: Self = Self { clusters: false, backs: false, sides: false, pixels: false };
}

impl Default for Culling {
    fn default() -> Self {
        Self::ALL
    }
}

/// How large a light's map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapSize {
    /// Texels along each side of a face.
    pub side: u32,
    /// Faces, one a layer.
    pub layers: u32,
}

impl MapSize {
    /// Bytes that it takes.
    pub fn bytes(self) -> u64 {
        4 * u64::from(self.side).pow(2) * u64::from(self.layers)
    }
}

impl ShadowSettings {
    /// The size of a map of so many faces. One of several, a quarter turn wide, has half the texels a side: they are
    /// then as wide as those of one face of 60 degrees to each side, 0.11 degrees.
    pub(crate) fn map_size(&self, faces: usize) -> MapSize {
        let side = if faces == 1 { self.resolution } else { (self.resolution / 2).max(Self::MIN_RESOLUTION) };
        MapSize { side, layers: faces as u32 }
    }

    /// The same with maps of that scale.
    pub(crate) fn scaled(self, scale: MapScale) -> Self {
        let resolution = (self.resolution / u32::from(scale.divisor())).max(Self::MIN_RESOLUTION);
        Self { resolution: resolution.min(self.resolution), ..self }
    }

    /// Coarsest map: the margin around a spotlight's cone needs a few texels.
    pub const MIN_RESOLUTION: u32 = 16;

    /// The error of an edge is measured in its middle and may be a fifth larger elsewhere (light model, section
    /// 4): this keeps all of it within half a texel.
    const EDGE_ERROR_TEXELS: f32 = 0.4;

    /// Refuses what no map can be made of.
    pub(crate) fn check(&self, largest_texture: u32) -> Result<(), RenderError> {
        if self.resolution > largest_texture {
            let (size, limit) = (f64::from(self.resolution), f64::from(largest_texture));
            return Err(RenderError::TooLarge { what: "the resolution of shadow maps", size, limit });
        }
        if self.resolution < Self::MIN_RESOLUTION {
            return Err(RenderError::InvalidShadows(
                "their maps have fewer than 16 texels a side; give them more",
            ));
        }
        let fine = |texels: f32| texels.is_nan() || texels < Self::MIN_EDGE_ERROR_TEXELS;
        if self.edge_error_texels.is_some_and(fine) {
            return Err(RenderError::InvalidShadows(
                "their edges are held to less than 0.05 texels; allow more",
            ));
        }
        if !(self.mesh_error >= 0.0 && self.mesh_error.is_finite()) {
            return Err(RenderError::InvalidShadows(
                "their mesh error is no finite length from 0 up; give it in world units",
            ));
        }
        Ok(())
    }

    /// Below it, f32 decides where edges are split.
    const MIN_EDGE_ERROR_TEXELS: f32 = 0.05;

    /// Above it, an edge is straight enough in a bent map.
    pub(crate) fn split_above_texels(&self) -> f32 {
        self.edge_error_texels.unwrap_or(f32::MAX)
    }

    /// How far, in texels, a receiver may lie behind what a bent map holds and still be lit: the map's own error,
    /// and a quarter more, because a neighbouring facet that rises a little out of the receiver's plane is no
    /// occluder. Finer edges do not make facets flatter: with less, they were seen to shadow each other.
    pub(crate) fn bent_tolerance_texels(&self) -> f32 {
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

/// `wgsl` with the constant that `shadow_filter.wgsl` asks for.
pub(crate) fn with_filter(filter: ShadowFilter, wgsl: &str) -> String {
    format!("const SHADOW_FILTER = {}u;\n{wgsl}", filter as u32)
}
