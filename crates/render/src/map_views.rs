//! Straight lights in a scene, with the projections of their maps, for both backends.

use glam::{DMat4, DVec2, DVec3};
use light::LightProfile;
use scene::PosedScene;

use crate::camera::columns;
use crate::clusters::MapCover;
use crate::gpu_structs;

/// Margin around casters in texels, so that the filter reads only texels that are drawn.
pub(crate) const MARGIN_TEXELS: f64 = 2.0;
/// Smallest fitted share of a face, or of the scene for parallel rays. Neither axis is fitted to less than a quarter of
/// the other. Finer texels are below the rounding error of positions.
pub(crate) const SMALLEST_SHARE: f64 = 1.0 / 128.0;
pub(crate) const SMALLEST_RATIO: f64 = 0.25;
/// Near plane of a shadow map that starts inside the scene, as a share of the distance to the scene's far end. It is
/// near enough for a lamp in its shade, and far enough for the map's depths to resolve a thousandth of that distance.
const NEAR_SHARE: f64 = 1e-3;

/// Straight light in a scene: its uniform, and the projections of its map.
#[derive(Clone, Debug)]
pub(crate) struct PlacedLight {
    pub uniform: LightUniform,
    /// Profile of the light, in f64. `uniform` has it in f32.
    pub light_profile: LightProfile,
    pub views: MapViews,
}

#[derive(Clone, Debug)]
pub(crate) enum LightUniform {
    Spot(gpu_structs::Spot),
    Omni(gpu_structs::Omni),
    Directional(gpu_structs::Directional),
}

impl LightUniform {
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Spot(spot) => bytemuck::bytes_of(spot),
            Self::Omni(omni) => bytemuck::bytes_of(omni),
            Self::Directional(directional) => bytemuck::bytes_of(directional),
        }
    }
}

/// Projections of the faces of a light's map.
#[derive(Clone, Debug)]
pub(crate) struct MapViews {
    pub light_from_scene: DMat4,
    /// Distance of the near plane in world units; `None` for parallel rays.
    pub near: Option<f64>,
    /// Projections, one per face; `None` for a face without casters.
    pub clip_from_light: Vec<Option<DMat4>>,
}

impl MapViews {
    /// Returns the uniforms, one per face of the map; `None` for a face without casters.
    pub fn shadow_views(&self) -> Vec<Option<gpu_structs::ShadowView>> {
        let view = |clip_from_light: &DMat4| {
            let clip_from_scene = columns(&(*clip_from_light * self.light_from_scene));
            gpu_structs::ShadowView { clip_from_scene }
        };
        self.clip_from_light.iter().map(|face| face.as_ref().map(view)).collect()
    }
}

/// Returns an upper bound of the distance from a source to any point of the scene.
pub(crate) fn far_distance(source_in_world: DVec3, posed: &PosedScene) -> f64 {
    ((source_in_world - posed.origin_in_world).abs() + posed.half_extent).length()
}

/// Returns the distance of the near plane of a map whose nearest caster is `nearest` ahead of the source, and the
/// profile of the light with the least distance at which it lights.
pub(crate) fn near_plane(nearest: f64, far: f64, profile: &LightProfile) -> (f64, LightProfile) {
    let least_distance = (NEAR_SHARE * far).max(f64::MIN_POSITIVE);
    let near = (0.99 * nearest.min(far)).max(least_distance);
    (near, LightProfile { min_distance: least_distance.max(profile.min_distance), ..profile.clone() })
}

/// Drawn part of a face of a map, as x / depth and y / depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FittedFace {
    pub center: DVec2,
    /// Half the size of the drawn part.
    pub half: DVec2,
    /// False if there are no casters: the face need not be drawn.
    pub has_casters: bool,
}

impl FittedFace {
    /// Returns the center and 1 / half size, as in the uniforms of lights.
    pub fn for_uniform(&self) -> [f32; 4] {
        let scale = self.half.recip();
        [self.center.x, self.center.y, scale.x, scale.y].map(|x| x as f32)
    }
}

/// Part of a face that boxes cover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceCover {
    pub low: DVec2,
    pub high: DVec2,
    /// Least depth; infinity without boxes.
    pub nearest: f64,
}

impl FaceCover {
    pub const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, nearest: f64::INFINITY };

    /// Fits the drawn part of a face from `low` to `high` to the cover, `grown` by the share that the filter reads
    /// beyond an edge. `smallest` is its smallest half size.
    pub fn fitted(&self, [low, high]: [DVec2; 2], grown: f64, smallest: f64) -> FittedFace {
        let (middle, widest) = ((low + high) / 2.0, (high - low) / 2.0 * grown);
        let has_casters = self.nearest < f64::INFINITY;
        let (low, high) = if has_casters { (self.low, self.high) } else { (low, high) };
        let half = (high - low) / 2.0;
        let least = (half.max_element() * SMALLEST_RATIO).max(smallest);
        let half = (half.max(DVec2::splat(least)) * grown).min(widest);
        // Grown, but no farther than the filter reads beyond the face.
        let room = widest - half;
        FittedFace { center: ((low + high) / 2.0).clamp(middle - room, middle + room), half, has_casters }
    }
}

impl MapCover for FaceCover {
    fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all() && self.nearest <= other.nearest
    }

    fn extend(&mut self, other: &Self) {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self.nearest = self.nearest.min(other.nearest);
    }
}
