//! What stands in a light's way, from its source on.

use glam::DVec3;

use crate::{BentHit, BentPath, Bvh, LinkedNodes};

/// Distance from a surface within which nothing shadows it, as a share of the light's size or of the way to the
/// source: the surface itself, and what lies on it. Rounding places a point to 1e-15 of that.
pub const CONTACT_TOLERANCE: f64 = 1e-9;

/// How light comes to a point.
#[derive(Clone, Copy, Debug)]
pub enum LightPath<'a> {
    /// Along a curve of constant (v, w), on which the point lies at `t`.
    Bent {
        /// The curve.
        path: BentPath<'a>,
        /// Parameter of the light at the point.
        t: f64,
    },
    /// Straight, from a source.
    FromPoint {
        /// In scene space.
        source: DVec3,
        /// The triangle on which the point lies, which a straight way meets nowhere else.
        own_triangle: usize,
    },
    /// Straight, from outside of the scene.
    FromDirection {
        /// Unit vector to where it comes from.
        to_light: DVec3,
        /// As above.
        own_triangle: usize,
    },
}

/// The first that light meets on its way.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle {
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    /// Position in scene space.
    pub position: DVec3,
    /// How far along the way from where it begins: the light's parameter on a bent one, else world units.
    pub t: f64,
}

impl Bvh {
    /// The first from the source on that stops light on its way to `point`, in scene space, of what throws shadows by `linked`.
    pub fn first_obstacle(&self, way: &LightPath, point: DVec3, linked: &LinkedNodes) -> Option<Obstacle> {
        match way {
            LightPath::Bent { path, t } => {
                let hit = self.first_bent_hit(path, *t, self.blocking_hits(path, point, linked))?;
                Some(Obstacle { triangle: hit.triangle, position: hit.position, t: hit.t })
            }
            LightPath::FromPoint { source, own_triangle: own } => {
                self.first_obstacle_between(*source, point, *own, linked)
            }
            LightPath::FromDirection { to_light, own_triangle: own } => {
                self.first_obstacle_between(self.point_outside_scene(point, *to_light), point, *own, linked)
            }
        }
    }

    /// Whether anything does, on a bent way on which the point lies at `t`.
    pub fn is_path_blocked(&self, path: &BentPath, t: f64, point: DVec3, linked: &LinkedNodes) -> bool {
        self.has_bent_hit(path, t, self.blocking_hits(path, point, linked))
    }

    /// Where light that comes from `toward`, a unit vector, is still outside of the scene on its way to a point of it.
    pub fn point_outside_scene(&self, point: DVec3, to_light: DVec3) -> DVec3 {
        point + to_light * (2.0 * self.posed.half_extent.length())
    }

    /// Whether a place of a triangle throws a shadow.
    pub fn casts_shadow_at(&self, linked: &LinkedNodes, triangle: usize, weights: DVec3) -> bool {
        let triangle = &self.triangles[triangle];
        linked.casts_shadow(triangle.node) && self.passes_alpha_test(triangle, weights)
    }

    /// Which hits stop light on a bent way to a point. Its own triangle may be one: a bent path can cross it elsewhere too.
    fn blocking_hits(
        &self,
        path: &BentPath,
        point: DVec3,
        linked: &LinkedNodes,
    ) -> impl Fn(&BentHit) -> bool {
        let contact = CONTACT_TOLERANCE * path.tube.placement.world_per_tube + rounding_error(point);
        move |hit| {
            hit.position.distance(point) > contact
                && self.casts_shadow_at(linked, hit.triangle, hit.barycentrics)
        }
    }

    fn first_obstacle_between(
        &self,
        from: DVec3,
        point: DVec3,
        own: usize,
        linked: &LinkedNodes,
    ) -> Option<Obstacle> {
        let way = point - from;
        let far = 1.0 - CONTACT_TOLERANCE - rounding_error(point) / way.length();
        let hit = self.first_hit(from, way, [0.0, far], |hit| {
            hit.triangle != own && self.casts_shadow_at(linked, hit.triangle, hit.barycentrics)
        })?;
        let (position, t) = (from + way * hit.distance, way.length() * hit.distance);
        Some(Obstacle { triangle: hit.triangle, position, t })
    }
}

/// What a position may be off by, generously.
pub fn rounding_error(position: DVec3) -> f64 {
    64.0 * f64::EPSILON * position.abs().max_element()
}
