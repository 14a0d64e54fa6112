//! Shadows, by following light from its source to the surface.

use glam::DVec3;
use light::{Parallel, Tube, TubePoint};
use raycast::{CONTACT, Obstacle, Way, rounding};

use crate::source::{place_beside, sample_cone, sample_omni, sample_parallel, sample_tube};
use crate::{LightSample, Linked, Reference, Source, Surface};

impl Reference {
    /// What a light for which all nodes count does at a surface, its shadow included; `None` outside the light.
    pub fn sample(&self, source: &Source, surface: &Surface) -> Option<LightSample> {
        self.sample_linked((source, &Linked::default()), surface)
    }

    /// What a light does at a surface, its shadow included; `None` outside the light, and on what it does not light.
    pub(crate) fn sample_linked(&self, light: (&Source, &Linked), surface: &Surface) -> Option<LightSample> {
        let mut sample = self.sample_unshadowed(light, surface)?;
        sample.visible = self.reaches(light, surface, &sample);
        Some(sample)
    }

    /// The same without looking for a shadow: `visible` says yes.
    pub(crate) fn sample_unshadowed(
        &self,
        (source, linked): (&Source, &Linked),
        surface: &Surface,
    ) -> Option<LightSample> {
        if !linked.lights(surface.node) {
            return None;
        }
        let point = surface.position;
        match source {
            Source::Bendy(tube) => sample_tube(tube, self.in_scene(tube.placement.translation), point),
            Source::Spot(cone) => sample_cone(cone, self.in_scene(cone.translation), point),
            Source::Omni(omni) => sample_omni(omni, self.in_scene(omni.translation), point),
            Source::Directional(parallel) => sample_parallel(&self.beside_scene(parallel), point),
        }
    }

    fn in_scene(&self, position_in_world: DVec3) -> DVec3 {
        position_in_world - self.bvh.posed.origin_in_world
    }

    /// The light with its window's middle in scene space.
    fn beside_scene(&self, parallel: &Parallel) -> Parallel {
        Parallel { translation: self.in_scene(parallel.translation), ..parallel.clone() }
    }

    /// Whether nothing is in the way of the light that `sample` says arrives at the surface, as a smooth one
    /// ([`Surface::shadow_position`]). Light that arrives from behind that, or through the surface's own triangle, meets the other side.
    pub(crate) fn reaches(&self, light: (&Source, &Linked), surface: &Surface, sample: &LightSample) -> bool {
        let shadow_enable = light.0.light_filter().shadow_enable;
        !shadow_enable
            || !self.turns_away(light.1, surface, sample) && self.is_way_free(light, surface, sample)
    }

    /// Whether light that can be shadowed arrives from behind the surface, as a smooth one or through its own triangle.
    pub(crate) fn turns_away(&self, linked: &Linked, surface: &Surface, sample: &LightSample) -> bool {
        let is_in_its_own_way = || linked.stops_at(surface.node) && self.is_in_its_own_way(surface, sample);
        surface.normal.dot(sample.along_path) <= 0.0 || is_in_its_own_way()
    }

    /// Whether nothing else is in the way.
    pub(crate) fn is_way_free(
        &self,
        (source, linked): (&Source, &Linked),
        surface: &Surface,
        sample: &LightSample,
    ) -> bool {
        match source {
            Source::Bendy(tube) => {
                let (origin, point) = (self.in_scene(tube.placement.translation), surface.shadow_position());
                let (t, vw) = place_beside(tube, origin, sample, point);
                let path = self.bvh.path(tube, vw.x, vw.y);
                !self.bvh.blocks_way(&path, t, point, linked)
            }
            Source::Spot(cone) => self.sees(surface, self.in_scene(cone.translation), linked),
            Source::Omni(omni) => self.sees(surface, self.in_scene(omni.translation), linked),
            Source::Directional(parallel) => self.sees_out(surface, parallel.direction(), linked),
        }
    }

    /// The first from the source on that is in the way.
    pub(crate) fn first_in_way(
        &self,
        (source, linked): (&Source, &Linked),
        surface: &Surface,
        sample: &LightSample,
    ) -> Option<Obstacle> {
        let (point, own) = (surface.shadow_position(), surface.triangle);
        let way = match source {
            Source::Bendy(tube) => {
                let (t, vw) = place_beside(tube, self.in_scene(tube.placement.translation), sample, point);
                Way::Bent { path: self.bvh.path(tube, vw.x, vw.y), t }
            }
            Source::Spot(cone) => Way::From { source: self.in_scene(cone.translation), own },
            Source::Omni(omni) => Way::From { source: self.in_scene(omni.translation), own },
            Source::Directional(parallel) => Way::Along { to_light: parallel.direction(), own },
        };
        self.bvh.first_in_way(&way, point, linked)
    }

    /// Whether light from behind the surface's triangle comes through it.
    fn is_in_its_own_way(&self, surface: &Surface, sample: &LightSample) -> bool {
        let arriving = surface.geometric_normal.dot(sample.along_path);
        if arriving > 0.0 {
            return false;
        }
        let height = surface.terminator_offset * surface.normal.dot(surface.geometric_normal);
        let through = surface.shadow_position() + sample.along_path * (height / -arriving);
        let triangle = &self.bvh.triangles[surface.triangle];
        // Seen edge on, light comes through nowhere; at no height it comes through the point itself.
        height <= 0.0 || triangle.weights_at(through).is_some()
    }

    /// The node that shadows a point, given where it lies in the light: the first on the light's way from its
    /// source, of those that count for it. `None` where nothing is in the way.
    pub fn occluder(
        &self,
        (tube, linked): (&Tube<f64>, &Linked),
        place: &TubePoint,
        point_in_world: DVec3,
    ) -> Option<usize> {
        let path = self.bvh.path(tube, place.v, place.w);
        let point = point_in_world - self.bvh.posed.origin_in_world;
        let obstacle = self.bvh.first_in_way(&Way::Bent { path, t: place.t }, point, linked)?;
        Some(self.bvh.triangles[obstacle.triangle].node)
    }

    /// Whether nothing that counts lies on the straight way from a surface to another point.
    fn sees(&self, surface: &Surface, there: DVec3, linked: &Linked) -> bool {
        let point = surface.shadow_position();
        let way = there - point;
        let near = CONTACT + rounding(point) / way.length();
        self.is_free(surface, way, [near, 1.0], linked)
    }

    /// Whether nothing lies on the straight way from a surface out of the scene, along the unit vector `towards`.
    fn sees_out(&self, surface: &Surface, towards: DVec3, linked: &Linked) -> bool {
        let near = CONTACT * self.bvh.posed.half_extent.length() + rounding(surface.shadow_position());
        self.is_free(surface, towards, [near, f64::INFINITY], linked)
    }

    /// Whether nothing but the surface's own triangle lies from `near` to `far` lengths of `way` from it.
    fn is_free(&self, surface: &Surface, way: DVec3, [near, far]: [f64; 2], linked: &Linked) -> bool {
        self.bvh
            .first_hit(surface.shadow_position(), way, [near, far], |hit| {
                hit.triangle != surface.triangle && self.bvh.stops(linked, hit.triangle, hit.weights)
            })
            .is_none()
    }
}
