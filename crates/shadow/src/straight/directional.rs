//! Directional lights. The map is one orthographic picture along the rays.

use glam::{DMat3, DMat4, DVec2, DVec3};
use light::Parallel;
use relight::DirectionalMapParams;
use scene::PosedScene;

use super::cover::FittedFace;
use super::{PlacedStraight, StraightCoords};
use crate::bounds::box_corners;
use crate::casters::{ClusterBounds, Clusters, MapCover, OpenSide};
use crate::settings::{MARGIN_TEXELS, SMALLEST_RATIO, SMALLEST_SHARE, ShadowSettings};

/// Smallest scene size, so that its inverse is within f32.
const SMALLEST: f64 = 1e-30;

/// Part of a scene that a directional light's map shows, in the light's axes around the scene's origin: x, y, and
/// height towards the light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OrthographicFit {
    pub drawn: FittedFace,
    /// Heights that have depth 0 and depth 1. The whole scene is above the first height, all casters are below the
    /// second.
    pub heights: [f64; 2],
}

impl OrthographicFit {
    /// Fit for a light that has no map.
    pub const NONE: Self =
        Self { drawn: FittedFace { center: DVec2::ZERO, half: DVec2::ONE, has_casters: false }, heights: [0.0, 1.0] };
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(parallel: &Parallel, posed: &PosedScene) -> [DVec3; 8] {
    let Extent { low, high, top } = window(parallel, posed);
    box_corners(low.extend(-top), high.extend(top)).map(|corner| posed.origin_in_world + parallel.rotation * corner)
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
}

impl MapCover for Extent {
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

/// Fits the map of a light to the casters in its window.
pub(crate) fn fit_map(
    parallel: &Parallel,
    posed: &PosedScene,
    clusters: &Clusters,
    settings: &ShadowSettings,
) -> OrthographicFit {
    let (side, mesh_error) = (f64::from(settings.map_size(1).side), settings.mesh_error);
    let grown = side / (side - 2.0 * MARGIN_TEXELS);
    let light_from_scene = parallel.rotation.transpose();
    let window = window(parallel, posed);
    // Casters beyond the edge are drawn as far as the filter reads.
    let size = (window.high - window.low).max(DVec2::ZERO);
    let drawn = Extent {
        low: window.low - size * (grown - 1.0) - mesh_error,
        high: window.high + size * (grown - 1.0) + mesh_error,
        ..window
    };
    let comes_in = |side: &OpenSide| side.normal.dot(parallel.direction()) >= 0.0;
    let mut extent = Extent::EMPTY;
    extent.extend_by_leaves(clusters.casting_trees(clusters.open_sides(comes_in)), |cluster| {
        Extent::of(cluster, &light_from_scene, &drawn)
    });
    let has_casters = extent.top > f64::NEG_INFINITY;
    let scene_size = posed.half_extent.length().max(SMALLEST);
    let Extent { low, high, .. } =
        if has_casters { extent } else { Extent { low: DVec2::ZERO, high: DVec2::ZERO, ..window } };
    let half = (high - low) / 2.0;
    let least = (half.max_element() * SMALLEST_RATIO).max(scene_size * SMALLEST_SHARE);
    let bottom = -window.top.abs() - mesh_error;
    // A margin for rounding, so that no caster is clipped.
    let top = if has_casters { extent.top.max(bottom) + 1e-5 * scene_size } else { bottom + scene_size };
    let half = half.max(DVec2::splat(least)) * grown;
    OrthographicFit {
        drawn: FittedFace { center: (low + high) / 2.0, half, has_casters },
        heights: [bottom - 1e-5 * scene_size, top],
    }
}

/// Places a checked light within reach of a scene, with its fitted map.
pub(crate) fn placed(
    parallel: &Parallel,
    posed: &PosedScene,
    settings: &ShadowSettings,
    fit: &OrthographicFit,
) -> PlacedStraight {
    let OrthographicFit { drawn, heights: [bottom, top] } = *fit;
    let FittedFace { center, half, has_casters } = drawn;
    let depth_scale = (top - bottom).recip();
    let clip_from_light = DMat4::from_cols(
        DVec3::X.extend(0.0) / half.x,
        DVec3::Y.extend(0.0) / half.y,
        DVec3::Z.extend(0.0) * depth_scale,
        (-center / half).extend(-bottom * depth_scale).extend(1.0),
    );
    // Coordinates in the window are (v, w) = (-x, y) scale + shift.
    let scale = DVec2::from(parallel.half_size.map(|half| half.map_or(0.0, f64::recip)));
    let [shift_x, shift_y] = (parallel.offset_in_window(posed.origin_in_world) * scale).to_array();
    PlacedStraight {
        light_from_scene: DMat4::from_mat3(parallel.rotation.transpose()),
        source_in_scene: None,
        light_profile: parallel.light_profile.clone(),
        coords: StraightCoords::Directional {
            window: [scale.x, scale.y, -shift_x, shift_y].map(|x| x as f32),
            map: DirectionalMapParams {
                fit: drawn.for_lookup(),
                bottom: bottom as f32,
                depth_scale: depth_scale as f32,
                mesh_error: settings.mesh_error_in_f32(),
                filter: settings.filter,
            },
        },
        near: None,
        clip_from_light: vec![has_casters.then_some(clip_from_light)],
    }
}
