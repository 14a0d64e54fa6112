//! Directional lights. The map is one orthographic picture along the rays.

use glam::{DMat3, DMat4, DVec2, DVec3};
use light::{LightProfile, MAX_EXTENT, Parallel};
use scene::PosedScene;

use crate::camera::columns;
use crate::clusters::{ClusterBounds, OpenSide};
use crate::gpu_scene::GpuScene;
use crate::map_views::MapViews;
use crate::shadow_settings::MapSize;
use crate::{ShadowSettings, gpu_structs};

/// Margin around casters in texels, so that the filter reads only texels that are drawn.
const MARGIN_TEXELS: f64 = 2.0;
/// Smallest share of the scene that a map covers. Neither axis covers less than a quarter of the other. Finer texels
/// are below the rounding error of positions.
const SMALLEST_SHARE: f64 = 1.0 / 128.0;
const SMALLEST_RATIO: f64 = 0.25;
/// Smallest scene size, so that its inverse is within f32.
const SMALLEST: f64 = 1e-30;

/// Part of a scene that a directional light's map shows, in the light's axes around the scene's origin: x, y, and
/// height towards the light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionalMapFit {
    pub center: DVec2,
    /// Half the size of the drawn part.
    pub half: DVec2,
    /// Heights that have depth 0 and depth 1. The whole scene is above the first height, all casters are below the
    /// second.
    pub heights: [f64; 2],
    /// False if there are no casters: the map need not be drawn.
    pub has_casters: bool,
}

impl DirectionalMapFit {
    /// Fit for a light that has no map.
    pub const NONE: Self =
        Self { center: DVec2::ZERO, half: DVec2::ONE, heights: [0.0, 1.0], has_casters: false };
}

/// Directional light in a scene: its uniform, and the projection of its map.
#[derive(Clone, Debug)]
pub(crate) struct GpuDirectional {
    pub uniform: gpu_structs::Directional,
    /// Profile of the light, in f64. `uniform` has it in f32.
    pub light_profile: LightProfile,
    pub views: MapViews,
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(parallel: &Parallel, posed: &PosedScene) -> [DVec3; 8] {
    let window = window(parallel, posed);
    let corner = |k: usize| {
        let pick = |bit: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        let x = pick(0, window.low.x, window.high.x);
        let y = pick(1, window.low.y, window.high.y);
        let height = pick(2, -window.top, window.top);
        posed.origin_in_world + parallel.rotation * DVec3::new(x, y, height)
    };
    std::array::from_fn(corner)
}

pub(crate) fn map_size(shadows: &ShadowSettings) -> MapSize {
    shadows.map_size(1)
}

/// A rectangle perpendicular to the light, with the greatest height of its content.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: DVec2,
    high: DVec2,
    top: f64,
}

impl Extent {
    const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, top: f64::NEG_INFINITY };

    /// Returns the extent of a box within `window`; `None` if none of it is inside.
    fn of(cluster: &ClusterBounds, light_from_scene: &DMat3, window: &Self) -> Option<Self> {
        let rows = light_from_scene.transpose();
        let [x, y, height] = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| cluster.range(row, 0.0));
        let (low, high) = (DVec2::new(x[0], y[0]).max(window.low), DVec2::new(x[1], y[1]).min(window.high));
        low.cmple(high).all().then_some(Self { low, high, top: height[1] })
    }

    fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all() && self.top >= other.top
    }

    fn extend(&mut self, other: &Self) {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self.top = self.top.max(other.top);
    }
}

/// Returns the light's window around the scene's origin, clipped to the scene.
fn window(parallel: &Parallel, posed: &PosedScene) -> Extent {
    let light_from_scene = parallel.rotation.transpose();
    let whole = ClusterBounds { center: DVec3::ZERO, half: posed.half_extent };
    let everywhere = Extent { low: DVec2::NEG_INFINITY, high: DVec2::INFINITY, top: 0.0 };
    let scene_extent = Extent::of(&whole, &light_from_scene, &everywhere).unwrap_or(everywhere);
    let middle = -parallel.offset_in_window(posed.origin_in_world);
    let half = DVec2::from(parallel.half_size.map(|half| half.unwrap_or(f64::INFINITY)));
    let (low, high) = (scene_extent.low.max(middle - half), scene_extent.high.min(middle + half));
    Extent { low, high, top: scene_extent.top }
}

