//! Layers: the contribution of each light to a view, cached between pictures, and sums of layers.
//!
//! A layer is the light's reflected radiance before factors of the whole light ([`light::LightProfile::lobe_weights`]).
//! An edit of a factor, an enabled or disabled light, and a view's exposure draw no layer. A moved light draws its own.
//!
//! Layers always add up in the same order, regardless of cache and edits: in groups of four if there are more than
//! eight, and those sums again in groups of four while there are more than eight.

use std::task::Poll;

use light::{LightDigest, LightId, LightInstance};
use scene::MapScale;

use super::backend::{FrameBackend, TERMS, Term};
use super::maps::{ShadowMaps, factors, reachable_pixels};
use super::memory::{Evictable, MemoryKind};
use super::pass_runs::{Cause, Pass, PassRuns};
use super::pause::{DrawnPiece, Pause, is_over};
use super::shared_scene::SceneView;
use super::tile::{Tile, area, pixel_count};
use crate::RenderError;

/// Number of layers or sums that are added to an intermediate sum. If one of 64 lights moves, its layer is added to
/// three others, their sum to three other sums, and that sum to three more.
const GROUP: usize = 4;

/// Layers of the lights in a view, and their sums. They are valid as long as the view's G-buffer is.
#[derive(Debug)]
pub(crate) struct Layers<B: FrameBackend> {
    lights: Vec<KeptLayer<B::Layer>>,
    /// Intermediate sums, level by level. The first level adds up groups of lights, each further level groups of the
    /// sums before.
    sums: Vec<Vec<KeptSum<B::Sum>>>,
}

#[derive(Debug)]
struct KeptLayer<Layer> {
    light: LightId,
    /// Revision of the light that the layer shows; `None` if invalid.
    radiance_revision: Option<LightDigest>,
    /// Scale of the shadow map with which the layer was drawn.
    shadow_map: MapScale,
    /// `None` if the light reaches no visible surface.
    layer: Option<Evictable<Layer>>,
}

#[derive(Debug)]
struct KeptSum<Sum> {
    /// Lights that the sum contains, each with the digest of all its values that affect a picture.
    light_revisions: Vec<(LightId, LightDigest)>,
    /// Scale of shadow maps that was requested when the sum was drawn.
    shadow_map: MapScale,
    sum: Evictable<Sum>,
}

pub(crate) struct LayerWork<'a, B: FrameBackend> {
    pub backend: &'a mut B,
    pub targets: &'a B::Targets,
    pub scene: SceneView<'a, B>,
    /// In pixels.
    pub size: [u32; 2],
    pub shadow_map: MapScale,
    pub shadow_maps: &'a mut ShadowMaps<B>,
    pub pass_runs: &'a mut PassRuns,
    /// Callback that decides after each piece of work if drawing the picture pauses. `None` if it never pauses.
    pub pause: Option<Pause<'a>>,
}

/// True if the layers of `light_count` lights and their sums take at most half of `budget`, in bytes.
pub(crate) fn do_layers_fit<B: FrameBackend>(budget: u64, size: [u32; 2], light_count: usize) -> bool {
    let lights = light_count as u64;
    let bytes_a_pixel = lights * B::LAYER_BYTES_PER_PIXEL + 2 * lights.div_ceil(GROUP as u64) * B::SUM_BYTES_PER_PIXEL;
    pixel_count(size) * bytes_a_pixel <= budget / 2
}

impl<B: FrameBackend> Default for Layers<B> {
    fn default() -> Self {
        Self { lights: Vec::new(), sums: Vec::new() }
    }
}

impl<B: FrameBackend> Layers<B> {
    /// Marks all layers and sums as invalid, and keeps their storage.
    pub fn invalidate(&mut self) {
        self.lights.iter_mut().for_each(|layer| layer.radiance_revision = None);
        self.sums.iter_mut().flatten().for_each(|sum| sum.light_revisions.clear());
    }

    /// Returns the layer of `light` if it is valid and was drawn with a map of at least that scale.
    fn cached_layer(&self, light: &LightInstance, shadow_map: MapScale) -> Option<B::Layer> {
        let shows = Some(light.light.revisions().radiance);
        let kept = self.lights.iter().find(|kept| (kept.light, kept.radiance_revision) == (light.id, shows))?;
        let layer = kept.layer.as_ref().filter(|_| kept.shadow_map <= shadow_map)?;
        layer.take().inspect(|held| layer.put(held.clone()))
    }

