//! Surfaces, layers and sums of a view or a tile on the native backend.

use std::sync::Arc;
use std::task::Poll;

use light::{CheckedLight, LightInstance};
use relight::{CameraRays, DrawnLight, Exposure, FillColors, GbufferRows, LayerSum, LayerTerms, LightLayer, Surfaces};

use crate::gpu_scene::GpuScene;
use crate::host_scene::caster_scene;
use crate::layers::{LayerWork, Layers, factors};
use crate::lights::ReadyLight;
use crate::native_layers::{NativeLayers, NativeTerms};
use crate::native_map::NativeLight;
use crate::passes::DrawContext;
use crate::stages::FrameStage;
use crate::tile::{area, pixel_count};
use crate::{Gpu, RenderError, gpu_structs};

/// Surfaces that pixels show, in CPU memory, with the light that was added up on them.
#[derive(Debug, Default)]
pub(crate) struct NativeTargets {
    /// Surfaces of the latest G-buffer; `None` until needed.
    surfaces: Option<Surfaces>,
    layers: Layers<Arc<LightLayer>, Arc<LayerSum>>,
    /// Sum of the lights added so far in the current sample.
    sample_sum: LayerSum,
    /// Sum of the samples before the current one: linear RGBA, rows from the top.
    radiance: Vec<[f32; 4]>,
}

/// Unpacks the surfaces of a G-buffer that was drawn with `view`.
pub(crate) fn surfaces(
    gpu: &Gpu,
    scene: &GpuScene,
    view: &gpu_structs::View,
    gbuffer: &GbufferRows,
) -> Result<Surfaces, RenderError> {
    let fill = &scene.posed.scene.fill;
    let fill = FillColors { sky: fill.sky.as_vec3().to_array(), ground: fill.ground.as_vec3().to_array() };
    let surfaces = Surfaces::new(gpu.workers(), &caster_scene(scene, None), camera(view), fill, gbuffer)?;
    gpu.stages.record_stage(FrameStage::Surfaces);
    Ok(surfaces)
}

fn camera(view: &gpu_structs::View) -> CameraRays {
    CameraRays {
        origin: view.ray_origin,
        origin_dx: view.ray_origin_dx,
        origin_dy: view.ray_origin_dy,
        direction: view.ray_direction,
        direction_dx: view.ray_direction_dx,
        direction_dy: view.ray_direction_dy,
        depth_from_z: view.depth_from_z,
        tile_origin: view.tile_origin,
    }
}

impl NativeTargets {
    /// Returns the largest size in bytes, without layers, for pictures of `size`.
    pub fn max_bytes(size: [u32; 2]) -> u64 {
        let (blocks, radiance) = (Surfaces::max_blocks(size), pixel_count(size) * size_of::<[f32; 4]>() as u64);
        Surfaces::bytes_of(blocks) + LayerSum::bytes(blocks) + radiance
    }

    /// Returns the bytes, without layers.
    pub fn bytes(&self) -> u64 {
        let surfaces = self.surfaces.as_ref().map_or(0, Surfaces::bytes);
        surfaces + LayerSum::bytes(self.sample_sum.block_count()) + size_of_val(&self.radiance[..]) as u64
    }

    pub fn has_surfaces(&self) -> bool {
        self.surfaces.is_some()
    }

    pub fn set_surfaces(&mut self, surfaces: Surfaces) {
        self.surfaces = Some(surfaces);
    }

    /// Drops the surfaces, and marks the layers as invalid.
    pub fn invalidate(&mut self) {
        self.surfaces = None;
        self.layers.invalidate();
    }

