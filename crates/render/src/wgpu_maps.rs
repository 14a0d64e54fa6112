//! Shadow maps on the GPU, and lights as their passes bind them.

use std::sync::Arc;

use shadow::{MapSize, PlacedLight};
use wgpu::{BindGroup, CommandEncoder};

use crate::backend::Backend;
use crate::bendy_light::Baked;
use crate::lighting::LightingPass;
use crate::lights::ReadyLight;
use crate::map_painter::{MapBuilders, MapPainter, MapStorage};
use crate::map_source::MapSource;
use crate::passes::Passes;
use crate::stages::FrameStage;
use crate::straight::BakedStraight;
use crate::straight_map::{ShadowMap, ShadowViews};
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

    fn storage(&self, size: MapSize) -> MapStorage {
        MapStorage::Wgpu(self.passes.straight.shadow.new_map(self.gpu, size))
    }

    fn draw(
        &mut self,
        storage: &mut MapStorage,
        placed: &PlacedLight,
        source: &MapSource,
        builders: MapBuilders,
    ) -> Result<(), RenderError> {
        let (Self { gpu, passes, encoder }, map) = (self, wgpu_map(storage));
        let placed = match placed {
            PlacedLight::Straight(placed) => placed,
            PlacedLight::Bent(placed) => {
                let Some(shape) = &placed.shape else { return Ok(()) };
                return passes.bendy.draw_map(gpu, builders.bent_buffers, placed, shape, source, &map.target);
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
        gpu.stages.count(|counters| {
            counters.triangles_seen += triangles;
            counters.triangles_drawn += triangles;
            counters.texels += u64::from(layers) * u64::from(side).pow(2);
        });
        Ok(())
    }

    fn light(&self, storage: &MapStorage, placed: PlacedLight) -> WgpuLight {
        let (Self { gpu, passes, .. }, map) = (self, wgpu_map(storage));
        match placed {
            PlacedLight::Straight(placed) => {
                let baked = BakedStraight::of(&placed, map.target.size.layers > 1);
                let group = passes.straight.light_group(gpu, &placed, &map.target);
                WgpuLight { kind: LightingKind::Straight(baked), group }
            }
            PlacedLight::Bent(placed) => {
                let is_cube = placed.map.slope.is_some();
                let baked = Baked::of(&placed.part.tube, is_cube, placed.map.filter);
                WgpuLight {
                    kind: LightingKind::Bendy(baked),
                    group: passes.bendy.light_group(gpu, &placed, &map.target),
                }
            }
        }
    }
}

fn wgpu_map(storage: &MapStorage) -> &ShadowMap {
    let MapStorage::Wgpu(map) = storage else { unreachable!("the storage was made for the GPU") };
    map
}
