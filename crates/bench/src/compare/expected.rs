//! Expected value of each pixel, by the reference.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use light::{Light, LightError, Tube};
use rayon::prelude::*;
use reference::{LightSample, Reference, ReferenceLight, ShadedPoint, evaluate_brdf};
use scene::{Fill, PosedScene, Scene, View};

use super::crossing::Crossing;
use super::{PixelVerdict, RenderedSubject, rgb};

/// Scene under one light and no fill, seen by a camera.
#[derive(Clone, Debug)]
pub struct ComparisonSubject {
    /// Name for reports and files.
    pub name: String,
    /// The fill is not used.
    pub scene: Scene,
    /// The only light; its shadows are compared.
    pub light: Light,
    /// One sample per pixel, at its center; the AOV is not used.
    pub view: View,
}

impl ComparisonSubject {
    /// Makes a subject without the fill of `scene`, which would make errors in the light's share look smaller.
    pub fn new(name: &str, scene: Scene, light: Light, view: View) -> Self {
        let fill = Fill { sky: DVec3::ZERO, ground: DVec3::ZERO };
        let view = View { samples: 1, light: 0, ..view };
        Self { name: name.into(), scene: Scene { fill, ..scene }, light, view }
    }
}

/// The reference's picture of a [`ComparisonSubject`], with the data that a comparison needs.
#[derive(Debug)]
pub struct ExpectedPicture<'a> {
    pub(super) subject: &'a ComparisonSubject,
    pub(super) reference: Reference,
    pub(super) source: ReferenceLight,
    pub(super) tube: Tube<f64>,
    /// Half the diagonal of the scene's bounds.
    scene_radius: f64,
    /// Pixels in rows from the top; `None` in the background.
    pub(super) pixels: Vec<Option<ExpectedPixel>>,
    /// Crossings of scan lines with shadow edges.
    pub(super) crossings: Vec<Crossing>,
}

/// Surface and light at the center of a pixel.
#[derive(Clone, Debug)]
pub(super) struct ExpectedPixel {
    pub surface: ShadedPoint,
    /// `None` outside the light.
    pub light: Option<ExpectedLight>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct ExpectedLight {
    pub sample: LightSample,
    /// Radiance without shadows.
    pub unshadowed: DVec3,
    /// Radiance with the shadow.
    pub radiance: DVec3,
}

impl ExpectedPixel {
    pub fn radiance(&self) -> DVec3 {
        self.light.map_or(DVec3::ZERO, |light| light.radiance)
    }

    /// True if the light reaches the point. `None` outside the light.
    pub fn is_visible(&self) -> Option<bool> {
        self.light.map(|light| light.sample.is_visible)
    }

    /// True if the light reaches the point. `None` outside the light, or if the point would reflect none of it.
    pub fn lit(&self) -> Option<bool> {
        self.light.filter(|light| light.unshadowed != DVec3::ZERO).map(|light| light.sample.is_visible)
    }
}

impl<'a> ExpectedPicture<'a> {
    /// Renders `subject` on all cores. Calls `row_done` for each row, from any thread.
    pub fn new(subject: &'a ComparisonSubject, row_done: impl Fn() + Sync) -> Result<Self, LightError> {
        let tube = Tube::new(&subject.light)?;
        let source = ReferenceLight::Bendy(tube.clone());
        let posed = scene::pose(subject.scene.clone(), 0.0);
        let reach = posed.half_extent.length();
        let mut expected = Self {
            subject,
            reference: Reference::new(posed),
            source,
            tube,
            scene_radius: reach,
            pixels: Vec::new(),
            crossings: Vec::new(),
        };
        let (width, height) = expected.size();
        let row = |y: usize| {
            let centre = |x: usize| DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let seen: Vec<_> = (0..width).map(|x| expected.seen(centre(x))).collect();
            row_done();
            seen
        };
        expected.pixels = (0..height).into_par_iter().flat_map_iter(row).collect();
        expected.crossings = expected.find_crossings();
        Ok(expected)
    }

