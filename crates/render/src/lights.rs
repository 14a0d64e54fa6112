//! Shadow maps and other data of lights, cached between pictures.

use std::collections::BTreeMap;
use std::sync::Arc;

use light::{CheckedLight, LightId, LightInstance, LightRays};
use scene::{MapScale, ViewSlot};
use shadow::{CoarseClusters, Culling, MapFit, MapSize, PlacedLight, ShadowSettings};
use wgpu::TextureView;

use crate::backend::Backend;
use crate::bendy_light::{self, BentMapBuffers, NativeOnto};
use crate::camera::CameraRaster;
use crate::coarse_casters::CoarseCasters;
use crate::gpu_scene::GpuScene;
use crate::linked::{KnownLinks, LinkedCasters, caster_set};
use crate::map_key::MapKey;
use crate::map_painter::{MapBuilders, MapPainter, MapStorage, NativeMapBuilders};
use crate::map_source::MapSource;
use crate::memory::{Evictable, MemoryKind, Reservation};
use crate::pass_runs::Cause;
use crate::passes::DrawContext;
use crate::{Gpu, RenderError};

/// Shadow maps of the lights in a scene, which all views share.
#[derive(Debug)]
pub(crate) struct ShadowMaps {
    maps: Vec<KeptMap>,
    users: Vec<MapUser>,
    pub bent_buffers: BentMapBuffers,
    native: NativeMapBuilders,
    known_links: KnownLinks,
    pub coarse: CoarseCasters,
    shadows: ShadowSettings,
    /// Key and size of the map that each backend drew last for each light, to find the cause of the next draw.
    drawn: BTreeMap<(LightId, Backend), (MapKey, MapSize)>,
}

#[derive(Debug)]
struct KeptMap {
    slot: Evictable<MapSlot>,
    /// True if the map may not be reused for another light: a picture in progress needs it, or it is the map of its
    /// light in the latest picture.
    needed: bool,
    /// Triangles selected by the light's links, if it has any.
    linked: Option<Arc<LinkedCasters>>,
}

/// View, with the keys of the maps that its latest picture used.
#[derive(Debug)]
struct MapUser {
    slot: ViewSlot,
    maps: Vec<MapKey>,
    is_finished: bool,
}

/// Cached map of a light.
#[derive(Debug)]
pub(crate) struct MapSlot {
    size: MapSize,
    /// True for a map of bent lights. Bending a light and straightening it again then finds both of its maps.
    is_bent: bool,
    storage: MapStorage,
    /// Key of the map, and its fit. `None` before the first one is drawn.
    shown: Option<(MapKey, MapFit)>,
}

/// Light whose shadow map is valid, as lighting passes of the backend use it.
#[derive(Debug)]
pub(crate) struct ReadyLight<Light> {
    pub light: Light,
    /// Rectangle of pixels that the light may reach: `[x, y, width, height]`.
    pub pixels: [u32; 4],
    /// Triangles that the light's links select; `None` if it has no links.
    pub linked: Option<Arc<LinkedCasters>>,
    pub shadow_map: MapScale,
    /// Cause for which the light's shadow map was drawn; `None` if a cached map was valid.
    pub shadow_map_cause: Option<Cause>,
    /// Counts the memory of the map if the budget has no room to cache it. The map is freed together with this.
    pub transient_map: Option<Reservation>,
}

