//! Position of a feature in the picture after a drag, computed anew by rays, not from the solver's numbers.

use std::cell::RefCell;

use glam::{DMat2, DVec2, DVec3};
use light::{CheckedLight, EndMode, LightRays};
use raycast::{Bvh, SeenPoint};
use scene::{ViewRay, pixel_of};

use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::{Feature, Viewport};
use crate::taken_feature::TakenFeature;
use crate::work::WorkBudget;

/// Largest angle between the normal and the direction to the light of a surface that faces the light, in radians: 0.1
/// degrees.
const ALIGNED_RADIANS: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// Largest distance of a highlight's center from a pixel of the highlight, as a share of the picture's width.
const NEAR_HIGHLIGHT: f64 = 0.1;

/// Distance in pixels between the pixels by whose difference the solver estimates the change of a direction over the
/// picture.
const BESIDE_PX: f64 = 0.25;

/// Finds the center of the highlight of `light` near `pixel`, in pixels: light arrives there along the mirror
/// direction.
///
/// `None` if `pixel` shows no surface or one outside the light, or if there is no center on the same node within a
/// tenth of the picture's width.
pub fn highlight_near(bvh: &Bvh, view: &Viewport, light: &CheckedLight, pixel: DVec2) -> Option<DVec2> {
    let origin = bvh.posed.origin_in_world;
    let seen = bvh.visible_point(&ViewRay::new(&view.camera, view.size, pixel, origin))?;
    let work = WorkBudget::new(&|_| true);
    let placed = SceneLight::new(light.rays(), origin, seen.position, &work);
    let coords = placed.locate(seen.position, None)?;
    let directions = [coords.to_light, seen.mirror_direction()];
    let feature = Feature::Highlight;
    let taken = TakenFeature { feature, from: seen, to: seen, pivot: None, start_coords: coords, directions };
    let centre = DraggedFeature { bvh, view, taken: &taken, placed: &placed }.nearest_aligned_pixel(coords.t, pixel)?;
    // The center must lie in the picture, in the light and on the node under the pointer.
    let [width, height] = view.size.map(f64::from);
    let is_near = centre.distance(pixel) <= NEAR_HIGHLIGHT * width;
    let is_in_picture = (0.0..width).contains(&centre.x) && (0.0..height).contains(&centre.y);
    let seen_at_centre = bvh.visible_point(&ViewRay::new(&view.camera, view.size, centre, origin))?;
    let is_lit = placed.contains(&placed.locate(seen_at_centre.position, Some(coords.t))?);
    (is_near && is_in_picture && is_lit && seen_at_centre.node == seen.node).then_some(centre)
}

/// Feature of a dragged light, in a view.
pub(crate) struct DraggedFeature<'a> {
    pub bvh: &'a Bvh,
    pub view: &'a Viewport,
    pub taken: &'a TakenFeature,
    pub placed: &'a SceneLight<'a>,
}

