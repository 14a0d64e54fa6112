//! The renderer: a scene, its caches and pictures.

mod layered;
mod native;
#[cfg(test)]
mod test_access;

use std::ops::Range;
use std::sync::Arc;

use light::{CheckedLight, LightInstance};
use scene::{PosedScene, Scene};
use wgpu::Buffer;

use crate::camera::{CameraRaster, sample_offset};
use crate::gpu_scene::{GpuScene, SceneOnDevice};
use crate::lights::{ShadowMaps, WireframeOnto};
use crate::native_targets::SurfacesBuilder;
use crate::pass_runs::{Cause, Pass, PassCounts, PassRun, PassRuns};
use crate::passes::{DrawContext, Passes};
use crate::pause::{DrawnPiece, Pause};
use crate::stages::{FrameStage, Recording};
use crate::targets::{LitTargets, Targets, Viewers};
use crate::tile::Tile;
use crate::wgpu_maps::WgpuMaps;
use crate::{Aov, Backend, Gpu, Picture, RenderError, ShadowSettings, View, ViewSlot, gpu_structs, position, readback};

/// Draws pictures of one scene at a time, for any number of viewers.
///
/// A light out of the scene's reach ([`light::SceneBounds`]) is left out of the beauty. An AOV of that light is an
/// error.
///
/// A picture reuses the work of earlier ones: each light's shadow map, and for each [`ViewSlot`] the G-buffer and the
/// picture itself.
#[derive(Debug)]
pub struct Renderer {
    gpu: Arc<Gpu>,
    pub(crate) passes: Arc<Passes>,
    view_uniform: Buffer,
    pub(crate) scene: GpuScene,
    viewers: Viewers,
    native_surfaces: SurfacesBuilder,
    pub(crate) shadow_maps: ShadowMaps,
    pass_runs: PassRuns,
}

