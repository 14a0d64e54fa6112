//! Measures the distance of a pixel from a shadow edge, in texels of the shadow map.
//!
//! A shadow map resolves the edge of an occluder to a fraction of a texel, and a texel covers a patch of the receiver's
//! plane. That plane can extend past the surface. If the light sees a wall edge on, so that it is narrower than a
//! texel, the displaced edge lies on the plane only. So both are tested: the surface that the camera sees there, and
//! the plane.

use glam::{DVec2, DVec3};
use reference::ShadedPoint;
use scene::View;

use super::expected::ExpectedPixel;
use super::{ExpectedPicture, RenderedSubject};

/// Distances in texels at which an edge is searched around a pixel. If none is found up to the last, the distance is
/// infinite.
const RINGS: [f64; 12] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0];
const DIRECTIONS: u32 = 16;
/// Longest step along the light, in widths of a texel. If the light meets a plane edge on, the step along it grows
/// without bound, and every shadow would be near an edge. At an angle of 27 degrees a texel reaches this length;
/// `off_edge` judges surfaces at smaller angles.
const LONGEST_STEP: f64 = 2.0;

/// Steps of one texel over the plane of a surface, in world space: along v and along w.
struct Texel {
    v: DVec3,
    w: DVec3,
}

impl ExpectedPicture<'_> {
    /// Returns the smallest ring on which the reference's visibility differs from that of the pixel; infinity if it
    /// differs on none.
    pub(super) fn texels_to_edge(&self, drawn: &RenderedSubject, pixel: usize, seen: &ExpectedPixel) -> f64 {
        let Some(texel) = self.texel(&seen.surface, drawn.shadows.resolution) else { return f64::INFINITY };
        // Rings are slow for a picture that is wrong everywhere, and would find nothing there.
        if self.is_surrounded_by_wrong(drawn, pixel, seen) && !self.has_edge_around(seen, &texel) {
            return f64::INFINITY;
        }
        RINGS.into_iter().find(|&radius| self.has_edge_on_ring(seen, &texel, radius)).unwrap_or(f64::INFINITY)
    }

    /// True if there is an edge within `texels` texels of a pixel.
    pub(super) fn has_edge_within(&self, seen: &ExpectedPixel, resolution: u32, texels: f64) -> bool {
        self.texel(&seen.surface, resolution).is_some_and(|texel| {
            let mut rings = RINGS.into_iter().take_while(|radius| *radius <= texels);
            rings.any(|radius| self.has_edge_on_ring(seen, &texel, radius))
        })
    }

    fn has_edge_on_ring(&self, seen: &ExpectedPixel, texel: &Texel, radius: f64) -> bool {
        (0..DIRECTIONS).any(|k| {
            let direction = DVec2::from_angle(f64::from(k) / f64::from(DIRECTIONS) * std::f64::consts::TAU);
            let step = (texel.v * direction.x + texel.w * direction.y) * radius;
            let there = self.visible_beside(&seen.surface, step);
            there.into_iter().any(|there| there.is_some() && there != seen.is_visible())
        })
    }

    /// True if all eight adjacent pixels have the visibility of `seen` in the reference and the opposite one in the
    /// picture.
    fn is_surrounded_by_wrong(&self, drawn: &RenderedSubject, pixel: usize, seen: &ExpectedPixel) -> bool {
        let (width, height) = self.size();
        let (x, y) = (pixel % width, pixel / width);
        let wrong = |other: usize| {
            let expected = self.pixels[other].as_ref().and_then(ExpectedPixel::is_visible);
            expected == seen.is_visible() && expected != Some(drawn.visibility.pixels[other][0] >= 0.5)
        };
        let inside = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
        inside && (y - 1..=y + 1).all(|row| (x - 1..=x + 1).all(|column| wrong(row * width + column)))
    }

    /// True if the visibility of any pixel within the last ring differs from that of `seen`.
    fn has_edge_around(&self, seen: &ExpectedPixel, texel: &Texel) -> bool {
        let position = self.in_world(seen.surface.position);
        let Some(centre) = self.pixel_of(position) else { return true };
        let reach = [texel.v, texel.w, -texel.v, -texel.w].into_iter().map(|step| {
            let there = self.pixel_of(position + step * RINGS[RINGS.len() - 1]);
            there.map_or(f64::INFINITY, |there| there.distance(centre))
        });
        // A point of the ring is at most sqrt 2 times as far away as the farthest of the four.
        let reach = reach.fold(0.0, f64::max) * std::f64::consts::SQRT_2 + 1.0;
        let (width, height) = self.size();
        let span =
            |at: f64, size: usize| ((at - reach).max(0.0) as usize)..((at + reach).ceil().min(size as f64) as usize);
        span(centre.y, height).any(|y| {
            let row = &self.pixels[y * width..][span(centre.x, width)];
            row.iter().flatten().any(|other| other.is_visible() != seen.is_visible())
        })
    }

    /// Returns the steps of a texel on the plane of the surface.
    ///
    /// On the map a step is `(dv, dw)`, 2 / resolution for a texel. On the plane it is `R (dv v_hat + dw w_hat) + T ds`
    /// with T along the light path and `n . e = 0`.
    fn texel(&self, surface: &ShadedPoint, resolution: u32) -> Option<Texel> {
        let placement = &self.tube.placement;
        let root = self.tube.nearest_root(placement.tube_from_world(self.in_world(surface.position)))?;
        let normal = placement.rotation.transpose() * surface.geometric_normal;
        let towards = self.tube.path_direction_at(&root);
        let width = 2.0 * root.radius / f64::from(resolution);
        let in_world = |across: DVec3| {
            let along = -normal.dot(across) / normal.dot(towards);
            let longest = LONGEST_STEP * width;
            let step = across + towards * (if along.is_nan() { longest } else { along.clamp(-longest, longest) });
            placement.rotation * step * placement.world_per_tube
        };
        Some(Texel { v: in_world(root.v_hat * width), w: in_world(root.u_hat.cross(root.v_hat) * width) })
    }

    /// Returns the visibility at `step` from `surface` on its plane, and the visibility of the surface that the camera
    /// sees there if it is nearly at the same position. `None` outside the light.
    fn visible_beside(&self, surface: &ShadedPoint, step: DVec3) -> [Option<bool>; 2] {
        let position = surface.position + step;
        let pixel = self.pixel_of(self.in_world(position));
        let seen = pixel.and_then(|pixel| self.reference.surface(&self.subject.view, pixel));
        let seen = seen.filter(|seen| seen.position.distance(position) <= 0.25 * step.length());
        let visible = |surface: &ShadedPoint| Some(self.reference.sample(&self.source, surface)?.is_visible);
        let mut beside = *surface;
        beside.seen.position = position;
        [visible(&beside), seen.as_ref().and_then(visible)]
    }

    /// Returns the world position of a position in the reference's space, whose origin is that of the scene.
    fn in_world(&self, position: DVec3) -> DVec3 {
        self.reference.bvh.posed.origin_in_world + position
    }

    /// Returns the point of the picture that shows a world position; `None` behind the camera.
    fn pixel_of(&self, position_in_world: DVec3) -> Option<DVec2> {
        let View { camera, width, height, .. } = &self.subject.view;
        scene::pixel_of(camera, [*width, *height], position_in_world, DVec3::ZERO)
    }
}
