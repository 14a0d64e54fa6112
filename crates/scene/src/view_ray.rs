//! Rays through points of a picture, and the inverse projection.

use glam::{DVec2, DVec3};

use crate::{Camera, Projection};

/// Ray of a camera through one point of a picture.
#[derive(Clone, Copy, Debug)]
pub struct ViewRay {
    /// In scene space.
    pub origin: DVec3,
    /// In scene space, of length 1 along the view axis, so that ray parameters are depths.
    pub direction: DVec3,
    pub depth_range: [f64; 2],
}

impl ViewRay {
    /// Makes the ray through `pixel` of a picture of `size`, in pixels from the top left corner. `origin_in_world` is
    /// the origin of scene space.
    pub fn new(camera: &Camera, size: [u32; 2], pixel: DVec2, origin_in_world: DVec3) -> Self {
        let size = DVec2::from(size.map(f64::from));
        let DVec2 { x, y } = (2.0 * pixel - size) * DVec2::new(1.0, -1.0) / size.y * frame_scale(camera, size);
        let world_from_camera = camera.world_from_camera();
        let (axes, eye) = (world_from_camera.matrix3, world_from_camera.translation - origin_in_world);
        match camera.projection {
            Projection::Perspective { yfov, znear, zfar, .. } => {
                let half = libm::tan(yfov / 2.0);
                let direction = axes * DVec3::new(x * half, y * half, -1.0);
                let range = [znear, zfar.unwrap_or(f64::INFINITY)];
                Self { origin: eye, direction, depth_range: range }
            }
            Projection::Orthographic { ymag, znear, zfar, .. } => {
                let origin = eye + axes * DVec3::new(x * ymag, y * ymag, 0.0);
                Self { origin, direction: -axes.z_axis, depth_range: [znear, zfar] }
            }
        }
    }
}

/// Projects a point in scene space to pixels from the top left corner of a picture. `None` if it is not in front of the
/// eye. The inverse of [`ViewRay::new`].
pub fn pixel_of(camera: &Camera, size: [u32; 2], point: DVec3, origin_in_world: DVec3) -> Option<DVec2> {
    let size = DVec2::from(size.map(f64::from));
    let world_from_camera = camera.world_from_camera();
    let from_eye = point - (world_from_camera.translation - origin_in_world);
    let in_camera = world_from_camera.matrix3.transpose() * from_eye;
    let across = match camera.projection {
        Projection::Perspective { yfov, .. } => {
            let depth = -in_camera.z;
            if depth <= 0.0 {
                return None;
            }
            in_camera.truncate() / (depth * libm::tan(yfov / 2.0))
        }
        Projection::Orthographic { ymag, .. } => in_camera.truncate() / ymag,
    };
    Some((across / frame_scale(camera, size) * size.y * DVec2::new(1.0, -1.0) + size) / 2.0)
}

/// Returns half the height of a picture as a share of half the height of the camera's frame: more than 1 if the picture
/// is narrower than the frame.
fn frame_scale(camera: &Camera, size: DVec2) -> f64 {
    camera.projection.aspect_ratio().map_or(1.0, |framed| (framed * size.y / size.x).max(1.0))
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    /// The camera frames 2 by 1. The numbers are the same in render's camera.rs and the page's camera.test.ts.
    #[test]
    fn all_that_a_camera_frames_is_in_the_picture() {
        let yfov = 2.0 * libm::atan(0.5);
        let perspective = Projection::Perspective { yfov, aspect_ratio: Some(2.0), znear: 0.1, zfar: None };
        let orthographic = Projection::Orthographic { ymag: 0.5, aspect_ratio: Some(2.0), znear: 0.0, zfar: 9.0 };
        for (width, height, x, y) in [(100, 100, 75.0, 37.5), (400, 100, 250.0, 25.0), (200, 100, 150.0, 25.0)] {
            for projection in [perspective, orthographic] {
                let (translation, rotation) = (DVec3::ZERO, DQuat::IDENTITY);
                let camera = Camera { name: String::new(), translation, rotation, projection };
                let (size, pixel) = ([width, height], DVec2::new(x, y));
                let ray = ViewRay::new(&camera, size, pixel, DVec3::ZERO);
                let point = ray.origin + ray.direction;
                assert!(
                    point.abs_diff_eq(DVec3::new(0.5, 0.25, -1.0), 1e-12),
                    "{width}x{height} {projection:?}: {point}"
                );
                let back = pixel_of(&camera, size, point, DVec3::ZERO).expect("before the eye");
                assert!(back.abs_diff_eq(pixel, 1e-9), "{back}");
            }
        }
    }
}