impl Renderer {
    /// Makes a renderer with an empty scene.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        let passes = gpu.with_error_scopes(|| Ok(Passes::new(&gpu)))?;
        Self::with(gpu, Arc::new(passes))
    }

    /// Makes a renderer with an empty scene of its own that shares this one's pipelines, including those compiled
    /// later.
    pub fn with_same_pipelines(&self) -> Result<Self, RenderError> {
        Self::with(Arc::clone(&self.gpu), Arc::clone(&self.passes))
    }

    fn with(gpu: Arc<Gpu>, passes: Arc<Passes>) -> Result<Self, RenderError> {
        let (view_uniform, scene) = gpu.with_error_scopes(|| {
            let view_uniform = gpu.uniform_buffer::<gpu_structs::View>("view");
            let (layouts, empty) = (&passes.group_layouts, scene::pose(Scene::default(), 0.0));
            let uploaded = SceneOnDevice::upload(&gpu, layouts, &empty, 0.0)?;
            let scene = GpuScene::new(&gpu, layouts, &view_uniform, uploaded, 0, 0.0)?;
            Ok((view_uniform, scene))
        })?;
        let (viewers, shadow_maps, ran) = (Viewers::default(), ShadowMaps::new(), PassRuns::default());
        let native_surfaces = SurfacesBuilder::default();
        Ok(Self { gpu, passes, view_uniform, scene, viewers, native_surfaces, shadow_maps, pass_runs: ran })
    }

    /// Sets the scene: its geometry, materials and fill. Its cameras and lights are ignored. On an error the previous
    /// scene stays.
    pub fn set_scene(&mut self, scene: &Arc<PosedScene>) -> Result<(), RenderError> {
        let mesh_error = self.shadow_maps.shadows().mesh_error;
        let layouts = &self.passes.group_layouts;
        let uploaded = self.gpu.with_error_scopes(|| SceneOnDevice::upload(&self.gpu, layouts, scene, mesh_error))?;
        self.share_scene(uploaded)
    }

    /// Sets a scene that another renderer on this device has uploaded, without a copy.
    pub fn share_scene(&mut self, uploaded: SceneOnDevice) -> Result<(), RenderError> {
        let (revision, mesh_error) = (self.scene.revision + 1, self.shadow_maps.shadows().mesh_error);
        let layouts = &self.passes.group_layouts;
        self.scene = self.gpu.with_error_scopes(|| {
            GpuScene::new(&self.gpu, layouts, &self.view_uniform, uploaded, revision, mesh_error)
        })?;
        Ok(())
    }

    /// Returns the uploaded scene, for [`Self::share_scene`].
    pub fn scene_on_device(&self) -> SceneOnDevice {
        self.scene.on_device().clone()
    }

    /// Sets the shadow settings for later pictures. On an error the previous settings stay.
    pub fn set_shadow_settings(&mut self, shadows: ShadowSettings) -> Result<(), RenderError> {
        let limit = self.gpu.device.limits().max_texture_dimension_2d;
        RenderError::check_size("the resolution of shadow maps", shadows.resolution.into(), limit.into())?;
        shadows.check()?;
        if shadows.mesh_error != self.shadow_maps.shadows().mesh_error {
            let simplify = || self.scene.casters_within(&self.gpu, shadows.mesh_error);
            self.scene.casters = self.gpu.with_error_scopes(simplify)?.into();
        }
        if self.shadow_maps.set_shadows(shadows) {
            self.viewers = Viewers::default();
        }
        Ok(())
    }

    /// Returns the number of runs of each pass.
    pub fn counts(&self) -> PassCounts {
        self.pass_runs.counts
    }

    /// Returns the passes that ran for the latest picture, with their causes. For a picture drawn in several slices of
    /// time, returns those of the latest slice.
    pub fn runs(&self) -> &[PassRun] {
        &self.pass_runs.runs
    }

    /// Drops a viewer's cached data and frees its memory. The viewer's next picture starts from scratch.
    pub fn drop_view(&mut self, slot: ViewSlot) {
        self.viewers.drop_view(slot);
        self.shadow_maps.drop_view(slot);
        self.gpu.free_dropped_memory();
    }

    /// Frees the memory of dropped renderers on this device.
    pub fn free_dropped_memory(&self) {
        self.gpu.free_dropped_memory();
    }

    /// Releases the lights of `slot`. Their maps stay, but are the first to be evicted.
    pub fn release_view(&mut self, slot: ViewSlot) {
        self.shadow_maps.release_view(slot);
    }

    /// Draws the raw values of `view` under `lights`.
    pub fn render(&mut self, view: &View, lights: &[LightInstance]) -> Result<Picture, RenderError> {
        let aov = position::rendered_aov(view.aov);
        let pixels =
            self.with_whole(view, aov, lights, |renderer, gpu, targets| renderer.read_raw(gpu, targets, targets.size))?;
        let mut picture = Picture { width: view.width, height: view.height, pixels };
        if view.aov == Aov::Position {
            position::from_depths(view, &mut picture);
        }
        Ok(picture)
    }

    /// Draws the same picture as [`Self::render_display`], stage by stage. Each stage is submitted and waited for, so
    /// the total takes longer. The wait includes work of other threads on the same device. A stage compiles pipelines
    /// at their first use, so draw the picture once before.
    pub fn record_display(
        &mut self,
        view: &View,
        lights: &[LightInstance],
    ) -> Result<(Vec<u8>, Recording), RenderError> {
        self.gpu.stages.start();
        let bytes = self.render_display(view, lights);
        let recording = self.gpu.stages.stop();
        Ok((bytes?, recording))
    }

    /// Marks all cached results as invalid, and keeps their memory.
    pub fn invalidate(&mut self) {
        self.viewers.invalidate();
        self.shadow_maps.invalidate();
    }

    /// Reads back the raw values of the upper left corner of `targets`.
    pub(crate) fn read_raw(&self, gpu: &Gpu, targets: &Targets, size: [u32; 2]) -> Result<Vec<[f32; 4]>, RenderError> {
        match gpu.backend() {
            Backend::Wgpu => readback::read(gpu, &targets.lit(gpu, &self.passes).radiance, size),
            Backend::Native => Ok(targets.native.radiance().to_vec()),
        }
    }

    /// Tone-maps the upper left corner of the beauty in `targets`, with `exposure` in stops, and reads it back.
    pub(crate) fn read_display(
        &mut self,
        gpu: &Gpu,
        targets: &Targets,
        size: [u32; 2],
        exposure: f64,
    ) -> Result<Vec<u8>, RenderError> {
        if gpu.backend() == Backend::Native {
            return Ok(self.display_natively(gpu, targets, exposure));
        }
        let mut encoder = gpu.encoder();
        targets.draw_display(gpu, &mut encoder, &self.passes, None, exposure);
        gpu.end_stage(&mut encoder, FrameStage::Display)?;
        gpu.queue.submit([encoder.finish()]);
        self.pass_runs.note(Pass::Display, None, Cause::NotKept);
        read_display_texture(gpu, targets.lit(gpu, &self.passes), size)
    }

    /// Draws the whole picture of `aov` for `view` into the targets of its slot, then runs `work` on them.
    fn with_whole<T>(
        &mut self,
        view: &View,
        aov: Aov,
        lights: &[LightInstance],
        work: impl FnOnce(&mut Self, &Gpu, &Targets) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        // Refuses an impossible picture before any cached data changes.
        let drawing = CheckedPicture::new(&View { aov, ..view.clone() }, lights)?;
        let tile = Tile { x: 0, y: 0, width: view.width, height: view.height };
        self.run_or_discard(view.slot, |renderer, gpu| {
            gpu.memory.begin_picture();
            let mut targets = renderer.viewers.take(gpu, &drawing.view)?;
            while !renderer.draw_sample(gpu, &mut targets, &drawing, tile, None)? {}
            let result = work(renderer, gpu, &targets)?;
            renderer.shadow_maps.finish(view.slot);
            renderer.viewers.put(gpu, view.slot, targets);
            Ok(result)
        })
    }

    /// Draws the next sample of `drawing` in `tile`, or a part of it if `pause` returns true between two pieces of
    /// work. Returns true if nothing is left.
    pub(crate) fn draw_sample(
        &mut self,
        gpu: &Gpu,
        targets: &mut Targets,
        drawing: &CheckedPicture,
        tile: Tile,
        pause: Option<Pause>,
    ) -> Result<bool, RenderError> {
        if gpu.backend() == Backend::Native {
            return self.draw_sample_natively(gpu, targets, drawing, tile, pause);
        }
        let CheckedPicture { view, raster, light_range: needed, samples, .. } = drawing;
        let lights = &self.straightened_lights(view.aov, &drawing.lights);
        let Self { passes, scene, shadow_maps, pass_runs: ran, view_uniform, .. } = self;
        let (passes, scene) = (&**passes, &*scene);
        shadow_maps.begin(view.slot, &lights[needed.clone()], scene.revision);
        targets.begin(scene.revision, view, tile, lights);
        let (sample, clear) = (targets.samples_drawn, targets.samples_drawn == 0);
        if sample == *samples {
            return Ok(true);
        }
        if view.aov == Aov::Wireframe {
            let onto = WireframeOnto::Wgpu(&targets.lit(gpu, passes).radiance_view);
            let context = DrawContext { gpu, passes, scene, raster, tile };
            shadow_maps.draw_wireframe(&context, &lights[view.light].light, onto)?;
            ran.note(Pass::ShadowMap, Some(lights[view.light].id), Cause::NotKept);
            targets.samples_drawn = *samples;
            return Ok(true);
        }
        let offset = sample_offset(sample, *samples);
        let weight = 1.0 / *samples as f32;
        let uniform = raster.uniform(offset, weight, view.fill, scene.posed.origin_in_world, [tile.x, tile.y])?;
        gpu.queue.write_buffer(view_uniform, 0, bytemuck::bytes_of(&uniform));
        let mut encoder = gpu.encoder();
        let context = DrawContext { gpu, passes, scene, raster, tile };
        let mut base = targets.lights_drawn.is_none();
        if base && let Some(cause) = targets.draw_gbuffer(&context, &mut encoder, offset)? {
            ran.note(Pass::Gbuffer, None, cause);
            gpu.end_stage(&mut encoder, FrameStage::Gbuffer)?;
        }
        let mut batch = Vec::new();
        let first = needed.start + targets.lights_drawn.unwrap_or(0);
        for (index, light) in lights.iter().enumerate().take(needed.end).skip(first) {
            if view.aov == Aov::Beauty && light.light.light_profile().is_dark() {
                continue;
            }
            let mut maps = WgpuMaps { gpu, passes, encoder: &mut encoder };
            let ready = match shadow_maps.ready_light(&mut maps, &context, light, view.shadow_map) {
                // The other lights still count; `light::SceneBounds` reports this one to callers that ask.
                Err(RenderError::OutOfReach(_)) if view.aov == Aov::Beauty => continue,
                ready => ready?,
            };
            // The light reaches no visible surface.
            let Some(ready) = ready else { continue };
            if let Some(cause) = ready.shadow_map_cause {
                ran.note(Pass::ShadowMap, Some(light.id), cause);
            }
            let (drawn, is_transient) = (ready.shadow_map_cause.is_some(), ready.transient_map.is_some());
            if drawn
                && !is_transient
                && let Some(pause) = pause
            {
                // The map is cached, so the light can wait.
                gpu.submit_and_wait(&mut encoder)?;
                if pause(DrawnPiece::ShadowMap) {
                    // The next call finds the G-buffer by its key, and the light's map by its own.
                    return Ok(false);
                }
            }
            batch.push(ready);
            // A map without room in the budget must be freed before the next one is drawn.
            if is_transient || pause.is_some() {
                targets.draw_lighting(&context, &mut encoder, view.aov, base, base && clear, &batch)?;
                gpu.submit_and_wait(&mut encoder)?;
                batch.clear();
                base = false;
                targets.lights_drawn = Some(index + 1 - needed.start);
                if index + 1 < needed.end && pause.is_some_and(|pause| pause(DrawnPiece::Pixels)) {
                    return Ok(false);
                }
            }
        }
        if base || !batch.is_empty() {
            targets.draw_lighting(&context, &mut encoder, view.aov, base, base && clear, &batch)?;
        }
        gpu.queue.submit([encoder.finish()]);
        ran.note(Pass::Lighting, None, Cause::NotKept);
        targets.samples_drawn = sample + 1;
        targets.lights_drawn = None;
        if sample + 1 < *samples || pause.is_some() {
            // Submission is quick: without waiting, all samples would be in flight at once.
            gpu.wait()?;
        }
        Ok(sample + 1 == *samples)
    }

    /// Returns the lights for pictures of `aov`. A straight BendyLight is replaced by the equal spotlight, unless the
    /// AOV shows positions along the curve.
    fn straightened_lights(&self, aov: Aov, lights: &[LightInstance]) -> Vec<LightInstance> {
        let shows_curve = matches!(aov, Aov::T | Aov::Wireframe);
        let reach = self.scene.posed.bounds();
        let straightened = |light: &CheckedLight| {
            let spot = light.equivalent_spotlight().filter(|_| self.shadow_maps.shadows().straighten && !shows_curve);
            // The curve may reach farther than can be drawn. The spotlight has no end points that could.
            spot.filter(|_| reach.check(light).is_ok()).cloned()
        };
        let drawn = |LightInstance { id, light }: &LightInstance| LightInstance {
            id: *id,
            light: straightened(light).unwrap_or_else(|| Arc::clone(light)),
        };
        lights.iter().map(drawn).collect()
    }

    /// Runs `work`. On an error, discards data that it may have left incomplete.
    pub(crate) fn run_or_discard<T>(
        &mut self,
        slot: ViewSlot,
        work: impl FnOnce(&mut Self, &Gpu) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let gpu = Arc::clone(&self.gpu);
        self.pass_runs.runs.clear();
        let result = gpu.with_error_scopes(|| work(self, &gpu));
        match &result {
            Ok(_) => {}
            Err(RenderError::Cancelled) => {
                // The cancelled work had taken its data out of the caches, so the data is gone.
                self.viewers.drop_view(slot);
                self.shadow_maps.bent_buffers.clear_deferred();
            }
            Err(_) => {
                self.viewers.drop_view(slot);
                self.shadow_maps.clear();
            }
        }
        result
    }
}

