//! Which of the casters a straight light's map looks at: those in its view.

use std::ops::Range;

use glam::{DMat3, DMat4, DVec3};

use crate::casters::Casters;
use crate::closed_components::TriangleComponent;
use crate::clusters::{BoxSelection, ClusterBounds, ClusterLeaf};
use crate::gpu_structs::Mat4;
use crate::shadow_settings::Culling;

/// A source is as large as this share of its distance: rounding.
const ROUNDING: f64 = 1e-6;

/// The opaque indices of leaves that may be seen by `clip_from_scene`, and what they are of as that view has it: `Closed`
/// where their fronts are counter-clockwise. Light begins at `source`, in scene space, or where that is `None` outside of
/// the scene; what is closed around it is `Open`.
pub(crate) fn visible_runs(
    casters: &Casters,
    clip_from_scene: &Mat4,
    source: Option<DVec3>,
    culling: Culling,
) -> Vec<(Range<u32>, TriangleComponent)> {
    let mirrored = is_mirrored(&in_f64(clip_from_scene));
    let mut runs: Vec<(Range<u32>, TriangleComponent)> = Vec::new();
    leaves_in_view(casters, clip_from_scene, source, culling, |leaf, shell| {
        let indices = 3 * leaf.triangles.start..3 * leaf.triangles.end;
        let shell = if mirrored { shell.mirrored() } else { shell };
        match runs.last_mut() {
            Some((run, same)) if run.end == indices.start && *same == shell => run.end = indices.end,
            _ => runs.push((indices, shell)),
        }
    });
    runs
}

/// Hands over the leaves without alpha tests that may be seen by `clip_from_scene`, and what they are of as light that begins
/// at `source` has it.
pub(crate) fn leaves_in_view(
    casters: &Casters,
    clip_from_scene: &Mat4,
    source: Option<DVec3>,
    culling: Culling,
    mut take: impl FnMut(&ClusterLeaf, TriangleComponent),
) {
    let planes = planes(&in_f64(clip_from_scene));
    let source = source.map(|center| {
        let half = DVec3::splat(ROUNDING * center.abs().max_element());
        ClusterBounds { center, half }
    });
    let clusters = &casters.clusters;
    for tree in clusters.casting_trees(clusters.open_sides(|_| true)) {
        tree.select(
            |cluster| {
                if culling.clusters { cluster.select_by_planes(&planes, 0.0) } else { BoxSelection::TakeAll }
            },
            |leaf| {
                let leaf = &clusters.leaves[leaf as usize];
                if 3 * leaf.triangles.end <= casters.opaque_indices {
                    take(
                        leaf,
                        if culling.backs {
                            leaf.component_from(source.as_ref())
                        } else {
                            TriangleComponent::Open
                        },
                    );
                }
            },
        );
    }
}

fn in_f64(matrix: &Mat4) -> DMat4 {
    DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
}

/// `normal . p + offset` is zero or more on the inner side of each of the four sides of the picture.
fn planes(clip_from_scene: &DMat4) -> [(DVec3, f64); 4] {
    let [x, y, w] = [0, 1, 3].map(|row| clip_from_scene.row(row));
    [w + x, w - x, w + y, w - y].map(|plane| (plane.truncate(), plane.w))
}

/// Whether the picture shows clockwise what is counter-clockwise seen from where light comes from.
fn is_mirrored(clip_from_scene: &DMat4) -> bool {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| clip_from_scene.row(row).truncate());
    // Without perspective depth tells which way light goes: it falls along that.
    let forward = if w == DVec3::ZERO { -z } else { w };
    DMat3::from_cols(x, y, forward).determinant() > 0.0
}
