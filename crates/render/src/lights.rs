//! What is kept of each light from picture to picture: above all its shadow map.

use std::collections::BTreeMap;
use std::sync::Arc;

use light::{CheckedLight, LightId, LightInstance, LightRays, Tube};
use scene::{MapScale, ViewSlot};
use wgpu::TextureView;

use crate::backend::Backend;
use crate::bendy_light::{self, BendySlot, BentMapBuffers};
use crate::camera::CameraRaster;
use crate::coarse_casters::{CoarseCasters, SimplifiedCasters};
use crate::gpu_scene::GpuScene;
use crate::linked::{KnownLinks, LinkedCasters};
use crate::map_key::MapKey;
use crate::memory::{Evictable, MemoryKind, Reservation};
#[cfg(test)]
use crate::native_slot::MapFit;
use crate::native_slot::{NativeMapBuilders, NativeSlot};
use crate::pass_runs::Cause;
use crate::passes::Passes;
use crate::shadow_settings::{Culling, MapSize};
use crate::straight::{StraightLight, StraightSlot};
use crate::{Gpu, RenderError, ShadowSettings};

/// The shadow maps of one scene's lights, whoever needs them.
#[derive(Debug)]
pub(crate) struct ShadowMaps {
    maps: Vec<KeptMap>,
    users: Vec<MapUser>,
    pub bent_buffers: BentMapBuffers,
    native_builders: NativeMapBuilders,
    known_links: KnownLinks,
    pub coarse: CoarseCasters,
    shadows: ShadowSettings,
    /// Which map of each light was drawn last by each who draws them, and how large.
    drawn: BTreeMap<(LightId, Backend), (MapKey, MapSize)>,
}

/// Who draws lights' maps: the device, or the processor.
pub(crate) trait MapPainter {
    /// What a light and its map are looked up by.
    type Light;
    const BACKEND: Backend;

    /// What a map of `light` of that size can be drawn in; nothing yet.
    fn slot(&self, light: &CheckedLight, size: MapSize) -> LightSlot;

    /// Brings `slot`, which is made for such lights, up to date. Returns the light in place and whether its map was
    /// drawn: of those casters that `linked` leaves, or of coarse ones where there are any and they serve.
    fn prepare(
        &mut self,
        slot: &mut LightSlot,
        light: (MapKey, &CheckedLight),
        what: (Option<&LinkedCasters>, &ShadowSettings),
        work: MapBuilders,
    ) -> Result<(Self::Light, bool), RenderError>;
}

/// What maps of bent lights are drawn with.
pub(crate) struct MapBuilders<'a> {
    pub bent_buffers: &'a mut BentMapBuffers,
    pub native_builders: &'a mut NativeMapBuilders,
    /// Casters of fewer triangles, where the map is a coarse one that may have them.
    pub coarse: Option<&'a SimplifiedCasters>,
}

#[derive(Debug)]
struct KeptMap {
    slot: Evictable<LightSlot>,
    /// Whether a picture under way needs it, or it shows its light as the latest picture of that has it.
    needed: bool,
    /// What of the scene counts for its light, where that has links.
    linked: Option<Arc<LinkedCasters>>,
}

/// Who draws, and the maps of the picture that is or was drawn last.
#[derive(Debug)]
struct MapUser {
    slot: ViewSlot,
    maps: Vec<MapKey>,
    /// Whether that picture is finished.
    is_finished: bool,
}

/// A map, by who draws it of which light.
#[derive(Debug)]
pub(crate) enum LightSlot {
    Straight(Box<StraightSlot>),
    Bendy(Box<BendySlot>),
    Native(Box<NativeSlot>),
}

/// A light whose shadows are up to date, in the form of who draws it.
#[derive(Debug)]
pub(crate) struct ReadyLight<Light> {
    pub light: Light,
    /// What it may reach: `[x, y, width, height]`.
    pub pixels: [u32; 4],
    /// What of the scene counts for it, where it has links.
    pub linked: Option<Arc<LinkedCasters>>,
    /// How fine its shadow map is.
    pub shadow_map: MapScale,
    /// Why its shadow map had to be drawn, where it had.
    pub shadow_map_cause: Option<Cause>,
    /// There is no room to keep its map, which lives as long as this.
    pub transient_map: Option<Reservation>,
}

