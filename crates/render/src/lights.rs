//! Shadow maps and other data of lights, cached between pictures.

use std::collections::BTreeMap;
use std::sync::Arc;

use light::{CheckedLight, LightId, LightInstance, LightRays, Tube};
use scene::{MapScale, ViewSlot};
use wgpu::TextureView;

use crate::backend::Backend;
use crate::bendy_light::{self, BendySlot, BentMapBuffers};
use crate::camera::CameraRaster;
use crate::coarse_casters::CoarseCasters;
use crate::gpu_scene::GpuScene;
use crate::linked::{CasterSource, KnownLinks, LinkedCasters};
use crate::map_key::MapKey;
use crate::memory::{Evictable, MemoryKind, Reservation};
#[cfg(test)]
use crate::native_slot::MapFit;
use crate::native_slot::{NativeMapBuilders, NativeSlot};
use crate::pass_runs::Cause;
use crate::passes::{DrawContext, Passes};
use crate::shadow_settings::{Culling, MapSize};
use crate::straight::{StraightLight, StraightSlot};
use crate::{Gpu, RenderError, ShadowSettings};

/// Shadow maps of the lights in a scene, which all views share.
#[derive(Debug)]
pub(crate) struct ShadowMaps {
    maps: Vec<KeptMap>,
    users: Vec<MapUser>,
    pub bent_buffers: BentMapBuffers,
    native_builders: NativeMapBuilders,
    known_links: KnownLinks,
    pub coarse: CoarseCasters,
    shadows: ShadowSettings,
    /// Key and size of the map that each backend drew last for each light, to find the cause of the next draw.
    drawn: BTreeMap<(LightId, Backend), (MapKey, MapSize)>,
}

/// Draws shadow maps of lights, on the GPU or the CPU.
pub(crate) trait MapPainter {
    /// Light with its map, as lighting passes of this backend use it.
    type Light;
    const BACKEND: Backend;

    /// Creates memory for a map of `light` of this size. Nothing is drawn yet.
    fn slot(&self, light: &CheckedLight, size: MapSize) -> LightSlot;

    /// Updates `slot`, which was created for such a light. Returns the placed light, and true if its map was drawn:
    /// with the casters of the source, or with its coarse ones if they are accurate enough.
    fn prepare(
        &mut self,
        slot: &mut LightSlot,
        key: MapKey,
        light: &CheckedLight,
        source: CasterSource,
        builders: MapBuilders,
    ) -> Result<(Self::Light, bool), RenderError>;
}

pub(crate) struct MapBuilders<'a> {
    pub bent_buffers: &'a mut BentMapBuffers,
    pub native_builders: &'a mut NativeMapBuilders,
}

#[derive(Debug)]
struct KeptMap {
    slot: Evictable<LightSlot>,
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

/// A map, by backend and shape of light.
#[derive(Debug)]
pub(crate) enum LightSlot {
    Straight(Box<StraightSlot>),
    Bendy(Box<BendySlot>),
    Native(Box<NativeSlot>),
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

impl LightSlot {
    /// True if `backend` can draw a map of that size here, for a light with those `rays`.
    fn fits(&self, backend: Backend, rays: &LightRays, size: MapSize) -> bool {
        match (self, backend, rays) {
            (Self::Bendy(slot), Backend::Wgpu, LightRays::Bent(_)) => slot.size() == size,
            (Self::Straight(slot), Backend::Wgpu, LightRays::Cone(_) | LightRays::Omni(_) | LightRays::Parallel(_)) => {
                slot.size() == size
            }
            (Self::Native(slot), Backend::Native, _) => slot.size() == size,
            _ => false,
        }
    }

    fn map_key(&self) -> Option<MapKey> {
        match self {
            Self::Straight(slot) => slot.map_key(),
            Self::Bendy(slot) => slot.map_key(),
            Self::Native(slot) => slot.map_key(),
        }
    }

    fn invalidate(&mut self) {
        match self {
            Self::Straight(slot) => slot.invalidate(),
            Self::Bendy(slot) => slot.invalidate(),
            Self::Native(slot) => slot.invalidate(),
        }
    }
}

impl KeptMap {
    fn map_key(&self) -> Option<MapKey> {
        self.slot.peek(LightSlot::map_key).flatten()
    }
}

impl ShadowMaps {
    pub fn new() -> Self {
        Self {
            maps: Vec::new(),
            users: Vec::new(),
            bent_buffers: BentMapBuffers::new(),
            native_builders: NativeMapBuilders::default(),
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
                slot.invalidate();
                map.slot.put(slot);
            }
        }
        self.users.clear();
        self.update_needed_maps();
    }

