//! What each light alone adds to a view, kept from picture to picture, and sums of that.
//!
//! A layer is what a light reflects before factors of all of it ([`light::LightFilter::weights`]). An edit of those, a light that
//! is switched off and on, and the exposure of a view draw no layer; a light that moves draws its own.
//!
//! Layers add up in one order, whatever is kept and whatever was edited: four by four where they are more than eight, and those
//! sums four by four again while they are.

use glam::DVec3;
use light::{Digest, LightId, LightInstance};
use scene::MapScale;
use wgpu::{BindGroup, CommandEncoder, TextureFormat, TextureView, TextureViewDescriptor};

use crate::camera::Raster;
use crate::composite::{Term, Terms};
use crate::gpu_scene::GpuScene;
use crate::gpu_structs::{LARGE, TERMS};
use crate::lights::{ShadowMaps, pixels_of};
use crate::memory::{Evictable, MemoryKind};
use crate::pass_runs::{Cause, Pass, PassRuns};
use crate::passes::Passes;
use crate::pipeline::color_attachment;
use crate::stages::Stage;
use crate::tile::Tile;
use crate::{Gpu, RenderError, composite, lighting};

/// How many layers, or sums, are added up at once where all are too many. One of 64 lights that moves is added to three others,
/// then their sum to three, and theirs to three.
const GROUP: usize = 4;

const LAYER_BYTES_A_PIXEL: u64 = 16;
const SUM_BYTES_A_PIXEL: u64 = 8;

/// The layers of a view whose G-buffer stays the same.
#[derive(Debug, Default)]
pub(crate) struct Layers {
    lights: Vec<KeptLayer>,
    /// Of groups of lights, then of groups of those, level by level.
    sums: Vec<Vec<KeptSum>>,
}

#[derive(Debug)]
struct KeptLayer {
    light: LightId,
    /// The light's revision of what it shows; `None` of nothing.
    shows: Option<Digest>,
    /// How fine the map was that it was drawn with.
    shadow_map: MapScale,
    /// `None` where the light reaches nothing that is seen.
    layer: Option<Evictable<TextureView>>,
}

#[derive(Debug)]
struct KeptSum {
    /// The lights that it is of, each with its revision of all that a picture depends on.
    of: Vec<(LightId, Digest)>,
    /// How fine maps had to be when it was drawn.
    shadow_map: MapScale,
    sum: Evictable<TextureView>,
}

/// What layers are drawn with.
pub(crate) struct Work<'a> {
    pub gpu: &'a Gpu,
    pub passes: &'a Passes,
    pub scene: &'a GpuScene,
    pub raster: &'a Raster,
    /// How fine maps have to be.
    pub shadow_map: MapScale,
    pub shadow_maps: &'a mut ShadowMaps,
    pub ran: &'a mut PassRuns,
}

/// What layers are drawn of: what pixels see, as lighting passes bind it, and their number.
#[derive(Clone, Copy)]
pub(crate) struct Seen<'a> {
    pub surface: &'a BindGroup,
    pub size: [u32; 2],
}

/// Whether layers of so many lights and their sums take at most half of the budget of bytes.
pub(crate) fn fit(budget: u64, size: [u32; 2], light_count: usize) -> bool {
    let lights = light_count as u64;
    let bytes_a_pixel = lights * LAYER_BYTES_A_PIXEL + 2 * lights.div_ceil(GROUP as u64) * SUM_BYTES_A_PIXEL;
    bytes(size, bytes_a_pixel) <= budget / 2
}

impl Layers {
    /// Makes each anew when it is next asked for.
    pub fn invalidate(&mut self) {
        self.lights.iter_mut().for_each(|layer| layer.shows = None);
        self.sums.iter_mut().flatten().for_each(|sum| sum.of.clear());
    }

    /// Where the content of `light` is held, drawn with a map that is fine enough.
    fn held(&self, light: &LightInstance, shadow_map: MapScale) -> Option<TextureView> {
        let shows = Some(light.light.revisions().radiance);
        let kept = self.lights.iter().find(|kept| (kept.light, kept.shows) == (light.id, shows))?;
        let layer = kept.layer.as_ref().filter(|_| kept.shadow_map <= shadow_map)?;
        layer.take().inspect(|texture| layer.put(texture.clone()))
    }

    /// Whether `light` reaches a pixel; where it reaches none, that is kept as its layer.
    fn reaches_something_seen(&mut self, work: &Work, light: &LightInstance) -> bool {
        let shows = Some(light.light.revisions().radiance);
        let known = self.lights.iter().find(|kept| (kept.light, kept.shows) == (light.id, shows));
        let culling = work.shadow_maps.shadows().culling;
        let reaches = known.map_or_else(
            || pixels_of(&light.light, (work.scene, work.raster), culling).is_some(),
            |kept| kept.layer.is_some(),
        );
        if !reaches && known.is_none() {
            self.lights.retain(|kept| kept.light != light.id);
            self.lights.push(KeptLayer { light: light.id, shows, shadow_map: MapScale::Full, layer: None });
        }
        reaches
    }

