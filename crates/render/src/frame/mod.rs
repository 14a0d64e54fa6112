//! The one loop that draws frames, and their caches. A [`FrameBackend`] draws the parts, on the GPU or the CPU.

mod alpha_test;
mod backend;
pub(crate) mod camera;
pub(crate) mod casters;
mod coarse_casters;
pub(crate) mod geometry;
mod host;
mod layered;
pub(crate) mod layers;
pub(crate) mod linked;
mod map_key;
mod map_source;
pub(crate) mod maps;
pub(crate) mod memory;
pub(crate) mod pass_runs;
mod pause;
pub(crate) mod position;
mod scene_backend;
pub(crate) mod shared_scene;
pub(crate) mod stages;
pub(crate) mod targets;
pub(crate) mod tile;
pub(crate) mod tiled;

use std::ops::Range;
use std::sync::Arc;

use light::{CheckedLight, LightInstance};
use scene::{Aov, PosedScene, Scene, View, ViewSlot};

pub(crate) use alpha_test::{AlphaTestList, AlphaTestedDraw, texel_wrap};
pub(crate) use backend::{FrameBackend, ReadyLight, TERMS, Term};
pub use host::Host;
pub(crate) use map_source::MapSource;
pub(crate) use scene_backend::{SceneBackend, SceneParts};

use crate::{Picture, RenderError, ShadowSettings};
use camera::{CameraRaster, Sample};
use maps::ShadowMaps;
use pass_runs::{Cause, Pass, PassRuns};
use pause::{DrawnPiece, Pause, is_over};
use shared_scene::{FrameScene, SceneView, SharedScene};
use stages::Recording;
use targets::{Targets, Viewers};
use tile::Tile;

/// Scene and caches of a [`crate::Renderer`] on one backend.
#[derive(Debug)]
pub(crate) struct Frame<B: FrameBackend> {
    pub backend: B,
    pub scene: FrameScene<B>,
    pub viewers: Viewers<B>,
    pub shadow_maps: ShadowMaps<B>,
    pub pass_runs: PassRuns,
}

impl<B: FrameBackend> Frame<B> {
    /// Makes a frame with an empty scene.
    pub fn new(mut backend: B) -> Result<Self, RenderError> {
        let device = Arc::clone(backend.device());
        let scene = B::catch_errors(&device, || {
            let shared = SharedScene::upload(&backend, &scene::pose(Scene::default(), 0.0), 0.0)?;
            backend.bind_scene(&shared);
            FrameScene::<B>::new(&device, Arc::new(shared), 0, 0.0)
        })?;
        let (viewers, shadow_maps, pass_runs) = (Viewers::default(), ShadowMaps::new(), PassRuns::default());
        Ok(Self { backend, scene, viewers, shadow_maps, pass_runs })
    }

    /// Does the work of [`crate::Renderer::set_scene`].
    pub fn set_scene(&mut self, scene: &Arc<PosedScene>) -> Result<(), RenderError> {
        let mesh_error = self.shadow_maps.shadows().mesh_error;
        let upload = || SharedScene::upload(&self.backend, scene, mesh_error);
        let shared = B::catch_errors(self.backend.device(), upload)?;
        self.share_scene(Arc::new(shared))
    }

    /// Does the work of [`crate::Renderer::share_scene`].
    pub fn share_scene(&mut self, shared: Arc<SharedScene<B>>) -> Result<(), RenderError> {
        let (revision, mesh_error) = (self.scene.revision + 1, self.shadow_maps.shadows().mesh_error);
        let device = Arc::clone(self.backend.device());
        self.scene = B::catch_errors(&device, || {
            let scene = FrameScene::<B>::new(&device, shared, revision, mesh_error)?;
            self.backend.bind_scene(&scene);
            Ok(scene)
        })?;
        Ok(())
    }

    /// Does the work of [`crate::Renderer::set_shadow_settings`].
    pub fn set_shadow_settings(&mut self, shadows: ShadowSettings) -> Result<(), RenderError> {
        let limit = self.backend.max_side();
        RenderError::check_size("the resolution of shadow maps", shadows.resolution.into(), limit.into())?;
        shadows.check()?;
        if shadows.mesh_error != self.shadow_maps.shadows().mesh_error {
            let device = self.backend.device();
            let simplify = || self.scene.casters_within(device, shadows.mesh_error);
            self.scene.casters = B::catch_errors(device, simplify)?.into();
        }
        if self.shadow_maps.set_shadows(shadows) {
            self.viewers = Viewers::default();
        }
        Ok(())
    }

    /// Does the work of [`crate::Renderer::drop_view`].
    pub fn drop_view(&mut self, slot: ViewSlot) {
        self.viewers.drop_view(slot);
        self.shadow_maps.drop_view(slot);
        self.backend.free_dropped_memory();
    }

    /// Does the work of [`crate::Renderer::render`].
    pub fn render(&mut self, view: &View, lights: &[LightInstance]) -> Result<Picture, RenderError> {
        let aov = position::rendered_aov(view.aov);
        let pixels =
            self.with_whole(view, aov, lights, |backend, targets| backend.read_radiance(&targets.drawn, targets.size))?;
        let mut picture = Picture { width: view.width, height: view.height, pixels };
        if view.aov == Aov::Position {
            position::from_depths(view, &mut picture);
        }
        Ok(picture)
    }

    /// Does the work of [`crate::Renderer::record_display`].
    pub fn record_display(
        &mut self,
        view: &View,
        lights: &[LightInstance],
    ) -> Result<(Vec<u8>, Recording), RenderError> {
        self.backend.host().stages.start();
        let bytes = self.render_display(view, lights);
        let recording = self.backend.host().stages.stop();
        Ok((bytes?, recording))
    }

