//! Surfaces, layers and sums of a view or a tile on the native backend.

use std::sync::Arc;
use std::task::Poll;

use glam::Mat4;
use light::{CheckedLight, LightInstance};
use relight::{
    CameraRays, DrawnLight, Exposure, FillColors, LayerSum, LayerTerms, LightAov, LightLayer, PicturePart, SurfaceAov,
    SurfaceScene, Surfaces, VisibilityBuffer, VisibilityBuilder, VisibleTriangles,
};
use scene::Projection;

use crate::gbuffer::GbufferKey;
use crate::host_scene::{caster_scene, host_materials};
use crate::layers::{LayerWork, Layers, factors};
use crate::lights::ReadyLight;
use crate::native_layers::{NativeLayers, NativeTerms};
use crate::native_map::NativeLight;
use crate::pass_runs::Cause;
use crate::passes::DrawContext;
use crate::stages::FrameStage;
use crate::tile::{area, pixel_count};
use crate::{Gpu, RenderError, gpu_structs};

/// Surfaces that pixels show, in CPU memory, with the light that was added up on them.
#[derive(Debug, Default)]
pub(crate) struct NativeTargets {
    /// Surfaces, and what they were made from; `None` until needed.
    surfaces: Option<(GbufferKey, Surfaces)>,
    layers: Layers<Arc<LightLayer>, Arc<LayerSum>>,
    /// Sum of the lights added so far in the current sample.
    sample_sum: LayerSum,
    /// Sum of the samples before the current one: linear RGBA, rows from the top.
    radiance: Vec<[f32; 4]>,
}

/// Memory for drawing the surfaces of pictures, reused from one to the next.
#[derive(Debug, Default)]
pub(crate) struct SurfacesBuilder {
    visible: VisibilityBuffer,
    builder: VisibilityBuilder,
}

impl SurfacesBuilder {
    /// Draws the surfaces of the context's tile. `view` is the uniform of the camera.
    fn draw(
        &mut self,
        &DrawContext { gpu, scene, raster, tile, .. }: &DrawContext,
        view: &gpu_structs::View,
    ) -> Result<Surfaces, RenderError> {
        let (triangles, host) = (caster_scene(scene, None), host_materials(scene));
        let near = match raster.projection {
            Projection::Perspective { znear, .. } => Some(znear as f32),
            Projection::Orthographic { .. } => None,
        };
        let part = PicturePart {
            clip_from_scene: Mat4::from_cols_array_2d(&view.clip_from_scene),
            near,
            camera: camera(view),
            whole: [raster.width, raster.height].map(|side| side as usize),
            first: [tile.x, tile.y].map(|pixels| pixels as usize),
            size: [tile.width, tile.height].map(|side| side as usize),
        };
        let drawn = VisibleTriangles { scene: &triangles, both_sides: &host.both_sides };
        self.builder.draw(gpu.workers(), &drawn, &part, &mut self.visible)?;
        gpu.stages.record_stage(FrameStage::Gbuffer);
        let fill = &scene.posed.scene.fill;
        let fill = FillColors { sky: fill.sky.as_vec3().to_array(), ground: fill.ground.as_vec3().to_array() };
        let shown = SurfaceScene { triangles: &triangles, materials: &host.materials };
        let surfaces = Surfaces::new(gpu.workers(), &shown, part.camera, fill, &self.visible)?;
        gpu.stages.record_stage(FrameStage::Surfaces);
        Ok(surfaces)
    }
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
        let surfaces = self.surfaces.as_ref().map_or(0, |(_, surfaces)| surfaces.bytes());
        surfaces + LayerSum::bytes(self.sample_sum.block_count()) + size_of_val(&self.radiance[..]) as u64
    }

    /// True if the surfaces are those of `key`.
    pub fn shows(&self, key: &GbufferKey) -> bool {
        self.surfaces.as_ref().is_some_and(|(shown, _)| shown == key)
    }

    /// Draws the surfaces of `key`, unless they are there. Returns the cause if they were drawn. `view` is the uniform of
    /// the camera.
    pub fn draw_surfaces(
        &mut self,
        context: &DrawContext,
        builder: &mut SurfacesBuilder,
        key: GbufferKey,
        view: &gpu_structs::View,
    ) -> Result<Option<Cause>, RenderError> {
        if self.shows(&key) {
            return Ok(None);
        }
        let cause = key.cause_after(self.surfaces.as_ref().map(|(before, _)| before));
        // Frees the old surfaces first, so that two never coexist.
        self.invalidate();
        self.surfaces = Some((key, builder.draw(context, view)?));
        Ok(Some(cause))
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

    /// Adds one sample of `aov`, times `weight`, to the radiance. The first sample replaces the radiance.
    pub fn add_surface_aov(&mut self, gpu: &Gpu, aov: SurfaceAov, is_first: bool, weight: f32) {
        self.begin_radiance(is_first);
        relight::add_surface_aov(expect_surfaces(self.surfaces.as_ref()), aov, weight, &mut self.radiance);
        gpu.stages.record_stage(FrameStage::Fill);
    }

    /// Adds one sample of `aov` of the light in `ready`, times `weight`, to the radiance. The first sample replaces the
    /// radiance. Tile and pixels are as in [`Self::add_light`].
    pub fn add_light_aov(
        &mut self,
        &DrawContext { gpu, scene, tile, .. }: &DrawContext,
        ready: Option<&ReadyLight<NativeLight>>,
        aov: LightAov,
        is_first: bool,
        weight: f32,
    ) -> Result<(), RenderError> {
        self.begin_radiance(is_first);
        let Some(ready) = ready else { return Ok(()) };
        let surfaces = expect_surfaces(self.surfaces.as_ref());
        let NativeLight { light, map } = &ready.light;
        let scene = caster_scene(scene, ready.linked.as_deref());
        let pixels = tile.clip(ready.pixels);
        let drawn = DrawnLight { light, map: map.as_deref(), pixels };
        relight::add_light_aov(gpu.workers(), surfaces, &scene, drawn, aov, weight, &mut self.radiance)?;
        gpu.stages.record_stage(FrameStage::Light);
        Ok(())
    }

    /// Returns the radiance as a picture of that size to draw on. What is there has no meaning.
    pub fn picture(&mut self, size: [u32; 2]) -> &mut [[f32; 4]] {
        self.radiance.resize(pixel_count(size) as usize, [0.0; 4]);
        &mut self.radiance
    }

    /// Makes the radiance zero before the first sample.
    fn begin_radiance(&mut self, is_first: bool) {
        if is_first {
            let [width, height] = expect_surfaces(self.surfaces.as_ref()).size().map(|side| side as usize);
            self.radiance.clear();
            self.radiance.resize(width * height, [0.0; 4]);
        }
    }

    /// Adds the current sample and the fill, times `weight`, to the radiance. The first sample replaces the radiance.
    pub fn end_sample(&mut self, gpu: &Gpu, is_first: bool, fill_factor: f32, weight: f32) {
        self.begin_radiance(is_first);
        let surfaces = expect_surfaces(self.surfaces.as_ref());
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

fn expect_surfaces(surfaces: Option<&(GbufferKey, Surfaces)>) -> &Surfaces {
    &surfaces.expect("whoever lights pixels has had them see").1
}