impl DraggedFeature<'_> {
    /// Measures the distance on the screen from `cursor` to the feature, in pixels; infinite if the feature is not in
    /// the picture.
    pub fn distance_px(&self, near: [f64; 2], cursor: DVec2) -> f64 {
        match self.taken.feature {
            Feature::Shadow | Feature::Hotspot => self.nearest_on_path_px(near, cursor),
            Feature::Highlight | Feature::Diffuse => {
                self.nearest_aligned_pixel(near[0], cursor).map_or(f64::INFINITY, |pixel| pixel.distance(cursor))
            }
        }
    }

    /// Measures the distance in pixels from the cursor to the nearest visible surface point that lies on the feature's
    /// light path.
    fn nearest_on_path_px(&self, near: [f64; 2], cursor: DVec2) -> f64 {
        let pivot = self.taken.pivot.and_then(|pivot| self.placed.locate(pivot, Some(near[1])));
        let (across, after) =
            pivot.map_or((self.taken.start_coords.cross_coords, 0.0), |pivot| (pivot.cross_coords, pivot.t));
        let distance = |position: &DVec3| {
            let pixel = self.pixel(*position)?;
            let seen = self.seen(pixel)?;
            // A hidden point is not in the picture.
            let is_seen = seen.position.distance(*position) < 1e-6 * self.bvh.posed.half_extent.length();
            is_seen.then(|| pixel.distance(cursor))
        };
        let Some(coords) = self.placed.locate(self.taken.to.position, Some(near[0])) else {
            return f64::INFINITY;
        };
        let hits = self.surfaces_on_path(&coords, across, after);
        hits.iter().filter_map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Finds all surface points on the light path at `across` whose `t` is larger than `after`.
    fn surfaces_on_path(&self, coords: &PointInLight, across: DVec2, after: f64) -> Vec<DVec3> {
        let hits = RefCell::new(Vec::new());
        let spend = |boxes| self.placed.work.spend_on_rays(boxes);
        let size = self.bvh.posed.half_extent.length();
        // Shadows fall on all surfaces, whatever the shadow links.
        let is_solid =
            |triangle: usize, weights: DVec3| self.bvh.passes_alpha_test(&self.bvh.triangle(triangle), weights);
        match self.placed.rays {
            LightRays::Bent(tube) => {
                let path = self.bvh.bent_path(tube, across.x, across.y);
                let last = &tube.segments[tube.segments.len() - 1].curve;
                let speed = 2.0 * last.d1.length() * tube.placement.world_per_tube;
                // An extended light goes on past its end as far as the scene reaches.
                let reach = 4.0 * (size + self.placed.source().length());
                let t_end = tube.n as f64 + if tube.end_mode() == EndMode::Extend { reach / speed } else { 0.0 };
                self.bvh.first_bent_hit_budgeted(&path, t_end, spend, |hit| {
                    if hit.t > after && is_solid(hit.triangle, hit.barycentrics) {
                        hits.borrow_mut().push(hit.position);
                    }
                    false
                });
            }
            rays => {
                let point = self.taken.to.position;
                let (from, level) = self.placed.straight_path(coords, across, point, 4.0 * size);
                let ray = level - from;
                let far = 4.0 * (size + from.length()) / ray.length();
                let t_of = |distance: f64| self.placed.locate(from + ray * distance, None).map(|coords| coords.t);
                let near = if matches!(rays, LightRays::Parallel(_)) { -far } else { 0.0 };
                self.bvh.first_hit_budgeted(from, ray, [near, far], spend, |hit| {
                    if t_of(hit.distance).is_some_and(|t| t > after) && is_solid(hit.triangle, hit.barycentrics) {
                        hits.borrow_mut().push(from + ray * hit.distance);
                    }
                    false
                });
            }
        }
        hits.into_inner()
    }

    /// Finds the pixel whose surface receives light along the mirror direction or the normal, by Newton's method over
    /// the picture from the cursor. `None` if the method does not converge.
    fn nearest_aligned_pixel(&self, near_t: f64, cursor: DVec2) -> Option<DVec2> {
        let mut pixel = cursor;
        for _ in 0..20 {
            let off = self.direction_error(pixel, near_t)?;
            let enough = if self.taken.feature == Feature::Diffuse { ALIGNED_RADIANS } else { 1e-9 };
            if off.length() <= enough {
                return Some(pixel);
            }
            let beside = |step: DVec2| Some((self.direction_error(pixel + step, near_t)? - off) / BESIDE_PX);
            let slope = DMat2::from_cols(beside(DVec2::X * BESIDE_PX)?, beside(DVec2::Y * BESIDE_PX)?);
            if slope.determinant().abs() < 1e-300 {
                return None;
            }
            let step = slope.inverse() * off;
            let longest = 0.1 * f64::from(self.view.size[0]);
            pixel -= step.clamp_length_max(longest);
            if step.length() < 1e-9 {
                return Some(pixel);
            }
        }
        None
    }

    /// Computes the deviation of the light at a pixel from the mirror direction or the normal, in radians along two
    /// axes across it.
    fn direction_error(&self, pixel: DVec2, near_t: f64) -> Option<DVec2> {
        let seen = self.seen(pixel)?;
        let coords = self.placed.locate(seen.position, Some(near_t))?;
        let target = self.taken.feature.target_direction(&seen);
        let (right, up) = target.any_orthonormal_pair();
        (coords.to_light.dot(target) > 0.0).then(|| DVec2::new(coords.to_light.dot(right), coords.to_light.dot(up)))
    }

    fn seen(&self, pixel: DVec2) -> Option<SeenPoint> {
        let Viewport { camera, size } = self.view;
        let spend = |boxes| self.placed.work.spend_on_rays(boxes);
        self.bvh.visible_point_budgeted(&ViewRay::new(camera, *size, pixel, self.placed.origin_in_world), spend)
    }

    fn pixel(&self, position: DVec3) -> Option<DVec2> {
        pixel_of(&self.view.camera, self.view.size, position, self.placed.origin_in_world)
    }
}
