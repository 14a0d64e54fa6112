//! What pictures are drawn into, and what it holds: a viewer's whole picture, or one tile of a larger one.

use std::sync::OnceLock;
use std::task::Poll;

use glam::DVec2;
use light::{LightDigest, LightId, LightInstance};
use wgpu::{CommandEncoder, Texture, TextureView, TextureViewDescriptor};

use crate::camera::CameraRaster;
use crate::composite::GpuTerms;
use crate::display::ExposedRadiance;
use crate::gbuffer::{self, GbufferKey, GbufferTexels, GbufferTextures};
use crate::gpu_scene::GpuScene;
use crate::layers::{LayerWork, Layers};
use crate::lights::ReadyLight;
use crate::memory::{Evictable, MemoryKind};
use crate::native_targets::{self, NativeTargets};
use crate::parts::{area, row_bands};
use crate::pass_runs::Cause;
use crate::passes::Passes;
use crate::pipeline::color_attachment;
use crate::stages::FrameStage;
use crate::tile::Tile;
use crate::wgpu_layers::WgpuLayers;
use crate::wgpu_maps::WgpuLight;
use crate::{Aov, Backend, Gpu, RenderError, View, ViewSlot, display, gpu_structs, lighting};

/// Bytes a pixel of radiance and of what a screen shows of it.
const LIT_BYTES_PER_PIXEL: u64 = 16 + 4;
/// Bytes a pixel of targets that the device lights.
const BYTES_PER_PIXEL: u64 = gbuffer::BYTES_PER_PIXEL + LIT_BYTES_PER_PIXEL;

/// The targets of every viewer.
#[derive(Debug, Default)]
pub(crate) struct Viewers(Vec<(ViewSlot, Evictable<Targets>)>);

/// What is made once a viewer and picture size.
#[derive(Debug)]
pub(crate) struct Targets {
    /// Width and height in pixels, of the tile where there is one.
    pub size: [u32; 2],
    gbuffer: GbufferTextures,
    /// What the G-buffer shows.
    gbuffer_key: Option<GbufferKey>,
    /// The same in memory, of what it was when it was last asked for.
    texels: (Option<GbufferKey>, GbufferTexels),
    /// What each light alone adds to what that shows.
    layers: Layers<TextureView, TextureView>,
    /// What the processor lights.
    pub native: NativeTargets,
    /// Made when the device first lights something.
    lit: OnceLock<LitTargets>,
    /// What the radiance shows: of which scene's revision, in which view, which tile, under which lights.
    radiance_key: Option<(u64, View, Tile, Vec<LightRevision>)>,
    /// Samples a pixel of it that have been added up.
    pub samples_drawn: u32,
    /// How many of the lights the sample after those has; `None` before it has anything.
    pub lights_drawn: Option<usize>,
}

/// What the device lights.
#[derive(Debug)]
pub(crate) struct LitTargets {
    pub radiance: Texture,
    pub radiance_view: TextureView,
    exposed: ExposedRadiance,
    pub display: Texture,
    display_view: TextureView,
}

/// A light and its revision of what pictures depend on.
type LightRevision = (LightId, LightDigest);

impl Viewers {
    /// The targets of the viewer of `view`, as it left them if the size is still the same. They are the caller's
    /// until it puts them back.
    pub fn take(&mut self, gpu: &Gpu, passes: &Passes, view: &View) -> Result<Targets, RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let side = view.width.max(view.height);
        if side > limit {
            let what = "the picture's width or height";
            return Err(RenderError::TooLarge { what, size: f64::from(side), limit: f64::from(limit) });
        }
        self.0.retain(|(_, targets)| targets.is_present());
        let size = [view.width, view.height];
        let kept = self.0.iter().find(|(slot, _)| *slot == view.slot).and_then(|(_, kept)| kept.take());
        if let Some(targets) = kept.filter(|targets| targets.size == size) {
            return Ok(targets);
        }
        self.drop_view(view.slot);
        gpu.make_room(bytes_of(gpu.backend_of(view.aov), size));
        Ok(Targets::new(gpu, passes, size))
    }

    /// Keeps the targets of a viewer for its next picture.
    pub fn put(&mut self, gpu: &Gpu, slot: ViewSlot, targets: Targets) {
        if let Some((_, kept)) = self.0.iter().find(|(known, _)| *known == slot) {
            kept.resize(targets.bytes());
            kept.put(targets);
        } else {
            let kept = gpu.memory.keep(MemoryKind::Views, targets.bytes(), targets);
            self.0.push((slot, kept));
        }
    }

    /// Draws everything anew when it is next asked for.
    pub fn invalidate(&mut self) {
        for (_, kept) in &self.0 {
            if let Some(mut targets) = kept.take() {
                targets.invalidate();
                kept.put(targets);
            }
        }
    }

    /// Drops the targets of a viewer.
    pub fn drop_view(&mut self, slot: ViewSlot) {
        self.0.retain(|(kept, _)| *kept != slot);
    }
}