    /// Why the layer of `light` has to be drawn.
    fn cause(&self, light: &LightInstance) -> Cause {
        match self.lights.iter().find(|kept| kept.light == light.id) {
            None => Cause::First,
            Some(KeptLayer { shows: None, .. }) => Cause::Gbuffer,
            Some(kept) if kept.shows != Some(light.light.revisions().radiance) => Cause::Light,
            Some(kept) if kept.layer.as_ref().is_some_and(Evictable::is_there) => Cause::Resolution,
            Some(_) => Cause::Evicted,
        }
    }

    /// Keeps what shows `light` now.
    fn keep(
        &mut self,
        gpu: &Gpu,
        size: [u32; 2],
        (light, shadow_map): (&LightInstance, MapScale),
        layer: TextureView,
    ) {
        let shows = Some(light.light.revisions().radiance);
        let own = self.lights.iter().position(|kept| kept.light == light.id);
        let room = own.and_then(|own| self.lights.swap_remove(own).layer);
        self.lights.retain(|kept| kept.layer.as_ref().is_none_or(Evictable::is_there));
        if let Some(room) = &room {
            room.put(layer.clone());
        }
        let layer = room
            .filter(Evictable::is_there)
            .unwrap_or_else(|| gpu.memory.keep(MemoryKind::Layers, layer_bytes(size), layer));
        let layer = Some(layer);
        self.lights.push(KeptLayer { light: light.id, shows, shadow_map, layer });
    }

    /// A texture for the layer of a light: its own, or a new one.
    fn texture_for(&self, gpu: &Gpu, size: [u32; 2], light: &LightInstance) -> TextureView {
        let own = self.lights.iter().find(|kept| kept.light == light.id);
        own.and_then(|kept| kept.layer.as_ref()?.take()).unwrap_or_else(|| {
            gpu.make_room(layer_bytes(size));
            texture(gpu, size, lighting::LAYER_FORMAT)
        })
    }

    /// Brings the layers of `lights` up to date, and adds them up to few terms: what a picture is besides its fill. `None` where no
    /// light adds anything.
    pub fn draw(
        &mut self,
        encoder: &mut CommandEncoder,
        (work, seen): (&mut Work, Seen),
        lights: &[LightInstance],
    ) -> Result<Option<Terms>, RenderError> {
        // Others shine all the same; `light::Reach` tells who asks.
        let is_there = |light: &&LightInstance| {
            !light.light.light_filter().is_dark() && work.scene.posed.reach().check(&light.light).is_ok()
        };
        let lights: Vec<&LightInstance> =
            lights.iter().filter(is_there).filter(|light| self.reaches_something_seen(work, light)).collect();
        for kept in &self.lights {
            let needed = lights.iter().any(|light| light.id == kept.light);
            if let Some(layer) = &kept.layer {
                layer.set_needed(needed);
            }
        }
        if lights.len() <= TERMS {
            let terms = self.terms_of_lights(encoder, (work, seen), &lights)?;
            return Ok((!terms.is_empty()).then(|| work.passes.composite.layers(work.gpu, &terms)));
        }
        let mut of: Vec<Vec<&LightInstance>> = lights.chunks(GROUP).map(<[_]>::to_vec).collect();
        let mut sums = Vec::new();
        for (index, group) in of.iter().enumerate() {
            let sum = if let Some(sum) = self.held_sum(0, index, group, work.shadow_map) {
                sum
            } else {
                let terms = self.terms_of_lights(encoder, (work, seen), group)?;
                let terms = work.passes.composite.layers(work.gpu, &terms);
                self.draw_sum(encoder, (work, seen), (0, index, group), &terms)?
            };
            sums.push(sum);
        }
        let mut level = 0;
        while sums.len() > TERMS {
            level += 1;
            of = of.chunks(GROUP).map(<[_]>::concat).collect();
            let mut next = Vec::new();
            for (index, sums) in sums.chunks(GROUP).enumerate() {
                let sum = if let Some(sum) = self.held_sum(level, index, &of[index], work.shadow_map) {
                    sum
                } else {
                    let terms = work.passes.composite.sums(work.gpu, sums);
                    self.draw_sum(encoder, (work, seen), (level, index, &of[index]), &terms)?
                };
                next.push(sum);
            }
            sums = next;
        }
        Ok(Some(work.passes.composite.sums(work.gpu, &sums)))
    }

    /// The layers of some lights with their weights, drawn where they are not held.
    fn terms_of_lights(
        &mut self,
        encoder: &mut CommandEncoder,
        (work, seen): (&mut Work, Seen),
        lights: &[&LightInstance],
    ) -> Result<Vec<Term>, RenderError> {
        let mut terms = Vec::with_capacity(lights.len());
        for light in lights {
            let held = self.held(light, work.shadow_map);
            let layer = if held.is_some() { held } else { self.draw_layer(encoder, (work, seen), light)? };
            let Some(texture) = layer else { continue };
            let weights = light.light.light_filter().weights();
            let [diffuse, specular] =
                weights.map(|weight: DVec3| weight.min(DVec3::splat(LARGE)).as_vec3().to_array());
            terms.push(Term { texture, diffuse, specular });
        }
        Ok(terms)
    }

