//! Shadow casters on a device.

use shadow::{CasterMesh, Clusters};

use super::alpha_test::AlphaTestedDraw;
use super::geometry::Vertices;
use super::scene_backend::SceneBackend;
use crate::RenderError;

#[cfg(test)]
pub(crate) mod tests;

/// Triangles of shadow maps, in scene space, in the order of their clusters. Triangles without an alpha test come first.
#[derive(Debug)]
pub(crate) struct Casters<B: SceneBackend> {
    pub uploaded: B::Casters,
    pub vertex_count: u32,
    pub triangle_count: u32,
    pub clusters: Clusters,
}

impl<B: SceneBackend> Casters<B> {
    /// Makes and uploads the shadow casters of the surface `vertices`, whose first `opaque_indices` indices have no
    /// alpha test. They have fewer triangles than the surface if `mesh_error`, their allowed distance from it in world
    /// units, permits.
    pub fn new(
        device: &B::Device,
        (vertices, opaque_indices): (&Vertices, usize),
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let mesh = || CasterMesh::new(&vertices.positions, &vertices.indices, opaque_indices, mesh_error);
        Self::upload(device, B::host_of(device).run_in_background(mesh)?)
    }

    pub fn upload(device: &B::Device, mut mesh: CasterMesh) -> Result<Self, RenderError> {
        let (vertex_count, triangle_count) = (mesh.positions.len() as u32, (mesh.indices.len() / 3) as u32);
        let clusters = std::mem::take(&mut mesh.clusters);
        Ok(Self { uploaded: B::upload_casters(device, mesh)?, vertex_count, triangle_count, clusters })
    }

    /// Returns the bytes of positions and indices.
    pub fn bytes(&self) -> u64 {
        B::caster_bytes(&self.uploaded)
    }
}

impl<B: SceneBackend> Clone for Casters<B> {
    fn clone(&self) -> Self {
        let Self { uploaded, vertex_count, triangle_count, clusters } = self;
        Self {
            uploaded: uploaded.clone(),
            vertex_count: *vertex_count,
            triangle_count: *triangle_count,
            clusters: clusters.clone(),
        }
    }
}

/// Shadow casters of a light: all of a scene, or those that the light's shadow links select.
#[derive(Debug)]
pub(crate) struct CasterSet<'a, B: SceneBackend> {
    pub casters: &'a Casters<B>,
    /// Alpha-tested triangles of the scene that cast shadows. Entry `k` has test `k`.
    pub alpha_tested: &'a [AlphaTestedDraw],
    /// Tests of `alpha_tested`; `None` if there are none.
    pub alpha_tests: Option<&'a B::AlphaTests>,
}

impl<B: SceneBackend> Clone for CasterSet<'_, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: SceneBackend> Copy for CasterSet<'_, B> {}
