//! Scenes in, pictures out; and what is kept in between.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec2;
use scene::{Light, Scene};
use wgpu::{Buffer, CommandEncoder, CommandEncoderDescriptor};

use crate::camera::{Raster, sample_offset};
use crate::lights::LightSlots;
use crate::passes::Passes;
use crate::staged::StagedScene;
use crate::targets::Viewers;
use crate::{Aov, Gpu, Picture, RenderError, ShadowSettings, View, ViewSlot, layout, readback};

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

/// How long each stage of a picture takes where nothing is kept from the one before, in milliseconds of wall
/// time. Each is waited for: together they take a little longer than they do one behind the other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageTimes {
    /// What each pixel sees.
    pub gbuffer_ms: f64,
    /// The shadow maps of all lights that the picture needs.
    pub shadow_ms: f64,
    /// One pass over the picture for the fill and each light.
    pub lighting_ms: f64,
}

/// Draws pictures of one scene at a time, for any number of viewers.
///
/// What a picture shares with the one before is not drawn again: each light's shadow map, and for each
/// [`ViewSlot`] the G-buffer and the picture itself.
#[derive(Debug)]
pub struct Renderer {
    gpu: Arc<Gpu>,
    passes: Arc<Passes>,
    view_uniform: Buffer,
    scene: StagedScene,
    viewers: Viewers,
    lights: LightSlots,
    counts: PassCounts,
}