    /// True if `light` reaches a pixel. If not, caches that fact as its layer.
    fn reaches_visible_pixels(&mut self, work: &LayerWork<B>, light: &LightInstance) -> bool {
        let shows = Some(light.light.revisions().radiance);
        let known = self.lights.iter().find(|kept| (kept.light, kept.radiance_revision) == (light.id, shows));
        let culling = work.shadow_maps.shadows().culling;
        let reaches = known.map_or_else(
            || reachable_pixels(&light.light, work.scene.scene, work.scene.raster, culling).is_some(),
            |kept| kept.layer.is_some(),
        );
        if !reaches && known.is_none() {
            self.lights.retain(|kept| kept.light != light.id);
            self.lights.push(KeptLayer {
                light: light.id,
                radiance_revision: shows,
                shadow_map: MapScale::Full,
                layer: None,
            });
        }
        reaches
    }

    /// Returns the cause for drawing the layer of `light`.
    fn cause(&self, light: &LightInstance) -> Cause {
        match self.lights.iter().find(|kept| kept.light == light.id) {
            None => Cause::First,
            Some(KeptLayer { radiance_revision: None, .. }) => Cause::Gbuffer,
            Some(kept) if kept.radiance_revision != Some(light.light.revisions().radiance) => Cause::Light,
            Some(kept) if kept.layer.as_ref().is_some_and(Evictable::is_present) => Cause::Resolution,
            Some(_) => Cause::Evicted,
        }
    }

    fn keep(&mut self, backend: &B, bytes: u64, light: &LightInstance, shadow_map: MapScale, layer: B::Layer) {
        let shows = Some(light.light.revisions().radiance);
        let own = self.lights.iter().position(|kept| kept.light == light.id);
        let room = own.and_then(|own| self.lights.swap_remove(own).layer);
        self.lights.retain(|kept| kept.layer.as_ref().is_none_or(Evictable::is_present));
        if let Some(room) = &room {
            room.put(layer.clone());
        }
        let layer = room
            .filter(Evictable::is_present)
            .unwrap_or_else(|| backend.host().memory.keep(MemoryKind::Layers, bytes, layer));
        let layer = Some(layer);
        self.lights.push(KeptLayer { light: light.id, radiance_revision: shows, shadow_map, layer });
    }

    /// Takes the cached layer of a light out of the cache, even if it is invalid.
    fn take(&self, light: &LightInstance) -> Option<B::Layer> {
        self.lights.iter().find(|kept| kept.light == light.id)?.layer.as_ref()?.take()
    }

    /// Updates the layers of `lights`, and adds them up until only a few terms remain, whose sum is the picture without
    /// its fill. `None` if no light contributes. Pending if the picture pauses; the next call continues with the layers
    /// drawn so far.
    pub fn draw(
        &mut self,
        work: &mut LayerWork<B>,
        lights: &[LightInstance],
    ) -> Result<Poll<Option<B::Terms>>, RenderError> {
        // The other lights still count; `light::SceneBounds` reports this one to callers that ask.
        let is_there = |light: &&LightInstance| {
            !light.light.light_profile().is_dark() && work.scene.scene.posed.bounds().check(&light.light).is_ok()
        };
        let lights: Vec<&LightInstance> =
            lights.iter().filter(is_there).filter(|light| self.reaches_visible_pixels(work, light)).collect();
        for kept in &self.lights {
            let needed = lights.iter().any(|light| light.id == kept.light);
            if let Some(layer) = &kept.layer {
                layer.set_needed(needed);
            }
        }
        if lights.len() <= TERMS {
            let Poll::Ready(terms) = self.terms_of_lights(work, &lights)? else {
                return Ok(Poll::Pending);
            };
            return Ok(Poll::Ready((!terms.is_empty()).then(|| work.backend.terms_of_layers(&terms))));
        }
        let mut of: Vec<Vec<&LightInstance>> = lights.chunks(GROUP).map(<[_]>::to_vec).collect();
        let mut sums = Vec::new();
        for (index, group) in of.iter().enumerate() {
            let sum = if let Some(sum) = self.cached_sum(0, index, group, work.shadow_map) {
                sum
            } else {
                let Poll::Ready(terms) = self.terms_of_lights(work, group)? else {
                    return Ok(Poll::Pending);
                };
                let terms = work.backend.terms_of_layers(&terms);
                self.draw_sum(work, 0, index, group, &terms)?
            };
            sums.push(sum);
        }
        let mut level = 0;
        while sums.len() > TERMS {
            level += 1;
            of = of.chunks(GROUP).map(<[_]>::concat).collect();
            let mut next = Vec::new();
            for (index, sums) in sums.chunks(GROUP).enumerate() {
                let sum = if let Some(sum) = self.cached_sum(level, index, &of[index], work.shadow_map) {
                    sum
                } else {
                    let terms = work.backend.terms_of_sums(sums);
                    self.draw_sum(work, level, index, &of[index], &terms)?
                };
                next.push(sum);
            }
            sums = next;
        }
        Ok(Poll::Ready(Some(work.backend.terms_of_sums(&sums))))
    }

