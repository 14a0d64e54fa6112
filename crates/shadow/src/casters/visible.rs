//! Selects the casters in the view of a straight light's map.

use std::ops::Range;

use glam::{DMat3, DMat4, DVec3, Mat4};

use super::closed_components::TriangleComponent;
use super::clusters::{ClusterBounds, ClusterLeaf, Clusters};
use crate::settings::Culling;

/// Size of a source as a share of its distance, for rounding.
const ROUNDING: f64 = 1e-6;

/// Leaves of casters that the faces of a map may show, for a backend that reads leaves.
#[derive(Debug, Default)]
pub struct VisibleLeaves {
    /// List of leaves for each face. An entry is the index of the leaf's first triangle; and its number of triangles in
    /// the low 16 bits, with its [`TriangleComponent`] above.
    pub faces: Vec<Vec<[u32; 2]>>,
    /// Indices of the blocks of vertices that the leaves use.
    pub blocks: Vec<u32>,
    /// Number of triangles, once for each face that may show it.
    pub triangles: u64,
}

/// Set of the blocks of vertices that selected leaves use.
pub(crate) struct UsedBlocks(Vec<bool>);

impl UsedBlocks {
    pub fn none_of(clusters: &Clusters) -> Self {
        Self(vec![false; clusters.block_count as usize])
    }

    pub fn add(&mut self, clusters: &Clusters, leaf: &ClusterLeaf) {
        for &block in clusters.blocks_of(leaf) {
            self.0[block as usize] = true;
        }
    }

    pub fn indices(self) -> Vec<u32> {
        (0..).zip(self.0).filter_map(|(block, is_used)| is_used.then_some(block)).collect()
    }
}

/// Returns the entry of a leaf in lists of leaves; see [`VisibleLeaves::faces`].
pub(crate) fn leaf_entry(leaf: &ClusterLeaf, component: TriangleComponent) -> [u32; 2] {
    [leaf.triangles.start, leaf.triangles.len() as u32 | (component as u32) << 16]
}

impl VisibleLeaves {
    /// Lists the leaves that each face may show; none for a face without a projection. Light begins at `source`, in
    /// scene space; `None` means outside the scene.
    pub fn new(
        clusters: &Clusters,
        clips_from_scene: &[Option<Mat4>],
        source: Option<DVec3>,
        culling: Culling,
    ) -> Self {
        let (mut blocks, mut triangles) = (UsedBlocks::none_of(clusters), 0);
        let leaves_of = |clip_from_scene: &Option<Mat4>| {
            let mut leaves = Vec::new();
            let Some(clip_from_scene) = clip_from_scene else { return leaves };
            leaves_in_view(clusters, clip_from_scene, source, culling, |leaf, component| {
                leaves.push(leaf_entry(leaf, component));
                triangles += leaf.triangles.len() as u64;
                blocks.add(clusters, leaf);
            });
            leaves
        };
        let faces = clips_from_scene.iter().map(leaves_of).collect();
        Self { faces, blocks: blocks.indices(), triangles }
    }
}

/// Returns the index ranges of opaque leaves that `clip_from_scene` may see, with their component in that view:
/// `Closed` if front faces are counter-clockwise. Light begins at `source`, in scene space; `None` means outside the
/// scene. Closed components around the source count as `Open`.
pub fn visible_runs(
    clusters: &Clusters,
    clip_from_scene: &Mat4,
    source: Option<DVec3>,
    culling: Culling,
) -> Vec<(Range<u32>, TriangleComponent)> {
    let mirrored = is_mirrored(&clip_from_scene.as_dmat4());
    let mut runs: Vec<(Range<u32>, TriangleComponent)> = Vec::new();
    leaves_in_view(clusters, clip_from_scene, source, culling, |leaf, component| {
        let indices = 3 * leaf.triangles.start..3 * leaf.triangles.end;
        let component = if mirrored { component.mirrored() } else { component };
        match runs.last_mut() {
            Some((run, same)) if run.end == indices.start && *same == component => run.end = indices.end,
            _ => runs.push((indices, component)),
        }
    });
    runs
}

/// Passes leaves without alpha tests that `clip_from_scene` may see to a callback, with their component for light from
/// `source`.
fn leaves_in_view(
    clusters: &Clusters,
    clip_from_scene: &Mat4,
    source: Option<DVec3>,
    culling: Culling,
    mut take: impl FnMut(&ClusterLeaf, TriangleComponent),
) {
    let planes = planes(&clip_from_scene.as_dmat4());
    let source = source.map(|center| {
        let half = DVec3::splat(ROUNDING * center.abs().max_element());
        ClusterBounds { center, half }
    });
    clusters.select(
        clusters.open_sides(|_| true),
        culling,
        source.as_ref(),
        |cluster| cluster.select_by_planes(&planes, 0.0),
        |leaf, component| {
            if leaf.triangles.end <= clusters.opaque_triangles {
                take(leaf, component);
            }
        },
    );
}

/// Returns the planes of the four sides of the picture, with `normal . p + offset` zero or more inside.
fn planes(clip_from_scene: &DMat4) -> [(DVec3, f64); 4] {
    let [x, y, w] = [0, 1, 3].map(|row| clip_from_scene.row(row));
    [w + x, w - x, w + y, w - y].map(|plane| (plane.truncate(), plane.w))
}

/// True if the picture shows counter-clockwise triangles clockwise, seen from the light.
fn is_mirrored(clip_from_scene: &DMat4) -> bool {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| clip_from_scene.row(row).truncate());
    // In orthographic projection, depth gives the direction of light: it decreases along it.
    let forward = if w == DVec3::ZERO { -z } else { w };
    DMat3::from_cols(x, y, forward).determinant() > 0.0
}
