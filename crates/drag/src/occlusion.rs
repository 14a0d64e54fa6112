//! What stands in a light's way.

use glam::{DVec2, DVec3};
use light::parameters::SHADOW_ENABLE;
use light::{CheckedLight, LightRays};
use raycast::{Bvh, CONTACT_TOLERANCE, LinkedNodes, SeenPoint, rounding_error};

use crate::point_in_light::{PointInLight, SceneLight};
use crate::work::WorkBudget;

/// The cosine below which a surface is turned away from light for certain: pictures go by the path's tangent, which is not quite
/// the direction that light arrives from.
const TURNED_AWAY: f64 = -0.05;

/// A scene as one light sees it.
pub(crate) struct Occlusion<'a> {
    pub bvh: &'a Bvh,
    linked: LinkedNodes,
    /// Whether anything shadows it.
    shadow_enable: bool,
    /// What following light costs.
    pub work: &'a WorkBudget<'a>,
}

/// The first that light meets on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowCaster {
    /// In scene space.
    pub position: DVec3,
    /// How far along the light's way, as [`PointInLight::t`].
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
    pub fn new(bvh: &'a Bvh, light: &CheckedLight, work: &'a WorkBudget<'a>) -> Self {
        let shadow_enable = light.light().get(SHADOW_ENABLE);
        Self { bvh, linked: LinkedNodes::new(&bvh.posed, light), shadow_enable, work }
    }

    /// Whether the light shows on a node.
    pub fn is_node_lit(&self, node: usize) -> bool {
        self.linked.is_lit(node)
    }

    /// The first that light meets on its way to a surface that lies at `place`.
    pub fn first_caster(
        &self,
        placed: &SceneLight,
        place: &PointInLight,
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
        self.first_caster_on_path(placed, place, place.cross_coords, surface.position, own)
    }

    /// Whether a surface that lies at `place` is dark in pictures: turned away from the light, or in shadow where that is
    /// looked for.
    pub fn is_unlit(&self, placed: &SceneLight, place: &PointInLight, surface: &SeenPoint) -> bool {
        let faces = surface.normal.dot(place.to_light);
        let at = SeenPoint { position: surface.shadow_position(), ..*surface };
        let place = placed.locate(at.position, Some(place.t));
        faces < TURNED_AWAY || place.is_some_and(|place| self.first_caster(placed, &place, &at).is_some())
    }

    /// The first that light meets on the way `across`, as far as `point`, which lies at `place`; what the way meets at the
    /// point itself does not count.
    pub fn first_caster_on_path(
        &self,
        placed: &SceneLight,
        place: &PointInLight,
        across: DVec2,
        point: DVec3,
        contact: Contact,
    ) -> Option<ShadowCaster> {
        self.first_matching_caster(placed, place, across, point, contact, |_| true)
    }

    /// The first of the nodes that `is_caster` says.
    pub fn first_matching_caster(
        &self,
        placed: &SceneLight,
        place: &PointInLight,
        across: DVec2,
        point: DVec3,
        contact: Contact,
        is_caster: impl Fn(usize) -> bool,
    ) -> Option<ShadowCaster> {
        if !self.shadow_enable {
            return None;
        }
        let stops = |triangle: usize, weights: DVec3| {
            is_caster(self.bvh.triangles[triangle].node)
                && self.bvh.casts_shadow_at(&self.linked, triangle, weights)
        };
        let spend = |boxes| self.work.spend_on_rays(boxes);
        if let LightRays::Bent(tube) = placed.rays {
            let path = self.bvh.bent_path(tube, across.x, across.y);
            let hit = self.bvh.first_bent_hit_budgeted(&path, place.t, spend, |hit| {
                hit.position.distance(point) > contact.within && stops(hit.triangle, hit.barycentrics)
            })?;
            let node = self.bvh.triangles[hit.triangle].node;
            return Some(ShadowCaster { position: hit.position, t: hit.t, node });
        }
        let (from, to) =
            placed.straight_path(place, across, point, 2.0 * self.bvh.posed.half_extent.length());
        let (way, length) = (to - from, to.distance(from));
        let hit =
            self.bvh.first_hit_budgeted(from, way, [0.0, 1.0 - contact.within / length], spend, |hit| {
                Some(hit.triangle) != contact.triangle && stops(hit.triangle, hit.barycentrics)
            })?;
        let node = self.bvh.triangles[hit.triangle].node;
        Some(ShadowCaster {
            position: from + way * hit.distance,
            t: place.t - length * (1.0 - hit.distance),
            node,
        })
    }
}
