//! What is kept of each light from picture to picture: above all its shadow map.

use std::ops::Range;

use scene::{Light, LightKind};
use wgpu::{BindGroup, CommandEncoder, TextureView};

use crate::bendy_light::{Baked, BendyPass, BendySlot, BentWork};
use crate::camera::Raster;
use crate::passes::Passes;
use crate::spot::SpotSlot;
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowFilter, ShadowSettings};

/// The lights of one scene.
#[derive(Debug)]
pub(crate) struct LightSlots {
    /// One a light, in the order of the last picture's lights; `None` where that light was not needed yet.
    slots: Vec<Option<LightSlot>>,
    pub bent_work: BentWork,
    shadows: ShadowSettings,
}

#[derive(Debug)]
enum LightSlot {
    Spot(SpotSlot),
    Bendy(BendySlot),
}

/// Which lighting pass draws a light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LightingKind {
    Spot(ShadowFilter),
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
}

impl LightSlot {
    fn of_kind(&self, light: &Light) -> bool {
        matches!(
            (self, &light.kind),
            (Self::Spot(_), LightKind::Spot(_)) | (Self::Bendy(_), LightKind::Bendy(_))
        )
    }

    /// Whether its map is that of `light` over the scene of that revision.
    fn shows(&self, light: &Light, revision: u64) -> bool {
        match (self, &light.kind) {
            (Self::Spot(slot), LightKind::Spot(spot)) => slot.shows(spot, revision),
            (Self::Bendy(slot), LightKind::Bendy(bendy)) => slot.shows(bendy, revision),
            _ => false,
        }
    }
}

impl LightSlots {
    pub fn new() -> Self {
        Self { slots: Vec::new(), bent_work: BentWork::new(), shadows: ShadowSettings::default() }
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
        for slot in self.slots.iter_mut().flatten() {
            match slot {
                LightSlot::Spot(slot) => slot.invalidate(),
                LightSlot::Bendy(slot) => slot.invalidate(),
            }
        }
    }

    /// Drops every map.
    pub fn clear(&mut self) {
        self.slots.clear();
    }

    /// Brings the shadows of `lights[wanted]` up to date.
    pub fn ready(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (passes, scene, raster): (&Passes, &StagedScene, &Raster),
        lights: &[Light],
        wanted: Range<usize>,
    ) -> Result<Vec<ReadyLight>, RenderError> {
        self.arrange(lights, scene.revision);
        let shadows = &self.shadows;
        let mut ready = Vec::with_capacity(wanted.len());
        for (slot, light) in self.slots.iter_mut().zip(lights).take(wanted.end).skip(wanted.start) {
            let (kind, group, corners_in_world, shadow_drawn) = match &light.kind {
                LightKind::Spot(spot) => {
                    let made = slot.get_or_insert_with(|| LightSlot::Spot(passes.spot.slot(gpu, shadows)));
                    let LightSlot::Spot(slot) = made else { continue };
                    let (placed, drawn) = passes.spot.prepare(gpu, encoder, slot, spot, (scene, shadows))?;
                    (
                        LightingKind::Spot(shadows.filter),
                        slot.group.clone(),
                        placed.corners_in_world.to_vec(),
                        drawn,
                    )
                }
                LightKind::Bendy(bendy) => {
                    let made = slot.get_or_insert_with(|| LightSlot::Bendy(BendyPass::slot(gpu, shadows)));
                    let LightSlot::Bendy(slot) = made else { continue };
                    let (placed, drawn) =
                        passes.bendy.prepare(gpu, (&mut self.bent_work, shadows), slot, bendy, scene)?;
                    (LightingKind::Bendy(placed.baked), placed.group, placed.corners_in_world, drawn)
                }
            };
            ready.push(ReadyLight { kind, group, pixels: raster.bounds_of(&corners_in_world), shadow_drawn });
        }
        Ok(ready)
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
        let work = (&mut self.bent_work, &self.shadows);
        match &light.kind {
            LightKind::Bendy(bendy) => passes.bendy.draw_wireframe(gpu, work, bendy, scene, picture),
            LightKind::Spot(spot) => {
                passes.bendy.draw_wireframe(gpu, work, &bendy::bend(spot, 1)?, scene, picture)
            }
        }
    }

    /// Gives each light the slot whose map is its own, wherever it stood before, or else a free one of its
    /// kind: a light that comes or goes leaves the maps of the others as they are.
    fn arrange(&mut self, lights: &[Light], revision: u64) {
        let mut free: Vec<LightSlot> = self.slots.drain(..).flatten().collect();
        let mut take = |fits: &dyn Fn(&LightSlot) -> bool| {
            let index = free.iter().position(fits)?;
            Some(free.remove(index))
        };
        let mut slots: Vec<_> =
            lights.iter().map(|light| take(&|slot| slot.shows(light, revision))).collect();
        for (slot, light) in slots.iter_mut().zip(lights).filter(|(slot, _)| slot.is_none()) {
            *slot = take(&|free| free.of_kind(light));
        }
        self.slots = slots;
    }
}
