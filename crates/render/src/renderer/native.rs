//! Pictures on the native backend.

use std::task::Poll;

use light::LightInstance;
use relight::{LightAov, SurfaceAov};

use super::{CheckedPicture, Renderer};
use crate::camera::sample_offset;
use crate::layers::LayerWork;
use crate::lights::WireframeOnto;
use crate::native_map::NativeMaps;
use crate::pass_runs::{Cause, Pass};
use crate::passes::DrawContext;
use crate::pause::{DrawnPiece, Pause};
use crate::stages::FrameStage;
use crate::targets::Targets;
use crate::tile::Tile;
use crate::{Aov, Gpu, RenderError, display, gpu_structs};

/// Quantity that a picture shows in place of radiance.
#[derive(Clone, Copy)]
enum Quantity {
    OfSurface(SurfaceAov),
    OfLight(LightAov),
}

/// Returns the quantity of `aov`; `None` for the beauty and the wireframe. Positions come from depths.
fn quantity(aov: Aov) -> Option<Quantity> {
    Some(match aov {
        Aov::Beauty | Aov::Wireframe => return None,
        Aov::Depth | Aov::Position => Quantity::OfSurface(SurfaceAov::Depth),
        Aov::Normal => Quantity::OfSurface(SurfaceAov::Normal),
        Aov::T => Quantity::OfLight(LightAov::T),
        Aov::Vw => Quantity::OfLight(LightAov::Vw),
        Aov::Direction => Quantity::OfLight(LightAov::Direction),
        Aov::Visibility => Quantity::OfLight(LightAov::Visibility),
    })
}

impl Renderer {
    /// Draws the surfaces of `tile` for the sample with that index, unless they are there. Returns the camera uniform.
    /// Pending if the picture pauses after they were drawn.
    fn prepare_surfaces(
        &mut self,
        gpu: &Gpu,
        targets: &mut Targets,
        drawing: &CheckedPicture,
        tile: Tile,
        sample: u32,
        pause: Option<Pause>,
    ) -> Result<Poll<gpu_structs::View>, RenderError> {
        let CheckedPicture { view, raster, samples, .. } = drawing;
        let Self { passes, scene, native_surfaces, pass_runs: ran, .. } = self;
        let (offset, weight) = (sample_offset(sample, *samples), 1.0 / *samples as f32);
        let context = DrawContext { gpu, passes, scene, raster, tile };
        let origin = scene.posed.origin_in_world;
        let uniform = raster.uniform(offset, weight, view.fill, origin, [tile.x, tile.y])?;
        let key = context.gbuffer_key(offset);
        if let Some(cause) = targets.native.draw_surfaces(&context, native_surfaces, key, &uniform)? {
            ran.note(Pass::Gbuffer, None, cause);
            if pause.is_some_and(|pause| pause(DrawnPiece::Pixels)) {
                return Ok(Poll::Pending);
            }
        }
        Ok(Poll::Ready(uniform))
    }

    /// Draws the picture of `drawing` for a screen, from layers of its lights. Pending if it pauses.
    pub(super) fn draw_natively(
        &mut self,
        gpu: &Gpu,
        targets: &mut Targets,
        drawing: &CheckedPicture,
        pause: Option<Pause>,
    ) -> Result<Poll<Vec<u8>>, RenderError> {
        let CheckedPicture { view, raster, .. } = drawing;
        let lights = self.straightened_lights(view.aov, &drawing.lights);
        let tile = Tile { x: 0, y: 0, width: view.width, height: view.height };
        self.shadow_maps.begin(view.slot, &lights, self.scene.revision);
        let seen = self.prepare_surfaces(gpu, targets, drawing, tile, 0, pause)?;
        let Poll::Ready(uniform) = seen else { return Ok(Poll::Pending) };
        let Self { passes, scene, shadow_maps, pass_runs: ran, .. } = self;
        let (shadow_map, size) = (view.shadow_map, targets.size);
        let context = DrawContext { gpu, passes, scene, raster, tile };
        let mut work = LayerWork { context, size, shadow_map, shadow_maps, pass_runs: ran, pause };
        let exposure = display::exposure_of(view.exposure);
        let bytes = targets.native.draw_layers(&mut work, &lights, uniform.fill_factor, exposure)?;
        if bytes.is_ready() {
            ran.note(Pass::Display, None, Cause::NotKept);
        }
        Ok(bytes)
    }

