//! Rays through points of a picture.

use glam::{DVec2, DVec3};
use scene::{Projection, View};

/// What a camera sees through one point of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewRay {
    /// In scene space.
    pub origin: DVec3,
    /// One unit long along the view axis, so that lengths of it are depths.
    pub direction: DVec3,
    /// Depths of the near and the far plane.
    pub range: [f64; 2],
}

impl ViewRay {
    /// Through `pixel`, in pixels from the picture's top left corner.
    pub fn new(view: &View, pixel: DVec2, scene_origin: DVec3) -> Self {
        let (width, height) = (f64::from(view.width), f64::from(view.height));
        let (mut x, mut y) = ((2.0 * pixel.x / width - 1.0) * width / height, 1.0 - 2.0 * pixel.y / height);
        // `y` reaches from -1 to 1 over what the camera frames, but over its width where the picture is narrower.
        if let Some(framed) = view.camera.projection.aspect_ratio().filter(|framed| width < framed * height) {
            let taller = framed * height / width;
            (x, y) = (x * taller, y * taller);
        }
        let world_from_camera = view.camera.world_from_camera();
        let (axes, eye) = (world_from_camera.matrix3, world_from_camera.translation - scene_origin);
        match view.camera.projection {
            Projection::Perspective { yfov, znear, zfar, .. } => {
                let half = libm::tan(yfov / 2.0);
                let direction = axes * DVec3::new(x * half, y * half, -1.0);
                let range = [znear, zfar.unwrap_or(f64::INFINITY)];
                Self { origin: eye, direction, range }
            }
            Projection::Orthographic { ymag, znear, zfar, .. } => {
                let origin = eye + axes * DVec3::new(x * ymag, y * ymag, 0.0);
                Self { origin, direction: -axes.z_axis, range: [znear, zfar] }
            }
        }
    }
}

/// Where sample `index` of `count` lies in a pixel, from its top left corner: a Fibonacci lattice, centred, so
/// that one sample is the pixel's centre.
pub(crate) fn sample_in_pixel(index: u32, count: u32) -> DVec2 {
    const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    let from_middle = f64::from(index) + 0.5 - f64::from(count) / 2.0;
    let across = (0.5 + from_middle * INVERSE_GOLDEN_RATIO).rem_euclid(1.0);
    DVec2::new(0.5 + from_middle / f64::from(count), across)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use scene::{Aov, Camera, ViewSlot};

    use super::*;

    /// The same numbers as in render's camera.rs and the page's camera.test.ts: a camera that frames 2 by 1.
    #[test]
    fn all_that_a_camera_frames_is_in_the_picture() {
        let yfov = 2.0 * libm::atan(0.5);
        let perspective = Projection::Perspective { yfov, aspect_ratio: Some(2.0), znear: 0.1, zfar: None };
        let orthographic =
            Projection::Orthographic { ymag: 0.5, aspect_ratio: Some(2.0), znear: 0.0, zfar: 9.0 };
        for (width, height, x, y) in
            [(100, 100, 75.0, 37.5), (400, 100, 250.0, 25.0), (200, 100, 150.0, 25.0)]
        {
            for projection in [perspective, orthographic] {
                let (translation, rotation) = (DVec3::ZERO, DQuat::IDENTITY);
                let camera = Camera { name: String::new(), translation, rotation, projection };
                let slot = ViewSlot::default();
                let view = View {
                    camera,
                    width,
                    height,
                    samples: 1,
                    aov: Aov::Depth,
                    light: 0,
                    fill: 1.0,
                    exposure: 0.0,
                    slot,
                };
                let ray = ViewRay::new(&view, DVec2::new(x, y), DVec3::ZERO);
                let point = ray.origin + ray.direction;
                assert!(
                    point.abs_diff_eq(DVec3::new(0.5, 0.25, -1.0), 1e-12),
                    "{width}x{height} {projection:?}: {point}"
                );
            }
        }
    }
}
