//! Shadow maps of BendyLights: the part of the tube that may hold casters, its faces, and its slabs.

mod faces;
mod fit;
mod map_shape;
mod near_slabs;
mod slab;

use glam::{DMat3, DMat4, DVec3, Mat4};
use light::{EndMode, Light, LightPart, Tube};
use relight::BentMapParams;
use scene::PosedScene;

use crate::casters::{ClusterBounds, Clusters};
use crate::settings::ShadowSettings;

use faces::Faces;
pub(crate) use faces::face_count;
use fit::BendyFit;
pub use map_shape::MapShape;
pub use near_slabs::CastersNearSlabs;
pub use slab::{BoxedSlab, slab_bounds, slabs, slabs_of_map};

/// BendyLight in a scene, with its shadow map.
#[derive(Clone, Debug)]
pub struct PlacedBent {
    /// Part of the light that the scene contains. f32 cannot hold both a light far longer than the scene and that part.
    pub part: LightPart,
    /// Transform from scene space to the tube space of the part.
    pub tube_from_scene: Mat4,
    /// Shape of the map; `None` for a light without shadows.
    pub shape: Option<MapShape>,
    /// Numbers by which surfaces look up the map; those of an empty map for a light without shadows.
    pub map: BentMapParams,
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(tube: &Tube<f64>, posed: &PosedScene) -> Vec<DVec3> {
    let part = part_in(posed, tube);
    let slabs = light::slabs(&part.tube, t_max(&part.tube, posed.origin_in_world, posed.half_extent), 0.0);
    let corners = slabs.iter().flat_map(|slab| slab.slab_curve.bounds.corners());
    corners.map(|corner| part.tube.placement.world_from_tube(corner)).collect()
}

/// Returns the part of a light that a scene contains.
pub(crate) fn part_in(posed: &PosedScene, tube: &Tube<f64>) -> LightPart {
    tube.part_near(posed.origin_in_world, posed.half_extent)
}

/// Fits a map to the casters in the tube of a part, those within `mesh_error` of the scene's surface in world units.
pub(crate) fn fit_map(
    light: &Light,
    tube: &Tube<f64>,
    posed: &PosedScene,
    (clusters, mesh_error): (&Clusters, f64),
    settings: &ShadowSettings,
) -> MapShape {
    let (origin, faces) = (posed.origin_in_world, Faces::of(light));
    let t_max = t_max(tube, origin, posed.half_extent);
    let fit = BendyFit::new(tube, faces, t_max, origin, clusters, settings.culling);
    MapShape::new(fit, settings.map_size(faces.count()).side, mesh_error)
}

/// Returns the shape of a map of all of the tube of a part, with all casters, for a wireframe.
pub(crate) fn whole_map(
    light: &Light,
    tube: &Tube<f64>,
    posed: &PosedScene,
    clusters: &Clusters,
    settings: &ShadowSettings,
) -> MapShape {
    let faces = Faces::of(light);
    let fit = BendyFit::whole(faces, clusters, t_max(tube, posed.origin_in_world, posed.half_extent));
    MapShape::new(fit, settings.map_size(faces.count()).side, settings.mesh_error)
}

/// Places the part of a light in a scene, with the shape of its map.
pub(crate) fn placed(
    part: LightPart,
    posed: &PosedScene,
    settings: &ShadowSettings,
    shape: Option<&MapShape>,
) -> PlacedBent {
    let map = shape.map_or_else(
        || BentMapParams { filter: settings.filter, ..BentMapParams::default() },
        |shape| shape.params(&part.tube, settings),
    );
    let tube_from_scene = tube_from_scene(&part.tube, posed.origin_in_world);
    PlacedBent { part, tube_from_scene, shape: shape.copied(), map }
}

/// Returns the matrix from scene space (world axes, origin at `scene_origin`) to tube space, composed in f64.
pub fn tube_from_scene(tube: &Tube<f64>, scene_origin: DVec3) -> Mat4 {
    let placement = &tube.placement;
    let rotation = placement.rotation.transpose() * DMat3::from_diagonal(DVec3::splat(1.0 / placement.world_per_tube));
    let offset = placement.tube_from_world(scene_origin);
    let matrix = DMat4::from_cols(
        rotation.x_axis.extend(0.0),
        rotation.y_axis.extend(0.0),
        rotation.z_axis.extend(0.0),
        offset.extend(1.0),
    );
    matrix.as_mat4()
}

/// Returns the upper bound of t within `half_extent` of the scene's origin: the end of the light, or of the part of its
/// extension that reaches the scene.
pub fn t_max(tube: &Tube<f64>, scene_origin: DVec3, half_extent: DVec3) -> f64 {
    let n = tube.n as f64;
    if tube.end_mode() == EndMode::Cut {
        return n;
    }
    let last = &tube.segments[tube.n].curve;
    let scene = ClusterBounds { center: scene_origin, half: half_extent };
    let farthest = scene
        .corners()
        .into_iter()
        .map(|corner| (tube.placement.tube_from_world(corner) - last.b0).dot(last.d0))
        .fold(0.0, f64::max);
    // One percent more, so that the far corner itself is inside.
    n + (farthest / (2.0 * last.d0.length_squared())) * 1.01 + 1e-3
}
