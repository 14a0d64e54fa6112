//! Draws pictures for a screen from cached layers, in one call or in several slices of drawing time.

use std::task::Poll;
use std::time::{Duration, Instant};

use glam::DVec2;
use light::LightInstance;
use scene::MapScale;

use super::{CheckedPicture, Renderer, read_display_texture};
use crate::layers::{self, LayerWork};
use crate::native_layers::NativeLayers;
use crate::pass_runs::{Cause, Pass};
use crate::passes::DrawContext;
use crate::pause::{DrawnPiece, Pause};
use crate::stages::FrameStage;
use crate::targets::Targets;
use crate::tile::Tile;
use crate::wgpu_layers::WgpuLayers;
use crate::{Aov, Backend, Gpu, RenderError, View};

impl Renderer {
    /// True if [`Self::render_display`] caches layers for such a picture: it has one sample per pixel, and the layers
    /// of `light_count` lights and their sums take at most half of the [`crate::MemoryBudget`].
    pub fn keeps_layers(&self, view: &View, light_count: usize) -> bool {
        let (budget, size) = (self.gpu.memory.budget(), [view.width, view.height]);
        let fit = match self.gpu.backend() {
            Backend::Wgpu => layers::do_layers_fit::<WgpuLayers>(budget, size, light_count),
            Backend::Native => layers::do_layers_fit::<NativeLayers>(budget, size, light_count),
        };
        view.samples <= 1 && fit
    }

    /// Draws the beauty of `view` under `lights` for a screen, regardless of `view.aov`: exposed, tone-mapped, sRGB,
    /// RGBA, 8 bits per channel, rows from the top.
    ///
    /// With layers ([`Self::keeps_layers`]), an edit of a factor of a light's whole radiance draws only the sum, and
    /// another edit draws the edited light. Otherwise lights are added to the picture one after another, as in
    /// [`Self::render`].
    pub fn render_display(&mut self, view: &View, lights: &[LightInstance]) -> Result<Vec<u8>, RenderError> {
        let bytes = self.draw_display(view, lights, None)?;
        let Poll::Ready(bytes) = bytes else { unreachable!("nothing pauses it") };
        Ok(bytes)
    }

    /// Works on [`Self::render_display`] for about `aim`, until the current piece of work is done: the G-buffer, a
    /// shadow map, or a light over the whole picture. Pending if work is left. Another call with the same arguments
    /// continues, and draws again only what was evicted meanwhile.
    pub fn advance_display(
        &mut self,
        view: &View,
        lights: &[LightInstance],
        aim: Duration,
    ) -> Result<Poll<Vec<u8>>, RenderError> {
        let until = Instant::now().checked_add(aim);
        let is_over = |_| until.is_some_and(|until| Instant::now() >= until);
        self.draw_display(view, lights, Some(&is_over))
    }

    fn draw_display(
        &mut self,
        view: &View,
        lights: &[LightInstance],
        pause: Option<Pause>,
    ) -> Result<Poll<Vec<u8>>, RenderError> {
        if !self.keeps_layers(view, lights.len()) {
            let whole = self.with_whole(view, Aov::Beauty, lights, |renderer, gpu, targets| {
                renderer.read_display(gpu, targets, targets.size, view.exposure)
            });
            return whole.map(Poll::Ready);
        }
        let drawing = CheckedPicture::new(&View { aov: Aov::Beauty, ..view.clone() }, lights)?;
        self.run_or_discard(view.slot, |renderer, gpu| {
            gpu.memory.begin_picture();
            let mut targets = renderer.viewers.take(gpu, &drawing.view)?;
            let bytes = match gpu.backend() {
                Backend::Native => renderer.draw_natively(gpu, &mut targets, &drawing, pause)?,
                Backend::Wgpu => loop {
                    // A picture in several slices waits for each piece, so it can check the fit of maps at once.
                    if pause.is_none() {
                        renderer.shadow_maps.bent_buffers.defer_fit_checks();
                    }
                    if renderer.draw_layered(gpu, &mut targets, &drawing, pause)?.is_pending() {
                        break Poll::Pending;
                    }
                    let bytes = read_display_texture(gpu, targets.lit(gpu, &renderer.passes), targets.size)?;
                    // Waits for the device once per picture. A map rarely does not fit; then everything is drawn again.
                    if renderer.shadow_maps.bent_buffers.check_deferred_fits(gpu)? {
                        break Poll::Ready(bytes);
                    }
                    renderer.shadow_maps.invalidate();
                    targets.invalidate();
                },
            };
            if bytes.is_ready() {
                renderer.shadow_maps.finish(view.slot);
            }
            renderer.viewers.put(gpu, view.slot, targets);
            Ok(bytes)
        })
    }

    /// Draws the picture of `drawing` for a screen, from layers of its lights. Pending if it pauses.
    fn draw_layered(
        &mut self,
        gpu: &Gpu,
        targets: &mut Targets,
        drawing: &CheckedPicture,
        pause: Option<Pause>,
    ) -> Result<Poll<()>, RenderError> {
        let CheckedPicture { view, raster, .. } = drawing;
        let lights = &self.straightened_lights(view.aov, &drawing.lights);
        let tile = Tile { x: 0, y: 0, width: view.width, height: view.height };
        let Self { passes, scene, shadow_maps, pass_runs: ran, view_uniform, .. } = self;
        let (passes, scene) = (&**passes, &*scene);
        shadow_maps.begin(view.slot, lights, scene.revision);
        // The fill depends on no shadow map.
        let of_fill = View { shadow_map: MapScale::Full, ..view.clone() };
        targets.begin(scene.revision, &of_fill, tile, &[]);
        let uniform = raster.uniform(DVec2::ZERO, 1.0, view.fill, scene.posed.origin_in_world, [0, 0])?;
        gpu.queue.write_buffer(view_uniform, 0, bytemuck::bytes_of(&uniform));
        let context = DrawContext { gpu, passes, scene, raster, tile };
        let mut encoder = gpu.encoder();
        if targets.samples_drawn == 0 {
            let drawn = targets.draw_gbuffer(&context, &mut encoder, DVec2::ZERO)?;
            if let Some(cause) = drawn {
                ran.note(Pass::Gbuffer, None, cause);
            }
            gpu.end_stage(&mut encoder, FrameStage::Gbuffer)?;
            targets.draw_lighting(&context, &mut encoder, view.aov, true, true, &[])?;
            ran.note(Pass::Lighting, None, drawn.unwrap_or(Cause::NotKept));
            targets.samples_drawn = 1;
            if let Some(pause) = pause {
                gpu.submit_and_wait(&mut encoder)?;
                if pause(DrawnPiece::Pixels) {
                    return Ok(Poll::Pending);
                }
            }
        }
        let (shadow_map, size) = (view.shadow_map, targets.size);
        let mut work = LayerWork { context, size, shadow_map, shadow_maps, pass_runs: ran, pause };
        let Poll::Ready(terms) = targets.draw_layers(&mut encoder, &mut work, lights)? else {
            return Ok(Poll::Pending);
        };
        targets.draw_display(gpu, &mut encoder, passes, terms.as_ref(), view.exposure);
        gpu.end_stage(&mut encoder, FrameStage::Display)?;
        gpu.queue.submit([encoder.finish()]);
        self.pass_runs.note(Pass::Display, None, Cause::NotKept);
        Ok(Poll::Ready(()))
    }
}
