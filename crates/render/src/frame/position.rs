//! World positions of pixels, from their depths.

use glam::{DVec2, DVec3};
use scene::ViewRay;

use crate::{Aov, Picture, View};

/// Returns the AOV to draw for `aov`: positions are computed from depths.
pub(crate) fn rendered_aov(aov: Aov) -> Aov {
    if aov == Aov::Position { Aov::Depth } else { aov }
}

/// Replaces depths with positions, along the rays through the centers of `view`'s pixels. Their error is that of
/// depths, 6e-8 relative, plus the rounding of the position itself to f32.
pub(crate) fn from_depths(view: &View, picture: &mut Picture) {
    let size = [view.width, view.height];
    let ray = |x: f64, y: f64| {
        let ray = ViewRay::new(&view.camera, size, DVec2::new(x, y), DVec3::ZERO);
        (ray.origin, ray.direction)
    };
    // Origin and direction are linear in the pixel.
    let (first, right, below) = (ray(0.5, 0.5), ray(1.5, 0.5), ray(0.5, 1.5));
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        let [depth, .., alpha] = *pixel;
        if alpha == 0.0 {
            continue;
        }
        let (x, y) = (index % view.width as usize, index / view.width as usize);
        let at =
            |first: DVec3, right: DVec3, below: DVec3| first + (right - first) * x as f64 + (below - first) * y as f64;
        let (origin, direction) = (at(first.0, right.0, below.0), at(first.1, right.1, below.1));
        let [x, y, z] = (origin + direction * f64::from(depth)).as_vec3().to_array();
        *pixel = [x, y, z, alpha];
    }
}
