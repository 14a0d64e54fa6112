//! Shadows, by tracing light paths from the source to the surface.

use glam::DVec3;
use light::{Parallel, Tube, TubePoint};
use raycast::{CONTACT_TOLERANCE, LightPath, Obstacle, rounding_error};

use crate::source::{coords_near, sample_cone, sample_omni, sample_parallel, sample_tube};
use crate::{LightSample, LinkedNodes, Reference, ReferenceLight, ShadedPoint};

impl Reference {
    /// Samples a light at a surface, including its shadow, with no links. Returns `None` outside the light.
    pub fn sample(&self, source: &ReferenceLight, surface: &ShadedPoint) -> Option<LightSample> {
        self.sample_linked((source, &LinkedNodes::default()), surface)
    }

    /// Samples a light at a surface, including its shadow. Returns `None` outside the light, and on nodes that
    /// its links exclude.
    pub(crate) fn sample_linked(
        &self,
        light: (&ReferenceLight, &LinkedNodes),
        surface: &ShadedPoint,
    ) -> Option<LightSample> {
        let mut sample = self.sample_unshadowed(light, surface)?;
        sample.is_visible = self.is_lit(light, surface, &sample);
        Some(sample)
    }

    /// Samples a light at a surface without tracing its shadow. `is_visible` is true.
    pub(crate) fn sample_unshadowed(
        &self,
        (source, linked): (&ReferenceLight, &LinkedNodes),
        surface: &ShadedPoint,
    ) -> Option<LightSample> {
        if !linked.is_lit(surface.node) {
            return None;
        }
        let point = surface.position;
        match source {
            ReferenceLight::Bendy(tube) => {
                sample_tube(tube, self.in_scene(tube.placement.translation), point)
            }
            ReferenceLight::Spot(cone) => sample_cone(cone, self.in_scene(cone.translation), point),
            ReferenceLight::Omni(omni) => sample_omni(omni, self.in_scene(omni.translation), point),
            ReferenceLight::Directional(parallel) => sample_parallel(&self.in_scene_space(parallel), point),
        }
    }

    fn in_scene(&self, position_in_world: DVec3) -> DVec3 {
        position_in_world - self.bvh.posed.origin_in_world
    }

    /// Returns the light with the centre of its window in scene space.
    fn in_scene_space(&self, parallel: &Parallel) -> Parallel {
        Parallel { translation: self.in_scene(parallel.translation), ..parallel.clone() }
    }

