//! What pictures are drawn into, and what it holds: a viewer's whole picture, or one tile of a larger one.

use glam::{DAffine3, DVec2};
use light::{Digest, LightId, LightInstance};
use scene::Projection;
use wgpu::{CommandEncoder, Texture, TextureView, TextureViewDescriptor};

use crate::camera::Raster;
use crate::composite::Terms;
use crate::display::Exposed;
use crate::gbuffer::Gbuffer;
use crate::gpu_scene::GpuScene;
use crate::layers::{Layers, Seen, Work};
use crate::lights::ReadyLight;
use crate::memory::{Evictable, MemoryKind};
use crate::pass_runs::Cause;
use crate::passes::Passes;
use crate::pipeline::color_attachment;
use crate::stages::Stage;
use crate::tile::Tile;
use crate::{Aov, Gpu, RenderError, View, ViewSlot, display, lighting};

/// Bytes a pixel of targets: G-buffer, its terminator's offset and its depth, radiance, display.
pub(crate) const BYTES_A_PIXEL: u64 = 16 + 4 + 4 + 16 + 4;

/// The targets of every viewer.
#[derive(Debug, Default)]
pub(crate) struct Viewers(Vec<(ViewSlot, Evictable<Targets>)>);

/// What is made once a viewer and picture size.
#[derive(Debug)]
pub(crate) struct Targets {
    /// Width and height in pixels, of the tile where there is one.
    pub size: [u32; 2],
    gbuffer: Gbuffer,
    /// What the G-buffer shows.
    gbuffer_key: Option<GbufferKey>,
    /// What each light alone adds to what that shows.
    layers: Layers,
    pub radiance: Texture,
    pub radiance_view: TextureView,
    exposed: Exposed,
    /// What the radiance shows: of which scene's revision, in which view, which tile, under which lights.
    shown: Option<(u64, View, Tile, Vec<Shown>)>,
    /// Samples a pixel of it that have been added up.
    pub samples_drawn: u32,
    /// How many of the lights the sample after those has; `None` before it has anything.
    pub lights_drawn: Option<usize>,
    pub display: Texture,
    display_view: TextureView,
}

/// A light and its revision of what pictures depend on.
type Shown = (LightId, Digest);

