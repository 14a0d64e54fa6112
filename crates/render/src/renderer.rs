//! Scenes in, pictures out; and what is kept in between.

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, DVec2};
use scene::{Light, LightKind, Projection, Scene};
use wgpu::{BindGroup, Buffer, CommandEncoder, Texture, TextureView};

use crate::bendy_light::{Baked, BendyPass, BendySlot};
use crate::camera::{Raster, sample_offset};
use crate::display::{self, DisplayPass};
use crate::gbuffer::{Gbuffer, GbufferPass};
use crate::lighting::{self, LightingPass};
use crate::pipeline::{STORAGE, UNIFORM, color_attachment};
use crate::spot::{SpotPass, SpotSlot};
use crate::staged::{SceneLayouts, StagedScene};
use crate::{Aov, Gpu, Picture, RenderError, View, layout, material, readback, shaders};

/// How often each pass has run since the renderer was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassCounts {
    /// Over the scene's triangles for the camera.
    pub gbuffer: u64,
    /// Over the scene's triangles for a light.
    pub shadow: u64,
    /// Over the picture, once a sample: all lights.
    pub lighting: u64,
    /// Over the picture, for a screen.
    pub display: u64,
}

/// Draws pictures of one scene at a time.
#[derive(Debug)]
pub struct Renderer {
    gpu: Arc<Gpu>,
    passes: Passes,
    view_uniform: Buffer,
    scene: StagedScene,
    targets: Targets,
    /// One a light, in the order of the last picture's lights; `None` where that light was not needed yet.
    slots: Vec<Option<LightSlot>>,
    counts: PassCounts,
}

/// The pipelines and layouts, which outlive scenes and pictures.
#[derive(Debug)]
struct Passes {
    layouts: SceneLayouts,
    gbuffer: GbufferPass,
    fill: LightingPass,
    inspect: LightingPass,
    spot: SpotPass,
    bendy: BendyPass,
    display: DisplayPass,
}

/// What is kept of a light from picture to picture.
#[derive(Debug)]
enum LightSlot {
    Spot(SpotSlot),
    Bendy(BendySlot),
}

/// Which lighting pass draws a light.
#[derive(Clone, Copy, Debug)]
enum LightingKind {
    Spot,
    Bendy(Baked),
}

/// A light whose shadows are up to date.
#[derive(Debug)]
struct ReadyLight {
    kind: LightingKind,
    /// Group 2 of its lighting pass.
    group: BindGroup,
    /// What it may reach: `[x, y, width, height]`.
    pixels: [u32; 4],
}

/// What is made once a picture size.
#[derive(Debug)]
struct Targets {
    size: [u32; 2],
    gbuffer: Gbuffer,
    /// What the G-buffer shows.
    gbuffer_key: Option<GbufferKey>,
    radiance: Texture,
    radiance_view: TextureView,
    radiance_group: BindGroup,
    display: Texture,
}

/// All that a G-buffer depends on, besides its size.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GbufferKey {
    revision: u64,
    world_from_camera: DAffine3,
    projection: Projection,
    sample_offset: DVec2,
}

impl Passes {
    fn new(gpu: &Gpu) -> Self {
        let layouts = SceneLayouts {
            view: gpu.layout("view", &[UNIFORM, STORAGE]),
            material: gpu.layout("material", &material::BINDINGS),
            fill: gpu.layout("fill", &[UNIFORM]),
        };
        let gbuffer = GbufferPass::new(gpu, &layouts.view, &layouts.material);
        let camera_groups = [&layouts.view, &gbuffer.surface_layout];
        let [view, surface] = camera_groups;
        Self {
            fill: LightingPass::new(gpu, "fill", shaders::FILL, &[view, surface, &layouts.fill]),
            inspect: LightingPass::new(gpu, "inspect", shaders::INSPECT, &camera_groups),
            spot: SpotPass::new(gpu, camera_groups, &layouts.material),
            bendy: BendyPass::new(gpu, camera_groups),
            display: DisplayPass::new(gpu),
            gbuffer,
            layouts,
        }
    }

    fn targets(&self, gpu: &Gpu, width: u32, height: u32) -> Targets {
        let radiance = gpu.target("radiance", width, height, lighting::FORMAT);
        let radiance_view = radiance.create_view(&wgpu::TextureViewDescriptor::default());
        Targets {
            size: [width, height],
            gbuffer: self.gbuffer.targets(gpu, width, height),
            gbuffer_key: None,
            radiance_group: self.display.group(gpu, &radiance_view),
            radiance,
            radiance_view,
            display: gpu.target("display", width, height, display::FORMAT),
        }
    }
}

