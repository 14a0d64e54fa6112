//! Cameras as matrices and rays, composed in f64.

use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4, Mat4};
use scene::Projection;

use crate::{RenderError, View};

/// One of the samples of each pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Offset from the center of each pixel, in pixels, right and down.
    pub offset: DVec2,
    /// Share of the picture.
    pub weight: f32,
}

impl Sample {
    /// Sample at the center of each pixel, the only one of its picture.
    pub const ONLY: Self = Self { offset: DVec2::ZERO, weight: 1.0 };

    /// Returns sample `index` of `count`.
    pub fn new(index: u32, count: u32) -> Self {
        Self { offset: sample_offset(index, count), weight: 1.0 / count as f32 }
    }
}

/// Camera of a sample in scene space, in f32: clip coordinates of points, and the ray through each pixel. The ray of
/// pixel (x, y) of the target has the origin `ray_origin + x ray_origin_dx + y ray_origin_dy`; its direction likewise,
/// of length 1 along the view axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SampleView {
    pub clip_from_scene: Mat4,
    pub ray_origin: [f32; 3],
    pub ray_origin_dx: [f32; 3],
    pub ray_origin_dy: [f32; 3],
    pub ray_direction: [f32; 3],
    pub ray_direction_dx: [f32; 3],
    pub ray_direction_dy: [f32; 3],
    /// [a, b, c, d] of the distance (a + b z) / (c + d z) along the view axis.
    pub depth_from_z: [f32; 4],
    /// First pixel of the target in the picture.
    pub tile_origin: [f32; 2],
    /// [`Sample::weight`].
    pub weight: f32,
    /// [`View::fill`].
    pub fill_factor: f32,
}

/// A camera with the size of its picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraRaster {
    pub world_from_camera: DAffine3,
    pub projection: Projection,
    pub width: u32,
    pub height: u32,
}

impl CameraRaster {
    pub fn new(view: &View) -> Result<Self, RenderError> {
        let invalid = |why| Err(RenderError::InvalidView(why));
        if view.width == 0 || view.height == 0 {
            return invalid("it has no pixels; give it a width and a height");
        }
        if view.samples == 0 {
            return invalid("it has no samples; give it at least 1 a pixel");
        }
        if !View::FILL_RANGE.contains(&view.fill) {
            return invalid("its factor of the fill is outside its domain; give one from 0 to 1000000");
        }
        if !View::EXPOSURE_RANGE.contains(&view.exposure) {
            return invalid("its exposure is outside its domain; give one from -32 to 32 stops");
        }
        let aspect_ratio = view.camera.projection.aspect_ratio();
        let has_sound_frame = aspect_ratio.is_none_or(|aspect| aspect > 0.0 && aspect.is_finite());
        let (world_from_camera, projection) = (view.camera.world_from_camera(), view.camera.projection);
        let is_sound = match projection {
            Projection::Perspective { yfov, znear, zfar, .. } => {
                yfov > 0.0 && yfov < std::f64::consts::PI && znear > 0.0 && zfar.is_none_or(|f| f > znear)
            }
            Projection::Orthographic { ymag, znear, zfar, .. } => ymag > 0.0 && znear >= 0.0 && zfar > znear,
        };
        if !has_sound_frame || !is_sound || !world_from_camera.is_finite() {
            return invalid("its camera has numbers outside their domains; correct the camera");
        }
        Ok(Self { world_from_camera, projection, width: view.width, height: view.height })
    }

    /// Returns half the width and height of the view: at distance 1 in perspective, at any distance in orthographic
    /// projection.
    fn half_size(&self) -> DVec2 {
        let aspect = f64::from(self.width) / f64::from(self.height);
        let y = match self.projection {
            Projection::Perspective { yfov, .. } => (yfov / 2.0).tan(),
            Projection::Orthographic { ymag, .. } => ymag,
        };
        // A picture narrower than the camera's frame keeps the frame's width.
        let y = y * self.projection.aspect_ratio().map_or(1.0, |framed| (framed / aspect).max(1.0));
        DVec2::new(y * aspect, y)
    }

