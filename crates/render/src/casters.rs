//! Triangles that cast shadows: the scene's own, or fewer within an error.

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

/// Ratio of the largest distance to the root mean square that meshoptimizer bounds. Measured up to 2.6 on balls and
/// bowls of 9,000 to 160,000 triangles.
const MAX_TO_RMS_ERROR: f64 = 3.0;
/// Smallest usable root mean square error, as a share of the extent of the simplified mesh. Its square is 1.3 ulps of 1
/// in f32. Below it, rounding decides which edges collapse: errors up to 6 times the bound occurred.
const MIN_RELATIVE_RMS_ERROR: f64 = 4e-4;

/// Triangles of shadow maps, in scene space, in the order of their clusters.
#[derive(Clone, Debug)]
pub(crate) struct Casters {
    /// `array<f32>`, three per vertex.
    pub positions: Buffer,
    /// Three per triangle; triangles without an alpha test come first.
    pub indices: Buffer,
    pub vertex_count: u32,
    pub triangle_count: u32,
    /// Number of leading indices whose triangles have no alpha test.
    pub opaque_indices: u32,
    pub clusters: Clusters,
    /// Positions and indices in CPU memory, for the native backend; `None` on the wgpu backend.
    pub host: Option<Arc<HostCasters>>,
}

/// Casters in CPU memory, for the native backend's maps.
#[derive(Debug)]
pub(crate) struct HostCasters {
    pub positions: Vec<[f32; 3]>,
    /// Indices in the order of [`Casters::indices`].
    pub indices: Vec<u32>,
}

/// Shadow casters in CPU memory, before they are uploaded.
pub(crate) struct CasterMesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    opaque_indices: usize,
    clusters: Clusters,
}

impl CasterMesh {
    /// Makes the casters for a surface, as [`Casters::new`] states, without uploading them.
    pub fn new((vertices, opaque_indices): (&Vertices, usize), mesh_error: f64) -> Self {
        let simplified;
        let (positions, indices, opaque_indices) = if mesh_error > 0.0 {
            simplified = simplify(&vertices.positions, vertices.indices.split_at(opaque_indices), mesh_error);
            (&simplified.positions, &simplified.indices, simplified.opaque_indices)
        } else {
            (&vertices.positions, &vertices.indices, opaque_indices)
        };
        let triangles = indices.as_chunks().0;
        let (mut clusters, order) = Clusters::new(positions, triangles, (opaque_indices / 3, mesh_error > 0.0));
        let mut indices: Vec<u32> = order.iter().flat_map(|&triangle| triangles[triangle as usize]).collect();
        // In the order of first use by triangles, so that the vertices of a leaf are in few blocks.
        let positions = meshopt::optimize_vertex_fetch(&mut indices, positions);
        clusters.note_blocks(&indices);
        Self { positions, indices, opaque_indices, clusters }
    }

    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

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
    /// Makes and uploads the shadow casters of the surface `vertices`, whose first `opaque_indices` indices have no
    /// alpha test. They have fewer triangles than the surface if `mesh_error`, their allowed distance from it in world
    /// units, permits.
    pub fn new(gpu: &Gpu, surface: (&Vertices, usize), mesh_error: f64) -> Result<Self, RenderError> {
        gpu.run_in_background(|| CasterMesh::new(surface, mesh_error))?.upload(gpu)
    }

    /// Returns the bytes of the buffers and of arrays in CPU memory.
    pub fn bytes(&self) -> u64 {
        let of = |host: &HostCasters| size_of_val(&host.positions[..]) + size_of_val(&host.indices[..]);
        self.positions.size() + self.indices.size() + self.host.as_deref().map_or(0, of) as u64
    }
}

/// Shadow casters of a light: all of a scene, or those that the light's shadow links select.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CasterSet<'a> {
    pub casters: &'a Casters,
    /// Alpha-tested triangles of the scene that cast shadows.
    pub alpha_tested: &'a [MaterialDraw],
    /// Tests of `alpha_tested`; `None` if there are none.
    pub alpha_tests: Option<&'a GpuAlphaTests>,
}

#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    opaque_indices: usize,
}

/// Collapses edges of the opaque triangles while the surface stays within `error` of the original, and drops unused
/// vertices.
fn simplify(positions: &[[f32; 3]], (opaque, masked): (&[u32], &[u32]), error: f64) -> Mesh {
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
