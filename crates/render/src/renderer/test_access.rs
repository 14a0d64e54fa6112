//! Access for tests of this crate, to inspect data and to plant faults.

use scene::View;
use shadow::MapShape;

use super::Renderer;
use crate::Gpu;
use crate::bendy_light::BentMapBuffers;
use crate::coarse_casters::CoarseCasters;
use crate::gpu_scene::GpuScene;
use crate::targets::Targets;

impl Renderer {
    pub(crate) fn bent_buffers(&mut self) -> &mut BentMapBuffers {
        &mut self.shadow_maps.bent_buffers
    }

    pub(crate) fn coarse_casters(&mut self) -> &mut CoarseCasters {
        &mut self.shadow_maps.coarse
    }

    /// Corrupts the native backend's shadow maps of BendyLights, for tests: `fault` changes each map. The next picture
    /// shows the error.
    pub(crate) fn corrupt_native_maps(&mut self, fault: impl FnMut(&mut relight::DepthMap, &MapShape)) {
        self.shadow_maps.corrupt_native_maps(fault);
        self.viewers.invalidate();
    }

    /// Returns the device, and the scene on it. A test that makes a deliberate fault has to do so before the first
    /// picture.
    pub(crate) fn gpu_scene(&mut self) -> (&Gpu, &mut GpuScene) {
        (&self.gpu, &mut self.scene)
    }

    pub(crate) fn take_targets(&mut self, view: &View) -> Targets {
        self.viewers.take(&self.gpu, view).expect("it is small")
    }
}