/// Bytes of targets of `size` pixels at most, lit by `backend`; without layers.
pub(crate) fn bytes_of(backend: Backend, size: [u32; 2]) -> u64 {
    match backend {
        Backend::Wgpu => pixels(size) * BYTES_PER_PIXEL,
        Backend::Native => {
            let device = pixels(size) * gbuffer::BYTES_PER_PIXEL;
            device + GbufferTexels::bytes_of(size) + NativeTargets::max_bytes(size)
        }
    }
}

fn pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

impl LitTargets {
    fn new(gpu: &Gpu, passes: &Passes, [width, height]: [u32; 2]) -> Self {
        let radiance = gpu.target("radiance", width, height, lighting::FORMAT);
        let radiance_view = radiance.create_view(&TextureViewDescriptor::default());
        let display = gpu.target("display", width, height, display::FORMAT);
        Self {
            exposed: passes.display.bind_radiance(gpu, &radiance_view),
            radiance,
            radiance_view,
            display_view: display.create_view(&TextureViewDescriptor::default()),
            display,
        }
    }
}

impl Targets {
    pub fn new(gpu: &Gpu, passes: &Passes, size: [u32; 2]) -> Self {
        let [width, height] = size;
        Self {
            size,
            gbuffer: passes.gbuffer.targets(gpu, width, height),
            gbuffer_key: None,
            texels: (None, GbufferTexels::default()),
            layers: Layers::default(),
            native: NativeTargets::default(),
            lit: OnceLock::new(),
            radiance_key: None,
            samples_drawn: 0,
            lights_drawn: None,
        }
    }

    /// Of its textures, of what of them is in memory, and of what the processor made of that; without layers.
    fn bytes(&self) -> u64 {
        let lit = if self.lit.get().is_some() { LIT_BYTES_PER_PIXEL } else { 0 };
        let device = pixels(self.size) * (gbuffer::BYTES_PER_PIXEL + lit);
        device + self.texels.1.bytes() + self.native.bytes()
    }

    /// What the device lights.
    pub fn lit(&self, gpu: &Gpu, passes: &Passes) -> &LitTargets {
        self.lit.get_or_init(|| LitTargets::new(gpu, passes, self.size))
    }

    /// The G-buffer in memory, read back unless it is there as it was drawn last. What draws it has to be submitted.
    pub fn gbuffer_texels(&mut self, gpu: &Gpu) -> Result<&GbufferTexels, RenderError> {
        let (key, texels) = &mut self.texels;
        if *key != self.gbuffer_key {
            *key = None;
            texels.read(gpu, &self.gbuffer)?;
            *key = self.gbuffer_key;
        }
        Ok(texels)
    }

    /// Starts anew, unless the radiance shows this picture or the beginning of it.
    pub fn begin(&mut self, revision: u64, view: &View, tile: Tile, lights: &[LightInstance]) {
        let shown = lights.iter().map(|instance| (instance.id, instance.light.revisions().picture));
        // Radiance knows no exposure: a view that differs in it alone is only shown anew.
        let shown = Some((revision, View { exposure: 0.0, ..view.clone() }, tile, shown.collect()));
        if self.radiance_key != shown {
            self.radiance_key = shown;
            (self.samples_drawn, self.lights_drawn) = (0, None);
        }
    }