impl Renderer {
    /// A renderer of an empty scene.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        let (passes, view_uniform, scene, targets) = gpu.checked(|| {
            let passes = Passes::new(&gpu);
            let view_uniform = gpu.uniform_buffer::<layout::View>("view");
            let scene = StagedScene::new(&gpu, &passes.layouts, &view_uniform, &Scene::default(), 0)?;
            let targets = passes.targets(&gpu, 1, 1);
            Ok((passes, view_uniform, scene, targets))
        })?;
        let (slots, counts) = (Vec::new(), PassCounts::default());
        Ok(Self { gpu, passes, view_uniform, scene, targets, slots, counts })
    }

    /// Takes over another scene: its geometry, materials and fill. Its promises hold ([`Scene::check`]); its
    /// cameras and lights are not used. On an error the scene before stays.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let revision = self.scene.revision + 1;
        self.scene = self.gpu.checked(|| {
            StagedScene::new(&self.gpu, &self.passes.layouts, &self.view_uniform, scene, revision)
        })?;
        Ok(())
    }

    /// The bent shadow maps' pass, for tests to plant faults in.
    #[cfg(test)]
    pub(crate) fn bent_shadow(&mut self) -> &mut crate::bendy_light::BentShadowPass {
        &mut self.passes.bendy.shadow
    }

    /// How often each pass has run.
    pub fn counts(&self) -> PassCounts {
        self.counts
    }

    /// The raw values of `view` under `lights`.
    pub fn render(&mut self, view: &View, lights: &[Light]) -> Result<Picture, RenderError> {
        let pixels = self.attempt(|renderer, gpu| {
            renderer.draw(gpu, view, view.aov, lights)?;
            readback::read(gpu, &renderer.targets.radiance)
        })?;
        Ok(Picture { width: view.width, height: view.height, pixels })
    }

    /// The beauty of `view` under `lights` as a screen shows it, whatever `view.aov` says: tone-mapped sRGB,
    /// RGBA, 8 bits a channel, rows from the top.
    pub fn render_display(&mut self, view: &View, lights: &[Light]) -> Result<Vec<u8>, RenderError> {
        self.attempt(|renderer, gpu| {
            renderer.draw(gpu, view, Aov::Beauty, lights)?;
            let Targets { radiance_group, display, .. } = &renderer.targets;
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let screen = display.create_view(&wgpu::TextureViewDescriptor::default());
            renderer.passes.display.draw(&mut encoder, radiance_group, &screen);
            gpu.queue.submit([encoder.finish()]);
            renderer.counts.display += 1;
            Ok(readback::read::<[u8; 4]>(gpu, &renderer.targets.display)?.into_flattened())
        })
    }

    /// Runs `work`; where it fails, nothing that it may have left half done is kept.
    fn attempt<T>(
        &mut self,
        work: impl FnOnce(&mut Self, &Gpu) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let gpu = Arc::clone(&self.gpu);
        let result = gpu.checked(|| work(self, &gpu));
        if result.is_err() {
            self.targets.size = [0, 0];
            self.slots.clear();
        }
        result
    }

    /// Draws `aov` of `view` into the radiance target.
    fn draw(&mut self, gpu: &Gpu, view: &View, aov: Aov, lights: &[Light]) -> Result<(), RenderError> {
        let raster = Raster::new(view)?;
        let wanted = wanted_lights(aov, view.light, lights.len())?;
        self.fit_targets(gpu, view.width, view.height)?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let ready = self.ready_lights(gpu, &mut encoder, &raster, lights, wanted)?;

        let samples = if aov.takes_samples() { view.samples } else { 1 };
        for sample in 0..samples {
            let offset = sample_offset(sample, samples);
            let uniform = raster.uniform(offset, 1.0 / samples as f32, self.scene.origin)?;
            gpu.queue.write_buffer(&self.view_uniform, 0, bytemuck::bytes_of(&uniform));
            self.draw_gbuffer(&mut encoder, &raster, offset);
            self.draw_lighting(gpu, &mut encoder, aov, &ready, sample == 0);
            // What is written to a buffer is seen by the next submission: one a sample.
            let next = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            gpu.queue.submit([std::mem::replace(&mut encoder, next).finish()]);
        }
        Ok(())
    }

    fn fit_targets(&mut self, gpu: &Gpu, width: u32, height: u32) -> Result<(), RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let size = width.max(height);
        if size > limit {
            let what = "the picture's width or height";
            return Err(RenderError::TooLarge { what, size: f64::from(size), limit: f64::from(limit) });
        }
        if self.targets.size != [width, height] {
            self.targets = self.passes.targets(gpu, width, height);
        }
        Ok(())
    }

    /// Brings the shadows of `lights[wanted]` up to date.
    fn ready_lights(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        raster: &Raster,
        lights: &[Light],
        wanted: Range<usize>,
    ) -> Result<Vec<ReadyLight>, RenderError> {
        let Self { passes, scene, slots, counts, .. } = self;
        slots.resize_with(lights.len(), || None);
        let mut ready = Vec::with_capacity(wanted.len());
        for (slot, light) in slots.iter_mut().zip(lights).take(wanted.end).skip(wanted.start) {
            let (kind, group, corners_in_world, shadow_drawn) = match &light.kind {
                LightKind::Spot(spot) => {
                    if !matches!(slot, Some(LightSlot::Spot(_))) {
                        *slot = Some(LightSlot::Spot(passes.spot.slot(gpu)));
                    }
                    let Some(LightSlot::Spot(slot)) = slot else { continue };
                    let (placed, drawn) = passes.spot.prepare(gpu, encoder, slot, spot, scene)?;
                    (LightingKind::Spot, slot.group.clone(), placed.corners_in_world.to_vec(), drawn)
                }
                LightKind::Bendy(bendy) => {
                    if !matches!(slot, Some(LightSlot::Bendy(_))) {
                        *slot = Some(LightSlot::Bendy(BendyPass::slot(gpu)));
                    }
                    let Some(LightSlot::Bendy(slot)) = slot else { continue };
                    let (placed, drawn) = passes.bendy.prepare(gpu, slot, bendy, scene)?;
                    (LightingKind::Bendy(placed.baked), placed.group, placed.corners_in_world, drawn)
                }
            };
            counts.shadow += u64::from(shadow_drawn);
            ready.push(ReadyLight { kind, group, pixels: raster.bounds_of(&corners_in_world) });
        }
        Ok(ready)
    }

    fn draw_gbuffer(&mut self, encoder: &mut CommandEncoder, raster: &Raster, sample_offset: DVec2) {
        let key = Some(GbufferKey {
            revision: self.scene.revision,
            world_from_camera: raster.world_from_camera,
            projection: raster.projection,
            sample_offset,
        });
        if self.targets.gbuffer_key != key {
            let StagedScene { view, geometry, draws, .. } = &self.scene;
            self.passes.gbuffer.draw(encoder, &self.targets.gbuffer, view, geometry, draws);
            self.targets.gbuffer_key = key;
            self.counts.gbuffer += 1;
        }
    }

    /// Adds one sample of `aov`, to nothing if it is the first.
    fn draw_lighting(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        aov: Aov,
        lights: &[ReadyLight],
        first: bool,
    ) {
        let Self { passes, scene, targets, counts, .. } = self;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[Some(color_attachment(&targets.radiance_view, first))],
            ..Default::default()
        });
        pass.set_bind_group(0, &scene.view, &[]);
        pass.set_bind_group(1, &targets.gbuffer.surface, &[]);
        let [width, height] = targets.size;
        let everywhere = [0, 0, width, height];
        match aov {
            Aov::Beauty => passes.fill.draw(gpu, &mut pass, aov, Some(&scene.fill), everywhere),
            Aov::Depth | Aov::Normal => passes.inspect.draw(gpu, &mut pass, aov, None, everywhere),
            Aov::T | Aov::Vw | Aov::Direction | Aov::Visibility => {}
        }
        for light in lights {
            let lighting = match light.kind {
                LightingKind::Spot => &passes.spot.lighting,
                LightingKind::Bendy(baked) => passes.bendy.lighting(baked),
            };
            lighting.draw(gpu, &mut pass, aov, Some(&light.group), light.pixels);
        }
        counts.lighting += 1;
    }
}

/// The lights that `aov` needs: all of them, the one it is of, or none.
fn wanted_lights(aov: Aov, index: usize, count: usize) -> Result<Range<usize>, RenderError> {
    match aov {
        Aov::Beauty => Ok(0..count),
        Aov::Depth | Aov::Normal => Ok(0..0),
        _ if index < count => Ok(index..index + 1),
        _ => Err(RenderError::NoSuchLight { index, count }),
    }
}