    /// Draws a sample, as [`Renderer::draw_sample`]. Lights add up in order in a sum for the
    /// sample; then the sum and the fill are added to the earlier samples. Layers of up to [`gpu_structs::TERMS`]
    /// lights on a screen add up the same way, so a single sample equals them bit for bit. With more lights, the layers
    /// add up in sums of four, with other roundings.
    ///
    /// The result depends neither on tiles nor on pauses.
    pub(super) fn draw_sample_natively(
        &mut self,
        gpu: &Gpu,
        targets: &mut Targets,
        drawing: &CheckedPicture,
        tile: Tile,
        pause: Option<Pause>,
    ) -> Result<bool, RenderError> {
        let CheckedPicture { view, raster, light_range: needed, samples, .. } = drawing;
        let lights = self.straightened_lights(view.aov, &drawing.lights);
        self.shadow_maps.begin(view.slot, &lights[needed.clone()], self.scene.revision);
        targets.begin(self.scene.revision, view, tile, &lights);
        let sample = targets.samples_drawn;
        if sample == *samples {
            return Ok(true);
        }
        if view.aov == Aov::Wireframe {
            let LightInstance { id, light } = &lights[view.light];
            let context = DrawContext { gpu, passes: &self.passes, scene: &self.scene, raster, tile };
            let size = targets.size;
            let onto = WireframeOnto::Native { size, picture: targets.native.picture(size) };
            self.shadow_maps.draw_wireframe(&context, light, onto)?;
            self.pass_runs.note(Pass::ShadowMap, Some(*id), Cause::NotKept);
            targets.samples_drawn = *samples;
            return Ok(true);
        }
        let seen = self.prepare_surfaces(gpu, targets, drawing, tile, sample, pause)?;
        let Poll::Ready(uniform) = seen else { return Ok(false) };
        if let Some(quantity) = quantity(view.aov) {
            self.draw_aov(gpu, targets, drawing, tile, quantity, &lights)?;
            targets.samples_drawn = sample + 1;
            return Ok(sample + 1 == *samples);
        }
        let Self { passes, scene, shadow_maps, pass_runs: ran, .. } = self;
        let (passes, scene) = (&**passes, &*scene);
        if targets.lights_drawn.is_none() {
            targets.native.begin_sample(gpu);
        }
        let context = DrawContext { gpu, passes, scene, raster, tile };
        let paused = |piece| pause.is_some_and(|pause| pause(piece));
        for (index, light) in lights.iter().enumerate().skip(targets.lights_drawn.unwrap_or(0)) {
            if light.light.light_profile().is_dark() {
                continue;
            }
            let ready = match shadow_maps.ready_light(&mut NativeMaps(gpu), &context, light, view.shadow_map) {
                // The other lights still count; `light::SceneBounds` reports this one to callers that ask.
                Err(RenderError::OutOfReach(_)) => continue,
                ready => ready?,
            };
            // The light reaches no visible surface.
            let Some(ready) = ready else { continue };
            if let Some(cause) = ready.shadow_map_cause {
                ran.note(Pass::ShadowMap, Some(light.id), cause);
                // A cached map can wait, and with it the light.
                if ready.transient_map.is_none() && paused(DrawnPiece::ShadowMap) {
                    return Ok(false);
                }
            }
            targets.native.add_light(&context, &light.light, &ready)?;
            // A map without room in the budget must be freed before the next one is drawn.
            drop(ready);
            targets.lights_drawn = Some(index + 1);
            if index + 1 < lights.len() && paused(DrawnPiece::Pixels) {
                return Ok(false);
            }
        }
        targets.native.end_sample(gpu, sample == 0, uniform.fill_factor, uniform.sample_weight);
        ran.note(Pass::Lighting, None, Cause::NotKept);
        (targets.samples_drawn, targets.lights_drawn) = (sample + 1, None);
        Ok(sample + 1 == *samples)
    }

    /// Adds the next sample of an AOV.
    fn draw_aov(
        &mut self,
        gpu: &Gpu,
        targets: &mut Targets,
        drawing: &CheckedPicture,
        tile: Tile,
        quantity: Quantity,
        lights: &[LightInstance],
    ) -> Result<(), RenderError> {
        let CheckedPicture { view, raster, samples, .. } = drawing;
        let Self { passes, scene, shadow_maps, pass_runs: ran, .. } = self;
        let context = DrawContext { gpu, passes, scene, raster, tile };
        let (is_first, weight) = (targets.samples_drawn == 0, 1.0 / *samples as f32);
        match quantity {
            Quantity::OfSurface(aov) => targets.native.add_surface_aov(gpu, aov, is_first, weight),
            Quantity::OfLight(aov) => {
                let light = &lights[view.light];
                let ready = shadow_maps.ready_light(&mut NativeMaps(gpu), &context, light, view.shadow_map)?;
                if let Some(cause) = ready.as_ref().and_then(|ready| ready.shadow_map_cause) {
                    ran.note(Pass::ShadowMap, Some(light.id), cause);
                }
                targets.native.add_light_aov(&context, ready.as_ref(), aov, is_first, weight)?;
            }
        }
        ran.note(Pass::Lighting, None, Cause::NotKept);
        Ok(())
    }

    /// Returns the bytes of a screen for the beauty in `targets`, with `exposure` in stops.
    pub(super) fn display_natively(&mut self, gpu: &Gpu, targets: &Targets, exposure: f64) -> Vec<u8> {
        let exposure = display::exposure_of(exposure);
        let bytes = relight::display_radiance(gpu.workers(), targets.native.radiance(), exposure);
        gpu.stages.record_stage(FrameStage::Display);
        self.pass_runs.note(Pass::Display, None, Cause::NotKept);
        bytes
    }
}