impl LightSlot {
    /// Whether a map of a light found by `rays`, which has that size, can be drawn here by `backend`.
    fn fits(&self, backend: Backend, rays: &LightRays, size: MapSize) -> bool {
        match (self, backend, rays) {
            (Self::Bendy(slot), Backend::Wgpu, LightRays::Bent(_)) => slot.size() == size,
            (
                Self::Straight(slot),
                Backend::Wgpu,
                LightRays::Cone(_) | LightRays::Omni(_) | LightRays::Parallel(_),
            ) => slot.size() == size,
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

    /// How maps are made.
    pub fn shadows(&self) -> &ShadowSettings {
        &self.shadows
    }

    /// Makes maps by other settings; drops those there are. Returns whether the settings are others.
    pub fn set_shadows(&mut self, shadows: ShadowSettings) -> bool {
        let other = self.shadows != shadows;
        if other {
            self.shadows = shadows;
            self.clear();
        }
        other
    }

    /// Draws every map anew when it is next asked for.
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

    /// See [`crate::Renderer::corrupt_native_maps`].
    #[cfg(test)]
    pub fn corrupt_native_maps(
        &mut self,
        mut fault: impl FnMut(&mut relight::DepthMap, &bendy_light::MapShape),
    ) {
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

    /// Drops every map.
    pub fn clear(&mut self) {
        self.maps.clear();
        self.users.clear();
        self.bent_buffers.clear_deferred();
    }

    /// `slot` draws `lights` over the scene of that revision from now on. Maps that nobody needs any more are the
    /// first to be made those of other lights: so are those of lights as finished pictures of others still show them, or a drag
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

    /// The picture of `slot` is finished: it needs no map any more of a light that another has drawn otherwise since.
    pub fn finish(&mut self, slot: ViewSlot) {
        if let Some(user) = self.users.iter_mut().find(|user| user.slot == slot) {
            user.is_finished = true;
            self.update_needed_maps();
        }
    }

    /// `slot` needs no lights any more; their maps stay while there is room.
    pub fn release_view(&mut self, slot: ViewSlot) {
        self.users.retain(|user| user.slot != slot);
        self.update_needed_maps();
    }

    /// `slot` needs no lights any more, and the maps that only it needed go.
    pub fn drop_view(&mut self, slot: ViewSlot) {
        let Some(index) = self.users.iter().position(|user| user.slot == slot) else { return };
        let gone = self.users.remove(index);
        self.update_needed_maps();
        let its_own = |map: &KeptMap| map.map_key().is_some_and(|key| gone.maps.contains(&key));
        self.maps.retain(|map| map.needed || !its_own(map));
    }

    fn update_needed_maps(&mut self) {
        let Self { users, drawn, .. } = self;
        drawn.retain(|(light, _), _| {
            users.iter().any(|user| user.maps.iter().any(|key| key.light() == *light))
        });
        for map in &mut self.maps {
            map.needed = map.map_key().is_some_and(|key| is_needed(users, key));
            map.slot.set_needed(map.needed);
        }
    }

    /// Brings the shadows of `light` up to date, in a map that is at least as fine as `scale` asks for: one that is there in
    /// full serves for half. `None`, and nothing drawn, where no pixel of the picture can be lit. Refuses a light that is out
    /// of the scene's reach, before anything is changed.
    pub fn ready_light<P: MapPainter>(
        &mut self,
        (gpu, painter): (&Gpu, &mut P),
        (passes, scene, raster): (&Passes, &GpuScene, &CameraRaster),
        (instance, scale): (&LightInstance, MapScale),
    ) -> Result<Option<ReadyLight<P::Light>>, RenderError> {
        let light = &*instance.light;
        let key = MapKey::of(instance, scene.revision);
        // A light whose shadows were switched off has another map of no size, and the one from before.
        let known_of = |size: MapSize| {
            let shows =
                |slot: &LightSlot| slot.map_key() == Some(key) && slot.fits(P::BACKEND, light.rays(), size);
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
        let Some(pixels) = reachable_pixels(light, (scene, raster), self.shadows.culling) else {
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
        let shadows = &shadows;
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        // What a light's links leave, and what strays already, is drawn as it is.
        let is_coarse =
            known.is_none() && shadow_map != MapScale::Full && matches!(light.rays(), LightRays::Bent(_));
        let coarse = if is_coarse && linked.is_none() && shadows.mesh_error == 0.0 {
            self.coarse.get(gpu, scene)?
        } else {
            None
        };
        let Self { bent_buffers: bent_work, native_builders: native_work, .. } = self;
        let work = MapBuilders { bent_buffers: bent_work, native_builders: native_work, coarse };
        let (placed, shadow_drawn) =
            painter.prepare(&mut slot, (key, light), (linked.as_deref(), shadows), work)?;
        let last = (instance.id, P::BACKEND);
        let shadow_drawn = shadow_drawn.then(|| match self.drawn.insert(last, (key, size)) {
            None => Cause::First,
            Some((before, size_before)) if before == key && size_before != size => Cause::Resolution,
            Some((before, _)) => key.cause_after(&before),
        });
        let passing = self.keep(gpu, index, (slot, linked.clone()), size);
        Ok(Some(ReadyLight {
            light: placed,
            pixels,
            linked,
            shadow_map,
            shadow_map_cause: shadow_drawn,
            transient_map: passing,
        }))
    }

    /// Puts a map back, or keeps a new one where there is room. Where there is none, the line that counts it until
    /// it is dropped.
    fn keep(
        &mut self,
        gpu: &Gpu,
        index: Option<usize>,
        (slot, linked): (LightSlot, Option<Arc<LinkedCasters>>),
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

    /// Draws the triangles of `light`'s shadow map into a picture of `size` pixels. A spotlight is one that was bent
    /// into one segment.
    pub fn draw_wireframe(
        &mut self,
        gpu: &Gpu,
        (passes, scene): (&Passes, &GpuScene),
        light: &CheckedLight,
        picture: (&TextureView, [u32; 2]),
    ) -> Result<(), RenderError> {
        scene.posed.bounds().check(light)?;
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        let (work, scene) = (&mut self.bent_buffers, (scene, linked.as_deref(), &self.shadows));
        match light.rays() {
            LightRays::Bent(tube) => {
                passes.bendy.draw_wireframe(gpu, work, (light.light(), tube), scene, picture)
            }
            LightRays::Omni(_) | LightRays::Parallel(_) => Err(RenderError::NoWireframe),
            LightRays::Cone(_) => {
                let bent = light::bend(light.light(), 1)?;
                let tube = Tube::new(&bent)?;
                passes.bendy.draw_wireframe(gpu, work, (&bent, &tube), scene, picture)
            }
        }
    }
}

/// Whether a picture under way needs the map, or it is as the latest picture of its light has it. The latest of `users` to begin is
/// the last.
fn is_needed(users: &[MapUser], map: MapKey) -> bool {
    let mut of_light =
        users.iter().rev().flat_map(|user| user.maps.iter().filter(|key| key.light() == map.light()));
    of_light.next() == Some(&map) || users.iter().any(|user| !user.is_finished && user.maps.contains(&map))
}

/// The pixels that `light` may reach, `[x, y, width, height]`; `None` where it reaches none.
pub(crate) fn reachable_pixels(
    light: &CheckedLight,
    (scene, raster): (&GpuScene, &CameraRaster),
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

/// How large the map of `light` is; least, to have something to bind, where nothing shadows it.
fn map_size_of(light: &CheckedLight, shadows: &ShadowSettings) -> MapSize {
    let size = match StraightLight::of(light) {
        Some(straight) => straight.map_size(shadows),
        None => bendy_light::map_size(light.light(), shadows),
    };
    if light.light_profile().shadow_enable { size } else { MapSize { side: 1, ..size } }
}
