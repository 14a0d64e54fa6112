//! What each viewer's picture is drawn into, and what it holds.

use glam::{DAffine3, DVec2};
use scene::{Light, Projection};
use wgpu::{BindGroup, CommandEncoder, Texture, TextureView, TextureViewDescriptor};

use crate::camera::Raster;
use crate::gbuffer::Gbuffer;
use crate::lights::{LightingKind, ReadyLight};
use crate::passes::Passes;
use crate::pipeline::color_attachment;
use crate::staged::StagedScene;
use crate::{Aov, Gpu, RenderError, View, ViewSlot, display, lighting};

/// Most viewers whose targets are kept; each takes 40 bytes a pixel. Past it, the one that drew longest ago
/// starts anew.
const MAX_SLOTS: usize = 32;

/// The targets of every viewer, the one that drew last at the end.
#[derive(Debug, Default)]
pub(crate) struct Viewers(Vec<(ViewSlot, Targets)>);

/// What is made once a viewer and picture size.
#[derive(Debug)]
pub(crate) struct Targets {
    pub size: [u32; 2],
    gbuffer: Gbuffer,
    /// What the G-buffer shows.
    gbuffer_key: Option<GbufferKey>,
    pub radiance: Texture,
    pub radiance_view: TextureView,
    radiance_group: BindGroup,
    /// What the radiance shows: of which scene's revision, in which view, under which lights.
    shown: Option<(u64, View, Vec<Light>)>,
    /// Samples a pixel of it that have been added up.
    pub samples_drawn: u32,
    pub display: Texture,
    display_view: TextureView,
}

/// All that a G-buffer depends on, besides its size.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GbufferKey {
    revision: u64,
    world_from_camera: DAffine3,
    projection: Projection,
    sample_offset: DVec2,
}

impl Viewers {
    /// The targets of the viewer of `view`, as it left them if the size is still the same.
    pub fn targets(&mut self, gpu: &Gpu, passes: &Passes, view: &View) -> Result<&mut Targets, RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let size = view.width.max(view.height);
        if size > limit {
            let what = "the picture's width or height";
            return Err(RenderError::TooLarge { what, size: f64::from(size), limit: f64::from(limit) });
        }
        let known = self.0.iter().position(|(slot, _)| *slot == view.slot);
        let kept = known.map(|index| self.0.remove(index).1);
        let targets = kept
            .filter(|targets| targets.size == [view.width, view.height])
            .unwrap_or_else(|| Targets::new(gpu, passes, view.width, view.height));
        if self.0.len() == MAX_SLOTS {
            self.0.remove(0);
        }
        self.0.push((view.slot, targets));
        Ok(&mut self.0.last_mut().expect("one was pushed").1)
    }

    /// Drops the targets of a viewer.
    pub fn forget(&mut self, slot: ViewSlot) {
        self.0.retain(|(kept, _)| *kept != slot);
    }
}

impl Targets {
    fn new(gpu: &Gpu, passes: &Passes, width: u32, height: u32) -> Self {
        let radiance = gpu.target("radiance", width, height, lighting::FORMAT);
        let radiance_view = radiance.create_view(&TextureViewDescriptor::default());
        let display = gpu.target("display", width, height, display::FORMAT);
        Self {
            size: [width, height],
            gbuffer: passes.gbuffer.targets(gpu, width, height),
            gbuffer_key: None,
            radiance_group: passes.display.group(gpu, &radiance_view),
            radiance,
            radiance_view,
            shown: None,
            samples_drawn: 0,
            display_view: display.create_view(&TextureViewDescriptor::default()),
            display,
        }
    }

    /// Starts anew, unless the radiance shows this picture or the beginning of it.
    pub fn begin(&mut self, revision: u64, view: &View, aov: Aov, lights: &[Light]) {
        let view = View { aov, ..view.clone() };
        let same = |(r, v, l): &(u64, View, Vec<Light>)| *r == revision && *v == view && l == lights;
        if !self.shown.as_ref().is_some_and(same) {
            self.shown = Some((revision, view, lights.to_vec()));
            self.samples_drawn = 0;
        }
    }

    /// Draws everything anew when it is next asked for.
    pub fn invalidate(&mut self) {
        (self.gbuffer_key, self.shown) = (None, None);
    }

    /// Fills the G-buffer, unless it shows just this. Returns whether it had to.
    pub fn draw_gbuffer(
        &mut self,
        encoder: &mut CommandEncoder,
        passes: &Passes,
        scene: &StagedScene,
        raster: &Raster,
        sample_offset: DVec2,
    ) -> bool {
        let key = Some(GbufferKey {
            revision: scene.revision,
            world_from_camera: raster.world_from_camera,
            projection: raster.projection,
            sample_offset,
        });
        let stale = self.gbuffer_key != key;
        if stale {
            passes.gbuffer.draw(encoder, &self.gbuffer, &scene.view, &scene.geometry, &scene.draws);
            self.gbuffer_key = key;
        }
        stale
    }

    /// Adds one sample of `aov`, to nothing if it is the first.
    pub fn draw_lighting(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene): (&Passes, &StagedScene),
        aov: Aov,
        lights: &[ReadyLight],
        first: bool,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[Some(color_attachment(&self.radiance_view, first))],
            ..Default::default()
        });
        pass.set_bind_group(0, &scene.view, &[]);
        pass.set_bind_group(1, &self.gbuffer.surface, &[]);
        let [width, height] = self.size;
        let everywhere = [0, 0, width, height];
        match aov {
            Aov::Beauty => passes.fill.draw(gpu, &mut pass, aov, Some(&scene.fill), everywhere),
            Aov::Depth | Aov::Normal => passes.inspect.draw(gpu, &mut pass, aov, None, everywhere),
            Aov::T | Aov::Vw | Aov::Direction | Aov::Visibility | Aov::Wireframe => {}
        }
        for light in lights {
            let lighting = match light.kind {
                LightingKind::Spot(filter) => passes.spot.lighting(gpu, filter),
                LightingKind::Bendy(baked) => passes.bendy.lighting(gpu, baked),
            };
            lighting.draw(gpu, &mut pass, aov, Some(&light.group), light.pixels);
        }
    }

    /// Tone-maps the radiance for a screen.
    pub fn draw_display(&self, encoder: &mut CommandEncoder, passes: &Passes) {
        passes.display.draw(encoder, &self.radiance_group, &self.display_view);
    }
}
