//! What is kept of each light from picture to picture: above all its shadow map.

use light::{Light, LightKind};
use scene::ViewSlot;
use wgpu::{BindGroup, CommandEncoder, TextureView};

use crate::bendy_light::{self, Baked, BendyPass, BendySlot, BentWork};
use crate::camera::Raster;
use crate::ledger::{Entry, Kept, MemoryKind};
use crate::passes::Passes;
use crate::shadow_settings::MapSize;
use crate::spot::{self, BakedSpot, SpotSlot};
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowSettings};

/// The shadow maps of one scene's lights, whoever needs them.
#[derive(Debug)]
pub(crate) struct ShadowMaps {
    maps: Vec<KeptMap>,
    users: Vec<User>,
    pub bent_work: BentWork,
    shadows: ShadowSettings,
}

#[derive(Debug)]
struct KeptMap {
    slot: Kept<LightSlot>,
    /// Whether one of the users has a light whose map this is.
    needed: bool,
}

/// Who draws, and the lights of the picture that is or was drawn last.
#[derive(Debug)]
struct User {
    slot: ViewSlot,
    revision: u64,
    lights: Vec<Light>,
}

#[derive(Debug)]
enum LightSlot {
    Spot(SpotSlot),
    Bendy(BendySlot),
}

/// Which lighting pass draws a light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightingKind {
    Spot(BakedSpot),
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
    /// Whether its shadow map had to be drawn.
    pub shadow_drawn: bool,
    /// There is no room to keep its map, which lives as long as this.
    pub passing: Option<Entry>,
}

impl LightSlot {
    /// Whether a map of `light`, which has that size, can be drawn here.
    fn fits(&self, light: &Light, size: MapSize) -> bool {
        match (self, &light.kind) {
            (Self::Spot(slot), LightKind::Spot(_)) => slot.size() == size,
            (Self::Bendy(slot), LightKind::Bendy(_)) => slot.size() == size,
            _ => false,
        }
    }

    /// Whether its map is that of `light` over the scene of that revision.
    fn shows(&self, light: &Light, revision: u64) -> bool {
        match (self, &light.kind) {
            (Self::Spot(slot), LightKind::Spot(spot)) => slot.shows(spot, revision),
            (Self::Bendy(slot), LightKind::Bendy(bendy)) => slot.shows(bendy, revision),
            _ => false,
        }
    }

    fn invalidate(&mut self) {
        match self {
            Self::Spot(slot) => slot.invalidate(),
            Self::Bendy(slot) => slot.invalidate(),
        }
    }
}

impl KeptMap {
    fn shows(&self, light: &Light, revision: u64) -> bool {
        self.slot.peek(|slot| slot.shows(light, revision)).unwrap_or(false)
    }
}

