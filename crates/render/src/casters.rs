//! Shadow casters on the device.

use std::sync::Arc;

use shadow::{CasterMesh, Clusters};
use wgpu::{Buffer, BufferUsages};

use crate::alpha_test::GpuAlphaTests;
use crate::geometry::{Vertices, upload};
use crate::material::MaterialDraw;
use crate::{Gpu, RenderError};

#[cfg(test)]
pub(crate) mod tests;

/// Triangles of shadow maps, in scene space, in the order of their clusters.
#[derive(Clone, Debug)]
pub(crate) struct Casters {
    /// `array<f32>`, three per vertex.
    pub positions: Buffer,
    /// Three per triangle; triangles without an alpha test come first.
    pub indices: Buffer,
    pub vertex_count: u32,
    pub triangle_count: u32,
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

impl Casters {
    /// Makes and uploads the shadow casters of the surface `vertices`, whose first `opaque_indices` indices have no
    /// alpha test. They have fewer triangles than the surface if `mesh_error`, their allowed distance from it in world
    /// units, permits.
    pub fn new(
        gpu: &Gpu,
        (vertices, opaque_indices): (&Vertices, usize),
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let mesh = || CasterMesh::new(&vertices.positions, &vertices.indices, opaque_indices, mesh_error);
        Self::upload(gpu, gpu.run_in_background(mesh)?)
    }

    pub fn upload(gpu: &Gpu, mesh: CasterMesh) -> Result<Self, RenderError> {
        let CasterMesh { positions, indices, clusters } = mesh;
        let (for_vertices, for_triangles) =
            (BufferUsages::STORAGE | BufferUsages::VERTEX, BufferUsages::STORAGE | BufferUsages::INDEX);
        Ok(Self {
            positions: upload(gpu, "the shadow mesh's vertices in bytes", &positions, for_vertices)?,
            indices: upload(gpu, "the shadow mesh's indices in bytes", &indices, for_triangles)?,
            vertex_count: positions.len() as u32,
            triangle_count: (indices.len() / 3) as u32,
            clusters,
            host: gpu.if_native(|| Arc::new(HostCasters { positions, indices })),
        })
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
