//! Compares the GPU's picture of a scene under one BendyLight with the reference's, pixel by pixel.
//!
//! Each pixel gets a verdict ([`PixelVerdict`]). Radiance is compared if both pictures see the same surface and no
//! shadow edge is near. Shadow edges are compared by their displacement, in texels of the shadow map and in pixels.

mod boundary;
mod crossing;
mod expected;
mod panels;
mod scan;
#[cfg(test)]
mod tests;

use glam::DVec3;
use light::{LightError, LightInstance};
use rayon::prelude::*;
use render::{Picture, RenderError, Renderer, ShadowFilter, ShadowSettings};
use scene::{Aov, View};
use serde::Serialize;

use crate::Quantiles;
use crate::compare::expected::ExpectedPixel;

pub use expected::{ComparisonSubject, ExpectedPicture};

/// Allowed displacement of a shadow edge, in texels of its map.
const TEXELS_ALLOWED: f64 = 1.5;

/// Visible error of a pixel's share of the light. A larger error is noticed, and flickers as things move.
const VISIBLE_ERROR: f32 = 0.1;

/// Weights of a shadow filter add up to 1 within some ulps.
const WEIGHT_EPSILON: f32 = 1e-6;

/// Verdict of the comparison on a pixel of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelVerdict {
    /// No surface in either picture.
    Background,
    /// Radiance is compared.
    Compared,
    /// Excluded: the two pictures see different surfaces.
    Silhouette,
    /// Excluded: two surfaces coincide within the precision of f32, and the two pictures see different ones.
    Coincident,
    /// Excluded: the pixel is inside the light in only one of the pictures.
    Rim,
    /// Excluded: a shadow edge is nearer than `TEXELS_ALLOWED`. A pixel on the right side of the edge is excluded up to
    /// that distance plus the radius of the shadow filter.
    Boundary,
    /// Compared: the pixel is lit instead of in shadow, and farther from the edge than that.
    Missed,
    /// Compared: the pixel is in shadow instead of lit, and farther from the edge than that.
    False,
    /// The picture has a number that is not finite.
    NotFinite,
}

/// Result of a comparison.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Comparison {
    /// Pixels that show a surface, in either picture.
    pub pixels: usize,
    /// Pixels inside the light by the reference.
    pub in_light: usize,
    /// Number of pixels excluded because the two pictures see different surfaces.
    pub silhouettes: usize,
    /// Number of pixels excluded because two surfaces coincide.
    pub coincident: usize,
    /// Number of pixels excluded because only one of the pictures has them inside the light.
    pub rim: usize,
    /// Number of pixels excluded because a shadow edge is near.
    pub boundary: usize,
    /// Number of pixels that are lit instead of in shadow, more than 1.5 texels from the edge.
    pub missed: usize,
    /// Number of pixels that are in shadow instead of lit, more than 1.5 texels from the edge.
    #[serde(rename = "false")]
    pub false_shadow: usize,
    /// Number of pixels with an error of more than a tenth of the light, where the reference has the same visibility
    /// for all 5 x 5 pixels around. This criterion does not depend on a map or on texels.
    pub off_edge: usize,
    /// Number of pixels with a number that is not finite.
    pub not_finite: usize,
    /// `sqrt(mean |gpu - reference|^2) / sqrt(mean |reference|^2)` over the compared pixels.
    pub radiance_rmse: f64,
    /// Distance in texels of the map to the shadow edge, for pixels on the wrong side of it; null if farther than 8.
    pub displacement_texels: Quantiles,
    /// Distance in pixels between the picture's edge and the reference's, perpendicular to it, at crossings of scan
    /// lines with shadow edges; null if farther than 6 along the line.
    pub displacement_pixels: Quantiles,
    /// One verdict per pixel.
    #[serde(skip)]
    pub verdicts: Vec<PixelVerdict>,
    /// Indices of the pixels that `off_edge` counts.
    #[serde(skip)]
    pub off_edge_pixels: Vec<usize>,
}

/// The GPU's pictures of a [`ComparisonSubject`].
#[derive(Clone, Debug)]
pub struct RenderedSubject {
    pub beauty: Picture,
    /// Distance along the view axis.
    pub depth: Picture,
    /// Shading normal.
    pub normal: Picture,
    /// Visibility of the light.
    pub visibility: Picture,
    /// Visibility at `scan::FINER` times the size. Every third row and column has the pixel centers of `visibility`.
    pub fine_visibility: Picture,
    /// Settings that the shadows were drawn with.
    pub shadows: ShadowSettings,
}

