//! Shadow maps on the GPU, and lights as their passes bind them.

use std::sync::Arc;

use light::{CheckedLight, LightRays};
use wgpu::{BindGroup, CommandEncoder};

use crate::backend::Backend;
use crate::bendy_light::{Baked, BendyPass};
use crate::lighting::LightingPass;
use crate::lights::{LightSlot, MapBuilders, MapPainter, ReadyLight};
use crate::linked::CasterSource;
use crate::map_key::MapKey;
use crate::passes::Passes;
use crate::shadow_settings::MapSize;
use crate::straight::{BakedStraight, StraightLight};
use crate::{Gpu, RenderError};

/// Draws shadow maps of lights in a scene on the GPU. Draws of straight lights are recorded in `encoder`; draws of bent
/// lights are submitted at once.
pub(crate) struct WgpuMaps<'a> {
    pub gpu: &'a Gpu,
    pub passes: &'a Passes,
    pub encoder: &'a mut CommandEncoder,
}

/// Light with the bind groups of its lighting pass.
#[derive(Debug)]
pub(crate) struct WgpuLight {
    kind: LightingKind,
    group: BindGroup,
}

#[derive(Clone, Copy, Debug)]
enum LightingKind {
    Straight(BakedStraight),
    Bendy(Baked),
}

impl ReadyLight<WgpuLight> {
    /// Returns the light's pass.
    pub fn lighting(&self, gpu: &Gpu, passes: &Passes) -> Arc<LightingPass> {
        let is_linked = self.linked.is_some();
        match self.light.kind {
            LightingKind::Straight(baked) => passes.straight.lighting.get(gpu, baked, is_linked),
            LightingKind::Bendy(baked) => passes.bendy.lighting.get(gpu, baked, is_linked),
        }
    }

    /// Returns the light's bind groups, which follow those of the view and the surface.
    pub fn groups(&self) -> Vec<&BindGroup> {
        [&self.light.group].into_iter().chain(self.linked.as_ref().map(|linked| &linked.group)).collect()
    }
}

impl MapPainter for WgpuMaps<'_> {
    type Light = WgpuLight;
    const BACKEND: Backend = Backend::Wgpu;

    fn slot(&self, light: &CheckedLight, size: MapSize) -> LightSlot {
        match light.rays() {
            LightRays::Cone(_) | LightRays::Omni(_) | LightRays::Parallel(_) => {
                LightSlot::Straight(Box::new(self.passes.straight.slot(self.gpu, size)))
            }
            LightRays::Bent(_) => LightSlot::Bendy(Box::new(BendyPass::slot(self.gpu, size))),
        }
    }

    fn prepare(
        &mut self,
        slot: &mut LightSlot,
        key: MapKey,
        light: &CheckedLight,
        source: CasterSource,
        builders: MapBuilders,
    ) -> Result<(WgpuLight, bool), RenderError> {
        let Self { gpu, passes, encoder } = self;
        let (kind, group, drawn) = match (slot, StraightLight::of(light)) {
            (LightSlot::Bendy(slot), None) => {
                let (placed, drawn) = passes.bendy.prepare(gpu, builders.bent_buffers, slot, key, light, source)?;
                (LightingKind::Bendy(placed.baked), placed.group, drawn)
            }
            (LightSlot::Straight(slot), Some(straight)) => {
                let (group, drawn) = passes.straight.prepare(gpu, encoder, slot, key, straight, source)?;
                (LightingKind::Straight(straight.baked(source.shadows.filter)), group, drawn)
            }
            _ => unreachable!("the slot was chosen or made for this kind of light"),
        };
        Ok((WgpuLight { kind, group }, drawn))
    }
}
