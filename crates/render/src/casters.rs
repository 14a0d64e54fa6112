//! What casts shadows: the scene's own triangles, or fewer that stray a little from them.

use glam::Vec3;
use wgpu::{Buffer, BufferUsages};

use crate::alpha_test::AlphaTests;
use crate::geometry::{Vertices, upload};
use crate::material::MaterialDraw;
use crate::{Gpu, RenderError};

#[cfg(test)]
mod tests;

/// Meshoptimizer bounds the root of a mean of squared distances. The largest distance is up to 2.6 times
/// that, measured on balls and bowls of 9,000 to 160,000 triangles.
const LARGEST_OVER_MEAN: f64 = 3.0;
/// The least such mean, of the extent of what is simplified: its square is 1.3 ulps of 1 in f32. With less,
/// rounding decides what is collapsed: up to 6 times the mean was seen.
const LEAST_MEAN: f64 = 4e-4;

/// The triangles that shadow maps are made of, in scene space.
#[derive(Clone, Debug)]
pub(crate) struct Casters {
    /// `array<f32>`, three a vertex.
    pub positions: Buffer,
    /// Three a triangle; those without an alpha test come first.
    pub indices: Buffer,
    pub vertex_count: u32,
    pub triangle_count: u32,
    /// How many indices have no alpha test.
    pub opaque_indices: u32,
}

impl Casters {
    /// The same surface, whose triangles are those of `vertices`, in fewer where `mesh_error` (world units) lets it
    /// stray; at 0 these very buffers.
    pub fn simplified(&self, gpu: &Gpu, vertices: &Vertices, mesh_error: f64) -> Result<Self, RenderError> {
        if mesh_error == 0.0 {
            return Ok(self.clone());
        }
        let triangles = vertices.indices.split_at(self.opaque_indices as usize);
        let mesh = simplify(&vertices.positions, triangles, mesh_error);
        let (vertices, triangles) =
            (BufferUsages::STORAGE | BufferUsages::VERTEX, BufferUsages::STORAGE | BufferUsages::INDEX);
        Ok(Self {
            positions: upload(gpu, "the shadow mesh's vertices in bytes", &mesh.positions, vertices)?,
            indices: upload(gpu, "the shadow mesh's indices in bytes", &mesh.indices, triangles)?,
            vertex_count: mesh.positions.len() as u32,
            triangle_count: (mesh.indices.len() / 3) as u32,
            opaque_indices: mesh.opaque_indices as u32,
        })
    }
}

/// What throws shadows in a light: all of a scene, or what its links leave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Casting<'a> {
    pub casters: &'a Casters,
    /// The scene's own triangles that have an alpha test.
    pub masked: &'a [MaterialDraw],
    /// Those of `masked`; `None` where there are none.
    pub alpha_tests: Option<&'a AlphaTests>,
}

/// Triangles by their corners.
#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    opaque_indices: usize,
}

/// Collapses edges of the opaque triangles while the surface stays within `error` of what it was, and drops
/// the vertices that nothing needs any more.
fn simplify(positions: &[[f32; 3]], (opaque, masked): (&[u32], &[u32]), error: f64) -> Mesh {
    // Vertices that only normals or uvs tell apart are one: no edge between them can tear.
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

/// A number for each vertex, the same for those that triangles connect.
fn connected(vertex_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..vertex_count as u32).collect();
    let root = |parents: &mut Vec<u32>, mut vertex: u32| {
        while parents[vertex as usize] != vertex {
            let above = parents[vertex as usize];
            parents[vertex as usize] = parents[above as usize];
            vertex = above;
        }
        vertex
    };
    for &[a, b, c] in triangles {
        let to = root(&mut parents, a);
        for vertex in [b, c] {
            let from = root(&mut parents, vertex);
            parents[from as usize] = to;
        }
    }
    (0..vertex_count as u32).map(|vertex| root(&mut parents, vertex)).collect()
}

/// Fewer triangles of what is connected, each part by itself: meshoptimizer measures in f32 against its whole
/// extent.
fn simplify_part(positions: &[[f32; 3]], indices: Vec<u32>, error: f64) -> Vec<u32> {
    let points = || positions.iter().copied().map(Vec3::from);
    let extent = points().fold(Vec3::MIN, Vec3::max) - points().fold(Vec3::MAX, Vec3::min);
    let mean_error = error / LARGEST_OVER_MEAN;
    if mean_error < LEAST_MEAN * f64::from(extent.max_element()) {
        return indices;
    }
    let mean_error = mean_error.min(f64::from(f32::MAX)) as f32;
    let options = meshopt::SimplifyOptions::ErrorAbsolute;
    meshopt::simplify_decoder(&indices, positions, 0, mean_error, options, None)
}

impl Mesh {
    /// Adds triangles and those of the vertices that they have.
    fn add(&mut self, positions: &[[f32; 3]], mut indices: Vec<u32>) {
        let used = meshopt::optimize_vertex_fetch(&mut indices, positions);
        let first = self.positions.len() as u32;
        self.indices.extend(indices.into_iter().map(|k| first + k));
        self.positions.extend(used);
    }
}
