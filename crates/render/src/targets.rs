//! Targets of pictures and their content: a viewer's whole picture, or one tile of a larger one.

use std::sync::OnceLock;
use std::task::Poll;

use glam::DVec2;
use light::{LightDigest, LightId, LightInstance};
use wgpu::{CommandEncoder, Texture, TextureView};

use crate::composite::GpuTerms;
use crate::display::ExposedRadiance;
use crate::gbuffer::{self, GbufferKey, GbufferTextures, GbufferView};
use crate::layers::{LayerWork, Layers};
use crate::lights::ReadyLight;
use crate::memory::{Evictable, MemoryKind};
use crate::native_targets::NativeTargets;
use crate::pass_runs::Cause;
use crate::passes::{DrawContext, Passes};
use crate::pipeline::{color_attachment, whole_view};
use crate::stages::FrameStage;
use crate::tile::{Tile, area, pixel_count, row_bands};
use crate::wgpu_layers::WgpuLayers;
use crate::wgpu_maps::WgpuLight;
use crate::{Aov, Backend, Gpu, RenderError, View, ViewSlot, display, lighting};

/// Bytes per pixel of radiance and of a screen's picture.
const LIT_BYTES_PER_PIXEL: u64 = 16 + 4;
/// Bytes per pixel of the targets of a picture that the GPU lights.
const BYTES_PER_PIXEL: u64 = gbuffer::BYTES_PER_PIXEL + LIT_BYTES_PER_PIXEL;

#[derive(Debug, Default)]
pub(crate) struct Viewers(Vec<(ViewSlot, Evictable<Targets>)>);

/// Textures and caches of one viewer and picture size.
#[derive(Debug)]
pub(crate) struct Targets {
    /// Width and height in pixels: of the tile, if the picture is drawn in tiles.
    pub size: [u32; 2],
    /// G-buffer on the device, created at first use.
    gbuffer: OnceLock<GbufferTextures>,
    /// Key of the G-buffer's content; `None` if it is invalid.
    gbuffer_key: Option<GbufferKey>,
    /// Layers of lights on the wgpu backend.
    layers: Layers<TextureView, TextureView>,
    pub native: NativeTargets,
    /// Textures for radiance and for the screen, created when the GPU first adds light.
    lit: OnceLock<LitTargets>,
    /// Key of the radiance: scene revision, view, tile, and lights with their digests.
    radiance_key: Option<(u64, View, Tile, Vec<LightRevision>)>,
    /// Number of samples per pixel that the radiance already contains.
    pub samples_drawn: u32,
    /// Number of lights that are already added to the next sample. `None` before that sample has begun.
    pub lights_drawn: Option<usize>,
}

#[derive(Debug)]
pub(crate) struct LitTargets {
    pub radiance: Texture,
    pub radiance_view: TextureView,
    exposed: ExposedRadiance,
    pub display: Texture,
    display_view: TextureView,
}

/// Light, with the digest of its values that affect pictures.
type LightRevision = (LightId, LightDigest);

impl Viewers {
    /// Takes the targets of the viewer of `view`, with their content if the size is unchanged. The caller must put them
    /// back.
    pub fn take(&mut self, gpu: &Gpu, view: &View) -> Result<Targets, RenderError> {
        gpu.check_picture_side(view.width.max(view.height))?;
        self.0.retain(|(_, targets)| targets.is_present());
        let size = [view.width, view.height];
        let kept = self.0.iter().find(|(slot, _)| *slot == view.slot).and_then(|(_, kept)| kept.take());
        if let Some(targets) = kept.filter(|targets| targets.size == size) {
            return Ok(targets);
        }
        self.drop_view(view.slot);
        gpu.make_room(bytes_of(gpu.backend(), size));
        Ok(Targets::new(size))
    }

    /// Caches the targets of a viewer for its next picture.
    pub fn put(&mut self, gpu: &Gpu, slot: ViewSlot, targets: Targets) {
        if let Some((_, kept)) = self.0.iter().find(|(known, _)| *known == slot) {
            kept.resize(targets.bytes());
            kept.put(targets);
        } else {
            let kept = gpu.memory.keep(MemoryKind::Views, targets.bytes(), targets);
            self.0.push((slot, kept));
        }
    }

