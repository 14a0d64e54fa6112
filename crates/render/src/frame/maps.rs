//! Shadow maps and other data of lights, cached between pictures.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use light::{CheckedLight, LightId, LightInstance, LightRays};
use scene::{MapScale, ViewSlot};
use shadow::{CoarseClusters, Culling, MapFit, MapSize, PlacedLight, ShadowSettings};

use super::backend::{FrameBackend, ReadyLight};
use super::camera::CameraRaster;
use super::coarse_casters::CoarseCasters;
use super::linked::{KnownLinks, LinkedCasters, caster_set};
use super::map_key::MapKey;
use super::map_source::MapSource;
use super::memory::{Evictable, MemoryKind, Reservation};
use super::pass_runs::Cause;
use super::shared_scene::{FrameScene, SceneView};
use crate::RenderError;

/// Shadow maps of the lights in a scene, which all views share.
#[derive(Debug)]
pub(crate) struct ShadowMaps<B: FrameBackend> {
    maps: Vec<KeptMap<B>>,
    users: Vec<MapUser>,
    known_links: KnownLinks<B>,
    pub coarse: CoarseCasters<B>,
    shadows: ShadowSettings,
    /// Key and size of the map that was drawn last for each light, to find the cause of the next draw.
    drawn: BTreeMap<LightId, (MapKey, MapSize)>,
}

#[derive(Debug)]
struct KeptMap<B: FrameBackend> {
    slot: Evictable<MapSlot<B>>,
    /// True if the map may not be reused for another light: a picture in progress needs it, or it is the map of its
    /// light in the latest picture.
    needed: bool,
    /// Triangles selected by the light's links, if it has any.
    linked: Option<Arc<LinkedCasters<B>>>,
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
pub(crate) struct MapSlot<B: FrameBackend> {
    size: MapSize,
    /// True for a map of bent lights. Bending a light and straightening it again then finds both of its maps.
    is_bent: bool,
    storage: B::Map,
    /// Key of the map, and its fit. `None` before the first one is drawn.
    shown: Option<(MapKey, MapFit)>,
}

impl<B: FrameBackend> MapSlot<B> {
    /// True if a map of that size for a light with those rays can be drawn here.
    fn fits(&self, rays: &LightRays, size: MapSize) -> bool {
        (self.size, self.is_bent) == (size, matches!(rays, LightRays::Bent(_)))
    }