    /// Updates the layers of `lights`, and returns a screen's bytes of their sum with the fill. Pending if the picture
    /// pauses.
    pub fn draw_layers(
        &mut self,
        work: &mut LayerWork,
        lights: &[LightInstance],
        fill_factor: f32,
        exposure: Exposure,
    ) -> Result<Poll<Vec<u8>>, RenderError> {
        let (gpu, surfaces) = (work.context.gpu, expect_surfaces(self.surfaces.as_ref()));
        let mut painter = NativeLayers { context: work.context, surfaces };
        let Poll::Ready(terms) = self.layers.draw(work, &mut painter, lights)? else {
            return Ok(Poll::Pending);
        };
        let terms = terms.unwrap_or(NativeTerms::Layers(Vec::new()));
        let bytes = terms.with(|terms| relight::display(gpu.workers(), surfaces, terms, fill_factor, exposure));
        gpu.stages.record_stage(FrameStage::Display);
        Ok(Poll::Ready(bytes))
    }

    /// Begins a sample with a sum of zero.
    pub fn begin_sample(&mut self, gpu: &Gpu) {
        let surfaces = expect_surfaces(self.surfaces.as_ref());
        relight::sum(gpu.workers(), surfaces, LayerTerms::Layers(&[]), &mut self.sample_sum);
    }

    /// Adds the contribution of `light` to the current sample. The context's tile is the part of the picture that these
    /// targets hold. The pixels in `ready` are those of the whole picture.
    pub fn add_light(
        &mut self,
        &DrawContext { gpu, scene, tile, .. }: &DrawContext,
        light: &CheckedLight,
        ready: &ReadyLight<NativeLight>,
    ) -> Result<(), RenderError> {
        let surfaces = expect_surfaces(self.surfaces.as_ref());
        let NativeLight { light: shape, map } = &ready.light;
        let scene = caster_scene(scene, ready.linked.as_deref());
        let pixels = tile.clip(ready.pixels);
        let drawn = DrawnLight { light: shape, map: map.as_deref(), pixels };
        relight::add_light(gpu.workers(), surfaces, &scene, drawn, factors(light), &mut self.sample_sum)?;
        gpu.stages.record_stage(FrameStage::Light);
        gpu.stages.count(|counters| counters.scissor_pixels += area(pixels));
        Ok(())
    }

    /// Writes the visibility of the light in `ready` as radiance, with tile and pixels as in [`Self::add_light`].
    pub fn draw_visibility(
        &mut self,
        &DrawContext { gpu, scene, tile, .. }: &DrawContext,
        ready: Option<&ReadyLight<NativeLight>>,
    ) -> Result<(), RenderError> {
        let surfaces = expect_surfaces(self.surfaces.as_ref());
        let [width, height] = surfaces.size().map(|side| side as usize);
        let Some(ready) = ready else {
            self.radiance = vec![[0.0; 4]; width * height];
            return Ok(());
        };
        let NativeLight { light, map } = &ready.light;
        let scene = caster_scene(scene, ready.linked.as_deref());
        let pixels = tile.clip(ready.pixels);
        let drawn = DrawnLight { light, map: map.as_deref(), pixels };
        self.radiance = relight::visibility_of(gpu.workers(), surfaces, &scene, drawn)?;
        gpu.stages.record_stage(FrameStage::Light);
        Ok(())
    }

    /// Adds the current sample and the fill, times `weight`, to the radiance. The first sample replaces the radiance.
    pub fn end_sample(&mut self, gpu: &Gpu, is_first: bool, fill_factor: f32, weight: f32) {
        let surfaces = expect_surfaces(self.surfaces.as_ref());
        let [width, height] = surfaces.size().map(|side| side as usize);
        if is_first {
            self.radiance.clear();
            self.radiance.resize(width * height, [0.0; 4]);
        }
        let terms = [&self.sample_sum];
        let terms = LayerTerms::Sums(&terms);
        relight::add_sample(gpu.workers(), surfaces, terms, fill_factor, weight, &mut self.radiance);
        gpu.stages.record_stage(FrameStage::Sum);
    }

    /// Returns the sum of the samples: linear RGBA, rows from the top.
    pub fn radiance(&self) -> &[[f32; 4]] {
        &self.radiance
    }
}

fn expect_surfaces(surfaces: Option<&Surfaces>) -> &Surfaces {
    surfaces.expect("whoever lights pixels has had them see")
}