    /// Returns the layers of some lights with their factors, and draws the layers that are not cached. Pending if
    /// drawing the picture pauses.
    fn terms_of_lights(
        &mut self,
        work: &mut LayerWork<B>,
        lights: &[&LightInstance],
    ) -> Result<Poll<Vec<Term<B::Layer>>>, RenderError> {
        let mut terms = Vec::with_capacity(lights.len());
        for light in lights {
            let held = self.cached_layer(light, work.shadow_map);
            let layer = if held.is_some() {
                held
            } else {
                match self.draw_layer(work, light)? {
                    Poll::Ready(layer) if !is_over(work.backend, work.pause, DrawnPiece::Pixels)? => layer,
                    _ => return Ok(Poll::Pending),
                }
            };
            let Some(layer) = layer else { continue };
            let [diffuse, specular] = factors(&light.light);
            terms.push(Term { layer, diffuse, specular });
        }
        Ok(Poll::Ready(terms))
    }

    /// Draws a light's layer. `None` if the light reaches no visible surface. Pending if the picture pauses after the
    /// light's map.
    fn draw_layer(
        &mut self,
        work: &mut LayerWork<B>,
        light: &LightInstance,
    ) -> Result<Poll<Option<B::Layer>>, RenderError> {
        let ready = work.shadow_maps.ready_light(work.backend, &work.scene, light, work.shadow_map)?;
        let Some(ready) = ready else { return Ok(Poll::Ready(None)) };
        if let Some(cause) = ready.shadow_map_cause {
            work.pass_runs.note(Pass::ShadowMap, Some(light.id), cause);
            // A map without room in the budget would be drawn again after a pause.
            if ready.transient_map.is_none() && is_over(work.backend, work.pause, DrawnPiece::ShadowMap)? {
                return Ok(Poll::Pending);
            }
        }
        let LayerWork { backend, targets, scene, size, pass_runs, .. } = work;
        pass_runs.note(Pass::Layer, Some(light.id), self.cause(light));
        let bytes = pixel_count(*size) * B::LAYER_BYTES_PER_PIXEL;
        let over = self.take(light);
        if over.is_none() {
            backend.make_room(bytes);
        }
        let pixels = Tile { x: 0, y: 0, width: size[0], height: size[1] }.clip(ready.pixels);
        let layer = backend.draw_layer(targets, scene, &ready, pixels, over)?;
        // A map without room in the budget must be freed before the next one is drawn.
        if ready.transient_map.is_some() {
            backend.finish()?;
        }
        backend.host().stages.count(|counters| counters.scissor_pixels += area(pixels));
        self.keep(*backend, bytes, light, ready.shadow_map, layer.clone());
        Ok(Poll::Ready(Some(layer)))
    }

    fn cached_sum(
        &self,
        level: usize,
        index: usize,
        lights: &[&LightInstance],
        shadow_map: MapScale,
    ) -> Option<B::Sum> {
        let kept = self.sums.get(level)?.get(index)?;
        if kept.light_revisions != revisions(lights) || kept.shadow_map > shadow_map {
            return None;
        }
        kept.sum.take().inspect(|sum| kept.sum.put(sum.clone()))
    }

    fn draw_sum(
        &mut self,
        work: &mut LayerWork<B>,
        level: usize,
        index: usize,
        lights: &[&LightInstance],
        terms: &B::Terms,
    ) -> Result<B::Sum, RenderError> {
        let LayerWork { backend, targets, size, shadow_map, pass_runs, .. } = work;
        let cause = match self.sums.get(level).and_then(|sums| sums.get(index)) {
            None => Cause::First,
            Some(kept) if kept.light_revisions.is_empty() => Cause::Gbuffer,
            Some(kept) if kept.light_revisions != revisions(lights) => Cause::Light,
            Some(kept) if kept.sum.is_present() => Cause::Resolution,
            Some(_) => Cause::Evicted,
        };
        pass_runs.note(Pass::Sum, None, cause);
        let sums = &mut self.sums;
        sums.resize_with(sums.len().max(level + 1), Vec::new);
        let own = sums[level].get(index).and_then(|kept| kept.sum.take());
        let is_kept = own.is_some();
        let sum = backend.draw_sum(targets, terms, own)?;
        if is_kept {
            sums[level][index].sum.put(sum.clone());
            (sums[level][index].light_revisions, sums[level][index].shadow_map) = (revisions(lights), *shadow_map);
            return Ok(sum);
        }
        let bytes = pixel_count(*size) * B::SUM_BYTES_PER_PIXEL;
        let kept = backend.host().memory.keep(MemoryKind::Layers, bytes, sum.clone());
        let kept = KeptSum { light_revisions: revisions(lights), shadow_map: *shadow_map, sum: kept };
        match sums[level].get_mut(index) {
            Some(before) => *before = kept,
            None => sums[level].push(kept),
        }
        Ok(sum)
    }
}

fn revisions(lights: &[&LightInstance]) -> Vec<(LightId, LightDigest)> {
    lights.iter().map(|light| (light.id, light.light.revisions().picture)).collect()
}