    /// Marks all cached results as invalid, and keeps their memory.
    pub fn invalidate(&mut self) {
        self.viewers.invalidate();
        self.shadow_maps.invalidate();
    }

    /// Draws the whole picture of `aov` for `view` into the targets of its slot, then runs `read` on them.
    fn with_whole<T>(
        &mut self,
        view: &View,
        aov: Aov,
        lights: &[LightInstance],
        read: impl FnOnce(&mut B, &Targets<B>) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        // Refuses an impossible picture before any cached data changes.
        let drawing = CheckedPicture::new(&View { aov, ..view.clone() }, lights)?;
        let tile = Tile { x: 0, y: 0, width: view.width, height: view.height };
        self.run_or_discard(view.slot, |frame| {
            frame.backend.host().memory.begin_picture();
            let mut targets = frame.viewers.take(&frame.backend, &drawing.view)?;
            while !frame.draw_sample(&mut targets, &drawing, tile, None)? {}
            let result = read(&mut frame.backend, &targets)?;
            frame.shadow_maps.finish(view.slot);
            frame.viewers.put(&frame.backend, view.slot, targets);
            Ok(result)
        })
    }

    /// Draws the next sample of `drawing` in `tile`, or a part of it if `pause` returns true between two pieces of
    /// work. Returns true if nothing is left.
    ///
    /// Lights add up in order. On the native backend, they add up in a sum for the sample; then the sum and the fill are
    /// added to the earlier samples. Layers of up to [`TERMS`] lights on a screen add up the same way there, so
    /// a single sample equals them bit for bit. With more lights, the layers add up in sums of four, with other
    /// roundings. The result depends neither on tiles nor on pauses.
    fn draw_sample(
        &mut self,
        targets: &mut Targets<B>,
        drawing: &CheckedPicture,
        tile: Tile,
        pause: Option<Pause>,
    ) -> Result<bool, RenderError> {
        let CheckedPicture { view, raster, light_range: needed, samples, .. } = drawing;
        let lights = &self.straightened_lights(view.aov, &drawing.lights);
        let Self { backend, scene, shadow_maps, pass_runs: ran, .. } = self;
        shadow_maps.begin(view.slot, &lights[needed.clone()], scene.revision);
        targets.begin(scene.revision, view, tile, lights);
        let index = targets.samples_drawn;
        if index == *samples {
            return Ok(true);
        }
        if view.aov == Aov::Wireframe {
            let LightInstance { id, light } = &lights[view.light];
            shadow_maps.draw_wireframe(backend, &mut targets.drawn, scene, light)?;
            ran.note(Pass::ShadowMap, Some(*id), Cause::NotKept);
            targets.samples_drawn = *samples;
            return Ok(true);
        }
        let sample = Sample::new(index, *samples);
        let origin = scene.posed.origin_in_world;
        backend.set_sample(&raster.sample_view(sample, view.fill, origin, [tile.x, tile.y])?);
        let scene = SceneView { scene, raster, tile };
        if let Some(cause) = targets.draw_surfaces(backend, &scene, sample.offset)? {
            ran.note(Pass::Gbuffer, None, cause);
            if is_over(backend, pause, DrawnPiece::Pixels)? {
                // The next call finds the surfaces by their key.
                return Ok(false);
            }
        }
        if targets.lights_drawn.is_none() {
            backend.begin_sample(&mut targets.drawn, &scene, view.aov, index == 0)?;
            targets.lights_drawn = Some(0);
        }
        let first = needed.start + targets.lights_drawn.unwrap_or(0);
        for (number, light) in lights.iter().enumerate().take(needed.end).skip(first) {
            if view.aov == Aov::Beauty && light.light.light_profile().is_dark() {
                continue;
            }
            let ready = match shadow_maps.ready_light(backend, &scene, light, view.shadow_map) {
                // The other lights still count; `light::SceneBounds` reports this one to callers that ask.
                Err(RenderError::OutOfReach(_)) if view.aov == Aov::Beauty => continue,
                ready => ready?,
            };
            // The light reaches no visible surface.
            let Some(ready) = ready else { continue };
            if let Some(cause) = ready.shadow_map_cause {
                ran.note(Pass::ShadowMap, Some(light.id), cause);
                // A cached map can wait, and with it the light. The next call finds the map by its key.
                if ready.transient_map.is_none() && is_over(backend, pause, DrawnPiece::ShadowMap)? {
                    return Ok(false);
                }
            }
            backend.add_light(&mut targets.drawn, &scene, view.aov, &ready)?;
            targets.lights_drawn = Some(number + 1 - needed.start);
            // A map without room in the budget must be freed before the next one is drawn.
            if ready.transient_map.is_some() {
                backend.finish()?;
            }
            drop(ready);
            if number + 1 < needed.end && is_over(backend, pause, DrawnPiece::Pixels)? {
                return Ok(false);
            }
        }
        backend.end_sample(&mut targets.drawn, view.aov)?;
        ran.note(Pass::Lighting, None, Cause::NotKept);
        (targets.samples_drawn, targets.lights_drawn) = (index + 1, None);
        if index + 1 < *samples || pause.is_some() {
            // Submission is quick: without waiting, all samples would be in flight at once.
            backend.finish()?;
        }
        Ok(index + 1 == *samples)
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
    fn run_or_discard<T>(
        &mut self,
        slot: ViewSlot,
        work: impl FnOnce(&mut Self) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let device = Arc::clone(self.backend.device());
        self.pass_runs.runs.clear();
        let result = B::catch_errors(&device, || work(self));
        if let Err(error) = &result {
            // The work had taken its data out of the caches, so the data is gone.
            self.viewers.drop_view(slot);
            self.backend.discard();
            if *error != RenderError::Cancelled {
                self.shadow_maps.clear();
            }
        }
        result
    }
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
