//! What casts shadows: the scene's own triangles, or fewer that stray a little from them.

use std::sync::Arc;

use glam::Vec3;
use wgpu::{Buffer, BufferUsages};

use crate::alpha_test::GpuAlphaTests;
use crate::closed_components::connected;
use crate::clusters::Clusters;
use crate::geometry::{Vertices, upload};
use crate::material::MaterialDraw;
use crate::{Gpu, RenderError};

#[cfg(test)]
pub(crate) mod tests;

/// Meshoptimizer bounds the root of a mean of squared distances. The largest distance is up to 2.6 times
/// that, measured on balls and bowls of 9,000 to 160,000 triangles.
const MAX_TO_RMS_ERROR: f64 = 3.0;
/// The least such mean, of the extent of what is simplified: its square is 1.3 ulps of 1 in f32. With less,
/// rounding decides what is collapsed: up to 6 times the mean was seen.
const MIN_RELATIVE_RMS_ERROR: f64 = 4e-4;

/// The triangles that shadow maps are made of, in scene space, in the order in which their clusters have them.
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
    pub clusters: Clusters,
    /// The same in memory, where the processor draws.
    pub host: Option<Arc<HostCasters>>,
}

/// Casters in memory, for maps that the processor draws.
#[derive(Debug)]
pub(crate) struct HostCasters {
    pub positions: Vec<[f32; 3]>,
    /// As [`Casters::indices`].
    pub indices: Vec<u32>,
}

/// What casters are made of, before any of it is on a device.
pub(crate) struct CasterMesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    opaque_indices: usize,
    clusters: Clusters,
}

impl CasterMesh {
    /// See [`Casters::new`].
    pub fn new((vertices, opaque_indices): (&Vertices, usize), mesh_error: f64) -> Self {
        let simplified;
        let (positions, indices, opaque_indices) = if mesh_error > 0.0 {
            simplified = simplify(&vertices.positions, vertices.indices.split_at(opaque_indices), mesh_error);
            (&simplified.positions, &simplified.indices, simplified.opaque_indices)
        } else {
            (&vertices.positions, &vertices.indices, opaque_indices)
        };
        let triangles = indices.as_chunks().0;
        let (mut clusters, order) =
            Clusters::new(positions, triangles, (opaque_indices / 3, mesh_error > 0.0));
        let mut indices: Vec<u32> = order.iter().flat_map(|&triangle| triangles[triangle as usize]).collect();
        // In the order in which triangles need them, so that few blocks have those of a leaf.
        let positions = meshopt::optimize_vertex_fetch(&mut indices, positions);
        clusters.note_blocks(&indices);
        Self { positions, indices, opaque_indices, clusters }
    }

    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Puts it on a device.
    pub fn upload(self, gpu: &Gpu) -> Result<Casters, RenderError> {
        let Self { positions, indices, opaque_indices, clusters } = self;
        let (for_vertices, for_triangles) =
            (BufferUsages::STORAGE | BufferUsages::VERTEX, BufferUsages::STORAGE | BufferUsages::INDEX);
        Ok(Casters {
            positions: upload(gpu, "the shadow mesh's vertices in bytes", &positions, for_vertices)?,
            indices: upload(gpu, "the shadow mesh's indices in bytes", &indices, for_triangles)?,
            vertex_count: positions.len() as u32,
            triangle_count: (indices.len() / 3) as u32,
            opaque_indices: opaque_indices as u32,
            clusters,
            host: gpu.if_native(|| Arc::new(HostCasters { positions, indices })),
        })
    }
}

impl Casters {
    /// The surface of `vertices`, of whose indices the first `opaque_indices` have no alpha test, in fewer triangles where
    /// `mesh_error` (world units) lets it stray.
    pub fn new(gpu: &Gpu, surface: (&Vertices, usize), mesh_error: f64) -> Result<Self, RenderError> {
        gpu.run_in_background(|| CasterMesh::new(surface, mesh_error))?.upload(gpu)
    }

    /// Of its buffers and arrays.
    pub fn bytes(&self) -> u64 {
        let of = |host: &HostCasters| size_of_val(&host.positions[..]) + size_of_val(&host.indices[..]);
        self.positions.size() + self.indices.size() + self.host.as_deref().map_or(0, of) as u64
    }
}

/// What throws shadows in a light: all of a scene, or what its links leave.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CasterSet<'a> {
    pub casters: &'a Casters,
    /// The scene's own triangles that have an alpha test.
    pub alpha_tested: &'a [MaterialDraw],
    /// Those of `masked`; `None` where there are none.
    pub alpha_tests: Option<&'a GpuAlphaTests>,
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

/// Fewer triangles of what is connected, each part by itself: meshoptimizer measures in f32 against its whole
/// extent.
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
    /// Adds triangles and those of the vertices that they have.
    fn add(&mut self, positions: &[[f32; 3]], mut indices: Vec<u32>) {
        let used = meshopt::optimize_vertex_fetch(&mut indices, positions);
        let first = self.positions.len() as u32;
        self.indices.extend(indices.into_iter().map(|k| first + k));
        self.positions.extend(used);
    }
}
