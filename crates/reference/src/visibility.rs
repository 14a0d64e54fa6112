//! Shadows, by tracing light paths from the source to the surface.

use glam::DVec3;
use light::{Tube, TubePoint};
use raycast::{CONTACT_TOLERANCE, Hit, LightPath, Obstacle, rounding_error};

use crate::source::coords_near;
use crate::{LightSample, LinkedNodes, Reference, ReferenceLight, ShadedPoint};

impl Reference {
    /// Samples a light at a surface, including its shadow, with no links. Returns `None` outside the light.
    pub fn sample(&self, source: &ReferenceLight, surface: &ShadedPoint) -> Option<LightSample> {
        self.sample_linked(source, &LinkedNodes::default(), surface)
    }

    /// Samples a light at a surface, including its shadow. Returns `None` outside the light, and on nodes that
    /// its links exclude.
    pub(crate) fn sample_linked(
        &self,
        source: &ReferenceLight,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
    ) -> Option<LightSample> {
        let sample = self.sample_unshadowed(source, linked, surface)?;
        Some(LightSample { is_visible: self.is_lit(source, linked, surface, &sample), ..sample })
    }

    /// Samples a light at a surface without tracing its shadow. `is_visible` is true.
    pub(crate) fn sample_unshadowed(
        &self,
        source: &ReferenceLight,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
    ) -> Option<LightSample> {
        if !linked.is_lit(surface.node) {
            return None;
        }
        source.sample(self.in_scene(source.position()), surface.position)
    }

    pub(crate) fn in_scene(&self, position_in_world: DVec3) -> DVec3 {
        position_in_world - self.bvh.posed.origin_in_world
    }

    /// Returns true if no occluder blocks the light that arrives at the surface as `sample` says. The surface
    /// counts as smooth ([`ShadedPoint::shadow_position`]). Light from behind it, or through the surface's own
    /// triangle, lights the other side.
    pub(crate) fn is_lit(
        &self,
        source: &ReferenceLight,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> bool {
        !source.light_profile().shadow_enable
            || !self.is_back_facing(linked, surface, sample) && self.has_line_of_sight(source, linked, surface, sample)
    }

    /// Returns true if light that can be shadowed arrives from behind the smooth surface, or through the
    /// surface's own triangle.
    pub(crate) fn is_back_facing(&self, linked: &LinkedNodes, surface: &ShadedPoint, sample: &LightSample) -> bool {
        surface.normal.dot(sample.along_path) <= 0.0
            || linked.casts_shadow(surface.node) && self.is_self_shadowed(surface, sample)
    }

    /// Returns the path on which light comes to the surface.
    fn path_to_surface<'a>(
        &self,
        source: &'a ReferenceLight,
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> LightPath<'a> {
        let (position, own_triangle) = (self.in_scene(source.position()), surface.triangle);
        match source {
            ReferenceLight::Bendy(tube) => {
                let (t, vw) = coords_near(tube, position, sample, surface.shadow_position());
                LightPath::Bent { path: self.bvh.bent_path(tube, vw.x, vw.y), t }
            }
            ReferenceLight::Spot(_) | ReferenceLight::Omni(_) => {
                LightPath::FromPoint { source: position, own_triangle }
            }
            ReferenceLight::Directional(parallel) => {
                LightPath::FromDirection { to_light: parallel.direction(), own_triangle }
            }
        }
    }

    /// Returns true if no other surface blocks the light on its path to the surface.
    pub(crate) fn has_line_of_sight(
        &self,
        source: &ReferenceLight,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> bool {
        let point = surface.shadow_position();
        let (direction, range) = match self.path_to_surface(source, surface, sample) {
            LightPath::Bent { path, t } => return !self.bvh.is_path_blocked(&path, t, point, linked),
            LightPath::FromPoint { source, .. } => {
                let direction = source - point;
                (direction, [CONTACT_TOLERANCE + rounding_error(point) / direction.length(), 1.0])
            }
            LightPath::FromDirection { to_light, .. } => {
                let near = CONTACT_TOLERANCE * self.bvh.posed.half_extent.length() + rounding_error(point);
                (to_light, [near, f64::INFINITY])
            }
        };
        let blocks = |hit: &Hit| {
            hit.triangle != surface.triangle && self.bvh.casts_shadow_at(linked, hit.triangle, hit.barycentrics)
        };
        self.bvh.first_hit(point, direction, range, blocks).is_none()
    }

    /// Returns the first occluder from the source on.
    pub(crate) fn first_occluder(
        &self,
        source: &ReferenceLight,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> Option<Obstacle> {
        let path = self.path_to_surface(source, surface, sample);
        self.bvh.first_obstacle(&path, surface.shadow_position(), linked)
    }

    /// Returns true if light from behind the surface's triangle passes through it.
    fn is_self_shadowed(&self, surface: &ShadedPoint, sample: &LightSample) -> bool {
        let arriving = surface.geometric_normal.dot(sample.along_path);
        if arriving > 0.0 {
            return false;
        }
        let height = surface.terminator_offset * surface.normal.dot(surface.geometric_normal);
        let through = surface.shadow_position() + sample.along_path * (height / -arriving);
        let triangle = &self.bvh.triangle(surface.triangle);
        // At a grazing angle light passes through no point. At height 0 it passes through the point itself.
        height <= 0.0 || triangle.barycentrics_at(through).is_some()
    }

    /// Returns the node that shadows a point, given its coordinates in the light: the first along the light
    /// path, among those that cast its shadows. Returns `None` if nothing blocks the light.
    pub fn occluding_node(
        &self,
        tube: &Tube<f64>,
        linked: &LinkedNodes,
        coords: &TubePoint,
        point_in_world: DVec3,
    ) -> Option<usize> {
        let path = LightPath::Bent { path: self.bvh.bent_path(tube, coords.v, coords.w), t: coords.t };
        let obstacle = self.bvh.first_obstacle(&path, self.in_scene(point_in_world), linked)?;
        Some(self.bvh.triangle(obstacle.triangle).node)
    }
}