    /// Marks all content as invalid, and keeps the memory.
    pub fn invalidate(&mut self) {
        for (_, kept) in &self.0 {
            if let Some(mut targets) = kept.take() {
                targets.invalidate();
                kept.put(targets);
            }
        }
    }

    pub fn drop_view(&mut self, slot: ViewSlot) {
        self.0.retain(|(kept, _)| *kept != slot);
    }
}

/// Returns the largest number of bytes of targets of `size` pixels, without layers. `backend` is the one that adds
/// light.
pub(crate) fn bytes_of(backend: Backend, size: [u32; 2]) -> u64 {
    match backend {
        Backend::Wgpu => pixel_count(size) * BYTES_PER_PIXEL,
        Backend::Native => NativeTargets::max_bytes(size),
    }
}

impl LitTargets {
    fn new(gpu: &Gpu, passes: &Passes, [width, height]: [u32; 2]) -> Self {
        let radiance = gpu.target("radiance", width, height, lighting::FORMAT);
        let radiance_view = whole_view(&radiance);
        let display = gpu.target("display", width, height, display::FORMAT);
        Self {
            exposed: passes.display.bind_radiance(gpu, &radiance_view),
            radiance,
            radiance_view,
            display_view: whole_view(&display),
            display,
        }
    }
}

