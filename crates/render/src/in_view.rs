//! Selects the casters in the view of a straight light's map.

use std::ops::Range;

use glam::{DMat3, DMat4, DVec3};

use crate::casters::Casters;
use crate::closed_components::TriangleComponent;
use crate::clusters::{ClusterBounds, ClusterLeaf};
use crate::gpu_structs::Mat4;
use crate::shadow_settings::Culling;

/// Size of a source as a share of its distance, for rounding.
const ROUNDING: f64 = 1e-6;

/// Returns the index ranges of opaque leaves that `clip_from_scene` may see, with their component in that view:
/// `Closed` if front faces are counter-clockwise. Light begins at `source`, in scene space; `None` means outside the
/// scene. Closed components around the source count as `Open`.
pub(crate) fn visible_runs(
    casters: &Casters,
    clip_from_scene: &Mat4,
    source: Option<DVec3>,
    culling: Culling,
) -> Vec<(Range<u32>, TriangleComponent)> {
    let mirrored = is_mirrored(&in_f64(clip_from_scene));
    let mut runs: Vec<(Range<u32>, TriangleComponent)> = Vec::new();
    leaves_in_view(casters, clip_from_scene, source, culling, |leaf, component| {
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
    clusters.select(
        clusters.open_sides(|_| true),
        culling,
        source.as_ref(),
        |cluster| cluster.select_by_planes(&planes, 0.0),
        |leaf, component| {
            if 3 * leaf.triangles.end <= casters.opaque_indices {
                take(leaf, component);
            }
        },
    );
}

fn in_f64(matrix: &Mat4) -> DMat4 {
    DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
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