impl RenderedSubject {
    /// Draws the pictures of `subject`. The renderer already has its scene.
    pub fn new(
        renderer: &mut Renderer,
        subject: &ComparisonSubject,
        shadows: ShadowSettings,
    ) -> Result<Self, RenderError> {
        Self::under(renderer, subject, &subject.lights()?, shadows)
    }

    /// Draws the pictures under `lights`, of which the first should look like the subject's.
    pub fn under(
        renderer: &mut Renderer,
        subject: &ComparisonSubject,
        lights: &[LightInstance],
        shadows: ShadowSettings,
    ) -> Result<Self, RenderError> {
        renderer.set_shadow_settings(shadows)?;
        let mut draw = |aov, finer| {
            let View { width, height, .. } = subject.view;
            let view = View { aov, width: width * finer, height: height * finer, ..subject.view.clone() };
            renderer.render(&view, lights)
        };
        Ok(Self {
            beauty: draw(Aov::Beauty, 1)?,
            depth: draw(Aov::Depth, 1)?,
            normal: draw(Aov::Normal, 1)?,
            visibility: draw(Aov::Visibility, 1)?,
            fine_visibility: draw(Aov::Visibility, scan::FINER)?,
            shadows,
        })
    }

    fn radiance(&self, pixel: usize) -> DVec3 {
        rgb(&self.beauty, pixel)
    }
}

fn rgb(picture: &Picture, pixel: usize) -> DVec3 {
    let [r, g, b, _] = picture.pixels[pixel].map(f64::from);
    DVec3::new(r, g, b)
}

impl ExpectedPicture<'_> {
    /// Compares the GPU's pictures with the reference.
    pub fn compare(&self, drawn: &RenderedSubject) -> Comparison {
        let judged: Vec<_> = (0..self.pixels.len()).into_par_iter().map(|pixel| self.judge(drawn, pixel)).collect();
        let verdicts: Vec<_> = judged.iter().map(|judged| judged.0).collect();
        let count = |verdict| verdicts.iter().filter(|v| **v == verdict).count();
        let in_light = |seen: &&Option<ExpectedPixel>| seen.as_ref().is_some_and(|seen| seen.light.is_some());
        let off_edge_pixels: Vec<_> = (0..self.pixels.len()).filter(|&pixel| self.is_off_edge(drawn, pixel)).collect();
        Comparison {
            pixels: verdicts.len() - count(PixelVerdict::Background),
            in_light: self.pixels.iter().filter(in_light).count(),
            silhouettes: count(PixelVerdict::Silhouette),
            coincident: count(PixelVerdict::Coincident),
            rim: count(PixelVerdict::Rim),
            boundary: count(PixelVerdict::Boundary),
            missed: count(PixelVerdict::Missed),
            false_shadow: count(PixelVerdict::False),
            off_edge: off_edge_pixels.len(),
            not_finite: count(PixelVerdict::NotFinite),
            radiance_rmse: self.radiance_rmse(drawn, &verdicts),
            displacement_texels: Quantiles::of(judged.iter().filter_map(|judged| judged.1)),
            displacement_pixels: Quantiles::of(self.displacements(&drawn.fine_visibility)),
            verdicts,
            off_edge_pixels,
        }
    }

    /// Returns the verdict on a pixel, and its distance in texels from the shadow edge if it is on the wrong side.
    fn judge(&self, drawn: &RenderedSubject, pixel: usize) -> (PixelVerdict, Option<f64>) {
        let pictures = [&drawn.beauty, &drawn.depth, &drawn.normal, &drawn.visibility];
        if pictures.iter().any(|picture| picture.pixels[pixel].iter().any(|x| !x.is_finite())) {
            return (PixelVerdict::NotFinite, None);
        }
        let Some(seen) = &self.pixels[pixel] else {
            let nothing = drawn.depth.pixels[pixel][3] == 0.0;
            return (if nothing { PixelVerdict::Background } else { PixelVerdict::Silhouette }, None);
        };
        if let Some(why) = self.surface_mismatch(drawn, pixel, &seen.surface) {
            return (why, None);
        }
        let [share, .., inside] = drawn.visibility.pixels[pixel];
        let Some(light) = &seen.light else {
            return (if inside == 0.0 { PixelVerdict::Compared } else { PixelVerdict::Rim }, None);
        };
        if inside == 0.0 {
            return (PixelVerdict::Rim, None);
        }
        let expected: f32 = if light.sample.is_visible { 1.0 } else { 0.0 };
        // A surface that reflects nothing looks the same in light and shadow.
        if (share - expected).abs() <= WEIGHT_EPSILON || light.unshadowed == DVec3::ZERO {
            return (PixelVerdict::Compared, None);
        }
        let wrong_side = (share >= 0.5) != light.sample.is_visible;
        let (near, texels) = if wrong_side {
            let texels = self.texels_to_edge(drawn, pixel, seen);
            (texels <= TEXELS_ALLOWED, Some(texels))
        } else {
            let reach = TEXELS_ALLOWED + filter_radius_texels(drawn.shadows.filter);
            (self.has_edge_within(seen, drawn.shadows.resolution, reach), None)
        };
        let wrong = if light.sample.is_visible { PixelVerdict::False } else { PixelVerdict::Missed };
        (if near { PixelVerdict::Boundary } else { wrong }, texels)
    }

    /// True if the picture visibly has light instead of shadow or shadow instead of light, where the reference has the
    /// same visibility for all 5 x 5 pixels around.
    fn is_off_edge(&self, drawn: &RenderedSubject, pixel: usize) -> bool {
        const REACH: usize = 2;
        let lit = |pixel: usize| self.pixels[pixel].as_ref()?.is_visible();
        let Some(seen) = &self.pixels[pixel] else { return false };
        let (Some(expected), [share, .., inside]) = (seen.lit(), drawn.visibility.pixels[pixel]) else {
            return false;
        };
        let (width, height) = self.size();
        let (x, y) = (pixel % width, pixel / width);
        let inner = x >= REACH && y >= REACH && x + REACH < width && y + REACH < height;
        let mut around = (0..=2 * REACH).flat_map(|dy| (0..=2 * REACH).map(move |dx| (dx, dy)));
        inside > 0.0
            && (share - if expected { 1.0 } else { 0.0 }).abs() > VISIBLE_ERROR
            && inner
            && around.all(|(dx, dy)| lit((y + dy - REACH) * width + x + dx - REACH) == Some(expected))
            && self.surface_mismatch(drawn, pixel, &seen.surface).is_none()
    }

    fn radiance_rmse(&self, drawn: &RenderedSubject, verdicts: &[PixelVerdict]) -> f64 {
        let (mut error2, mut reference2) = (0.0, 0.0);
        for (pixel, verdict) in verdicts.iter().enumerate() {
            if let (PixelVerdict::Compared | PixelVerdict::Missed | PixelVerdict::False, Some(seen)) =
                (verdict, &self.pixels[pixel])
            {
                error2 += (drawn.radiance(pixel) - seen.radiance()).length_squared();
                reference2 += seen.radiance().length_squared();
            }
        }
        if error2 == 0.0 { 0.0 } else { (error2 / reference2).sqrt() }
    }
}

