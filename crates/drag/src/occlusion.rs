//! What stands in a light's way.

use glam::{DVec2, DVec3};
use light::parameters::SHADOW_ENABLE;
use light::{CheckedLight, Rays};
use raycast::{Bvh, Linked, Seen};

use crate::pins::Cut;
use crate::place::{Place, Placed};

/// Distance from a surface within which nothing shadows it, as a share of the light's size or of the way to the source.
const CONTACT: f64 = 1e-9;

/// How far from a surface the source stays, in the scene's sizes.
const FROM_SURFACE: f64 = 1e-3;

/// A scene as one light sees it.
pub(crate) struct Occlusion<'a> {
    bvh: &'a Bvh,
    linked: Linked,
    /// Whether anything shadows it.
    shadow_enable: bool,
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
    pub fn new(bvh: &'a Bvh, light: &CheckedLight) -> Self {
        let shadow_enable = light.light().get(SHADOW_ENABLE);
        Self { bvh, linked: Linked::new(&bvh.posed, light), shadow_enable }
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
        let rounding = 64.0 * f64::EPSILON * surface.position.abs().max_element();
        let own = Contact { within: CONTACT * size + rounding, triangle: Some(surface.triangle) };
        self.first_on(placed, place, place.across, surface.position, own)
    }

    /// The first that light meets on its way to where a surface's shadow is looked for.
    pub fn first_at_terminator(&self, placed: &Placed, surface: &Seen) -> Option<Caster> {
        let at = Seen { position: surface.shadow_position(), ..*surface };
        self.first(placed, &placed.locate(at.position, None)?, &at)
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
            let triangle = &self.bvh.triangles[triangle];
            self.linked.stops_at(triangle.node)
                && is_caster(triangle.node)
                && self.bvh.is_solid(triangle, weights)
        };
        if let Rays::Bent(tube) = placed.rays {
            let path = self.bvh.path(tube, across.x, across.y);
            let hit = self.bvh.first_bent_hit(&path, place.t, |hit| {
                hit.position.distance(point) > contact.within && stops(hit.triangle, hit.weights)
            })?;
            let node = self.bvh.triangles[hit.triangle].node;
            return Some(Caster { position: hit.position, t: hit.t, node });
        }
        let (from, to) = placed.straight_way(place, across, point, 2.0 * self.bvh.posed.half_extent.length());
        let (way, length) = (to - from, to.distance(from));
        let hit = self.bvh.first_hit(from, way, [0.0, 1.0 - contact.within / length], |hit| {
            Some(hit.triangle) != contact.triangle && stops(hit.triangle, hit.weights)
        })?;
        let node = self.bvh.triangles[hit.triangle].node;
        Some(Caster { position: from + way * hit.distance, t: place.t - length * (1.0 - hit.distance), node })
    }

    /// The first surface on a way, whichever light it stops, as what the source may not go through. The source stays off it by
    /// a thousandth of the scene's size, or by half of how near it was.
    pub fn surface_between(&self, from: DVec3, way: DVec3) -> Option<Cut> {
        let size = self.bvh.posed.half_extent.length();
        // As much farther as the source has to stay off.
        let reach = 1.0 + FROM_SURFACE * size / way.length().max(f64::MIN_POSITIVE);
        let hit = self.bvh.first_hit(from, way, [0.0, reach], |hit| {
            self.bvh.is_solid(&self.bvh.triangles[hit.triangle], hit.weights)
        })?;
        let normal = self.bvh.triangles[hit.triangle].normal().normalize();
        let normal = if normal.dot(way) < 0.0 { normal } else { -normal };
        let at = from + way * hit.distance;
        let off = (FROM_SURFACE * size).min(0.5 * (from - at).dot(normal));
        let is_off = (from + way - at).dot(normal) >= 0.99 * off;
        (!is_off).then_some(Cut::Surface { at, normal, off, size })
    }
}
