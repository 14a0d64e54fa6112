//! Draws pictures for a screen from cached layers, in one call or in several slices of drawing time.

use std::task::Poll;
use std::time::{Duration, Instant};

use light::LightInstance;
use scene::{Aov, MapScale, View};

use super::backend::FrameBackend;
use super::camera::Sample;
use super::layers::{self, LayerWork};
use super::pass_runs::{Cause, Pass};
use super::pause::{DrawnPiece, Pause, is_over};
use super::shared_scene::SceneView;
use super::targets::Targets;
use super::tile::Tile;
use super::{CheckedPicture, Frame};
use crate::RenderError;

impl<B: FrameBackend> Frame<B> {
    /// True if [`Self::render_display`] caches layers for such a picture: it has one sample per pixel, and the layers
    /// of `light_count` lights and their sums take at most half of the [`crate::MemoryBudget`].
    pub fn keeps_layers(&self, view: &View, light_count: usize) -> bool {
        let budget = self.backend.host().memory.budget();
        view.samples <= 1 && layers::do_layers_fit::<B>(budget, [view.width, view.height], light_count)
    }

    /// Does the work of [`crate::Renderer::render_display`].
    pub fn render_display(&mut self, view: &View, lights: &[LightInstance]) -> Result<Vec<u8>, RenderError> {
        let bytes = self.draw_display(view, lights, None)?;
        let Poll::Ready(bytes) = bytes else { unreachable!("nothing pauses it") };
        Ok(bytes)
    }

    /// Does the work of [`crate::Renderer::advance_display`].
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
            let whole = self.with_whole(view, Aov::Beauty, lights, |backend, targets| {
                backend.show_radiance(&targets.drawn, targets.size, view.exposure)
            })?;
            self.pass_runs.note(Pass::Display, None, Cause::NotKept);
            return Ok(Poll::Ready(whole));
        }
        let drawing = CheckedPicture::new(&View { aov: Aov::Beauty, ..view.clone() }, lights)?;
        self.run_or_discard(view.slot, |frame| {
            frame.backend.host().memory.begin_picture();
            let mut targets = frame.viewers.take(&frame.backend, &drawing.view)?;
            let bytes = loop {
                // A picture in several slices waits for each piece, so it can check the fit of maps at once.
                if pause.is_none() {
                    frame.backend.defer_fit_checks();
                }
                let bytes = frame.draw_layered(&mut targets, &drawing, pause)?;
                // Waits for the device once per picture. A map rarely does not fit; then everything is drawn again.
                if bytes.is_pending() || frame.backend.have_maps_fitted()? {
                    break bytes;
                }
                frame.shadow_maps.invalidate();
                targets.invalidate();
            };
            if bytes.is_ready() {
                frame.shadow_maps.finish(view.slot);
            }
            frame.viewers.put(&frame.backend, view.slot, targets);
            Ok(bytes)
        })
    }

    /// Draws the picture of `drawing` for a screen, from layers of its lights. Pending if it pauses.
    fn draw_layered(
        &mut self,
        targets: &mut Targets<B>,
        drawing: &CheckedPicture,
        pause: Option<Pause>,
    ) -> Result<Poll<Vec<u8>>, RenderError> {
        let CheckedPicture { view, raster, .. } = drawing;
        let lights = &self.straightened_lights(view.aov, &drawing.lights);
        let tile = Tile { x: 0, y: 0, width: view.width, height: view.height };
        let Self { backend, scene, shadow_maps, pass_runs: ran, .. } = self;
        shadow_maps.begin(view.slot, lights, scene.revision);
        // The fill depends on no shadow map.
        let of_fill = View { shadow_map: MapScale::Full, ..view.clone() };
        targets.begin(scene.revision, &of_fill, tile, &[]);
        let origin = scene.posed.origin_in_world;
        backend.set_sample(&raster.sample_view(Sample::ONLY, view.fill, origin, [0, 0])?);
        let scene = SceneView { scene, raster, tile };
        let surfaces = targets.draw_surfaces(backend, &scene, Sample::ONLY.offset)?;
        if let Some(cause) = surfaces {
            ran.note(Pass::Gbuffer, None, cause);
        }
        let mut is_fill_drawn = false;
        if targets.samples_drawn == 0 {
            is_fill_drawn = backend.draw_fill(&mut targets.drawn, &scene)?;
            targets.samples_drawn = 1;
        }
        if is_fill_drawn {
            ran.note(Pass::Lighting, None, surfaces.unwrap_or(Cause::NotKept));
        }
        if (surfaces.is_some() || is_fill_drawn) && is_over(backend, pause, DrawnPiece::Pixels)? {
            return Ok(Poll::Pending);
        }
        let Targets { size, drawn, layers, .. } = targets;
        let (size, shadow_map, pass_runs) = (*size, view.shadow_map, &mut *ran);
        let mut work = LayerWork { backend, targets: drawn, scene, size, shadow_map, shadow_maps, pass_runs, pause };
        let Poll::Ready(terms) = layers.draw(&mut work, lights)? else { return Ok(Poll::Pending) };
        let bytes = work.backend.show(work.targets, terms.as_ref(), view.exposure)?;
        ran.note(Pass::Display, None, Cause::NotKept);
        Ok(Poll::Ready(bytes))
    }
}