    fn map_key(&self) -> Option<MapKey> {
        self.shown.as_ref().map(|(key, _)| *key)
    }
}

impl<B: FrameBackend> KeptMap<B> {
    fn map_key(&self) -> Option<MapKey> {
        self.slot.peek(MapSlot::map_key).flatten()
    }
}

impl<B: FrameBackend> ShadowMaps<B> {
    pub fn new() -> Self {
        Self {
            maps: Vec::new(),
            users: Vec::new(),
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

    /// Calls `work` with each cached map of a BendyLight, and its fit.
    #[cfg(test)]
    pub fn each_bent_map(&mut self, mut work: impl FnMut(&mut B::Map, &shadow::MapShape)) {
        for kept in &self.maps {
            let Some(mut slot) = kept.slot.take() else { continue };
            if let Some(shape) = slot.shown.as_ref().and_then(|(_, fit)| fit.bent_shape()) {
                work(&mut slot.storage, shape);
            }
            kept.slot.put(slot);
        }
    }

    pub fn clear(&mut self) {
        self.maps.clear();
        self.users.clear();
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
        let its_own = |map: &KeptMap<B>| map.map_key().is_some_and(|key| gone.maps.contains(&key));
        self.maps.retain(|map| map.needed || !its_own(map));
    }

    fn update_needed_maps(&mut self) {
        let Self { users, drawn, .. } = self;
        drawn.retain(|light, _| users.iter().any(|user| user.maps.iter().any(|key| key.light() == *light)));
        for map in &mut self.maps {
            map.needed = map.map_key().is_some_and(|key| is_needed(users, key));
            map.slot.set_needed(map.needed);
        }
    }

    /// Updates the shadows of `light`, in a map of at least the given scale; a cached full map serves for half. Returns
    /// `None`, and draws nothing, if the light reaches no pixel of the picture. Returns an error, before any change, if
    /// the light is out of the scene's reach.
    pub fn ready_light(
        &mut self,
        backend: &mut B,
        &SceneView { scene, raster, .. }: &SceneView<B>,
        instance: &LightInstance,
        scale: MapScale,
    ) -> Result<Option<ReadyLight<B>>, RenderError> {
        let light = &*instance.light;
        let key = MapKey::of(instance, scene.revision);
        // A light whose shadows are off has a map of size 1, apart from the one before.
        let known_of = |size: MapSize| {
            let shows = |slot: &MapSlot<B>| slot.map_key() == Some(key) && slot.fits(light.rays(), size);
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
            let fits = |slot: &MapSlot<B>| slot.fits(light.rays(), size);
            self.maps.iter().position(|map| !map.needed && map.slot.peek(fits).unwrap_or(false))
        };
        let index = known.or_else(free);
        let is_bent = matches!(light.rays(), LightRays::Bent(_));
        let mut slot = match index.and_then(|index| self.maps[index].slot.take()) {
            Some(slot) => slot,
            None => MapSlot { size, is_bent, storage: backend.new_map(size), shown: None },
        };
        let linked = self.known_links.get(backend, scene, light.light());
        let is_shadowed = light.light_profile().shadow_enable;
        let kept = slot.shown.take().filter(|(kept, _)| *kept == key);
        let drawn = kept.is_none() && is_shadowed;
        let mut casting = scene.all_casters();
        let fit = if let Some((_, fit)) = kept {
            fit
        } else {
            let (mut coarse, is_coarse) = (None, shadow_map != MapScale::Full && is_bent);
            if is_shadowed {
                casting = caster_set::<B>(backend.device(), scene, linked.as_deref(), shadows.mesh_error)?;
                // Casters that are reduced by links or already simplified are used unchanged.
                if is_coarse && linked.is_none() && shadows.mesh_error == 0.0 {
                    coarse = self.coarse.get(backend.device(), scene)?;
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
            backend.draw_map(&mut slot.storage, &placed, &source)?;
        }
        let ready = backend.light(&slot.storage, placed);
        slot.shown = Some((key, fit));
        let shadow_map_cause = drawn.then(|| match self.drawn.insert(instance.id, (key, size)) {
            None => Cause::First,
            Some((before, size_before)) if before == key && size_before != size => Cause::Resolution,
            Some((before, _)) => key.cause_after(&before),
        });
        let transient_map = self.keep(backend, index, slot, linked.clone(), size);
        let factors = factors(light);
        Ok(Some(ReadyLight { light: ready, factors, pixels, linked, shadow_map, shadow_map_cause, transient_map }))
    }

    /// Puts a map back into the cache, or adds a new one if there is room. Otherwise returns the reservation that
    /// counts its memory.
    fn keep(
        &mut self,
        backend: &B,
        index: Option<usize>,
        slot: MapSlot<B>,
        linked: Option<Arc<LinkedCasters<B>>>,
        size: MapSize,
    ) -> Option<Reservation> {
        if let Some(map) = index.and_then(|index| self.maps.get_mut(index)) {
            (map.needed, map.linked) = (true, linked);
            map.slot.set_needed(true);
            map.slot.put(slot);
            return None;
        }
        let bytes = size.bytes();
        if !backend.make_room(bytes) {
            return Some(backend.host().memory.reserve(MemoryKind::ShadowMaps, bytes));
        }
        let slot = backend.host().memory.keep(MemoryKind::ShadowMaps, bytes, slot);
        self.maps.push(KeptMap { slot, needed: true, linked });
        None
    }

    /// Draws the triangles of `light`'s shadow map as radiance. A spotlight is first bent into one segment.
    pub fn draw_wireframe(
        &mut self,
        backend: &mut B,
        targets: &mut B::Targets,
        scene: &FrameScene<B>,
        light: &CheckedLight,
    ) -> Result<(), RenderError> {
        scene.posed.bounds().check(light)?;
        let bent = match light.rays() {
            LightRays::Cone(_) => &CheckedLight::new(light::bend(light.light(), 1)?)?,
            _ => light,
        };
        let linked = self.known_links.get(backend, scene, bent.light());
        let casting = caster_set::<B>(backend.device(), scene, linked.as_deref(), self.shadows.mesh_error)?;
        let clusters = &casting.casters.clusters;
        let placed =
            shadow::wireframe_of(bent, &scene.posed, clusters, &self.shadows).ok_or(RenderError::NoWireframe)?;
        let Some(shape) = &placed.shape else { return Err(RenderError::NoWireframe) };
        let source = MapSource { scene, linked: linked.as_deref(), casting, shadows: &self.shadows };
        backend.draw_wireframe(targets, &placed, shape, &source)
    }
}

/// True if a picture under way needs the map, or if it is the map of its light in the latest picture. `users` are in
/// the order of their latest pictures.
fn is_needed(users: &[MapUser], map: MapKey) -> bool {
    let mut of_light = users.iter().rev().flat_map(|user| user.maps.iter().filter(|key| key.light() == map.light()));
    of_light.next() == Some(&map) || users.iter().any(|user| !user.is_finished && user.maps.contains(&map))
}

/// Returns the pixels that `light` may reach, `[x, y, width, height]`; `None` if it reaches none.
pub(crate) fn reachable_pixels<B: FrameBackend>(
    light: &CheckedLight,
    scene: &FrameScene<B>,
    raster: &CameraRaster,
    culling: Culling,
) -> Option<[u32; 4]> {
    if !culling.pixels {
        return Some(raster.all_pixels());
    }
    let hull_in_world = shadow::lit_hull_in_world(light, &scene.posed);
    Some(raster.bounds_of(&hull_in_world)).filter(|[_, _, width, height]| *width > 0 && *height > 0)
}

/// Limit of a light's factors, with which sums stay finite in f32.
const MAX_FACTOR: f64 = 1e30;

/// Returns the linear RGB factors of a layer of `light`, for its diffuse and its specular part.
pub(crate) fn factors(light: &CheckedLight) -> [[f32; 3]; 2] {
    light.light_profile().lobe_weights().map(|weight| weight.min(DVec3::splat(MAX_FACTOR)).as_vec3().to_array())
}
