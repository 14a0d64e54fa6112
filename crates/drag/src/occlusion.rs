//! What stands in a light's way.

use glam::{DVec2, DVec3};
use light::parameters::SHADOW_ENABLE;
use light::{CheckedLight, Rays};
use raycast::{Bvh, CONTACT, Linked, Seen, rounding};

use crate::place::{Place, Placed};
use crate::work::Work;

/// The cosine below which a surface is turned away from light for certain: pictures go by the path's tangent, which is not quite
/// the direction that light arrives from.
const TURNED_AWAY: f64 = -0.05;

/// A scene as one light sees it.
pub(crate) struct Occlusion<'a> {
    pub bvh: &'a Bvh,
    linked: Linked,
    /// Whether anything shadows it.
    shadow_enable: bool,
    /// What following light costs.
    pub work: &'a Work<'a>,
}

/// The first that light meets on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caster {
    /// In scene space.
    pub position: DVec3,
    /// How far along the light's way, as [`Place::t`].
    pub t: f64,
    pub node: usize,
}

/// What counts as the very point that light is to reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// World units.
    pub within: f64,
    /// Its own triangle, which no straight way meets twice.
    pub triangle: Option<usize>,
}

impl<'a> Occlusion<'a> {
    pub fn new(bvh: &'a Bvh, light: &CheckedLight, work: &'a Work<'a>) -> Self {
        let shadow_enable = light.light().get(SHADOW_ENABLE);
        Self { bvh, linked: Linked::new(&bvh.posed, light), shadow_enable, work }
    }

    /// Whether the light shows on a node.
    pub fn lights(&self, node: usize) -> bool {
        self.linked.lights(node)
    }

    /// The first that light meets on its way to a surface that lies at `place`.
    pub fn first(&self, placed: &Placed, place: &Place, surface: &Seen) -> Option<Caster> {
        let size = match placed.rays {
            Rays::Bent(tube) => tube.placement.world_per_tube,
            Rays::Parallel(_) => 2.0 * self.bvh.posed.half_extent.length(),
            _ => surface.position.distance(placed.source()),
        };
        let own =
            Contact { within: CONTACT * size + rounding(surface.position), triangle: Some(surface.triangle) };
        self.first_on(placed, place, place.across, surface.position, own)
    }

    /// Whether a surface that lies at `place` is dark in pictures: turned away from the light, or in shadow where that is
    /// looked for.
    pub fn is_dark(&self, placed: &Placed, place: &Place, surface: &Seen) -> bool {
        let faces = surface.normal.dot(place.to_light);
        let at = Seen { position: surface.shadow_position(), ..*surface };
        let place = placed.locate(at.position, Some(place.t));
        faces < TURNED_AWAY || place.is_some_and(|place| self.first(placed, &place, &at).is_some())
    }

    /// The first that light meets on the way `across`, as far as `point`, which lies at `place`; what the way meets at the
    /// point itself does not count.
    pub fn first_on(
        &self,
        placed: &Placed,
        place: &Place,
        across: DVec2,
        point: DVec3,
        contact: Contact,
    ) -> Option<Caster> {
        self.first_of(placed, place, across, point, contact, |_| true)
    }

    /// The first of the nodes that `is_caster` says.
    pub fn first_of(
        &self,
        placed: &Placed,
        place: &Place,
        across: DVec2,
        point: DVec3,
        contact: Contact,
        is_caster: impl Fn(usize) -> bool,
    ) -> Option<Caster> {
        if !self.shadow_enable {
            return None;
        }
        let stops = |triangle: usize, weights: DVec3| {
            is_caster(self.bvh.triangles[triangle].node) && self.bvh.stops(&self.linked, triangle, weights)
        };
        let spend = |boxes| self.work.spend_on_rays(boxes);
        if let Rays::Bent(tube) = placed.rays {
            let path = self.bvh.path(tube, across.x, across.y);
            let hit = self.bvh.first_bent_hit_counted(&path, place.t, spend, |hit| {
                hit.position.distance(point) > contact.within && stops(hit.triangle, hit.weights)
            })?;
            let node = self.bvh.triangles[hit.triangle].node;
            return Some(Caster { position: hit.position, t: hit.t, node });
        }
        let (from, to) = placed.straight_way(place, across, point, 2.0 * self.bvh.posed.half_extent.length());
        let (way, length) = (to - from, to.distance(from));
        let hit =
            self.bvh.first_hit_counted(from, way, [0.0, 1.0 - contact.within / length], spend, |hit| {
                Some(hit.triangle) != contact.triangle && stops(hit.triangle, hit.weights)
            })?;
        let node = self.bvh.triangles[hit.triangle].node;
        Some(Caster { position: from + way * hit.distance, t: place.t - length * (1.0 - hit.distance), node })
    }
}
