//! Layers: the contribution of each light to a view, cached between pictures, and sums of layers.
//!
//! A layer is the light's reflected radiance before factors of the whole light ([`light::LightProfile::lobe_weights`]).
//! An edit of a factor, an enabled or disabled light, and a view's exposure draw no layer. A moved light draws its own.
//!
//! Layers always add up in the same order, regardless of cache and edits: in groups of four if there are more than
//! eight, and those sums again in groups of four while there are more than eight.

use std::task::Poll;

use glam::DVec3;
use light::{CheckedLight, LightDigest, LightId, LightInstance};
use scene::MapScale;

use crate::composite::GpuTerm;
use crate::gpu_structs::{LARGE, TERMS};
use crate::lights::{ReadyLight, ShadowMaps, reachable_pixels};
use crate::memory::{Evictable, MemoryKind};
use crate::pass_runs::{Cause, Pass, PassRuns};
use crate::passes::DrawContext;
use crate::pause::{DrawnPiece, Pause};
use crate::tile::{Tile, area, pixel_count};
use crate::{Gpu, RenderError};

/// Number of layers or sums that are added to an intermediate sum. If one of 64 lights moves, its layer is added to
/// three others, their sum to three other sums, and that sum to three more.
const GROUP: usize = 4;

/// Draws and sums the layers of a view, on the GPU or the CPU.
pub(crate) trait LayerPainter {
    /// Storage of a layer; clones share it.
    type Layer: Clone + Send + 'static;
    /// Storage of a sum; clones share it.
    type Sum: Clone + Send + 'static;
    /// A light with its map, ready for lookups.
    type Light;
    /// Terms of a picture or a sum: at least one and at most [`TERMS`] layers or sums.
    type Terms;
    const LAYER_BYTES_PER_PIXEL: u64;
    const SUM_BYTES_PER_PIXEL: u64;

    /// Calls [`ShadowMaps::ready_light`] for this backend.
    fn ready_light(
        &mut self,
        shadow_maps: &mut ShadowMaps,
        light: &LightInstance,
        scale: MapScale,
    ) -> Result<Option<ReadyLight<Self::Light>>, RenderError>;

    /// Draws the contribution of `light` to `pixels`, `[x, y, width, height]`, and zero elsewhere. Reuses the storage
    /// of `over`, which is no longer needed. Records [`crate::FrameStage::Light`].
    fn draw_layer(
        &mut self,
        light: &ReadyLight<Self::Light>,
        pixels: [u32; 4],
        over: Option<Self::Layer>,
    ) -> Result<Self::Layer, RenderError>;

    /// Draws a sum. Reuses the storage of `over`, which is no longer needed. Records [`crate::FrameStage::Sum`].
    fn draw_sum(&mut self, terms: &Self::Terms, over: Option<Self::Sum>) -> Result<Self::Sum, RenderError>;

    /// Makes the terms of a sum from layers and their factors.
    fn terms_of_layers(&self, layers: &[GpuTerm<Self::Layer>]) -> Self::Terms;

    /// Makes the terms of a sum from sums, each with factor 1.
    fn terms_of_sums(&self, sums: &[Self::Sum]) -> Self::Terms;

    /// Waits until all layers are drawn.
    fn finish(&mut self) -> Result<(), RenderError>;
}

/// Layers of the lights in a view, and their sums. They are valid as long as the view's G-buffer is.
#[derive(Debug)]
pub(crate) struct Layers<Layer, Sum> {
    lights: Vec<KeptLayer<Layer>>,
    /// Intermediate sums, level by level. The first level adds up groups of lights, each further level groups of the
    /// sums before.
    sums: Vec<Vec<KeptSum<Sum>>>,
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

pub(crate) struct LayerWork<'a> {
    pub context: DrawContext<'a>,
    /// In pixels.
    pub size: [u32; 2],
    pub shadow_map: MapScale,
    pub shadow_maps: &'a mut ShadowMaps,
    pub pass_runs: &'a mut PassRuns,
    /// Callback that decides after each piece of work if drawing the picture pauses. `None` if it never pauses.
    pub pause: Option<Pause<'a>>,
}

impl LayerWork<'_> {
    /// Waits until a piece of work is drawn. Returns true if drawing the picture pauses now.
    fn pauses(&mut self, painter: &mut impl LayerPainter, piece: DrawnPiece) -> Result<bool, RenderError> {
        let Some(pause) = self.pause else { return Ok(false) };
        painter.finish()?;
        Ok(pause(piece))
    }
}

/// True if the layers of `light_count` lights and their sums take at most half of `budget`, in bytes.
pub(crate) fn do_layers_fit<P: LayerPainter>(budget: u64, size: [u32; 2], light_count: usize) -> bool {
    let lights = light_count as u64;
    let bytes_a_pixel = lights * P::LAYER_BYTES_PER_PIXEL + 2 * lights.div_ceil(GROUP as u64) * P::SUM_BYTES_PER_PIXEL;
    pixel_count(size) * bytes_a_pixel <= budget / 2
}