    /// Corrupts maps of the native backend for tests, as [`crate::Renderer::corrupt_native_maps`] states.
    #[cfg(test)]
    pub fn corrupt_native_maps(&mut self, mut fault: impl FnMut(&mut relight::DepthMap, &bendy_light::MapShape)) {
        for kept in &self.maps {
            let Some(mut slot) = kept.slot.take() else { continue };
            if let LightSlot::Native(native) = &mut slot
                && let Some((_, shown)) = &mut native.shown
                && let MapFit::Bent(Some(shape)) = &shown.fitted
            {
                fault(Arc::get_mut(&mut shown.map).expect("no picture is under way"), shape);
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
            let shows = |slot: &LightSlot| slot.map_key() == Some(key) && slot.fits(P::BACKEND, light.rays(), size);
            self.maps.iter().position(|map| map.slot.peek(shows).unwrap_or(false))
        };
        let (mut shadow_map, mut shadows) = (MapScale::Full, self.shadows);
        let mut known = known_of(map_size_of(light, &shadows));
        if known.is_none() && scale != MapScale::Full {
            (shadow_map, shadows) = (scale, self.shadows.scaled(scale));
            known = known_of(map_size_of(light, &shadows));
        }
        let size = map_size_of(light, &shadows);
        if known.is_none() {
            scene.posed.bounds().check(light)?;
        }
        let Some(pixels) = reachable_pixels(light, scene, raster, self.shadows.culling) else {
            return Ok(None);
        };
        let free = || {
            let fits = |slot: &LightSlot| slot.fits(P::BACKEND, light.rays(), size);
            self.maps.iter().position(|map| !map.needed && map.slot.peek(fits).unwrap_or(false))
        };
        let index = known.or_else(free);
        let mut slot = match index.and_then(|index| self.maps[index].slot.take()) {
            Some(slot) => slot,
            None => painter.slot(light, size),
        };
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        // Casters that are reduced by links or already simplified are used unchanged.
        let is_coarse = known.is_none() && shadow_map != MapScale::Full && matches!(light.rays(), LightRays::Bent(_));
        let coarse = if is_coarse && linked.is_none() && shadows.mesh_error == 0.0 {
            self.coarse.get(gpu, scene)?
        } else {
            None
        };
        let source = CasterSource { scene, linked: linked.as_deref(), shadows: &shadows, coarse };
        let Self { bent_buffers, native_builders, .. } = self;
        let builders = MapBuilders { bent_buffers, native_builders };
        let (placed, drawn) = painter.prepare(&mut slot, key, light, source, builders)?;
        let last = (instance.id, P::BACKEND);
        let shadow_map_cause = drawn.then(|| match self.drawn.insert(last, (key, size)) {
            None => Cause::First,
            Some((before, size_before)) if before == key && size_before != size => Cause::Resolution,
            Some((before, _)) => key.cause_after(&before),
        });
        let transient_map = self.keep(gpu, index, slot, linked.clone(), size);
        Ok(Some(ReadyLight { light: placed, pixels, linked, shadow_map, shadow_map_cause, transient_map }))
    }

    /// Puts a map back into the cache, or adds a new one if there is room. Otherwise returns the reservation that
    /// counts its memory.
    fn keep(
        &mut self,
        gpu: &Gpu,
        index: Option<usize>,
        slot: LightSlot,
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
        gpu: &Gpu,
        passes: &Passes,
        scene: &GpuScene,
        light: &CheckedLight,
        picture: &TextureView,
    ) -> Result<(), RenderError> {
        scene.posed.bounds().check(light)?;
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        let source = CasterSource { scene, linked: linked.as_deref(), shadows: &self.shadows, coarse: None };
        let work = &mut self.bent_buffers;
        match light.rays() {
            LightRays::Bent(tube) => passes.bendy.draw_wireframe(gpu, work, light.light(), tube, source, picture),
            LightRays::Omni(_) | LightRays::Parallel(_) => Err(RenderError::NoWireframe),
            LightRays::Cone(_) => {
                let bent = light::bend(light.light(), 1)?;
                let tube = Tube::new(&bent)?;
                passes.bendy.draw_wireframe(gpu, work, &bent, &tube, source, picture)
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
    let corners_in_world = match (StraightLight::of(light), light.rays()) {
        (Some(straight), _) => straight.corners_in_world(&scene.posed),
        (None, LightRays::Bent(tube)) => bendy_light::corners_in_world(tube, &scene.posed),
        (None, _) => unreachable!("what is not straight is bent"),
    };
    Some(raster.bounds_of(&corners_in_world)).filter(|[_, _, width, height]| *width > 0 && *height > 0)
}

/// Returns the size of the map of `light`. A light without shadows has the smallest size, because a binding must not be
/// empty.
fn map_size_of(light: &CheckedLight, shadows: &ShadowSettings) -> MapSize {
    let faces =
        StraightLight::of(light).map_or_else(|| bendy_light::face_count(light.light()), StraightLight::face_count);
    let size = shadows.map_size(faces);
    if light.light_profile().shadow_enable { size } else { MapSize { side: 1, ..size } }
}
