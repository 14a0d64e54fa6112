//! Which of the casters a turn of a bent map looks at: those near its slabs.

use glam::DVec3;
use light::Tube;
use relight::MapSlab;

use super::map_shape::MapShape;
use crate::casters::Casters;
use crate::closed_components::TriangleComponent;
use crate::clusters::{BoxSelection, ClusterBounds, ClusterLeaf, VERTICES_PER_BLOCK};
use crate::shadow_settings::Culling;

/// A source is larger by this share of the light's size: rounding.
const ROUNDING: f64 = 1e-6;

/// Lists for `map_vertices` and `map_triangles`: an entry for each of their workgroups.
#[derive(Debug, Default)]
pub(super) struct CastersNearSlabs {
    /// First triangle of a leaf, and how many it has with its [`TriangleComponent`] above 16 bits.
    pub leaves: Vec<[u32; 2]>,
    /// Blocks of vertices.
    pub blocks: Vec<u32>,
    pub triangles: u32,
}

/// A slab: `normal . p + offset` of its planes is the distance inside, in the light's size, of a position in scene space.
struct Planes([(DVec3, f64); 6]);

impl CastersNearSlabs {
    /// What of `casters` has a box that touches one of `slabs`. Leaves that lie on closed surfaces which the light does not
    /// begin in are listed as such.
    pub fn new(
        casters: &Casters,
        (tube, scene_origin): (&Tube<f64>, DVec3),
        (map, slabs): (&MapShape, &[(MapSlab, [DVec3; 8])]),
        culling: Culling,
    ) -> Self {
        let slabs: Vec<Planes> =
            slabs.iter().map(|(slab, _)| Planes::new(slab, tube, scene_origin)).collect();
        let source = source(tube, scene_origin);
        let shell_of = |leaf: &ClusterLeaf| {
            if culling.backs { leaf.component_from(Some(&source)) } else { TriangleComponent::Open }
        };
        // In the light's size, by which its positions are rounded.
        let within = |cluster: &ClusterBounds| {
            slabs.iter().map(|Planes(planes)| cluster.select_by_planes(planes, 1.0)).max()
        };
        let clusters = &casters.clusters;
        let mut is_near = vec![false; (casters.vertex_count as usize).div_ceil(VERTICES_PER_BLOCK)];
        let mut near = Self::default();
        for tree in clusters.casting_trees(map.open_sides()) {
            tree.select(
                |cluster| {
                    if culling.clusters {
                        within(cluster).unwrap_or(BoxSelection::Skip)
                    } else {
                        BoxSelection::TakeAll
                    }
                },
                |leaf| {
                    let leaf = &clusters.leaves[leaf as usize];
                    let count = leaf.triangles.len() as u32;
                    near.leaves.push([leaf.triangles.start, count | (shell_of(leaf) as u32) << 16]);
                    near.triangles += count;
                    for &block in clusters.blocks_of(leaf) {
                        is_near[block as usize] = true;
                    }
                },
            );
        }
        near.blocks =
            (0_u32..).zip(is_near).filter_map(|(block, is_near)| is_near.then_some(block)).collect();
        near
    }
}

/// Around all places where paths begin.
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

#[cfg(test)]
mod tests;