impl Targets {
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            gbuffer: OnceLock::new(),
            gbuffer_key: None,
            layers: Layers::default(),
            native: NativeTargets::default(),
            lit: OnceLock::new(),
            radiance_key: None,
            samples_drawn: 0,
            lights_drawn: None,
        }
    }

    /// Returns the bytes of textures and of the native backend's data; without layers.
    fn bytes(&self) -> u64 {
        let lit = if self.lit.get().is_some() { LIT_BYTES_PER_PIXEL } else { 0 };
        let gbuffer = if self.gbuffer.get().is_some() { gbuffer::BYTES_PER_PIXEL } else { 0 };
        pixel_count(self.size) * (gbuffer + lit) + self.native.bytes()
    }

    /// Returns the G-buffer. Creates it at first use.
    fn gbuffer(&self, gpu: &Gpu, passes: &Passes) -> &GbufferTextures {
        let [width, height] = self.size;
        self.gbuffer.get_or_init(|| passes.gbuffer.targets(gpu, width, height))
    }

    /// Returns the textures to which the GPU adds light. Creates them at first use.
    pub fn lit(&self, gpu: &Gpu, passes: &Passes) -> &LitTargets {
        self.lit.get_or_init(|| LitTargets::new(gpu, passes, self.size))
    }

    /// Begins a picture. Clears the progress, unless the radiance already has a part of this picture.
    pub fn begin(&mut self, revision: u64, view: &View, tile: Tile, lights: &[LightInstance]) {
        let shown = lights.iter().map(|instance| (instance.id, instance.light.revisions().picture));
        // Radiance does not include exposure: a view that differs only in exposure is only tone-mapped again.
        let shown = Some((revision, View { exposure: 0.0, ..view.clone() }, tile, shown.collect()));
        if self.radiance_key != shown {
            self.radiance_key = shown;
            (self.samples_drawn, self.lights_drawn) = (0, None);
        }
    }

    /// Draws the G-buffer, unless it is valid for this key. Returns the cause if it was drawn.
    pub fn draw_gbuffer(
        &mut self,
        context: &DrawContext,
        encoder: &mut CommandEncoder,
        sample_offset: DVec2,
    ) -> Result<Option<Cause>, RenderError> {
        let DrawContext { gpu, passes, scene, tile, .. } = *context;
        let key = context.gbuffer_key(sample_offset);
        let cause = match self.gbuffer_key {
            Some(before) if before == key => return Ok(None),
            before => key.cause_after(before.as_ref()),
        };
        // Invalid until all of it is drawn.
        self.gbuffer_key = None;
        let shown = GbufferView { scene, size: key.size, tile };
        passes.gbuffer.draw(gpu, encoder, self.gbuffer(gpu, passes), shown)?;
        self.layers.invalidate();
        self.gbuffer_key = Some(key);
        Ok(Some(cause))
    }

    /// Marks all content as invalid, and keeps the memory.
    pub fn invalidate(&mut self) {
        (self.gbuffer_key, self.radiance_key) = (None, None);
        self.layers.invalidate();
        self.native.invalidate();
    }

    /// Calls [`Self::draw_lights`]. While stages are recorded, draws the fill and each light separately.
    pub fn draw_lighting(
        &self,
        context: &DrawContext,
        encoder: &mut CommandEncoder,
        aov: Aov,
        base: bool,
        clear: bool,
        lights: &[ReadyLight<WgpuLight>],
    ) -> Result<(), RenderError> {
        let DrawContext { gpu, scene, tile, .. } = *context;
        let drawn: Vec<_> = lights.iter().map(|light| (light, tile.clip(light.pixels))).collect();
        if !gpu.stages.is_recording() && drawn.iter().all(|(_, pixels)| scene.part_count(gpu, area(*pixels)) == 1) {
            self.draw_lights(context, encoder, aov, base, clear, &drawn);
            return Ok(());
        }
        if base {
            self.draw_lights(context, encoder, aov, base, clear, &[]);
            gpu.end_stage(encoder, FrameStage::Fill)?;
        }
        for (light, pixels) in drawn {
            for (part, is_last) in row_bands(pixels, scene.part_count(gpu, area(pixels))) {
                self.draw_lights(context, encoder, aov, false, false, &[(light, part)]);
                if !is_last {
                    gpu.submit_and_wait(encoder)?;
                    gpu.yield_point()?;
                }
            }
            gpu.end_stage(encoder, FrameStage::Light)?;
            gpu.stages.count(|counters| counters.scissor_pixels += area(pixels));
        }
        Ok(())
    }

    /// Adds one sample of `aov` to the radiance, or to zero if `clear`: the part without lights if `base`, and the
    /// contribution of `lights`, each within its pixels of the tile.
    fn draw_lights(
        &self,
        &DrawContext { gpu, passes, scene, tile, .. }: &DrawContext,
        encoder: &mut CommandEncoder,
        aov: Aov,
        base: bool,
        clear: bool,
        lights: &[(&ReadyLight<WgpuLight>, [u32; 4])],
    ) {
        let radiance = &self.lit(gpu, passes).radiance_view;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[Some(color_attachment(radiance, clear))],
            ..Default::default()
        });
        pass.set_bind_group(0, &scene.view, &[]);
        pass.set_bind_group(1, &self.gbuffer(gpu, passes).surface, &[]);
        let everywhere = [0, 0, tile.width, tile.height];
        match aov {
            Aov::Beauty if base => passes.fill.draw(gpu, &mut pass, aov, &[&scene.fill], everywhere),
            Aov::Depth | Aov::Normal if base => passes.inspect.draw(gpu, &mut pass, aov, &[], everywhere),
            _ => {}
        }
        for (light, pixels) in lights {
            light.lighting(gpu, passes).draw(gpu, &mut pass, aov, &light.groups(), *pixels);
        }
    }

    /// Tone-maps the radiance plus the sum of `terms` for a screen, with `exposure` in stops.
    pub fn draw_display(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        passes: &Passes,
        terms: Option<&GpuTerms>,
        exposure: f64,
    ) {
        let lit = self.lit(gpu, passes);
        passes.display.draw(gpu, encoder, &lit.exposed, terms, exposure, &lit.display_view);
    }

    /// Updates the layers of `lights`, and returns the terms of their sum; `None` if no light contributes. Pending if
    /// the picture pauses.
    pub fn draw_layers(
        &mut self,
        encoder: &mut CommandEncoder,
        work: &mut LayerWork,
        lights: &[LightInstance],
    ) -> Result<Poll<Option<GpuTerms>>, RenderError> {
        let DrawContext { gpu, passes, .. } = work.context;
        let gbuffer = self.gbuffer.get_or_init(|| passes.gbuffer.targets(gpu, self.size[0], self.size[1]));
        let surface = &gbuffer.surface;
        let mut painter = WgpuLayers { context: work.context, surface, size: self.size, encoder };
        self.layers.draw(work, &mut painter, lights)
    }
}

#[cfg(test)]
mod tests;