/// Picture of a wireframe, by backend.
pub(crate) enum WireframeOnto<'a> {
    Wgpu(&'a TextureView),
    Native { size: [u32; 2], picture: &'a mut [[f32; 4]] },
}

impl MapSlot {
    /// True if `backend` can draw a map of that size here for a light with those rays.
    fn fits(&self, backend: Backend, rays: &LightRays, size: MapSize) -> bool {
        let of = match self.storage {
            MapStorage::Wgpu(_) => Backend::Wgpu,
            MapStorage::Native(_) => Backend::Native,
        };
        (of, self.size, self.is_bent) == (backend, size, matches!(rays, LightRays::Bent(_)))
    }

    fn map_key(&self) -> Option<MapKey> {
        self.shown.as_ref().map(|(key, _)| *key)
    }
}

impl KeptMap {
    fn map_key(&self) -> Option<MapKey> {
        self.slot.peek(MapSlot::map_key).flatten()
    }
}

impl ShadowMaps {
    pub fn new() -> Self {
        Self {
            maps: Vec::new(),
            users: Vec::new(),
            bent_buffers: BentMapBuffers::new(),
            native: NativeMapBuilders::default(),
            known_links: KnownLinks::default(),
            coarse: CoarseCasters::default(),
            shadows: ShadowSettings::default(),
            drawn: BTreeMap::new(),
        }
    }

    pub fn shadows(&self) -> &ShadowSettings {
        &self.shadows
    }

    /// Sets the shadow settings. If they differ, drops all maps and returns true.
    pub fn set_shadows(&mut self, shadows: ShadowSettings) -> bool {
        let other = self.shadows != shadows;
        if other {
            self.shadows = shadows;
            self.clear();
        }
        other
    }

    /// Marks every map as invalid, and keeps its storage.
    pub fn invalidate(&mut self) {
        for map in &mut self.maps {
            if let Some(mut slot) = map.slot.take() {
                slot.shown = None;
                map.slot.put(slot);
            }
        }
        self.users.clear();
        self.update_needed_maps();
    }

    /// Corrupts maps of the native backend for tests, as [`crate::Renderer::corrupt_native_maps`] states.
    #[cfg(test)]
    pub fn corrupt_native_maps(&mut self, mut fault: impl FnMut(&mut relight::DepthMap, &shadow::MapShape)) {
        for kept in &self.maps {
            let Some(mut slot) = kept.slot.take() else { continue };
            if let MapStorage::Native(map) = &mut slot.storage
                && let Some(shape) = slot.shown.as_ref().and_then(|(_, fit)| fit.bent_shape())
            {
                fault(Arc::get_mut(map).expect("no picture is under way"), shape);
            }
            kept.slot.put(slot);
        }
    }

    pub fn clear(&mut self) {
        self.maps.clear();
        self.users.clear();
        self.bent_buffers.clear_deferred();
    }

    /// Begins a picture of `slot` with `lights`, over the scene of that revision. Maps that no picture needs are the
    /// first to be reused for other lights. That includes lights as other views' finished pictures show them, or a drag
    /// would leave a map for each view that watches it.
    pub fn begin(&mut self, slot: ViewSlot, lights: &[LightInstance], revision: u64) {
        self.maps.retain(|map| map.slot.is_present());
        self.coarse.forget_before(revision);
        let maps: Vec<_> = lights.iter().map(|light| MapKey::of(light, revision)).collect();
        let known = self.users.iter().position(|user| user.slot == slot);
        if let Some(index) = known {
            let user = &self.users[index];
            if user.maps == maps && !user.is_finished {
                return;
            }
            self.users.remove(index);
        }
        self.users.push(MapUser { slot, maps, is_finished: false });
        self.update_needed_maps();
    }

    /// Ends the picture of `slot`. It no longer needs a map of a light that another view has drawn in a later state.
    pub fn finish(&mut self, slot: ViewSlot) {
        if let Some(user) = self.users.iter_mut().find(|user| user.slot == slot) {
            user.is_finished = true;
            self.update_needed_maps();
        }
    }

    /// Releases the lights of `slot`. Their maps stay while there is room.
    pub fn release_view(&mut self, slot: ViewSlot) {
        self.users.retain(|user| user.slot != slot);
        self.update_needed_maps();
    }

    /// Releases the lights of `slot`, and drops the maps that no other view needs.
    pub fn drop_view(&mut self, slot: ViewSlot) {
        let Some(index) = self.users.iter().position(|user| user.slot == slot) else { return };
        let gone = self.users.remove(index);
        self.update_needed_maps();
        let its_own = |map: &KeptMap| map.map_key().is_some_and(|key| gone.maps.contains(&key));
        self.maps.retain(|map| map.needed || !its_own(map));
    }

    fn update_needed_maps(&mut self) {
        let Self { users, drawn, .. } = self;
        drawn.retain(|(light, _), _| users.iter().any(|user| user.maps.iter().any(|key| key.light() == *light)));
        for map in &mut self.maps {
            map.needed = map.map_key().is_some_and(|key| is_needed(users, key));
            map.slot.set_needed(map.needed);
        }
    }

    /// Updates the shadows of `light`, in a map of at least the given scale; a cached full map serves for half. Returns
    /// `None`, and draws nothing, if the light reaches no pixel of the picture. Returns an error, before any change, if
    /// the light is out of the scene's reach.
    pub fn ready_light<P: MapPainter>(
        &mut self,
        painter: &mut P,
        &DrawContext { gpu, passes, scene, raster, .. }: &DrawContext,
        instance: &LightInstance,
        scale: MapScale,
    ) -> Result<Option<ReadyLight<P::Light>>, RenderError> {
        let light = &*instance.light;
        let key = MapKey::of(instance, scene.revision);
        // A light whose shadows are off has a map of size 1, apart from the one before.
        let known_of = |size: MapSize| {
            let shows = |slot: &MapSlot| slot.map_key() == Some(key) && slot.fits(P::BACKEND, light.rays(), size);
            self.maps.iter().position(|map| map.slot.peek(shows).unwrap_or(false))
        };
        let (mut shadow_map, mut shadows) = (MapScale::Full, self.shadows);
        let mut known = known_of(shadow::map_size(light, &shadows));
        if known.is_none() && scale != MapScale::Full {
            (shadow_map, shadows) = (scale, self.shadows.scaled(scale));
            known = known_of(shadow::map_size(light, &shadows));
        }
        let size = shadow::map_size(light, &shadows);
        if known.is_none() {
            scene.posed.bounds().check(light)?;
        }
        let Some(pixels) = reachable_pixels(light, scene, raster, self.shadows.culling) else {
            return Ok(None);
        };
        let free = || {
            let fits = |slot: &MapSlot| slot.fits(P::BACKEND, light.rays(), size);
            self.maps.iter().position(|map| !map.needed && map.slot.peek(fits).unwrap_or(false))
        };
        let index = known.or_else(free);
        let is_bent = matches!(light.rays(), LightRays::Bent(_));
        let mut slot = match index.and_then(|index| self.maps[index].slot.take()) {
            Some(slot) => slot,
            None => MapSlot { size, is_bent, storage: painter.storage(size), shown: None },
        };
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        let is_shadowed = light.light_profile().shadow_enable;
        let kept = slot.shown.take().filter(|(kept, _)| *kept == key);
        let drawn = kept.is_none() && is_shadowed;
        let mut casting = scene.all_casters();
        let fit = if let Some((_, fit)) = kept {
            fit
        } else {
            let (mut coarse, is_coarse) = (None, shadow_map != MapScale::Full && is_bent);
            if is_shadowed {
                casting = caster_set(gpu, scene, linked.as_deref(), shadows.mesh_error)?;
                // Casters that are reduced by links or already simplified are used unchanged.
                if is_coarse && linked.is_none() && shadows.mesh_error == 0.0 {
                    coarse = self.coarse.get(gpu, scene)?;
                }
            }
            let coarse_clusters = coarse
                .map(|coarse| CoarseClusters { clusters: &coarse.casters.clusters, mesh_error: coarse.mesh_error });
            let clusters = &casting.casters.clusters;
            let (fit, is_coarse) = shadow::fit_map(light, &scene.posed, clusters, coarse_clusters, &shadows);
            if let Some(coarse) = coarse.filter(|_| is_coarse) {
                casting.casters = &coarse.casters;
            }
            fit
        };
        let placed = PlacedLight::new(light, &scene.posed, &fit, &shadows);
        if drawn {
            let source = MapSource { scene, linked: linked.as_deref(), casting, shadows: &shadows };
            let builders = MapBuilders { bent_buffers: &mut self.bent_buffers, native: &mut self.native };
            painter.draw(&mut slot.storage, &placed, &source, builders)?;
        }
        let light = painter.light(&slot.storage, placed);
        slot.shown = Some((key, fit));
        let last = (instance.id, P::BACKEND);
        let shadow_map_cause = drawn.then(|| match self.drawn.insert(last, (key, size)) {
            None => Cause::First,
            Some((before, size_before)) if before == key && size_before != size => Cause::Resolution,
            Some((before, _)) => key.cause_after(&before),
        });
        let transient_map = self.keep(gpu, index, slot, linked.clone(), size);
        Ok(Some(ReadyLight { light, pixels, linked, shadow_map, shadow_map_cause, transient_map }))
    }

    /// Puts a map back into the cache, or adds a new one if there is room. Otherwise returns the reservation that
    /// counts its memory.
    fn keep(
        &mut self,
        gpu: &Gpu,
        index: Option<usize>,
        slot: MapSlot,
        linked: Option<Arc<LinkedCasters>>,
        size: MapSize,
    ) -> Option<Reservation> {
        if let Some(map) = index.and_then(|index| self.maps.get_mut(index)) {
            (map.needed, map.linked) = (true, linked);
            map.slot.set_needed(true);
            map.slot.put(slot);
            return None;
        }
        let bytes = size.bytes();
        if !gpu.make_room(bytes) {
            return Some(gpu.memory.reserve(MemoryKind::ShadowMaps, bytes));
        }
        let slot = gpu.memory.keep(MemoryKind::ShadowMaps, bytes, slot);
        self.maps.push(KeptMap { slot, needed: true, linked });
        None
    }

    /// Draws the triangles of `light`'s shadow map into a picture. A spotlight is first bent into one segment.
    pub fn draw_wireframe(
        &mut self,
        &DrawContext { gpu, passes, scene, .. }: &DrawContext,
        light: &CheckedLight,
        onto: WireframeOnto,
    ) -> Result<(), RenderError> {
        scene.posed.bounds().check(light)?;
        let bent = match light.rays() {
            LightRays::Cone(_) => &CheckedLight::new(light::bend(light.light(), 1)?)?,
            _ => light,
        };
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, bent.light());
        let casting = caster_set(gpu, scene, linked.as_deref(), self.shadows.mesh_error)?;
        let clusters = &casting.casters.clusters;
        let placed =
            shadow::wireframe_of(bent, &scene.posed, clusters, &self.shadows).ok_or(RenderError::NoWireframe)?;
        let Some(shape) = &placed.shape else { return Err(RenderError::NoWireframe) };
        let source = MapSource { scene, linked: linked.as_deref(), casting, shadows: &self.shadows };
        match onto {
            WireframeOnto::Wgpu(picture) => {
                passes.bendy.draw_wireframe(gpu, &mut self.bent_buffers, &placed, shape, &source, picture)
            }
            WireframeOnto::Native { size, picture } => {
                let onto = NativeOnto::Wireframe { size, picture };
                bendy_light::draw_map(gpu, &mut self.native.bent, &placed, shape, &source, onto)
            }
        }
    }
}

/// True if a picture under way needs the map, or if it is the map of its light in the latest picture. `users` are in
/// the order of their latest pictures.
fn is_needed(users: &[MapUser], map: MapKey) -> bool {
    let mut of_light = users.iter().rev().flat_map(|user| user.maps.iter().filter(|key| key.light() == map.light()));
    of_light.next() == Some(&map) || users.iter().any(|user| !user.is_finished && user.maps.contains(&map))
}

/// Returns the pixels that `light` may reach, `[x, y, width, height]`; `None` if it reaches none.
pub(crate) fn reachable_pixels(
    light: &CheckedLight,
    scene: &GpuScene,
    raster: &CameraRaster,
    culling: Culling,
) -> Option<[u32; 4]> {
    if !culling.pixels {
        return Some(raster.all_pixels());
    }
    let hull_in_world = shadow::lit_hull_in_world(light, &scene.posed);
    Some(raster.bounds_of(&hull_in_world)).filter(|[_, _, width, height]| *width > 0 && *height > 0)
}
