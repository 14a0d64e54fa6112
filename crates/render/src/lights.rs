//! What is kept of each light from picture to picture: above all its shadow map.

use std::collections::BTreeMap;
use std::sync::Arc;

use light::{CheckedLight, LightId, LightInstance, Rays, Tube};
use scene::{MapScale, ViewSlot};
use wgpu::{BindGroup, CommandEncoder, TextureView};

use crate::bendy_light::{self, Baked, BendyPass, BendySlot, BentWork};
use crate::camera::Raster;
use crate::coarse_casters::CoarseCasters;
use crate::gpu_scene::GpuScene;
use crate::lighting::LightingPass;
use crate::linked::{KnownLinks, Linked};
use crate::map_key::MapKey;
use crate::memory::{Evictable, MemoryKind, Reservation};
use crate::pass_runs::Cause;
use crate::passes::Passes;
use crate::shadow_settings::{Culling, MapSize};
use crate::straight::{BakedStraight, Straight, StraightSlot};
use crate::{Gpu, RenderError, ShadowSettings};

/// The shadow maps of one scene's lights, whoever needs them.
#[derive(Debug)]
pub(crate) struct ShadowMaps {
    maps: Vec<KeptMap>,
    users: Vec<User>,
    pub bent_work: BentWork,
    known_links: KnownLinks,
    pub coarse: CoarseCasters,
    shadows: ShadowSettings,
    /// Which map of each light was drawn last, and how large.
    drawn: BTreeMap<LightId, (MapKey, MapSize)>,
}

#[derive(Debug)]
struct KeptMap {
    slot: Evictable<LightSlot>,
    /// Whether one of the users has a light whose map this is.
    needed: bool,
    /// What of the scene counts for its light, where that has links.
    linked: Option<Arc<Linked>>,
}

/// Who draws, and the maps of the picture that is or was drawn last.
#[derive(Debug)]
struct User {
    slot: ViewSlot,
    maps: Vec<MapKey>,
}

#[derive(Debug)]
enum LightSlot {
    Straight(Box<StraightSlot>),
    Bendy(Box<BendySlot>),
}

/// Which lighting pass draws a light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightingKind {
    Straight(BakedStraight),
    Bendy(Baked),
}

/// A light whose shadows are up to date.
#[derive(Debug)]
pub(crate) struct ReadyLight {
    pub kind: LightingKind,
    /// Group 2 of its lighting pass.
    pub group: BindGroup,
    /// What it may reach: `[x, y, width, height]`.
    pub pixels: [u32; 4],
    /// What of the scene counts for it, where it has links.
    pub linked: Option<Arc<Linked>>,
    /// How fine its shadow map is.
    pub shadow_map: MapScale,
    /// Why its shadow map had to be drawn, where it had.
    pub shadow_drawn: Option<Cause>,
    /// There is no room to keep its map, which lives as long as this.
    pub passing: Option<Reservation>,
}

impl ReadyLight {
    /// The pass that draws it.
    pub fn lighting(&self, gpu: &Gpu, passes: &Passes) -> Arc<LightingPass> {
        let is_linked = self.linked.is_some();
        match self.kind {
            LightingKind::Straight(baked) => passes.straight.lighting(gpu, baked, is_linked),
            LightingKind::Bendy(baked) => passes.bendy.lighting(gpu, baked, is_linked),
        }
    }

    /// What its lighting pass binds after view and surface.
    pub fn groups(&self) -> Vec<&BindGroup> {
        [&self.group].into_iter().chain(self.linked.as_ref().map(|linked| &linked.group)).collect()
    }
}

impl LightSlot {
    /// Whether a map of a light found by `rays`, which has that size, can be drawn here.
    fn fits(&self, rays: &Rays, size: MapSize) -> bool {
        match (self, rays) {
            (Self::Bendy(slot), Rays::Bent(_)) => slot.size() == size,
            (Self::Straight(slot), Rays::Cone(_) | Rays::Omni(_) | Rays::Parallel(_)) => slot.size() == size,
            _ => false,
        }
    }

    fn shows(&self) -> Option<MapKey> {
        match self {
            Self::Straight(slot) => slot.shows(),
            Self::Bendy(slot) => slot.shows(),
        }
    }

    fn invalidate(&mut self) {
        match self {
            Self::Straight(slot) => slot.invalidate(),
            Self::Bendy(slot) => slot.invalidate(),
        }
    }
}

