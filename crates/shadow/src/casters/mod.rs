//! Triangles that cast shadows: the scene's own, or fewer within an error.

mod closed_components;
mod clusters;
mod simplify;
mod visible;

pub use closed_components::TriangleComponent;
#[cfg(test)]
pub(crate) use clusters::of_opaque;
pub(crate) use clusters::{BoxSelection, MapCover, OpenSide, OpenSides};
pub use clusters::{ClusterBounds, ClusterLeaf, Clusters, TRIANGLES_PER_LEAF, VERTICES_PER_BLOCK};
pub(crate) use visible::{UsedBlocks, leaf_entry};
pub use visible::{VisibleLeaves, visible_runs};

use simplify::simplify;

/// Triangles of shadow maps in scene space, in the order of their clusters. Triangles without an alpha test come first.
#[derive(Clone, Debug)]
pub struct CasterMesh {
    pub positions: Vec<[f32; 3]>,
    /// Three per triangle.
    pub indices: Vec<u32>,
    pub clusters: Clusters,
}

impl CasterMesh {
    /// Makes the casters of a surface, whose first `opaque_indices` indices have no alpha test. They have fewer
    /// triangles than the surface if `mesh_error`, their allowed distance from it in world units, permits.
    pub fn new(positions: &[[f32; 3]], indices: &[u32], opaque_indices: usize, mesh_error: f64) -> Self {
        let simplified;
        let (positions, indices, opaque_indices) = if mesh_error > 0.0 {
            simplified = simplify(positions, indices.split_at(opaque_indices), mesh_error);
            (&simplified.positions[..], &simplified.indices[..], simplified.opaque_indices)
        } else {
            (positions, indices, opaque_indices)
        };
        let triangles = indices.as_chunks().0;
        let (mut clusters, order) = Clusters::new(positions, triangles, (opaque_indices / 3, mesh_error > 0.0));
        let mut indices: Vec<u32> = order.iter().flat_map(|&triangle| triangles[triangle as usize]).collect();
        // In the order of first use by triangles, so that the vertices of a leaf are in few blocks.
        let positions = meshopt::optimize_vertex_fetch(&mut indices, positions);
        clusters.note_blocks(&indices);
        Self { positions, indices, clusters }
    }

    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }
}