    /// `None` where the light reaches nothing that is seen.
    fn draw_layer(
        &mut self,
        encoder: &mut CommandEncoder,
        (work, seen): (&mut Work, Seen),
        light: &LightInstance,
    ) -> Result<Option<TextureView>, RenderError> {
        let Work { gpu, passes, scene, raster, shadow_map, shadow_maps, ran } = work;
        let ready = shadow_maps.ready(gpu, encoder, (passes, scene, raster), (light, *shadow_map))?;
        let Some(ready) = ready else { return Ok(None) };
        if let Some(cause) = ready.shadow_drawn {
            ran.note(Pass::ShadowMap, Some(light.id), cause);
        }
        ran.note(Pass::Layer, Some(light.id), self.cause(light));
        let layer = self.texture_for(gpu, seen.size, light);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("layer"),
            color_attachments: &[Some(color_attachment(&layer, true))],
            ..Default::default()
        });
        pass.set_bind_group(0, &scene.view, &[]);
        pass.set_bind_group(1, seen.surface, &[]);
        let tile = Tile { x: 0, y: 0, width: seen.size[0], height: seen.size[1] };
        let pixels = tile.cut(ready.pixels);
        ready.lighting(gpu, passes).draw_layer(gpu, &mut pass, &ready.groups(), pixels);
        drop(pass);
        gpu.end_stage(encoder, Stage::Light)?;
        gpu.stages.count(|counters| counters.scissor_pixels += u64::from(pixels[2]) * u64::from(pixels[3]));
        // A map that passes is to be gone before the next one comes.
        if ready.passing.is_some() {
            gpu.finish(encoder)?;
        }
        self.keep(gpu, seen.size, (light, ready.shadow_map), layer.clone());
        Ok(Some(layer))
    }

    fn held_sum(
        &self,
        level: usize,
        index: usize,
        lights: &[&LightInstance],
        shadow_map: MapScale,
    ) -> Option<TextureView> {
        let kept = self.sums.get(level)?.get(index)?;
        if kept.of != revisions(lights) || kept.shadow_map > shadow_map {
            return None;
        }
        kept.sum.take().inspect(|sum| kept.sum.put(sum.clone()))
    }

    fn draw_sum(
        &mut self,
        encoder: &mut CommandEncoder,
        (work, seen): (&mut Work, Seen),
        (level, index, lights): (usize, usize, &[&LightInstance]),
        terms: &Terms,
    ) -> Result<TextureView, RenderError> {
        let Work { gpu, passes, shadow_map, ran, .. } = work;
        let cause = match self.sums.get(level).and_then(|sums| sums.get(index)) {
            None => Cause::First,
            Some(kept) if kept.of.is_empty() => Cause::Gbuffer,
            Some(kept) if kept.of != revisions(lights) => Cause::Light,
            Some(kept) if kept.sum.is_there() => Cause::Resolution,
            Some(_) => Cause::Evicted,
        };
        ran.note(Pass::Sum, None, cause);
        let sums = &mut self.sums;
        sums.resize_with(sums.len().max(level + 1), Vec::new);
        let own = sums[level].get(index).and_then(|kept| kept.sum.take());
        let is_kept = own.is_some();
        let sum = own.unwrap_or_else(|| texture(gpu, seen.size, composite::SUM_FORMAT));
        passes.composite.draw_sum(encoder, terms, &sum);
        gpu.end_stage(encoder, Stage::Sum)?;
        if is_kept {
            sums[level][index].sum.put(sum.clone());
            (sums[level][index].of, sums[level][index].shadow_map) = (revisions(lights), *shadow_map);
            return Ok(sum);
        }
        let bytes = bytes(seen.size, SUM_BYTES_A_PIXEL);
        let kept = gpu.memory.keep(MemoryKind::Layers, bytes, sum.clone());
        let kept = KeptSum { of: revisions(lights), shadow_map: *shadow_map, sum: kept };
        match sums[level].get_mut(index) {
            Some(before) => *before = kept,
            None => sums[level].push(kept),
        }
        Ok(sum)
    }
}

fn revisions(lights: &[&LightInstance]) -> Vec<(LightId, Digest)> {
    lights.iter().map(|light| (light.id, light.light.revisions().picture)).collect()
}

fn texture(gpu: &Gpu, [width, height]: [u32; 2], format: TextureFormat) -> TextureView {
    gpu.target("layer", width, height, format).create_view(&TextureViewDescriptor::default())
}

fn layer_bytes(size: [u32; 2]) -> u64 {
    bytes(size, LAYER_BYTES_A_PIXEL)
}

fn bytes([width, height]: [u32; 2], bytes_a_pixel: u64) -> u64 {
    u64::from(width) * u64::from(height) * bytes_a_pixel
}
