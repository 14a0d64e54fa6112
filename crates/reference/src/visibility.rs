//! Shadows, by following light from its source to the surface.

use glam::DVec3;
use light::{Tube, TubePoint};
use raycast::BentHit;

use crate::source::{place_beside, sample_cone, sample_tube};
use crate::{LightSample, Reference, Source, Surface};

/// Distance from a surface within which nothing shadows it, as a share of the light's size or of the way to the
/// source: the surface itself, and what lies on it. Rounding places a point to 1e-15 of that.
const CONTACT: f64 = 1e-9;

impl Reference {
    /// What a light does at a surface, its shadow included; `None` outside the light.
    pub fn sample(&self, source: &Source, surface: &Surface) -> Option<LightSample> {
        let mut sample = self.sample_unshadowed(source, surface)?;
        sample.visible = self.reaches(source, surface, &sample);
        Some(sample)
    }

    /// The same without looking for a shadow: `visible` says yes.
    pub(crate) fn sample_unshadowed(&self, source: &Source, surface: &Surface) -> Option<LightSample> {
        let origin = self.in_scene(source);
        match source {
            Source::Bendy(tube) => sample_tube(tube, origin, surface.position),
            Source::Spot(cone) => sample_cone(cone, origin, surface.position),
        }
    }

    fn in_scene(&self, source: &Source) -> DVec3 {
        source.position_in_world() - self.bvh.posed.origin_in_world
    }

    /// Whether nothing is in the way of the light that `sample` says arrives at the surface, as a smooth one
    /// ([`Surface::shadow_position`]). Light that arrives from behind that, or through the surface's own triangle, meets the other side.
    pub(crate) fn reaches(&self, source: &Source, surface: &Surface, sample: &LightSample) -> bool {
        if surface.normal.dot(sample.along_path) <= 0.0 || self.is_in_its_own_way(surface, sample) {
            return false;
        }
        let (origin, point) = (self.in_scene(source), surface.shadow_position());
        let Source::Bendy(tube) = source else { return self.sees(surface, origin) };
        let (t, vw) = place_beside(tube, origin, sample, point);
        let path = self.bvh.path(tube, vw.x, vw.y);
        !self.bvh.blocks(&path, t, self.in_the_way_of(point, tube))
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
    /// source. `None` where nothing is in the way.
    pub fn occluder(&self, tube: &Tube<f64>, place: &TubePoint, point_in_world: DVec3) -> Option<usize> {
        let path = self.bvh.path(tube, place.v, place.w);
        let point = point_in_world - self.bvh.posed.origin_in_world;
        let hit = self.bvh.first_bent_hit(&path, place.t, self.in_the_way_of(point, tube))?;
        Some(self.bvh.triangles[hit.triangle].node)
    }

    /// Which hits stop light on its way to a point. Its own triangle may be one: a bent path can cross it
    /// elsewhere too.
    fn in_the_way_of(&self, point: DVec3, tube: &Tube<f64>) -> impl Fn(&BentHit) -> bool {
        let contact = CONTACT * tube.placement.world_per_tube + rounding(point);
        move |hit| {
            hit.position.distance(point) > contact
                && self.is_solid(&self.bvh.triangles[hit.triangle], hit.weights)
        }
    }

    /// Whether nothing lies on the straight way from a surface to another point.
    fn sees(&self, surface: &Surface, there: DVec3) -> bool {
        let point = surface.shadow_position();
        let way = there - point;
        let near = CONTACT + rounding(point) / way.length();
        self.bvh
            .first_hit(point, way, [near, 1.0], |hit| {
                hit.triangle != surface.triangle
                    && self.is_solid(&self.bvh.triangles[hit.triangle], hit.weights)
            })
            .is_none()
    }
}

/// What a position may be off by, generously.
fn rounding(position: DVec3) -> f64 {
    64.0 * f64::EPSILON * position.abs().max_element()
}