/// Returns the relative RMSE of the radiance of `beauty`, a scene under several lights, against the sum of the
/// references `each`, and the number of pixels in it: those that are compared under each light alone, by `alone`.
pub(crate) fn radiance_rmse_of_all(each: &[ExpectedPicture], alone: &[Comparison], beauty: &Picture) -> (f64, usize) {
    use PixelVerdict::{Compared, False, Missed};
    let (mut error2, mut reference2, mut compared) = (0.0, 0.0, 0);
    for pixel in 0..beauty.pixels.len() {
        if alone.iter().all(|found| matches!(found.verdicts[pixel], Compared | Missed | False)) {
            let radiance = |expected: &ExpectedPicture| {
                expected.pixels[pixel].as_ref().map_or(DVec3::ZERO, ExpectedPixel::radiance)
            };
            let expected: DVec3 = each.iter().map(radiance).sum();
            error2 += (rgb(beauty, pixel) - expected).length_squared();
            reference2 += expected.length_squared();
            compared += 1;
        }
    }
    (if error2 == 0.0 { 0.0 } else { (error2 / reference2).sqrt() }, compared)
}

/// Returns the radius in texels over which a filter blends a straight edge.
fn filter_radius_texels(filter: ShadowFilter) -> f64 {
    let texels = match filter {
        ShadowFilter::Nearest => 0.0,
        ShadowFilter::Bilinear => 1.0,
        ShadowFilter::Pcf3x3 => 2.0,
    };
    texels * std::f64::consts::SQRT_2
}

impl ComparisonSubject {
    /// Checks the light of the subject, for a renderer.
    pub(crate) fn lights(&self) -> Result<Vec<LightInstance>, LightError> {
        LightInstance::numbered([self.light.clone()])
    }
}
