//! First caster on a light path, from the source on.

use glam::DVec3;

use crate::{BentHit, BentPath, Bvh, LinkedNodes};

/// Distance from a surface within which nothing shadows it, as a share of the light's size or of the distance to the
/// source. It excludes the surface itself and surfaces in contact. Rounding moves a point by 1e-15 of that.
pub const CONTACT_TOLERANCE: f64 = 1e-9;

/// Path of light to a point.
#[derive(Clone, Copy, Debug)]
pub enum LightPath<'a> {
    /// Curve of constant (v, w) through the point.
    Bent {
        path: BentPath<'a>,
        /// Parameter t of the light at the point.
        t: f64,
    },
    /// Straight path from a source.
    FromPoint {
        /// In scene space.
        source: DVec3,
        /// Triangle of the point. A straight path meets it nowhere else.
        own_triangle: usize,
    },
    /// Straight path from outside of the scene.
    FromDirection {
        /// Unit vector towards the light.
        to_light: DVec3,
        /// Triangle that the point lies on.
        own_triangle: usize,
    },
}

/// First caster on a light path.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle {
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    pub position: DVec3,
    /// Distance along the path from its start: the light's parameter t on a bent path, else world units.
    pub t: f64,
}

impl Bvh {
    /// Finds the first caster from the source on that blocks light to `point`, in scene space, among the nodes that
    /// cast shadows by `linked`.
    pub fn first_obstacle(&self, path: &LightPath, point: DVec3, linked: &LinkedNodes) -> Option<Obstacle> {
        let (from, own_triangle) = match path {
            LightPath::Bent { path, t } => {
                let hit = self.first_bent_hit(path, *t, self.blocking_hits(path, point, linked))?;
                return Some(Obstacle { triangle: hit.triangle, position: hit.position, t: hit.t });
            }
            LightPath::FromPoint { source, own_triangle } => (*source, *own_triangle),
            LightPath::FromDirection { to_light, own_triangle } => {
                (self.point_outside_scene(point, *to_light), *own_triangle)
            }
        };
        let direction = point - from;
        let far = 1.0 - CONTACT_TOLERANCE - rounding_error(point) / direction.length();
        let hit = self.first_hit(from, direction, [0.0, far], |hit| {
            hit.triangle != own_triangle && self.casts_shadow_at(linked, hit.triangle, hit.barycentrics)
        })?;
        let (position, t) = (from + direction * hit.distance, direction.length() * hit.distance);
        Some(Obstacle { triangle: hit.triangle, position, t })
    }

    /// Returns true if a caster blocks a bent path on which the point is at `t`.
    pub fn is_path_blocked(&self, path: &BentPath, t: f64, point: DVec3, linked: &LinkedNodes) -> bool {
        self.has_bent_hit(path, t, self.blocking_hits(path, point, linked))
    }

    /// Returns a point outside of the scene on the path of light that comes to `point` from the direction `to_light`, a
    /// unit vector.
    pub fn point_outside_scene(&self, point: DVec3, to_light: DVec3) -> DVec3 {
        point + to_light * (2.0 * self.posed.half_extent.length())
    }

    /// Returns true if a point of a triangle casts a shadow.
    pub fn casts_shadow_at(&self, linked: &LinkedNodes, triangle: usize, weights: DVec3) -> bool {
        let triangle = &self.triangle(triangle);
        linked.casts_shadow(triangle.node) && self.passes_alpha_test(triangle, weights)
    }

    /// Returns a test for hits that block light on a bent path to a point. The point's own triangle may block it: a
    /// bent path can cross it elsewhere too.
    fn blocking_hits(&self, path: &BentPath, point: DVec3, linked: &LinkedNodes) -> impl Fn(&BentHit) -> bool {
        let contact = CONTACT_TOLERANCE * path.tube.placement.world_per_tube + rounding_error(point);
        move |hit| {
            hit.position.distance(point) > contact && self.casts_shadow_at(linked, hit.triangle, hit.barycentrics)
        }
    }
}

/// Generous bound of the rounding error of a position.
pub fn rounding_error(position: DVec3) -> f64 {
    64.0 * f64::EPSILON * position.abs().max_element()
}
