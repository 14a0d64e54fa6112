//! Straight rays.

use glam::DVec3;

use crate::hierarchy::ThickLine;
use crate::{Bvh, Triangle};

/// Intersection of a straight ray with a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    /// Distance along the ray, in lengths of its direction.
    pub distance: f64,
    /// Barycentric weights of the triangle's corners at the point.
    pub barycentrics: DVec3,
}

impl Bvh {
    /// Finds the nearest triangle that the ray meets from `near` to `far` (in lengths of the direction; `far` may be
    /// infinite) and that `accept` takes. Both sides of triangles count. Of two at the same distance the one with the
    /// lower index counts.
    ///
    /// Accuracy: the error of the distance is some ulps of the largest coordinate, over the cosine between ray and
    /// normal. Adjacent triangles overlap by 1e-12 of their size, so no ray slips between them.
    pub fn first_hit(
        &self,
        origin: DVec3,
        direction: DVec3,
        range: [f64; 2],
        accept: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        self.first_hit_budgeted(origin, direction, range, |_| true, accept)
    }

    /// Finds the nearest triangle as `Self::first_hit` does, and counts steps for boxes and triangles near the ray.
    /// `spend` is called before steps are taken. If it returns false, the search stops and its result has no meaning.
    pub fn first_hit_budgeted(
        &self,
        origin: DVec3,
        direction: DVec3,
        [near, far]: [f64; 2],
        spend: impl Fn(u64) -> bool,
        accept: impl Fn(&Hit) -> bool,
    ) -> Option<Hit> {
        let far = far.min(self.hierarchy.max_distance_from(origin) / direction.length());
        if near > far {
            return None;
        }
        let at = |distance: f64| origin + direction * distance;
        let line = ThickLine { from: at(near), to: at(far), radius: 0.0 };
        let mut best: Option<Hit> = None;
        self.hierarchy.visit_along_line(line, spend, |index| {
            if let Some(hit) = intersect_ray(&self.triangle(index), index, origin, direction)
                && (near..=far).contains(&hit.distance)
                && best.is_none_or(|best| (hit.distance, index) < (best.distance, best.triangle))
                && accept(&hit)
            {
                best = Some(hit);
            }
            best.map_or(1.0, |best| (best.distance - near) / (far - near))
        });
        best
    }
}

fn intersect_ray(triangle: &Triangle, index: usize, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let normal = triangle.normal();
    // Zero for a ray in the plane and for a triangle without area. Neither is a hit.
    let closing = normal.dot(direction);
    let distance = normal.dot(triangle.corners[0] - origin) / closing;
    let weights = triangle.barycentrics_at(origin + direction * distance)?;
    (closing != 0.0).then_some(Hit { triangle: index, distance, barycentrics: weights })
}