/// All that a G-buffer depends on, besides its size.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GbufferKey {
    revision: u64,
    world_from_camera: DAffine3,
    projection: Projection,
    size: [u32; 2],
    tile: Tile,
    sample_offset: DVec2,
}

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
        self.0.retain(|(_, targets)| targets.is_there());
        let size = [view.width, view.height];
        let kept = self.0.iter().find(|(slot, _)| *slot == view.slot).and_then(|(_, kept)| kept.take());
        if let Some(targets) = kept.filter(|targets| targets.size == size) {
            return Ok(targets);
        }
        self.forget(view.slot);
        gpu.make_room(bytes(size));
        Ok(Targets::new(gpu, passes, size))
    }

    /// Keeps the targets of a viewer for its next picture.
    pub fn put(&mut self, gpu: &Gpu, slot: ViewSlot, targets: Targets) {
        if let Some((_, kept)) = self.0.iter().find(|(known, _)| *known == slot) {
            kept.put(targets);
        } else {
            let kept = gpu.memory.keep(MemoryKind::Views, bytes(targets.size), targets);
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
    pub fn forget(&mut self, slot: ViewSlot) {
        self.0.retain(|(kept, _)| *kept != slot);
    }
}

fn bytes([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height) * BYTES_A_PIXEL
}

impl Targets {
    pub fn new(gpu: &Gpu, passes: &Passes, size: [u32; 2]) -> Self {
        let [width, height] = size;
        let radiance = gpu.target("radiance", width, height, lighting::FORMAT);
        let radiance_view = radiance.create_view(&TextureViewDescriptor::default());
        let display = gpu.target("display", width, height, display::FORMAT);
        Self {
            size,
            gbuffer: passes.gbuffer.targets(gpu, width, height),
            gbuffer_key: None,
            layers: Layers::default(),
            exposed: passes.display.exposed(gpu, &radiance_view),
            radiance,
            radiance_view,
            shown: None,
            samples_drawn: 0,
            lights_drawn: None,
            display_view: display.create_view(&TextureViewDescriptor::default()),
            display,
        }
    }

    /// Starts anew, unless the radiance shows this picture or the beginning of it.
    pub fn begin(&mut self, revision: u64, view: &View, tile: Tile, lights: &[LightInstance]) {
        let shown = lights.iter().map(|instance| (instance.id, instance.light.revisions().picture));
        // Radiance knows no exposure: a view that differs in it alone is only shown anew.
        let shown = Some((revision, View { exposure: 0.0, ..view.clone() }, tile, shown.collect()));
        if self.shown != shown {
            self.shown = shown;
            (self.samples_drawn, self.lights_drawn) = (0, None);
        }
    }

    /// Fills the G-buffer, unless it shows just this. Returns why it had to.
    pub fn draw_gbuffer(
        &mut self,
        encoder: &mut CommandEncoder,
        passes: &Passes,
        scene: &GpuScene,
        (raster, tile): (&Raster, Tile),
        sample_offset: DVec2,
    ) -> Option<Cause> {
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
            Some(before) if before == key => return None,
            None => Cause::First,
            Some(before) if before.revision != key.revision => Cause::Scene,
            Some(before) if (before.tile, before.sample_offset) != (tile, sample_offset) => Cause::NotKept,
            Some(_) => Cause::Camera,
        };
        passes.gbuffer.draw(encoder, &self.gbuffer, (size, tile), scene);
        self.layers.invalidate();
        self.gbuffer_key = Some(key);
        Some(cause)
    }

    /// Draws everything anew when it is next asked for.
    pub fn invalidate(&mut self) {
        (self.gbuffer_key, self.shown) = (None, None);
        self.layers.invalidate();
    }

    /// As [`Self::draw_lights`]; where stages are taken down, what comes from no light and each light apart.
    pub fn draw_lighting(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        what: (&Passes, &GpuScene),
        onto: (Aov, Tile),
        (base, clear): (bool, bool),
        lights: &[ReadyLight],
    ) -> Result<(), RenderError> {
        if !gpu.stages.is_on() {
            self.draw_lights(gpu, encoder, what, onto, (base, clear), lights);
            return Ok(());
        }
        if base {
            self.draw_lights(gpu, encoder, what, onto, (base, clear), &[]);
            gpu.end_stage(encoder, Stage::Fill)?;
        }
        for light in lights {
            self.draw_lights(gpu, encoder, what, onto, (false, false), std::slice::from_ref(light));
            gpu.end_stage(encoder, Stage::Light)?;
            let [_, _, width, height] = onto.1.cut(light.pixels);
            gpu.stages.count(|counters| counters.scissor_pixels += u64::from(width) * u64::from(height));
        }
        Ok(())
    }

    /// Adds to the radiance, or to nothing if it is the picture's beginning: what of one sample of `aov` comes from
    /// no light where `base`, and what comes from `lights`. They reach pixels of the picture, of which this is `tile`.
    fn draw_lights(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene): (&Passes, &GpuScene),
        (aov, tile): (Aov, Tile),
        (base, clear): (bool, bool),
        lights: &[ReadyLight],
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[Some(color_attachment(&self.radiance_view, clear))],
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
        for light in lights {
            light.lighting(gpu, passes).draw(gpu, &mut pass, aov, &light.groups(), tile.cut(light.pixels));
        }
    }

    /// Tone-maps the radiance, and what `terms` add to it, for a screen, brightened by so many stops.
    pub fn draw_display(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        passes: &Passes,
        (terms, exposure): (Option<&Terms>, f64),
    ) {
        passes.display.draw(gpu, encoder, (&self.exposed, terms, exposure), &self.display_view);
    }

    /// Brings what each of `lights` alone adds up to date: the terms of what they add together, `None` where that is nothing.
    pub fn draw_layers(
        &mut self,
        encoder: &mut CommandEncoder,
        work: &mut Work,
        lights: &[LightInstance],
    ) -> Result<Option<Terms>, RenderError> {
        let seen = Seen { surface: &self.gbuffer.surface, size: self.size };
        self.layers.draw(encoder, (work, seen), lights)
    }
}