    /// Returns what is drawn in the picture.
    pub fn subject(&self) -> &'a ComparisonSubject {
        self.subject
    }

    /// Returns the posed scene of the subject, to draw it with another renderer.
    pub fn posed(&self) -> &Arc<PosedScene> {
        &self.reference.bvh.posed
    }

    /// Returns the width and height in pixels.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.subject.view.width as usize, self.subject.view.height as usize)
    }

    /// Returns the surface and light seen through a point of the picture, in pixels from its top left corner.
    pub(super) fn seen(&self, pixel: DVec2) -> Option<ExpectedPixel> {
        let surface = self.reference.surface(&self.subject.view, pixel)?;
        let filter = self.source.light_profile();
        let light = self.reference.sample(&self.source, &surface).map(|sample| {
            let lobes = [filter.diffuse, filter.specular];
            let unshadowed = evaluate_brdf(&surface, sample.coords.direction, lobes) * sample.irradiance;
            let visibility = if sample.is_visible { 1.0 } else { 0.0 };
            ExpectedLight { sample, unshadowed, radiance: unshadowed * filter.arriving(visibility) }
        });
        Some(ExpectedPixel { surface, light })
    }

    /// Tests if the GPU sees the same surface. Returns the verdict if not, and `None` if it does.
    ///
    /// A rasterizer snaps corners to 1/256 pixel, so a pixel can show the surface at that distance: 2^-7 of the step to
    /// the adjacent pixels, over both axes. In addition, f32 rounds positions of the scene's size and rays of the
    /// depth's length, a few ulps together, divided by the cosine between ray and surface. Normals are packed to 2 x 16
    /// bits, 2^-15 along each axis.
    pub(super) fn surface_mismatch(
        &self,
        drawn: &RenderedSubject,
        pixel: usize,
        surface: &ShadedPoint,
    ) -> Option<PixelVerdict> {
        let (mut depth_step, mut normal_step) = (0.0_f64, 0.0_f64);
        for beside in self.adjacent_surfaces(pixel) {
            depth_step = depth_step.max((beside.depth - surface.depth).abs());
            normal_step = normal_step.max(beside.normal.distance(surface.normal));
        }
        let cosine = surface.geometric_normal.dot(surface.to_eye).abs().max(1e-3);
        let rounding = 2_f64.powi(-20) * (self.scene_radius + surface.depth) / cosine;
        let snapped = 2_f64.powi(-7);
        let depth_error = (rgb(&drawn.depth, pixel).x - surface.depth).abs();
        let normal_error = rgb(&drawn.normal, pixel).distance(surface.normal);
        let nothing = drawn.depth.pixels[pixel][3] == 0.0;
        if nothing || depth_error > rounding + snapped * depth_step {
            return Some(PixelVerdict::Silhouette);
        }
        if normal_error <= 2_f64.powi(-14) + snapped * normal_step {
            return None;
        }
        let twin = self.reference.bvh.first_hit(surface.position, -surface.to_eye, [-rounding, rounding], |hit| {
            hit.triangle != surface.triangle
        });
        Some(if twin.is_some() { PixelVerdict::Coincident } else { PixelVerdict::Silhouette })
    }

    /// Returns the surfaces of the pixels to the left, right, above and below.
    fn adjacent_surfaces(&self, pixel: usize) -> impl Iterator<Item = &ShadedPoint> {
        let (width, height) = self.size();
        let (x, y) = (pixel % width, pixel / width);
        let around = [
            (x > 0).then(|| pixel - 1),
            (x + 1 < width).then(|| pixel + 1),
            (y > 0).then(|| pixel - width),
            (y + 1 < height).then(|| pixel + width),
        ];
        around.into_iter().flatten().filter_map(|beside| self.pixels[beside].as_ref().map(|seen| &seen.surface))
    }
}