    /// Fills the G-buffer, unless it shows just this. Returns why it had to.
    pub fn draw_gbuffer(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene): (&Passes, &GpuScene),
        (raster, tile): (&CameraRaster, Tile),
        sample_offset: DVec2,
    ) -> Result<Option<Cause>, RenderError> {
        let size = [raster.width, raster.height];
        let key = GbufferKey {
            revision: scene.revision,
            world_from_camera: raster.world_from_camera,
            projection: raster.projection,
            size,
            tile,
            sample_offset,
        };
        let cause = match self.gbuffer_key {
            Some(before) if before == key => return Ok(None),
            before => key.cause_after(before.as_ref()),
        };
        // Until all of it is drawn it shows nothing.
        self.gbuffer_key = None;
        passes.gbuffer.draw(gpu, encoder, &self.gbuffer, (size, tile), scene)?;
        self.layers.invalidate();
        self.native.invalidate();
        self.gbuffer_key = Some(key);
        Ok(Some(cause))
    }

    /// Draws everything anew when it is next asked for.
    pub fn invalidate(&mut self) {
        (self.gbuffer_key, self.texels.0, self.radiance_key) = (None, None, None);
        self.layers.invalidate();
        self.native.invalidate();
    }

    /// As [`Self::draw_lights`]; where stages are taken down, what comes from no light and each light apart.
    pub fn draw_lighting(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        what: (&Passes, &GpuScene),
        onto: (Aov, Tile),
        (base, clear): (bool, bool),
        lights: &[ReadyLight<WgpuLight>],
    ) -> Result<(), RenderError> {
        let (_, scene) = what;
        let drawn: Vec<_> = lights.iter().map(|light| (light, onto.1.clip(light.pixels))).collect();
        if !gpu.stages.is_recording()
            && drawn.iter().all(|(_, pixels)| scene.part_count(gpu, area(*pixels)) == 1)
        {
            self.draw_lights(gpu, encoder, what, onto, (base, clear), &drawn);
            return Ok(());
        }
        if base {
            self.draw_lights(gpu, encoder, what, onto, (base, clear), &[]);
            gpu.end_stage(encoder, FrameStage::Fill)?;
        }
        for (light, pixels) in drawn {
            for (part, is_last) in row_bands(pixels, scene.part_count(gpu, area(pixels))) {
                self.draw_lights(gpu, encoder, what, onto, (false, false), &[(light, part)]);
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

    /// Adds to the radiance, or to nothing if it is the picture's beginning: what of one sample of `aov` comes from
    /// no light where `base`, and what comes from `lights`, each within those pixels of the `tile`.
    fn draw_lights(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene): (&Passes, &GpuScene),
        (aov, tile): (Aov, Tile),
        (base, clear): (bool, bool),
        lights: &[(&ReadyLight<WgpuLight>, [u32; 4])],
    ) {
        let radiance = &self.lit(gpu, passes).radiance_view;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[Some(color_attachment(radiance, clear))],
            ..Default::default()
        });
        pass.set_bind_group(0, &scene.view, &[]);
        pass.set_bind_group(1, &self.gbuffer.surface, &[]);
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

    /// Tone-maps the radiance, and what `terms` add to it, for a screen, brightened by so many stops.
    pub fn draw_display(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        passes: &Passes,
        (terms, exposure): (Option<&GpuTerms>, f64),
    ) {
        let lit = self.lit(gpu, passes);
        passes.display.draw(gpu, encoder, (&lit.exposed, terms, exposure), &lit.display_view);
    }

    /// Brings what each of `lights` alone adds up to date: the terms of what they add together, `None` where that is nothing. Pending
    /// where the picture pauses.
    pub fn draw_layers(
        &mut self,
        encoder: &mut CommandEncoder,
        passes: &Passes,
        work: &mut LayerWork,
        lights: &[LightInstance],
    ) -> Result<Poll<Option<GpuTerms>>, RenderError> {
        let (gpu, scene, size, surface) = (work.gpu, work.scene, self.size, &self.gbuffer.surface);
        let mut painter = WgpuLayers { gpu, passes, scene, surface, size, encoder };
        self.layers.draw((work, &mut painter), lights)
    }

    /// Has what the pixels of the upper left `size` see in memory, as the processor lights it. `view` is what the G-buffer was
    /// drawn with, which has to be submitted.
    pub fn prepare_surfaces(
        &mut self,
        gpu: &Gpu,
        scene: &GpuScene,
        (view, size): (&gpu_structs::View, [u32; 2]),
    ) -> Result<(), RenderError> {
        if self.native.has_surfaces() {
            return Ok(());
        }
        let row = self.size[0] as usize;
        let GbufferTexels { packed, offset, depth, .. } = self.gbuffer_texels(gpu)?;
        let gbuffer =
            relight::GbufferRows { size, row_stride: row, packed, z: depth, terminator_offset: offset };
        let surfaces = native_targets::surfaces(gpu, scene, view, &gbuffer)?;
        self.native.set_surfaces(surfaces);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