impl<Layer, Sum> Default for Layers<Layer, Sum> {
    fn default() -> Self {
        Self { lights: Vec::new(), sums: Vec::new() }
    }
}

impl<Layer: Clone + Send + 'static, Sum: Clone + Send + 'static> Layers<Layer, Sum> {
    /// Marks all layers and sums as invalid, and keeps their storage.
    pub fn invalidate(&mut self) {
        self.lights.iter_mut().for_each(|layer| layer.radiance_revision = None);
        self.sums.iter_mut().flatten().for_each(|sum| sum.light_revisions.clear());
    }

    /// Returns the layer of `light` if it is valid and was drawn with a map of at least that scale.
    fn cached_layer(&self, light: &LightInstance, shadow_map: MapScale) -> Option<Layer> {
        let shows = Some(light.light.revisions().radiance);
        let kept = self.lights.iter().find(|kept| (kept.light, kept.radiance_revision) == (light.id, shows))?;
        let layer = kept.layer.as_ref().filter(|_| kept.shadow_map <= shadow_map)?;
        layer.take().inspect(|held| layer.put(held.clone()))
    }

    /// True if `light` reaches a pixel. If not, caches that fact as its layer.
    fn reaches_visible_pixels(&mut self, work: &LayerWork, light: &LightInstance) -> bool {
        let shows = Some(light.light.revisions().radiance);
        let known = self.lights.iter().find(|kept| (kept.light, kept.radiance_revision) == (light.id, shows));
        let culling = work.shadow_maps.shadows().culling;
        let reaches = known.map_or_else(
            || reachable_pixels(&light.light, work.context.scene, work.context.raster, culling).is_some(),
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

    fn keep(&mut self, gpu: &Gpu, bytes: u64, light: &LightInstance, shadow_map: MapScale, layer: Layer) {
        let shows = Some(light.light.revisions().radiance);
        let own = self.lights.iter().position(|kept| kept.light == light.id);
        let room = own.and_then(|own| self.lights.swap_remove(own).layer);
        self.lights.retain(|kept| kept.layer.as_ref().is_none_or(Evictable::is_present));
        if let Some(room) = &room {
            room.put(layer.clone());
        }
        let layer =
            room.filter(Evictable::is_present).unwrap_or_else(|| gpu.memory.keep(MemoryKind::Layers, bytes, layer));
        let layer = Some(layer);
        self.lights.push(KeptLayer { light: light.id, radiance_revision: shows, shadow_map, layer });
    }

    /// Takes the cached layer of a light out of the cache, even if it is invalid.
    fn take(&self, light: &LightInstance) -> Option<Layer> {
        self.lights.iter().find(|kept| kept.light == light.id)?.layer.as_ref()?.take()
    }

    /// Updates the layers of `lights`, and adds them up until only a few terms remain, whose sum is the picture without
    /// its fill. `None` if no light contributes. Pending if the picture pauses; the next call continues with the layers
    /// drawn so far.
    pub fn draw<P: LayerPainter<Layer = Layer, Sum = Sum>>(
        &mut self,
        work: &mut LayerWork,
        painter: &mut P,
        lights: &[LightInstance],
    ) -> Result<Poll<Option<P::Terms>>, RenderError> {
        // The other lights still count; `light::SceneBounds` reports this one to callers that ask.
        let is_there = |light: &&LightInstance| {
            !light.light.light_profile().is_dark() && work.context.scene.posed.bounds().check(&light.light).is_ok()
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
            let Poll::Ready(terms) = self.terms_of_lights(work, painter, &lights)? else {
                return Ok(Poll::Pending);
            };
            return Ok(Poll::Ready((!terms.is_empty()).then(|| painter.terms_of_layers(&terms))));
        }
        let mut of: Vec<Vec<&LightInstance>> = lights.chunks(GROUP).map(<[_]>::to_vec).collect();
        let mut sums = Vec::new();
        for (index, group) in of.iter().enumerate() {
            let sum = if let Some(sum) = self.cached_sum(0, index, group, work.shadow_map) {
                sum
            } else {
                let Poll::Ready(terms) = self.terms_of_lights(work, painter, group)? else {
                    return Ok(Poll::Pending);
                };
                let terms = painter.terms_of_layers(&terms);
                self.draw_sum(work, painter, 0, index, group, &terms)?
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
                    let terms = painter.terms_of_sums(sums);
                    self.draw_sum(work, painter, level, index, &of[index], &terms)?
                };
                next.push(sum);
            }
            sums = next;
        }
        Ok(Poll::Ready(Some(painter.terms_of_sums(&sums))))
    }

    /// Returns the layers of some lights with their factors, and draws the layers that are not cached. Pending if
    /// drawing the picture pauses.
    fn terms_of_lights<P: LayerPainter<Layer = Layer, Sum = Sum>>(
        &mut self,
        work: &mut LayerWork,
        painter: &mut P,
        lights: &[&LightInstance],
    ) -> Result<Poll<Vec<GpuTerm<Layer>>>, RenderError> {
        let mut terms = Vec::with_capacity(lights.len());
        for light in lights {
            let held = self.cached_layer(light, work.shadow_map);
            let layer = if held.is_some() {
                held
            } else {
                match self.draw_layer(work, painter, light)? {
                    Poll::Ready(layer) if !work.pauses(painter, DrawnPiece::Pixels)? => layer,
                    _ => return Ok(Poll::Pending),
                }
            };
            let Some(layer) = layer else { continue };
            let [diffuse, specular] = factors(&light.light);
            terms.push(GpuTerm { layer, diffuse, specular });
        }
        Ok(Poll::Ready(terms))
    }

    /// Draws a light's layer. `None` if the light reaches no visible surface. Pending if the picture pauses after the
    /// light's map.
    fn draw_layer<P: LayerPainter<Layer = Layer, Sum = Sum>>(
        &mut self,
        work: &mut LayerWork,
        painter: &mut P,
        light: &LightInstance,
    ) -> Result<Poll<Option<Layer>>, RenderError> {
        let ready = painter.ready_light(work.shadow_maps, light, work.shadow_map)?;
        let Some(ready) = ready else { return Ok(Poll::Ready(None)) };
        if let Some(cause) = ready.shadow_map_cause {
            work.pass_runs.note(Pass::ShadowMap, Some(light.id), cause);
            // A map without room in the budget would be drawn again after a pause.
            if ready.transient_map.is_none() && work.pauses(painter, DrawnPiece::ShadowMap)? {
                return Ok(Poll::Pending);
            }
        }
        let LayerWork { context: DrawContext { gpu, .. }, size, pass_runs, .. } = work;
        pass_runs.note(Pass::Layer, Some(light.id), self.cause(light));
        let bytes = pixel_count(*size) * P::LAYER_BYTES_PER_PIXEL;
        let over = self.take(light);
        if over.is_none() {
            gpu.make_room(bytes);
        }
        let pixels = Tile { x: 0, y: 0, width: size[0], height: size[1] }.clip(ready.pixels);
        let layer = painter.draw_layer(&ready, pixels, over)?;
        gpu.stages.count(|counters| counters.scissor_pixels += area(pixels));
        self.keep(gpu, bytes, light, ready.shadow_map, layer.clone());
        Ok(Poll::Ready(Some(layer)))
    }

    fn cached_sum(&self, level: usize, index: usize, lights: &[&LightInstance], shadow_map: MapScale) -> Option<Sum> {
        let kept = self.sums.get(level)?.get(index)?;
        if kept.light_revisions != revisions(lights) || kept.shadow_map > shadow_map {
            return None;
        }
        kept.sum.take().inspect(|sum| kept.sum.put(sum.clone()))
    }

    fn draw_sum<P: LayerPainter<Layer = Layer, Sum = Sum>>(
        &mut self,
        work: &mut LayerWork,
        painter: &mut P,
        level: usize,
        index: usize,
        lights: &[&LightInstance],
        terms: &P::Terms,
    ) -> Result<Sum, RenderError> {
        let LayerWork { context: DrawContext { gpu, .. }, size, shadow_map, pass_runs, .. } = work;
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
        let sum = painter.draw_sum(terms, own)?;
        if is_kept {
            sums[level][index].sum.put(sum.clone());
            (sums[level][index].light_revisions, sums[level][index].shadow_map) = (revisions(lights), *shadow_map);
            return Ok(sum);
        }
        let bytes = pixel_count(*size) * P::SUM_BYTES_PER_PIXEL;
        let kept = gpu.memory.keep(MemoryKind::Layers, bytes, sum.clone());
        let kept = KeptSum { light_revisions: revisions(lights), shadow_map: *shadow_map, sum: kept };
        match sums[level].get_mut(index) {
            Some(before) => *before = kept,
            None => sums[level].push(kept),
        }
        Ok(sum)
    }
}

/// Returns the linear RGB factors of a layer of `light`, for its diffuse and its specular part.
pub(crate) fn factors(light: &CheckedLight) -> [[f32; 3]; 2] {
    light.light_profile().lobe_weights().map(|weight| weight.min(DVec3::splat(LARGE)).as_vec3().to_array())
}

fn revisions(lights: &[&LightInstance]) -> Vec<(LightId, LightDigest)> {
    lights.iter().map(|light| (light.id, light.light.revisions().picture)).collect()
}