    /// Returns the projection with reversed z: 1 at the near plane, 0 at the far plane or at infinity.
    pub fn clip_from_world(&self) -> DMat4 {
        let scale = self.half_size().recip();
        // z_clip = a z + b and w_clip = c z + d, for z in camera space.
        let [a, b, c, d] = match self.projection {
            Projection::Perspective { znear, zfar: None, .. } => [0.0, znear, -1.0, 0.0],
            Projection::Perspective { znear, zfar: Some(zfar), .. } => {
                let k = znear / (zfar - znear);
                [k, k * zfar, -1.0, 0.0]
            }
            Projection::Orthographic { znear, zfar, .. } => [1.0 / (zfar - znear), zfar / (zfar - znear), 0.0, 1.0],
        };
        let clip_from_camera = DMat4::from_cols(
            DVec4::new(scale.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale.y, 0.0, 0.0),
            DVec4::new(0.0, 0.0, a, c),
            DVec4::new(0.0, 0.0, b, d),
        );
        clip_from_camera * self.world_from_camera.inverse()
    }

    /// Returns the view of `sample`, in a target whose first pixel is `tile_origin` of the picture. `fill_factor` is
    /// [`View::fill`].
    pub fn sample_view(
        &self,
        sample: Sample,
        fill_factor: f64,
        scene_origin: DVec3,
        tile_origin: [u32; 2],
    ) -> Result<SampleView, RenderError> {
        let jitter = sample.offset;
        let pixel = DVec2::new(2.0 / f64::from(self.width), -2.0 / f64::from(self.height));
        // The sample of pixel (0, 0) in normalized device coordinates.
        let first = (DVec2::splat(0.5) + jitter) * pixel + DVec2::new(-1.0, 1.0);
        let shift = DMat4::from_translation((-jitter * pixel).extend(0.0));
        let clip_from_scene = shift * self.clip_from_world() * DMat4::from_translation(scene_origin);

        let half = self.half_size();
        let axes = self.world_from_camera.matrix3;
        let (dx, dy) = (axes.x_axis * half.x * pixel.x, axes.y_axis * half.y * pixel.y);
        let corner = axes.x_axis * half.x * first.x + axes.y_axis * half.y * first.y;
        let eye = self.world_from_camera.translation - scene_origin;
        let forward = -axes.z_axis;
        let (origins, directions, depth_from_z) = match self.projection {
            Projection::Perspective { znear, zfar, .. } => {
                let k = zfar.map_or(0.0, |f| znear / (f - znear));
                let scale = zfar.map_or(znear, |f| f * k);
                ([eye, DVec3::ZERO, DVec3::ZERO], [forward + corner, dx, dy], [scale, 0.0, k, 1.0])
            }
            Projection::Orthographic { znear, zfar, .. } => {
                let depth_from_z = [zfar, znear - zfar, 1.0, 0.0];
                ([eye + corner, dx, dy], [forward, DVec3::ZERO, DVec3::ZERO], depth_from_z)
            }
        };
        let [ray_origin, ray_origin_dx, ray_origin_dy] = origins.map(|v| v.as_vec3().to_array());
        let [ray_direction, ray_direction_dx, ray_direction_dy] = directions.map(|v| v.as_vec3().to_array());
        let view = SampleView {
            clip_from_scene: clip_from_scene.as_mat4(),
            ray_origin,
            ray_origin_dx,
            ray_origin_dy,
            ray_direction,
            ray_direction_dx,
            ray_direction_dy,
            depth_from_z: depth_from_z.map(|x| x as f32),
            tile_origin: tile_origin.map(|x| x as f32),
            weight: sample.weight,
            fill_factor: fill_factor as f32,
        };
        let rays = [ray_origin, ray_origin_dx, ray_origin_dy, ray_direction, ray_direction_dx, ray_direction_dy];
        let is_finite = rays.as_flattened().iter().chain(&view.depth_from_z).all(|x| x.is_finite());
        if is_finite && view.clip_from_scene.is_finite() {
            Ok(view)
        } else {
            Err(RenderError::InvalidView("its camera leaves the range of f32; bring it to the scene's size"))
        }
    }

    /// Returns all pixels, as `[x, y, width, height]`.
    pub fn all_pixels(&self) -> [u32; 4] {
        [0, 0, self.width, self.height]
    }