impl KeptMap {
    fn shows(&self) -> Option<MapKey> {
        self.slot.peek(LightSlot::shows).flatten()
    }
}

impl ShadowMaps {
    pub fn new() -> Self {
        Self {
            maps: Vec::new(),
            users: Vec::new(),
            bent_work: BentWork::new(),
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
        self.see_who_needs_what();
    }

    /// Drops every map.
    pub fn clear(&mut self) {
        self.maps.clear();
        self.users.clear();
        self.bent_work.forget();
    }

    /// `slot` draws `lights` over the scene of that revision from now on. Maps that nobody needs any more are the
    /// first to be made those of other lights.
    pub fn begin(&mut self, slot: ViewSlot, lights: &[LightInstance], revision: u64) {
        self.maps.retain(|map| map.slot.is_there());
        self.coarse.forget_before(revision);
        let maps: Vec<_> = lights.iter().map(|light| MapKey::of(light, revision)).collect();
        let known = self.users.iter().position(|user| user.slot == slot);
        match known.map(|index| &mut self.users[index]) {
            Some(user) if user.maps == maps => return,
            Some(user) => user.maps = maps,
            None => self.users.push(User { slot, maps }),
        }
        self.see_who_needs_what();
    }

    /// `slot` needs no lights any more; their maps stay while there is room.
    pub fn end(&mut self, slot: ViewSlot) {
        self.users.retain(|user| user.slot != slot);
        self.see_who_needs_what();
    }

    /// `slot` needs no lights any more, and the maps that only it needed go.
    pub fn forget(&mut self, slot: ViewSlot) {
        let Some(index) = self.users.iter().position(|user| user.slot == slot) else { return };
        let gone = self.users.remove(index);
        self.see_who_needs_what();
        let its_own = |map: &KeptMap| map.shows().is_some_and(|key| gone.maps.contains(&key));
        self.maps.retain(|map| map.needed || !its_own(map));
    }

    fn see_who_needs_what(&mut self) {
        let Self { users, drawn, .. } = self;
        drawn.retain(|light, _| users.iter().any(|user| user.maps.iter().any(|key| key.light() == *light)));
        for map in &mut self.maps {
            let key = map.shows();
            map.needed = key.is_some_and(|key| self.users.iter().any(|user| user.maps.contains(&key)));
            map.slot.set_needed(map.needed);
        }
    }

    /// Brings the shadows of `light` up to date, in a map that is at least as fine as `scale` asks for: one that is there in
    /// full serves for half. `None`, and nothing drawn, where no pixel of the picture can be lit. Refuses a light that is out
    /// of the scene's reach, before anything is changed.
    pub fn ready(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene, raster): (&Passes, &GpuScene, &Raster),
        (instance, scale): (&LightInstance, MapScale),
    ) -> Result<Option<ReadyLight>, RenderError> {
        let light = &*instance.light;
        let key = MapKey::of(instance, scene.revision);
        // A light whose shadows were switched off has another map of no size, and the one from before.
        let known_of = |size: MapSize| {
            let shows = |slot: &LightSlot| slot.shows() == Some(key) && slot.fits(light.rays(), size);
            self.maps.iter().position(|map| map.slot.peek(shows).unwrap_or(false))
        };
        let (mut shadow_map, mut shadows) = (MapScale::Full, self.shadows);
        let mut known = known_of(size_of(light, &shadows));
        if known.is_none() && scale != MapScale::Full {
            (shadow_map, shadows) = (scale, self.shadows.scaled(scale));
            known = known_of(size_of(light, &shadows));
        }
        let size = size_of(light, &shadows);
        if known.is_none() {
            scene.posed.reach().check(light)?;
        }
        let Some(pixels) = pixels_of(light, (scene, raster), self.shadows.culling) else { return Ok(None) };
        let free = || {
            let fits = |map: &KeptMap| map.slot.peek(|slot| slot.fits(light.rays(), size)).unwrap_or(false);
            self.maps.iter().position(|map| !map.needed && fits(map))
        };
        let index = known.or_else(free);
        let mut slot = match index.and_then(|index| self.maps[index].slot.take()) {
            Some(slot) => slot,
            None => Self::new_slot(gpu, passes, light, size),
        };
        let shadows = &shadows;
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        let what = (scene, linked.as_deref(), shadows);
        let (kind, group, shadow_drawn) = match (&mut slot, light.rays(), Straight::of(light)) {
            (LightSlot::Bendy(slot), Rays::Bent(tube), _) => {
                let work = &mut self.bent_work;
                // What a light's links leave, and what strays already, is drawn as it is.
                let is_coarse = known.is_none() && shadow_map != MapScale::Full;
                let coarse = if is_coarse && linked.is_none() && shadows.mesh_error == 0.0 {
                    self.coarse.get(gpu, scene)?
                } else {
                    None
                };
                let of = (key, light, tube);
                let (placed, drawn) = passes.bendy.prepare(gpu, work, slot, of, what, coarse)?;
                (LightingKind::Bendy(placed.baked), placed.group, drawn)
            }
            (LightSlot::Straight(slot), _, Some(straight)) => {
                let ready = passes.straight.prepare(gpu, encoder, slot, (key, straight), what)?;
                let kind = LightingKind::Straight(straight.baked(shadows.filter));
                (kind, ready.group, ready.drawn)
            }
            _ => unreachable!("the slot was chosen or made for this kind of light"),
        };
        let shadow_drawn = shadow_drawn.then(|| match self.drawn.insert(instance.id, (key, size)) {
            None => Cause::First,
            Some((before, size_before)) if before == key && size_before != size => Cause::Resolution,
            Some((before, _)) => key.cause_after(&before),
        });
        let passing = self.keep(gpu, index, (slot, linked.clone()), size);
        Ok(Some(ReadyLight { kind, group, pixels, linked, shadow_map, shadow_drawn, passing }))
    }