/// Fits the map of a light over `scene` to the casters in its window.
pub(crate) fn fit_map(parallel: &Parallel, scene: &GpuScene, shadows: &ShadowSettings) -> DirectionalMapFit {
    let (side, mesh_error) = (f64::from(map_size(shadows).side), shadows.mesh_error);
    let grown = side / (side - 2.0 * MARGIN_TEXELS);
    let light_from_scene = parallel.rotation.transpose();
    let window = window(parallel, &scene.posed);
    // Casters beyond the edge are drawn as far as the filter reads.
    let size = (window.high - window.low).max(DVec2::ZERO);
    let drawn = Extent {
        low: window.low - size * (grown - 1.0) - mesh_error,
        high: window.high + size * (grown - 1.0) + mesh_error,
        ..window
    };
    let comes_in = |side: &OpenSide| side.normal.dot(parallel.direction()) >= 0.0;
    let clusters = &scene.casters.clusters;
    let mut extent = Extent::EMPTY;
    for tree in clusters.casting_trees(clusters.open_sides(comes_in)) {
        tree.walk(|cluster, has_more| {
            let Some(here) = Extent::of(cluster, &light_from_scene, &drawn) else { return false };
            if !has_more {
                extent.extend(&here);
            }
            has_more && !extent.contains(&here)
        });
    }
    let casts = extent.top > f64::NEG_INFINITY;
    let scene_size = scene.posed.half_extent.length().max(SMALLEST);
    let Extent { low, high, .. } =
        if casts { extent } else { Extent { low: DVec2::ZERO, high: DVec2::ZERO, ..window } };
    let half = (high - low) / 2.0;
    let least = (half.max_element() * SMALLEST_RATIO).max(scene_size * SMALLEST_SHARE);
    let bottom = -window.top.abs() - mesh_error;
    // A margin for rounding, so that no caster is clipped.
    let top = if casts { extent.top.max(bottom) + 1e-5 * scene_size } else { bottom + scene_size };
    DirectionalMapFit {
        center: (low + high) / 2.0,
        half: half.max(DVec2::splat(least)) * grown,
        heights: [bottom - 1e-5 * scene_size, top],
        has_casters: casts,
    }
}

impl GpuDirectional {
    /// Places a checked light within reach of a scene, with its fitted map.
    pub fn new(
        parallel: &Parallel,
        scene: &GpuScene,
        shadows: &ShadowSettings,
        fitted: &DirectionalMapFit,
    ) -> Self {
        let light_from_scene = parallel.rotation.transpose();
        let DirectionalMapFit { center, half, heights: [bottom, top], has_casters: casts } = *fitted;
        let depth_scale = (top - bottom).recip();
        let clip_from_light = DMat4::from_cols(
            DVec3::X.extend(0.0) / half.x,
            DVec3::Y.extend(0.0) / half.y,
            DVec3::Z.extend(0.0) * depth_scale,
            (-center / half).extend(-bottom * depth_scale).extend(1.0),
        );
        let light_from_scene = DMat4::from_mat3(light_from_scene);
        // Coordinates in the window are (v, w) = (-x, y) scale + shift.
        let scale = DVec2::from(parallel.half_size.map(|half| half.map_or(0.0, f64::recip)));
        let [shift_x, shift_y] = (parallel.offset_in_window(scene.posed.origin_in_world) * scale).to_array();
        Self {
            uniform: gpu_structs::Directional {
                light_from_scene: columns(&light_from_scene),
                window: [scale.x, scale.y, -shift_x, shift_y].map(|x| x as f32),
                fit: [center.x, center.y, half.x.recip(), half.y.recip()].map(|x| x as f32),
                light_profile: (&parallel.light_profile).into(),
                bottom: bottom as f32,
                depth_scale: depth_scale as f32,
                mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
                pad0: 0.0,
            },
            light_profile: parallel.light_profile.clone(),
            views: MapViews {
                light_from_scene,
                near: None,
                clip_from_light: vec![casts.then_some(clip_from_light)],
            },
        }
    }
}