    /// Returns true if no occluder blocks the light that arrives at the surface as `sample` says. The surface
    /// counts as smooth ([`ShadedPoint::shadow_position`]). Light from behind it, or through the surface's own
    /// triangle, lights the other side.
    pub(crate) fn is_lit(
        &self,
        light: (&ReferenceLight, &LinkedNodes),
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> bool {
        let shadow_enable = light.0.light_profile().shadow_enable;
        !shadow_enable
            || !self.is_back_facing(light.1, surface, sample)
                && self.has_line_of_sight(light, surface, sample)
    }

    /// Returns true if light that can be shadowed arrives from behind the smooth surface, or through the
    /// surface's own triangle.
    pub(crate) fn is_back_facing(
        &self,
        linked: &LinkedNodes,
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> bool {
        let is_in_its_own_way =
            || linked.casts_shadow(surface.node) && self.is_self_shadowed(surface, sample);
        surface.normal.dot(sample.along_path) <= 0.0 || is_in_its_own_way()
    }

    /// Returns true if no other surface blocks the light on its path to the surface.
    pub(crate) fn has_line_of_sight(
        &self,
        (source, linked): (&ReferenceLight, &LinkedNodes),
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> bool {
        match source {
            ReferenceLight::Bendy(tube) => {
                let (origin, point) = (self.in_scene(tube.placement.translation), surface.shadow_position());
                let (t, vw) = coords_near(tube, origin, sample, point);
                let path = self.bvh.bent_path(tube, vw.x, vw.y);
                !self.bvh.is_path_blocked(&path, t, point, linked)
            }
            ReferenceLight::Spot(cone) => {
                self.has_line_of_sight_to(surface, self.in_scene(cone.translation), linked)
            }
            ReferenceLight::Omni(omni) => {
                self.has_line_of_sight_to(surface, self.in_scene(omni.translation), linked)
            }
            ReferenceLight::Directional(parallel) => {
                self.has_line_of_sight_along(surface, parallel.direction(), linked)
            }
        }
    }

    /// Returns the first occluder from the source on.
    pub(crate) fn first_occluder(
        &self,
        (source, linked): (&ReferenceLight, &LinkedNodes),
        surface: &ShadedPoint,
        sample: &LightSample,
    ) -> Option<Obstacle> {
        let (point, own) = (surface.shadow_position(), surface.triangle);
        let way = match source {
            ReferenceLight::Bendy(tube) => {
                let (t, vw) = coords_near(tube, self.in_scene(tube.placement.translation), sample, point);
                LightPath::Bent { path: self.bvh.bent_path(tube, vw.x, vw.y), t }
            }
            ReferenceLight::Spot(cone) => {
                LightPath::FromPoint { source: self.in_scene(cone.translation), own_triangle: own }
            }
            ReferenceLight::Omni(omni) => {
                LightPath::FromPoint { source: self.in_scene(omni.translation), own_triangle: own }
            }
            ReferenceLight::Directional(parallel) => {
                LightPath::FromDirection { to_light: parallel.direction(), own_triangle: own }
            }
        };
        self.bvh.first_obstacle(&way, point, linked)
    }

    /// Returns true if light from behind the surface's triangle passes through it.
    fn is_self_shadowed(&self, surface: &ShadedPoint, sample: &LightSample) -> bool {
        let arriving = surface.geometric_normal.dot(sample.along_path);
        if arriving > 0.0 {
            return false;
        }
        let height = surface.terminator_offset * surface.normal.dot(surface.geometric_normal);
        let through = surface.shadow_position() + sample.along_path * (height / -arriving);
        let triangle = &self.bvh.triangles[surface.triangle];
        // At a grazing angle light passes through no point. At height 0 it passes through the point itself.
        height <= 0.0 || triangle.barycentrics_at(through).is_some()
    }

    /// Returns the node that shadows a point, given its coordinates in the light: the first along the light
    /// path, among those that cast its shadows. Returns `None` if nothing blocks the light.
    pub fn occluding_node(
        &self,
        (tube, linked): (&Tube<f64>, &LinkedNodes),
        place: &TubePoint,
        point_in_world: DVec3,
    ) -> Option<usize> {
        let path = self.bvh.bent_path(tube, place.v, place.w);
        let point = point_in_world - self.bvh.posed.origin_in_world;
        let obstacle = self.bvh.first_obstacle(&LightPath::Bent { path, t: place.t }, point, linked)?;
        Some(self.bvh.triangles[obstacle.triangle].node)
    }

    /// Returns true if no caster lies on the straight line from a surface to another point.
    fn has_line_of_sight_to(&self, surface: &ShadedPoint, there: DVec3, linked: &LinkedNodes) -> bool {
        let point = surface.shadow_position();
        let way = there - point;
        let near = CONTACT_TOLERANCE + rounding_error(point) / way.length();
        self.is_ray_unblocked(surface, way, [near, 1.0], linked)
    }

    /// Returns true if no caster lies on the straight line from a surface out of the scene, along the unit
    /// vector `towards`.
    fn has_line_of_sight_along(&self, surface: &ShadedPoint, towards: DVec3, linked: &LinkedNodes) -> bool {
        let near = CONTACT_TOLERANCE * self.bvh.posed.half_extent.length()
            + rounding_error(surface.shadow_position());
        self.is_ray_unblocked(surface, towards, [near, f64::INFINITY], linked)
    }

    /// Returns true if no triangle except the surface's own is met along `way` from the surface, between `near` and
    /// `far` lengths of `way`.
    fn is_ray_unblocked(
        &self,
        surface: &ShadedPoint,
        way: DVec3,
        [near, far]: [f64; 2],
        linked: &LinkedNodes,
    ) -> bool {
        self.bvh
            .first_hit(surface.shadow_position(), way, [near, far], |hit| {
                hit.triangle != surface.triangle
                    && self.bvh.casts_shadow_at(linked, hit.triangle, hit.barycentrics)
            })
            .is_none()
    }
}
