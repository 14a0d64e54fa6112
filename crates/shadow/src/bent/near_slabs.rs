//! Selects the casters near the slabs of one turn of a bent map.

use glam::DVec3;
use light::Tube;
use relight::MapSlab;

use super::map_shape::MapShape;
use super::slab::BoxedSlab;
use crate::casters::{BoxSelection, ClusterBounds, Clusters, UsedBlocks, leaf_entry};
use crate::settings::Culling;

/// Enlarges the source by this share of the light's size, for rounding.
const ROUNDING: f64 = 1e-6;

/// Leaves and blocks of casters near some slabs. They are the input of `map_triangles` and `map_vertices`, one entry
/// for each workgroup.
#[derive(Debug, Default)]
pub struct CastersNearSlabs {
    /// First triangle of a leaf; and its number of triangles in the low 16 bits, with its [`crate::TriangleComponent`]
    /// above.
    pub leaves: Vec<[u32; 2]>,
    /// Indices of blocks of vertices.
    pub blocks: Vec<u32>,
    pub triangles: u32,
}

/// Planes around a slab. `normal . p + offset` is the distance of a position p in scene space to the inside of a plane,
/// in units of the light's size.
struct Planes([(DVec3, f64); 6]);

impl CastersNearSlabs {
    /// Lists leaves and blocks of `clusters` with a box that touches one of `slabs`. A leaf on a closed component counts
    /// as closed only if the light begins outside the component.
    pub fn new(
        clusters: &Clusters,
        tube: &Tube<f64>,
        scene_origin: DVec3,
        map: &MapShape,
        slabs: &[BoxedSlab],
        culling: Culling,
    ) -> Self {
        let slabs: Vec<Planes> = slabs.iter().map(|boxed| Planes::new(&boxed.slab, tube, scene_origin)).collect();
        let source = source(tube, scene_origin);
        // In units of the light's size, which scales the rounding of its positions.
        let within =
            |cluster: &ClusterBounds| slabs.iter().map(|Planes(planes)| cluster.select_by_planes(planes, 1.0)).max();
        let mut blocks = UsedBlocks::none_of(clusters);
        let mut near = Self::default();
        clusters.select(
            map.open_sides(),
            culling,
            Some(&source),
            |cluster| within(cluster).unwrap_or(BoxSelection::Skip),
            |leaf, component| {
                near.leaves.push(leaf_entry(leaf, component));
                near.triangles += leaf.triangles.len() as u32;
                blocks.add(clusters, leaf);
            },
        );
        near.blocks = blocks.indices();
        near
    }
}

/// Bounds of the points where light paths begin.
fn source(tube: &Tube<f64>, scene_origin: DVec3) -> ClusterBounds {
    let curve = &tube.segments[0].curve;
    let center = tube.placement.world_from_tube(curve.b0) - scene_origin;
    let radius = curve.r0.abs() * tube.placement.world_per_tube;
    let slack = ROUNDING * (tube.placement.world_per_tube + center.abs().max_element());
    ClusterBounds { center, half: DVec3::splat(radius + slack) }
}

impl Planes {
    fn new(slab: &MapSlab, tube: &Tube<f64>, scene_origin: DVec3) -> Self {
        let placement = &tube.placement;
        let origin = placement.tube_from_world(scene_origin);
        Self(slab.planes.map(|plane| {
            let [x, y, z, w] = plane.map(f64::from);
            let normal = DVec3::new(x, y, z);
            (placement.rotation * normal / placement.world_per_tube, normal.dot(origin) + w)
        }))
    }
}