    /// Returns the pixels that the convex hull of `corners` may touch, as `[x, y, width, height]`; of size 0 if it
    /// touches none.
    ///
    /// Returns all pixels if a corner is behind the camera, since its projection is meaningless, unless all of the hull
    /// is behind the camera or beyond one side of the picture.
    pub fn bounds_of(&self, corners_in_world: &[DVec3]) -> [u32; 4] {
        let clip_from_world = self.clip_from_world();
        let clip = || corners_in_world.iter().map(|corner| clip_from_world * corner.extend(1.0));
        // A margin of one pixel on each side, as below.
        let edge = |pixels: u32| 1.0 + 4.0 / f64::from(pixels);
        let (x, y) = (edge(self.width), edge(self.height));
        let beyond = |is: &dyn Fn(DVec4) -> bool| clip().all(is);
        if beyond(&|p| p.w < 0.0)
            || beyond(&|p| p.x > x * p.w)
            || beyond(&|p| p.x < -x * p.w)
            || beyond(&|p| p.y > y * p.w)
            || beyond(&|p| p.y < -y * p.w)
        {
            return [0; 4];
        }
        let size = DVec2::new(f64::from(self.width), f64::from(self.height));
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for clip in clip() {
            // The near plane has z = w. Also false for NaN.
            if !(clip.w > 0.0 && clip.z <= clip.w) {
                return self.all_pixels();
            }
            let at = (DVec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * size;
            low = low.min(at);
            high = high.max(at);
        }
        // A pixel's samples are up to half a pixel from its center, and f32 rounds.
        let low = (low.floor() - 1.0).clamp(DVec2::ZERO, size).as_uvec2();
        let high = (high.ceil() + 1.0).clamp(DVec2::ZERO, size).as_uvec2();
        let extent = high.saturating_sub(low);
        [low.x, low.y, extent.x, extent.y]
    }
}

/// Returns the offset of sample `index` of `count` from the pixel's center, in pixels.
///
/// Samples form a centered Fibonacci lattice, so their mean is the center. A single sample is the center itself.
fn sample_offset(index: u32, count: u32) -> DVec2 {
    const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    let from_middle = f64::from(index) + 0.5 - f64::from(count) / 2.0;
    let along = (0.5 + from_middle * INVERSE_GOLDEN_RATIO).rem_euclid(1.0);
    DVec2::new(from_middle / f64::from(count), along - 0.5)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    #[test]
    fn one_sample_is_the_centre_and_many_fill_the_pixel() {
        assert_eq!(sample_offset(0, 1), DVec2::ZERO);
        for count in [2, 3, 4, 16, 61] {
            let offsets: Vec<_> = (0..count).map(|i| sample_offset(i, count)).collect();
            assert!(offsets.iter().all(|o| o.abs().max_element() <= 0.5));
            let mean = offsets.iter().sum::<DVec2>() / f64::from(count);
            // Samples mirror each other about the center; the half-open edge can leave one pair unmatched.
            assert!(mean.abs().max_element() <= 1.0 / f64::from(count), "{count}: {mean}");
            // Each of the `count` columns holds one sample; each quadrant holds its share, within two.
            for (sx, sy) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let there = offsets.iter().filter(|o| o.x * sx > 0.0 && o.y * sy > 0.0).count();
                assert!(there.abs_diff(count as usize / 4) <= 2, "{count}: {there}");
            }
        }
    }

