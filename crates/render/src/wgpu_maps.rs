//! Shadow maps on the GPU, and lights as their passes bind them.

use std::sync::Arc;

use light::{CheckedLight, LightRays};
use wgpu::{BindGroup, CommandEncoder};

use crate::backend::Backend;
use crate::bendy_light::{Baked, BendyPass};
use crate::gpu_scene::GpuScene;
use crate::lighting::LightingPass;
use crate::lights::{LightSlot, MapBuilders, MapPainter, ReadyLight};
use crate::linked::LinkedCasters;
use crate::map_key::MapKey;
use crate::passes::Passes;
use crate::shadow_settings::MapSize;
use crate::straight::{BakedStraight, StraightLight};
use crate::{Gpu, RenderError, ShadowSettings};

/// Draws shadow maps of lights in a scene on the GPU. Draws of straight lights are recorded in `encoder`; draws of bent
/// lights are submitted at once.
pub(crate) struct WgpuMaps<'a> {
    pub gpu: &'a Gpu,
    pub passes: &'a Passes,
    pub scene: &'a GpuScene,
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
            LightingKind::Straight(baked) => passes.straight.lighting(gpu, baked, is_linked),
            LightingKind::Bendy(baked) => passes.bendy.lighting(gpu, baked, is_linked),
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
        (key, light): (MapKey, &CheckedLight),
        (linked, shadows): (Option<&LinkedCasters>, &ShadowSettings),
        MapBuilders { bent_buffers: bent_work, coarse, .. }: MapBuilders,
    ) -> Result<(WgpuLight, bool), RenderError> {
        let Self { gpu, passes, scene, encoder } = self;
        let what = (*scene, linked, shadows);
        let (kind, group, drawn) = match (slot, light.rays(), StraightLight::of(light)) {
            (LightSlot::Bendy(slot), LightRays::Bent(tube), _) => {
                let of = (key, light, tube);
                let (placed, drawn) = passes.bendy.prepare(gpu, bent_work, slot, of, what, coarse)?;
                (LightingKind::Bendy(placed.baked), placed.group, drawn)
            }
            (LightSlot::Straight(slot), _, Some(straight)) => {
                let ready = passes.straight.prepare(gpu, encoder, slot, (key, straight), what)?;
                let kind = LightingKind::Straight(straight.baked(shadows.filter));
                (kind, ready.group, ready.drawn)
            }
            _ => unreachable!("the slot was chosen or made for this kind of light"),
        };
        Ok((WgpuLight { kind, group }, drawn))
    }
}