impl Renderer {
    /// A renderer of an empty scene.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        let passes = gpu.checked(|| Ok(Passes::new(&gpu)))?;
        Self::with(gpu, Arc::new(passes))
    }

    /// A renderer of another scene, empty at first, by the same pipelines: what this one has compiled, or
    /// will, serves both.
    pub fn another(&self) -> Result<Self, RenderError> {
        Self::with(Arc::clone(&self.gpu), Arc::clone(&self.passes))
    }

    fn with(gpu: Arc<Gpu>, passes: Arc<Passes>) -> Result<Self, RenderError> {
        let (view_uniform, scene) = gpu.checked(|| {
            let view_uniform = gpu.uniform_buffer::<layout::View>("view");
            let scene = StagedScene::new(&gpu, &passes.layouts, &view_uniform, &Scene::default(), 0, 0.0)?;
            Ok((view_uniform, scene))
        })?;
        let (viewers, lights, counts) = (Viewers::default(), LightSlots::new(), PassCounts::default());
        Ok(Self { gpu, passes, view_uniform, scene, viewers, lights, counts })
    }

    /// Takes over another scene: its geometry, materials and fill. Its promises hold ([`Scene::check`]); its
    /// cameras and lights are not used. On an error the scene before stays.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let (revision, mesh_error) = (self.scene.revision + 1, self.lights.shadows().mesh_error);
        self.scene = self.gpu.checked(|| {
            StagedScene::new(&self.gpu, &self.passes.layouts, &self.view_uniform, scene, revision, mesh_error)
        })?;
        Ok(())
    }

    /// Makes shadow maps by other settings from the next picture on. On an error the settings before stay.
    pub fn set_shadow_settings(&mut self, shadows: ShadowSettings) -> Result<(), RenderError> {
        shadows.check(self.gpu.device.limits().max_texture_dimension_2d)?;
        if shadows.mesh_error != self.lights.shadows().mesh_error {
            let simplify = || self.scene.surface.simplified(&self.gpu, shadows.mesh_error);
            self.scene.casters = self.gpu.checked(simplify)?;
        }
        if self.lights.set_shadows(shadows) {
            self.viewers = Viewers::default();
        }
        Ok(())
    }

    /// What bent shadow maps are made in, for tests to plant faults in.
    #[cfg(test)]
    pub(crate) fn bent_work(&mut self) -> &mut crate::bendy_light::BentWork {
        &mut self.lights.bent_work
    }

    /// The device and what is on it of the scene, for tests to plant faults in before the first picture.
    #[cfg(test)]
    pub(crate) fn staged(&mut self) -> (&Gpu, &mut StagedScene) {
        (&self.gpu, &mut self.scene)
    }

    /// How often each pass has run.
    pub fn counts(&self) -> PassCounts {
        self.counts
    }

    /// Drops what is kept for a viewer; a later picture of it starts anew.
    pub fn forget(&mut self, slot: ViewSlot) {
        self.viewers.forget(slot);
    }

    /// Draws some of the samples that `view` under `lights` takes: at least one, then more while `keep_going`
    /// says so. Returns whether none is left.
    ///
    /// Called again with the same view and lights it goes on where it stopped, as do [`Self::render`] and
    /// [`Self::render_display`]; another picture in the same slot starts anew.
    pub fn advance(
        &mut self,
        view: &View,
        lights: &[Light],
        mut keep_going: impl FnMut() -> bool,
    ) -> Result<bool, RenderError> {
        self.draw(view, view.aov, lights, &mut keep_going)
    }

    /// The raw values of `view` under `lights`.
    pub fn render(&mut self, view: &View, lights: &[Light]) -> Result<Picture, RenderError> {
        self.draw(view, view.aov, lights, &mut || true)?;
        let pixels = self.attempt(view.slot, |renderer, gpu| {
            readback::read(gpu, &renderer.viewers.targets(gpu, &renderer.passes, view)?.radiance)
        })?;
        Ok(Picture { width: view.width, height: view.height, pixels })
    }

    /// The beauty of `view` under `lights` as a screen shows it, whatever `view.aov` says: tone-mapped sRGB,
    /// RGBA, 8 bits a channel, rows from the top.
    pub fn render_display(&mut self, view: &View, lights: &[Light]) -> Result<Vec<u8>, RenderError> {
        self.draw(view, Aov::Beauty, lights, &mut || true)?;
        self.attempt(view.slot, |renderer, gpu| {
            let targets = renderer.viewers.targets(gpu, &renderer.passes, view)?;
            let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
            targets.draw_display(&mut encoder, &renderer.passes);
            gpu.queue.submit([encoder.finish()]);
            renderer.counts.display += 1;
            Ok(readback::read::<[u8; 4]>(gpu, &targets.display)?.into_flattened())
        })
    }

    /// Draws samples of `aov` of `view` into the radiance of its slot, as [`Self::advance`] says.
    fn draw(
        &mut self,
        view: &View,
        aov: Aov,
        lights: &[Light],
        keep_going: &mut dyn FnMut() -> bool,
    ) -> Result<bool, RenderError> {
        // What cannot be drawn is refused here, before anything that is kept has changed.
        let raster = Raster::new(view)?;
        let wanted = wanted_lights(aov, view.light, lights.len())?;
        let samples = if aov.takes_samples() { view.samples } else { 1 };
        self.attempt(view.slot, |renderer, gpu| {
            let Self { passes, scene, viewers, counts, view_uniform, .. } = renderer;
            let targets = viewers.targets(gpu, passes, view)?;
            targets.begin(scene.revision, view, aov, lights);
            if targets.samples_drawn == samples {
                return Ok(true);
            }
            if aov == Aov::Wireframe {
                let picture = (&targets.radiance_view, targets.size);
                renderer.lights.draw_wireframe(gpu, (passes, scene), &lights[view.light], picture)?;
                counts.shadow += 1;
                targets.samples_drawn = samples;
                return Ok(true);
            }
            let new_encoder = || gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
            let mut encoder = new_encoder();
            let ready = renderer.lights.ready(gpu, &mut encoder, (passes, scene, &raster), lights, wanted)?;
            counts.shadow += ready.iter().filter(|light| light.shadow_drawn).count() as u64;

            for sample in targets.samples_drawn..samples {
                let offset = sample_offset(sample, samples);
                let uniform = raster.uniform(offset, 1.0 / samples as f32, scene.origin)?;
                gpu.queue.write_buffer(view_uniform, 0, bytemuck::bytes_of(&uniform));
                counts.gbuffer +=
                    u64::from(targets.draw_gbuffer(&mut encoder, passes, scene, &raster, offset));
                targets.draw_lighting(gpu, &mut encoder, (passes, scene), aov, &ready, sample == 0);
                counts.lighting += 1;
                // What is written to a buffer is seen by the next submission: one a sample.
                gpu.queue.submit([std::mem::replace(&mut encoder, new_encoder()).finish()]);
                targets.samples_drawn = sample + 1;
                if targets.samples_drawn < samples {
                    // Submitting is quick: without waiting, all would be under way before anybody can stop
                    // it.
                    gpu.wait()?;
                    if !keep_going() {
                        return Ok(false);
                    }
                }
            }
            Ok(true)
        })
    }

    /// Draws one sample of the beauty of `view` under `lights`, whatever `view.aov` says, stage by stage, each anew
    /// and waited for. Pipelines that were not used before are compiled in the stage that needs them: draw the
    /// picture once before.
    pub fn time_stages(&mut self, view: &View, lights: &[Light]) -> Result<StageTimes, RenderError> {
        let raster = Raster::new(view)?;
        self.attempt(view.slot, |renderer, gpu| {
            let Self { passes, scene, viewers, view_uniform, lights: slots, .. } = renderer;
            let targets = viewers.targets(gpu, passes, view)?;
            slots.invalidate();
            let uniform = raster.uniform(DVec2::ZERO, 1.0, scene.origin)?;
            gpu.queue.write_buffer(view_uniform, 0, bytemuck::bytes_of(&uniform));
            gpu.wait()?;
            let ((), gbuffer_ms) = timed(gpu, |encoder| {
                targets.invalidate();
                targets.draw_gbuffer(encoder, passes, scene, &raster, DVec2::ZERO);
                Ok(())
            })?;
            let (ready, shadow_ms) = timed(gpu, |encoder| {
                slots.ready(gpu, encoder, (passes, scene, &raster), lights, 0..lights.len())
            })?;
            let ((), lighting_ms) = timed(gpu, |encoder| {
                targets.draw_lighting(gpu, encoder, (passes, scene), Aov::Beauty, &ready, true);
                Ok(())
            })?;
            Ok(StageTimes { gbuffer_ms, shadow_ms, lighting_ms })
        })
    }

    /// Runs `work`; where it fails, nothing that it may have left half done is kept.
    fn attempt<T>(
        &mut self,
        slot: ViewSlot,
        work: impl FnOnce(&mut Self, &Gpu) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let gpu = Arc::clone(&self.gpu);
        let result = gpu.checked(|| work(self, &gpu));
        if result.is_err() {
            self.viewers.forget(slot);
            self.lights.clear();
        }
        result
    }
}

/// Encodes, submits and waits for one stage; its result and how long that took, in milliseconds.
fn timed<T>(
    gpu: &Gpu,
    stage: impl FnOnce(&mut CommandEncoder) -> Result<T, RenderError>,
) -> Result<(T, f64), RenderError> {
    let start = Instant::now();
    let mut encoder = gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
    let result = stage(&mut encoder)?;
    gpu.queue.submit([encoder.finish()]);
    gpu.wait()?;
    Ok((result, start.elapsed().as_secs_f64() * 1000.0))
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