    #[test]
    fn rays_and_matrix_agree() {
        // A point on a sample's ray must project to the pixel's center, at the depth that z stands for.
        let world_from_camera = DAffine3 {
            matrix3: DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(-0.3),
            translation: DVec3::new(4.0, 5.0, 6.0),
        };
        let projections = [
            Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 0.1, zfar: None },
            Projection::Perspective { yfov: 0.8, aspect_ratio: Some(2.0), znear: 0.1, zfar: None },
            Projection::Perspective { yfov: 1.6, aspect_ratio: None, znear: 0.5, zfar: Some(40.0) },
            Projection::Orthographic { ymag: 3.0, aspect_ratio: None, znear: 0.0, zfar: 30.0 },
            Projection::Orthographic { ymag: 3.0, aspect_ratio: Some(2.0), znear: 0.0, zfar: 30.0 },
        ];
        for projection in projections {
            let raster = CameraRaster { world_from_camera, projection, width: 7, height: 5 };
            let scene_origin = DVec3::new(3.0, -2.0, 1.0);
            let sample = Sample { offset: DVec2::new(0.3, -0.2), weight: 1.0 };
            let view = raster.sample_view(sample, 1.0, scene_origin, [0, 0]).unwrap();
            let clip_from_scene = view.clip_from_scene;
            let along = |base: [f32; 3], dx: [f32; 3], dy: [f32; 3], x: f32, y: f32| {
                glam::Vec3::from(base) + glam::Vec3::from(dx) * x + glam::Vec3::from(dy) * y
            };
            for (x, y, depth) in [(0.0, 0.0, 1.0), (6.0, 4.0, 7.0), (2.0, 3.0, 25.0)] {
                let u = &view;
                let origin = along(u.ray_origin, u.ray_origin_dx, u.ray_origin_dy, x, y);
                let direction = along(u.ray_direction, u.ray_direction_dx, u.ray_direction_dy, x, y);
                let clip = clip_from_scene * (origin + direction * depth).extend(1.0);
                let ndc = clip / clip.w;
                // f32 rounds coordinates of size 30 by 2e-6, and one of 7 pixels is 2 / 7 of the unit: 1e-5 pixels.
                let pixel = [(ndc.x * 0.5 + 0.5) * 7.0 - 0.5, (0.5 - ndc.y * 0.5) * 5.0 - 0.5];
                assert!((pixel[0] - x).abs() < 1e-4 && (pixel[1] - y).abs() < 1e-4, "{projection:?} {pixel:?}");
                let [a, b, c, d] = view.depth_from_z;
                let back = (a + b * ndc.z) / (c + d * ndc.z);
                // Without a far plane the error of z is relative. With one, z = 0 is the far plane, and 6e-8 of its
                // distance is lost.
                assert!((back - depth).abs() < 1e-4 * depth, "{projection:?} {back} {depth}");
            }
        }
    }

    /// Uses the numbers of scene's `view_ray.rs` and the page's `camera.test.ts`: a camera that frames 2 by 1.
    #[test]
    fn all_that_a_camera_frames_is_in_the_picture() {
        let yfov = 2.0 * 0.5_f64.atan();
        let perspective = Projection::Perspective { yfov, aspect_ratio: Some(2.0), znear: 0.1, zfar: None };
        let orthographic = Projection::Orthographic { ymag: 0.5, aspect_ratio: Some(2.0), znear: 0.0, zfar: 9.0 };
        for (width, height, x, y) in [(100, 100, 75.0, 37.5), (400, 100, 250.0, 25.0), (200, 100, 150.0, 25.0)] {
            for projection in [perspective, orthographic] {
                let raster = CameraRaster { world_from_camera: DAffine3::IDENTITY, projection, width, height };
                let clip = raster.clip_from_world() * DVec4::new(0.5, 0.25, -1.0, 1.0);
                let pixel =
                    (DVec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * DVec2::new(width.into(), height.into());
                assert!(pixel.abs_diff_eq(DVec2::new(x, y), 1e-12), "{width}x{height} {projection:?}: {pixel}");
            }
        }
    }

    #[test]
    fn bounds_hold_what_they_are_of() {
        let projection = Projection::Perspective { yfov: 1.0, aspect_ratio: None, znear: 0.1, zfar: None };
        let raster = CameraRaster { world_from_camera: DAffine3::IDENTITY, projection, width: 100, height: 100 };
        let pixels_a_unit = 50.0 / 0.5_f64.tan();
        let [x, y, width, height] = raster.bounds_of(&[DVec3::new(0.1, 0.0, -1.0), DVec3::new(0.2, 0.1, -1.0)]);
        assert_eq!(x, (50.0 + 0.1 * pixels_a_unit).floor() as u32 - 1);
        assert_eq!(x + width, (50.0 + 0.2 * pixels_a_unit).ceil() as u32 + 1);
        assert_eq!((y + height, y), (51, (50.0 - 0.1 * pixels_a_unit).floor() as u32 - 1));
        // A hull partly behind the camera gives all pixels; one entirely behind it or outside the picture gives none.
        let [behind, ahead, aside] = [1.0, -1.0, 0.0].map(|z| DVec3::new(0.0, 0.0, z));
        let all = [0, 0, 100, 100];
        assert_eq!(raster.bounds_of(&[behind, ahead]), all);
        assert_eq!(raster.bounds_of(&[behind]), [0; 4]);
        assert_eq!(raster.bounds_of(&[]), [0; 4]);
        for turn in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y] {
            let far = 9.0 * turn;
            assert_eq!(raster.bounds_of(&[far + ahead, 2.0 * far + ahead, far + behind]), [0; 4], "{turn}");
            // Each corner is beyond the side or behind the camera, but the segment between them is ahead.
            assert_eq!(raster.bounds_of(&[far + behind, ahead - far]), all, "{turn}");
            // Barely visible: within the pixel that rounding may take.
            let edge = turn * (0.5_f64.tan() * 1.01);
            assert!(raster.bounds_of(&[edge + ahead]) != [0; 4], "{turn}");
        }
        assert_eq!(raster.bounds_of(&[aside + 9.0 * DVec3::X, ahead]), all, "in the viewer's plane");
    }
}