    fn new_slot(gpu: &Gpu, passes: &Passes, light: &CheckedLight, size: MapSize) -> LightSlot {
        match light.rays() {
            Rays::Cone(_) | Rays::Omni(_) | Rays::Parallel(_) => {
                LightSlot::Straight(Box::new(passes.straight.slot(gpu, size)))
            }
            Rays::Bent(_) => LightSlot::Bendy(Box::new(BendyPass::slot(gpu, size))),
        }
    }

    /// Puts a map back, or keeps a new one where there is room. Where there is none, the line that counts it until
    /// it is dropped.
    fn keep(
        &mut self,
        gpu: &Gpu,
        index: Option<usize>,
        (slot, linked): (LightSlot, Option<Arc<Linked>>),
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
        scene.posed.reach().check(light)?;
        let linked = self.known_links.get(gpu, &passes.group_layouts.links, scene, light.light());
        let (work, scene) = (&mut self.bent_work, (scene, linked.as_deref(), &self.shadows));
        match light.rays() {
            Rays::Bent(tube) => passes.bendy.draw_wireframe(gpu, work, (light.light(), tube), scene, picture),
            Rays::Omni(_) | Rays::Parallel(_) => Err(RenderError::NoWireframe),
            Rays::Cone(_) => {
                let bent = light::bend(light.light(), 1)?;
                let tube = Tube::new(&bent)?;
                passes.bendy.draw_wireframe(gpu, work, (&bent, &tube), scene, picture)
            }
        }
    }
}

/// The pixels that `light` may reach, `[x, y, width, height]`; `None` where it reaches none.
pub(crate) fn pixels_of(
    light: &CheckedLight,
    (scene, raster): (&GpuScene, &Raster),
    culling: Culling,
) -> Option<[u32; 4]> {
    if !culling.pixels {
        return Some(raster.whole());
    }
    let corners_in_world = match (Straight::of(light), light.rays()) {
        (Some(straight), _) => straight.corners_in_world(&scene.posed),
        (None, Rays::Bent(tube)) => bendy_light::corners_in_world(tube, &scene.posed),
        (None, _) => unreachable!("what is not straight is bent"),
    };
    Some(raster.bounds_of(&corners_in_world)).filter(|[_, _, width, height]| *width > 0 && *height > 0)
}

/// How large the map of `light` is; least, to have something to bind, where nothing shadows it.
fn size_of(light: &CheckedLight, shadows: &ShadowSettings) -> MapSize {
    let size = match Straight::of(light) {
        Some(straight) => straight.map_size(shadows),
        None => bendy_light::map_size(light.light(), shadows),
    };
    if light.light_filter().shadow_enable { size } else { MapSize { side: 1, ..size } }
}
