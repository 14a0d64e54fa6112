//! Lights as lighting passes bind them, and the drawing of their maps.

use std::sync::Arc;

use shadow::{MapSize, PlacedLight};
use wgpu::{BindGroup, CommandEncoder};

use super::Wgpu;
use super::bendy_light::{Baked, BentMapBuffers};
use super::lighting::LightingPass;
use super::passes::Passes;
use super::straight::BakedStraight;
use super::straight_map::{ShadowMap, ShadowViews};
use crate::frame::stages::FrameStage;
use crate::frame::{MapSource, ReadyLight};
use crate::{Gpu, RenderError};

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

impl WgpuLight {
    pub fn new(gpu: &Gpu, passes: &Passes, map: &ShadowMap, placed: &PlacedLight) -> Self {
        match placed {
            PlacedLight::Straight(placed) => {
                let baked = BakedStraight::of(placed, map.target.size.layers > 1);
                let group = passes.straight.light_group(gpu, placed, &map.target);
                Self { kind: LightingKind::Straight(baked), group }
            }
            PlacedLight::Bent(placed) => {
                let baked = Baked::of(&placed.part.tube, placed.map.slope.is_some(), placed.map.filter);
                let group = passes.bendy.light_group(gpu, placed, &map.target);
                Self { kind: LightingKind::Bendy(baked), group }
            }
        }
    }
}

impl ReadyLight<Wgpu> {
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
        [&self.light.group].into_iter().chain(self.linked.as_ref().map(|linked| &linked.links)).collect()
    }
}

/// Draws the map of a light. Draws of straight lights are recorded in `encoder`; draws of bent lights are submitted at
/// once.
pub(crate) fn draw_map(
    gpu: &Gpu,
    passes: &Passes,
    encoder: &mut CommandEncoder,
    bent_buffers: &mut BentMapBuffers,
    map: &ShadowMap,
    placed: &PlacedLight,
    source: &MapSource<Wgpu>,
) -> Result<(), RenderError> {
    let placed = match placed {
        PlacedLight::Straight(placed) => placed,
        PlacedLight::Bent(placed) => {
            let Some(shape) = &placed.shape else { return Ok(()) };
            return passes.bendy.draw_map(gpu, bent_buffers, placed, shape, source, &map.target);
        }
    };
    let views = ShadowViews {
        clips_from_scene: &placed.clips_from_scene(),
        source: placed.source_in_scene,
        culling: source.shadows.culling,
    };
    let triangles = passes.straight.shadow.draw(gpu, encoder, map, views, source.scene, &source.casting)?;
    gpu.end_stage(encoder, FrameStage::Draw)?;
    let MapSize { side, layers } = map.target.size;
    gpu.host.stages.count(|counters| {
        counters.triangles_seen += triangles;
        counters.triangles_drawn += triangles;
        counters.texels += u64::from(layers) * u64::from(side).pow(2);
    });
    Ok(())
}
