//! A scene on a device, and as one renderer uses it.

use std::ops::Deref;
use std::sync::Arc;

use relight::AlphaTest;
use scene::PosedScene;

use super::alpha_test::{AlphaTestList, AlphaTestedDraw};
use super::camera::CameraRaster;
use super::casters::{CasterSet, Casters};
use super::geometry::{DrawRun, MaterialRange, Vertices, in_draw_order};
use super::memory::{MemoryKind, Reservation};
use super::scene_backend::{SceneBackend, SceneParts};
use super::tile::Tile;
use crate::RenderError;

/// Scene that is uploaded once and shared by renderers.
#[derive(Debug)]
pub(crate) struct SharedScene<B: SceneBackend> {
    pub posed: Arc<PosedScene>,
    pub triangle_count: u32,
    /// Number of leading indices whose triangles have no alpha test.
    pub opaque_indices: u32,
    /// Triangle ranges of each node.
    pub runs: Vec<DrawRun>,
    /// Triangles with an alpha test, one range per material.
    pub alpha_tested: Vec<AlphaTestedDraw>,
    /// Alpha tests of `alpha_tested`, and the same on the device; `None` if there are none.
    pub alpha_tests: Option<(Vec<AlphaTest>, B::AlphaTests)>,
    pub uploaded: B::Scene,
    /// Largest distance of the shadow casters from the surface in world units, and the casters.
    casters: (f64, Arc<Casters<B>>),
    /// Counts the memory of everything.
    _memory: Reservation,
}

/// Scene as one renderer uses it.
#[derive(Debug)]
pub(crate) struct FrameScene<B: SceneBackend> {
    /// Number that the renderer gives to each scene it is set to. Cached data of another number is invalid.
    pub revision: u64,
    pub casters: Arc<Casters<B>>,
    shared: Arc<SharedScene<B>>,
}

/// Scene as a camera sees it.
#[derive(Debug)]
pub(crate) struct SceneView<'a, B: SceneBackend> {
    pub scene: &'a FrameScene<B>,
    pub raster: &'a CameraRaster,
    /// Part of the picture that is drawn.
    pub tile: Tile,
}

impl<B: SceneBackend> Clone for SceneView<'_, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: SceneBackend> Copy for SceneView<'_, B> {}

impl<B: SceneBackend> Deref for FrameScene<B> {
    type Target = SharedScene<B>;

    fn deref(&self) -> &SharedScene<B> {
        &self.shared
    }
}

impl<B: SceneBackend> FrameScene<B> {
    /// Makes the scene of a renderer. Casters are within `mesh_error` of the surface, in world units.
    pub fn new(
        device: &B::Device,
        shared: Arc<SharedScene<B>>,
        revision: u64,
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let mut scene = Self { revision, casters: Arc::clone(&shared.casters.1), shared };
        if scene.shared.casters.0 != mesh_error {
            scene.casters = scene.casters_within(device, mesh_error)?.into();
        }
        Ok(scene)
    }

    /// Returns the shadow casters of lights without links.
    pub fn all_casters(&self) -> CasterSet<'_, B> {
        CasterSet {
            casters: &self.casters,
            alpha_tested: &self.alpha_tested,
            alpha_tests: self.alpha_tests.as_ref().map(|(_, tests)| tests),
        }
    }

    /// Returns the casters within `mesh_error` of the surface, in world units.
    pub fn casters_within(&self, device: &B::Device, mesh_error: f64) -> Result<Casters<B>, RenderError> {
        Casters::new(device, (&Vertices::new(&self.posed)?, self.opaque_indices as usize), mesh_error)
    }

    /// Returns the part that other renderers can share.
    pub fn shared(&self) -> &Arc<SharedScene<B>> {
        &self.shared
    }
}

impl<B: SceneBackend> SharedScene<B> {
    /// Uploads a scene. Casters are within `mesh_error` of the surface, in world units.
    pub fn upload(backend: &B, posed: &Arc<PosedScene>, mesh_error: f64) -> Result<Self, RenderError> {
        let (device, host) = (backend.device(), backend.host());
        let materials = &posed.scene.materials;
        let mut vertices = host.run_in_background(|| Vertices::new(posed))??;
        let is_alpha_tested = |range: &MaterialRange| materials[range.material].alpha_cutoff.is_some();
        let opaque_draws = vertices.draws.partition_point(|range| !is_alpha_tested(range));
        let opaque_indices = vertices.draws[..opaque_draws].last().map_or(0, |range| range.indices.end);
        let tested = &vertices.draws[opaque_draws..];
        let alpha_tested =
            (opaque_draws..).zip(tested).map(|(draw, range)| AlphaTestedDraw { draw, indices: range.indices.clone() });
        let alpha_tested: Vec<_> = alpha_tested.collect();
        let list = AlphaTestList::new(&posed.scene, tested);
        let alpha_tests = match list {
            Some(list) => Some((list.tests.clone(), B::upload_alpha_tests(device, list)?)),
            None => None,
        };
        let casters = Casters::<B>::new(device, (&vertices, opaque_indices as usize), mesh_error)?;
        host.yield_point()?;
        let (triangle_count, runs) = (vertices.planes.len() as u32, std::mem::take(&mut vertices.runs));
        let (hierarchy, hierarchy_triangles) = host.run_in_background(|| {
            let hierarchy = Arc::clone(posed.hierarchy());
            let triangles = in_draw_order(posed, &runs, &hierarchy.order);
            (hierarchy, triangles)
        })?;
        let parts = SceneParts { posed, vertices, hierarchy, hierarchy_triangles };
        let (uploaded, bytes) = backend.upload_scene(parts)?;
        host.yield_point()?;
        let tests = alpha_tests.as_ref().map_or(0, |(_, tests)| B::alpha_test_bytes(tests));
        let memory = host.memory.reserve(MemoryKind::Scenes, bytes + casters.bytes() + tests);
        Ok(Self {
            posed: Arc::clone(posed),
            triangle_count,
            opaque_indices,
            runs,
            alpha_tested,
            alpha_tests,
            uploaded,
            casters: (mesh_error, casters.into()),
            _memory: memory,
        })
    }
}
