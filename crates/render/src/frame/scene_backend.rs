//! Interface by which scenes are kept on a device: the GPU, or CPU memory.

use std::fmt::Debug;
use std::sync::Arc;

use hierarchy::Hierarchy;
use relight::AlphaTest;
use scene::PosedScene;
use shadow::CasterMesh;

use super::alpha_test::AlphaTestList;
use super::geometry::Vertices;
use super::host::Host;
use crate::RenderError;

/// Uploads scenes for the renderers of a device.
pub(crate) trait SceneBackend: Debug + Sized + 'static {
    /// Device that any number of renderers share.
    type Device: Debug + Send + Sync;
    /// Scene on the device: geometry and materials.
    type Scene: Debug + Send + Sync;
    /// Triangles of shadow casters on the device.
    type Casters: Clone + Debug + Send + Sync;
    /// Alpha tests on the device, with the texels that they read.
    type AlphaTests: Debug + Send + Sync;
    /// Triangles that a light's links select, one bit per triangle.
    type Links: Debug + Send + Sync;

    fn device(&self) -> &Arc<Self::Device>;

    fn host_of(device: &Self::Device) -> &Host;

    /// Runs `work` on this thread, and returns errors of the device's driver as a `RenderError`.
    fn catch_errors<T>(device: &Self::Device, work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError>;

    /// Frees the memory of dropped data that no work under way uses.
    fn free_dropped_memory(&self);

    fn upload_casters(device: &Self::Device, mesh: CasterMesh) -> Result<Self::Casters, RenderError>;

    fn caster_bytes(casters: &Self::Casters) -> u64;

    fn upload_alpha_tests(device: &Self::Device, list: AlphaTestList) -> Result<Self::AlphaTests, RenderError>;

    /// Makes other tests over the texels of `known`.
    fn replace_alpha_tests(
        device: &Self::Device,
        known: &Self::AlphaTests,
        tests: Vec<AlphaTest>,
    ) -> Result<Self::AlphaTests, RenderError>;

    fn alpha_test_bytes(tests: &Self::AlphaTests) -> u64;

    /// Uploads geometry and materials. Also returns their bytes.
    fn upload_scene(&self, parts: SceneParts) -> Result<(Self::Scene, u64), RenderError>;

    /// Uploads two words for each 32 triangles, with one bit per triangle: `[0]` is set if the light lights it, `[1]` if
    /// it casts shadows. Also returns their bytes.
    fn upload_links(&self, bits: Vec<[u32; 2]>) -> (Self::Links, u64);

    fn host(&self) -> &Host {
        Self::host_of(self.device())
    }

    /// Calls [`crate::MemoryBudget::make_room`] and frees the memory of evicted data.
    fn make_room(&self, bytes: u64) -> bool {
        let memory = &self.host().memory;
        let before = memory.total();
        let room = memory.make_room(bytes);
        if memory.total() < before {
            self.free_dropped_memory();
        }
        room
    }
}

/// Geometry and materials to upload.
pub(crate) struct SceneParts<'a> {
    pub posed: &'a PosedScene,
    pub vertices: Vertices,
    pub hierarchy: Arc<Hierarchy>,
    /// The triangles in the order of the hierarchy's leaves.
    pub hierarchy_triangles: Vec<u32>,
}