/// Reads back the upper left corner of the screen texture.
fn read_display_texture(gpu: &Gpu, lit: &LitTargets, size: [u32; 2]) -> Result<Vec<u8>, RenderError> {
    let bytes = readback::read::<[u8; 4]>(gpu, &lit.display, size)?.into_flattened();
    gpu.stages.record_stage(FrameStage::Readback);
    gpu.stages.count(|counters| counters.bytes += bytes.len() as u64);
    Ok(bytes)
}

#[derive(Clone, Debug)]
pub(crate) struct CheckedPicture {
    pub view: View,
    pub lights: Vec<LightInstance>,
    pub raster: CameraRaster,
    /// Indices of the lights that the picture needs.
    pub light_range: Range<usize>,
    pub samples: u32,
}

impl CheckedPicture {
    pub fn new(view: &View, lights: &[LightInstance]) -> Result<Self, RenderError> {
        Ok(Self {
            raster: CameraRaster::new(view)?,
            light_range: required_lights(view.aov, view.light, lights.len())?,
            samples: if view.aov.can_be_multisampled() { view.samples } else { 1 },
            view: view.clone(),
            lights: lights.to_vec(),
        })
    }
}

/// Returns the range of indices of the lights that `aov` needs: all lights, its own light, or none.
fn required_lights(aov: Aov, index: usize, count: usize) -> Result<Range<usize>, RenderError> {
    match aov {
        Aov::Beauty => Ok(0..count),
        Aov::Depth | Aov::Normal | Aov::Position => Ok(0..0),
        _ if index < count => Ok(index..index + 1),
        _ => Err(RenderError::NoSuchLight { index, count }),
    }
}