impl ShadowMaps {
    pub fn new() -> Self {
        Self {
            maps: Vec::new(),
            users: Vec::new(),
            bent_work: BentWork::new(),
            shadows: ShadowSettings::default(),
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
    }

    /// `slot` draws `lights` over the scene of that revision from now on. Maps that nobody needs any more are the
    /// first to be made those of other lights.
    pub fn begin(&mut self, slot: ViewSlot, lights: &[Light], revision: u64) {
        self.maps.retain(|map| map.slot.is_there());
        let known = self.users.iter().position(|user| user.slot == slot);
        match known.map(|index| &mut self.users[index]) {
            Some(user) if user.revision == revision && user.lights == lights => return,
            Some(user) => (user.revision, user.lights) = (revision, lights.to_vec()),
            None => self.users.push(User { slot, revision, lights: lights.to_vec() }),
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
        let its_own = |map: &KeptMap| gone.lights.iter().any(|light| map.shows(light, gone.revision));
        self.maps.retain(|map| map.needed || !its_own(map));
    }

    fn see_who_needs_what(&mut self) {
        for map in &mut self.maps {
            let shows = |user: &User| user.lights.iter().any(|light| map.shows(light, user.revision));
            map.needed = self.users.iter().any(shows);
            map.slot.set_needed(map.needed);
        }
    }

    /// Brings the shadows of `light` up to date. Refuses one that is out of the scene's reach, before anything is
    /// changed.
    pub fn ready(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene, raster): (&Passes, &StagedScene, &Raster),
        light: &Light,
    ) -> Result<ReadyLight, RenderError> {
        let known = self.maps.iter().position(|map| map.shows(light, scene.revision));
        if known.is_none() {
            scene.reach().check(light)?;
        }
        let size = self.size_of(light);
        let free = || {
            let fits = |map: &KeptMap| map.slot.peek(|slot| slot.fits(light, size)).unwrap_or(false);
            self.maps.iter().position(|map| !map.needed && fits(map))
        };
        let index = known.or_else(free);
        let mut slot = match index.and_then(|index| self.maps[index].slot.take()) {
            Some(slot) => slot,
            None => Self::new_slot(gpu, passes, light, size),
        };
        let shadows = &self.shadows;
        let (kind, group, corners_in_world, shadow_drawn) = match (&mut slot, &light.kind) {
            (LightSlot::Spot(slot), LightKind::Spot(spot)) => {
                let (placed, group, drawn) =
                    passes.spot.prepare(gpu, encoder, slot, spot, (scene, shadows))?;
                (
                    LightingKind::Spot(BakedSpot::of(spot, shadows.filter)),
                    group,
                    placed.corners_in_world.to_vec(),
                    drawn,
                )
            }
            (LightSlot::Bendy(slot), LightKind::Bendy(bendy)) => {
                let work = (&mut self.bent_work, shadows);
                let (placed, drawn) = passes.bendy.prepare(gpu, work, slot, bendy, scene)?;
                (LightingKind::Bendy(placed.baked), placed.group, placed.corners_in_world, drawn)
            }
            _ => unreachable!("the slot was chosen or made for this kind of light"),
        };
        let passing = self.keep(gpu, index, slot, size);
        let pixels = raster.bounds_of(&corners_in_world);
        Ok(ReadyLight { kind, group, pixels, shadow_drawn, passing })
    }

    fn size_of(&self, light: &Light) -> MapSize {
        match &light.kind {
            LightKind::Spot(spot) => spot::map_size(spot, &self.shadows),
            LightKind::Bendy(bendy) => bendy_light::map_size(bendy, &self.shadows),
        }
    }

    fn new_slot(gpu: &Gpu, passes: &Passes, light: &Light, size: MapSize) -> LightSlot {
        match light.kind {
            LightKind::Spot(_) => LightSlot::Spot(passes.spot.slot(gpu, size)),
            LightKind::Bendy(_) => LightSlot::Bendy(BendyPass::slot(gpu, size)),
        }
    }

    /// Puts a map back, or keeps a new one where there is room. Where there is none, the line that counts it until
    /// it is dropped.
    fn keep(&mut self, gpu: &Gpu, index: Option<usize>, slot: LightSlot, size: MapSize) -> Option<Entry> {
        if let Some(map) = index.and_then(|index| self.maps.get_mut(index)) {
            map.needed = true;
            map.slot.set_needed(true);
            map.slot.put(slot);
            return None;
        }
        let bytes = size.bytes();
        if !gpu.make_room(bytes) {
            return Some(gpu.ledger.enter(MemoryKind::ShadowMaps, bytes));
        }
        let slot = gpu.ledger.keep(MemoryKind::ShadowMaps, bytes, slot);
        self.maps.push(KeptMap { slot, needed: true });
        None
    }

    /// Draws the triangles of `light`'s shadow map into a picture of `size` pixels. A spotlight is one that was bent
    /// into one segment.
    pub fn draw_wireframe(
        &mut self,
        gpu: &Gpu,
        (passes, scene): (&Passes, &StagedScene),
        light: &Light,
        picture: (&TextureView, [u32; 2]),
    ) -> Result<(), RenderError> {
        scene.reach().check(light)?;
        let work = (&mut self.bent_work, &self.shadows);
        match &light.kind {
            LightKind::Bendy(bendy) => passes.bendy.draw_wireframe(gpu, work, bendy, scene, picture),
            LightKind::Spot(spot) => {
                passes.bendy.draw_wireframe(gpu, work, &light::bend(spot, 1)?, scene, picture)
            }
        }
    }
}
