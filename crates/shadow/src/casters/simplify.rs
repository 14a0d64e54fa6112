//! Simplifies opaque casters within an error.

use glam::Vec3;

use super::closed_components::connected;

#[cfg(test)]
mod tests;

/// Ratio of the largest distance to the root mean square that meshoptimizer bounds. Measured up to 2.6 on balls and
/// bowls of 9,000 to 160,000 triangles.
const MAX_TO_RMS_ERROR: f64 = 3.0;
/// Smallest usable root mean square error, as a share of the extent of the simplified mesh. Its square is 1.3 ulps of 1
/// in f32. Below it, rounding decides which edges collapse: errors up to 6 times the bound occurred.
const MIN_RELATIVE_RMS_ERROR: f64 = 4e-4;

#[derive(Default)]
pub(super) struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<u32>,
    pub opaque_indices: usize,
}

/// Collapses edges of the opaque triangles while the surface stays within `error` of the original, and drops unused
/// vertices.
pub(super) fn simplify(positions: &[[f32; 3]], (opaque, masked): (&[u32], &[u32]), error: f64) -> Mesh {
    // Vertices that differ only in normals or uvs are welded, so no edge between them can tear.
    let first_at = meshopt::generate_position_remap_decoder(positions);
    let corners = opaque.as_chunks::<3>().0.iter().map(|triangle| triangle.map(|k| first_at[k as usize]));
    let mut triangles: Vec<_> = corners.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let part_of = connected(positions.len(), &triangles);
    triangles.sort_by_key(|triangle| part_of[triangle[0] as usize]);

    let mut mesh = Mesh::default();
    let mut index_in_part = vec![u32::MAX; positions.len()];
    for part in triangles.chunk_by(|a, b| part_of[a[0] as usize] == part_of[b[0] as usize]) {
        let mut own_positions = Vec::new();
        let own_index = |&vertex: &u32| {
            let index = &mut index_in_part[vertex as usize];
            if *index == u32::MAX {
                *index = own_positions.len() as u32;
                own_positions.push(positions[vertex as usize]);
            }
            *index
        };
        let own_indices: Vec<_> = part.as_flattened().iter().map(own_index).collect();
        mesh.add(&own_positions, simplify_part(&own_positions, own_indices, error));
    }
    mesh.opaque_indices = mesh.indices.len();
    mesh.add(positions, masked.to_vec());
    mesh
}

/// Simplifies one connected component. meshoptimizer measures in f32 against the whole extent of its input.
fn simplify_part(positions: &[[f32; 3]], indices: Vec<u32>, error: f64) -> Vec<u32> {
    let points = || positions.iter().copied().map(Vec3::from);
    let extent = points().fold(Vec3::MIN, Vec3::max) - points().fold(Vec3::MAX, Vec3::min);
    let mean_error = error / MAX_TO_RMS_ERROR;
    if mean_error < MIN_RELATIVE_RMS_ERROR * f64::from(extent.max_element()) {
        return indices;
    }
    let mean_error = mean_error.min(f64::from(f32::MAX)) as f32;
    let options = meshopt::SimplifyOptions::ErrorAbsolute;
    meshopt::simplify_decoder(&indices, positions, 0, mean_error, options, None)
}

impl Mesh {
    /// Appends triangles with the vertices that they use.
    fn add(&mut self, positions: &[[f32; 3]], mut indices: Vec<u32>) {
        let used = meshopt::optimize_vertex_fetch(&mut indices, positions);
        let first = self.positions.len() as u32;
        self.indices.extend(indices.into_iter().map(|k| first + k));
        self.positions.extend(used);
    }
}
