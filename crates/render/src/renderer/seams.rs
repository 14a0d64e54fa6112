//! What tests of this crate reach into, to look at and to plant faults in.

use scene::View;

use super::Renderer;
use crate::bendy_light::{BentMapBuffers, MapShape};
use crate::coarse_casters::CoarseCasters;
use crate::gpu_scene::GpuScene;
use crate::targets::Targets;
use crate::{Gpu, ViewSlot};

impl Renderer {
    /// What bent shadow maps are made in, for tests to plant faults in.
    pub(crate) fn bent_buffers(&mut self) -> &mut BentMapBuffers {
        &mut self.shadow_maps.bent_buffers
    }

    /// Casters of coarse maps, for tests to look at and to plant faults in.
    pub(crate) fn coarse_casters(&mut self) -> &mut CoarseCasters {
        &mut self.shadow_maps.coarse
    }

    /// Spoils what the processor has drawn of maps of BendyLights, for tests to plant faults in: the next picture shows it.
    pub(crate) fn corrupt_native_maps(&mut self, fault: impl FnMut(&mut relight::DepthMap, &MapShape)) {
        self.shadow_maps.corrupt_native_maps(fault);
        self.viewers.invalidate();
    }

    /// The device and what is on it of the scene, for tests to plant faults in before the first picture.
    pub(crate) fn gpu_scene(&mut self) -> (&Gpu, &mut GpuScene) {
        (&self.gpu, &mut self.scene)
    }

    /// What pictures of a view are drawn into, for tests to look at.
    pub(crate) fn take_targets(&mut self, view: &View) -> Targets {
        self.viewers.take(&self.gpu, &self.passes, view).expect("it is small")
    }

    /// Puts that back.
    pub(crate) fn put_targets(&mut self, targets: Targets) {
        self.viewers.put(&self.gpu, ViewSlot::default(), targets);
    }
}
