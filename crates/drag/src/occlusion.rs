//! Surfaces that a picture shows, and casters that light meets on its path.

use glam::{DVec2, DVec3};
use light::parameters::SHADOW_ENABLE;
use light::{CheckedLight, LightRays};
use raycast::{Bvh, CONTACT_TOLERANCE, LinkedNodes, SeenPoint, rounding_error};
use scene::ViewRay;

use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::Viewport;
use crate::work::WorkBudget;

/// Cosine below which a surface surely faces away from the light. Pictures use the tangent of the light path, which
/// differs slightly from the direction from which light arrives.
const TURNED_AWAY: f64 = -0.05;

/// Scene with the nodes that one light illuminates, and those that cast shadows in the light.
pub(crate) struct Occlusion<'a> {
    pub bvh: &'a Bvh,
    linked: LinkedNodes,
    shadow_enable: bool,
    /// Budget for the rays.
    pub work: &'a WorkBudget<'a>,
}

/// First caster on a light path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowCaster {
    /// In scene space.
    pub position: DVec3,
    /// Distance along the light path, as [`PointInLight::t`].
    pub t: f64,
    pub node: usize,
}

/// Rule by which a hit counts as the receiving point itself and not as a caster.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Distance from the point, in world units, within which a hit is the point itself.
    pub within: f64,
    /// Triangle that the point lies on. A straight path meets it only once.
    pub triangle: Option<usize>,
}

/// Returns the surface that a pixel shows.
pub(crate) fn seen_at(bvh: &Bvh, view: &Viewport, pixel: DVec2, work: &WorkBudget) -> Option<SeenPoint> {
    let ray = ViewRay::new(&view.camera, view.size, pixel, bvh.posed.origin_in_world);
    bvh.visible_point_budgeted(&ray, |boxes| work.spend_on_rays(boxes))
}

impl<'a> Occlusion<'a> {
    pub fn new(bvh: &'a Bvh, light: &CheckedLight, work: &'a WorkBudget<'a>) -> Self {
        let shadow_enable = light.light().get(SHADOW_ENABLE);
        Self { bvh, linked: LinkedNodes::new(&bvh.posed, light), shadow_enable, work }
    }

    /// True if the light's links let it illuminate the node.
    pub fn is_node_lit(&self, node: usize) -> bool {
        self.linked.is_lit(node)
    }

    /// Finds the first caster that blocks light on the light path to a surface point at `coords`.
    pub fn first_caster(
        &self,
        placed: &SceneLight,
        coords: &PointInLight,
        surface: &SeenPoint,
    ) -> Option<ShadowCaster> {
        let size = match placed.rays {
            LightRays::Bent(tube) => tube.placement.world_per_tube,
            LightRays::Parallel(_) => 2.0 * self.bvh.posed.half_extent.length(),
            _ => surface.position.distance(placed.source()),
        };
        let own = Contact {
            within: CONTACT_TOLERANCE * size + rounding_error(surface.position),
            triangle: Some(surface.triangle),
        };
        self.first_caster_on_path(placed, coords, coords.cross_coords, surface.position, own, |_| true)
    }

    /// Finds the node whose shadow a surface point is in.
    pub fn caster_of(&self, light: &CheckedLight, surface: &SeenPoint) -> Option<usize> {
        let origin = self.bvh.posed.origin_in_world;
        let placed = SceneLight::new(light.rays(), origin, surface.position, self.work);
        let coords = placed.locate(surface.position, None)?;
        self.first_caster(&placed, &coords, surface).map(|caster| caster.node)
    }

    /// True if a surface point at `coords` is dark in pictures: the surface faces away from the light, or its shadow
    /// position is in shadow.
    pub fn is_unlit(&self, placed: &SceneLight, coords: &PointInLight, surface: &SeenPoint) -> bool {
        let faces = surface.normal.dot(coords.to_light);
        let at = SeenPoint { position: surface.shadow_position(), ..*surface };
        let coords = placed.locate(at.position, Some(coords.t));
        faces < TURNED_AWAY || coords.is_some_and(|coords| self.first_caster(placed, &coords, &at).is_some())
    }

    /// Finds the first caster on the light path at `across`, up to the point `point` at `coords`, among the nodes that
    /// `is_caster` accepts. Hits at the point itself do not count.
    pub fn first_caster_on_path(
        &self,
        placed: &SceneLight,
        coords: &PointInLight,
        across: DVec2,
        point: DVec3,
        contact: Contact,
        is_caster: impl Fn(usize) -> bool,
    ) -> Option<ShadowCaster> {
        if !self.shadow_enable {
            return None;
        }
        let stops = |triangle: usize, weights: DVec3| {
            is_caster(self.bvh.triangle(triangle).node) && self.bvh.casts_shadow_at(&self.linked, triangle, weights)
        };
        let spend = |boxes| self.work.spend_on_rays(boxes);
        let (triangle, position, t) = if let LightRays::Bent(tube) = placed.rays {
            let path = self.bvh.bent_path(tube, across.x, across.y);
            let hit = self.bvh.first_bent_hit_budgeted(&path, coords.t, spend, |hit| {
                hit.position.distance(point) > contact.within && stops(hit.triangle, hit.barycentrics)
            })?;
            (hit.triangle, hit.position, hit.t)
        } else {
            let (from, to) = placed.straight_path(coords, across, point, 2.0 * self.bvh.posed.half_extent.length());
            let (ray, length) = (to - from, to.distance(from));
            let hit = self.bvh.first_hit_budgeted(from, ray, [0.0, 1.0 - contact.within / length], spend, |hit| {
                Some(hit.triangle) != contact.triangle && stops(hit.triangle, hit.barycentrics)
            })?;
            (hit.triangle, from + ray * hit.distance, coords.t - length * (1.0 - hit.distance))
        };
        Some(ShadowCaster { position, t, node: self.bvh.triangle(triangle).node })
    }
}
