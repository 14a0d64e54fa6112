//! The GPU's picture of a scene under one BendyLight against the reference's, pixel by pixel.
//!
//! Pixels are sorted by what they say about the picture ([`PixelVerdict`]). Radiance is compared where both see the
//! same surface and no shadow's edge is near; a shadow's edge is compared by how far it is displaced, in texels of
//! the shadow map and in pixels.

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

/// A shadow may lie this many texels of its map beside where it should.
const TEXELS_ALLOWED: f64 = 1.5;

/// A pixel whose share of the light is wrong by more than this is seen to be, and to come and go as things move.
const VISIBLE_ERROR: f32 = 0.1;

/// Weights of a filter add up to 1 within some ulps.
const WEIGHT_EPSILON: f32 = 1e-6;

/// What a pixel says about the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelVerdict {
    /// Nothing is seen there.
    Background,
    /// Radiance is compared.
    Compared,
    /// Left out: the two see different surfaces.
    Silhouette,
    /// Left out: two surfaces lie in one place, nearer to each other than f32 can tell, and the two see different ones.
    Coincident,
    /// Left out: only one of them sees it inside the light.
    Rim,
    /// Left out: a shadow's edge is nearer than `TEXELS_ALLOWED`, or within the filter's reach more.
    Boundary,
    /// Compared: light where there should be shadow, farther from its edge than that.
    Missed,
    /// Compared: shadow where there should be light, farther from its edge than that.
    False,
    /// The picture holds a number that is not finite.
    NotFinite,
}

/// What a comparison found.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Comparison {
    /// Pixels that show a surface, in either picture.
    pub pixels: usize,
    /// Of those, inside the light by the reference.
    pub in_light: usize,
    /// Left out because the two see different surfaces.
    pub silhouettes: usize,
    /// Left out because two surfaces lie in one place.
    pub coincident: usize,
    /// Left out because only one of them sees the pixel inside the light.
    pub rim: usize,
    /// Left out because a shadow's edge is near.
    pub boundary: usize,
    /// Light where there should be shadow, more than 1.5 texels from its edge.
    pub missed: usize,
    /// Shadow where there should be light, more than 1.5 texels from its edge.
    #[serde(rename = "false")]
    pub false_shadow: usize,
    /// Light or shadow, or more than a tenth of either, where the reference says the other of all 5 x 5 pixels around.
    /// This knows nothing of maps and texels.
    pub off_edge: usize,
    /// Pixels that hold a number that is not finite.
    pub not_finite: usize,
    /// `sqrt(mean |gpu - reference|^2) / sqrt(mean |reference|^2)` over what is compared.
    pub radiance_rmse: f64,
    /// Of pixels on the wrong side of a shadow's edge, how many texels of the map they are from it; null is farther
    /// than 8.
    pub displacement_texels: Quantiles,
    /// Where scan lines cross shadows' edges, how many pixels the picture's edge is from the reference's, square to it;
    /// null is farther than 6 along the line.
    pub displacement_pixels: Quantiles,
    /// One a pixel.
    #[serde(skip)]
    pub verdicts: Vec<PixelVerdict>,
    /// Indices of those that `off_edge` counts.
    #[serde(skip)]
    pub off_edge_pixels: Vec<usize>,
}

/// What the GPU makes of a [`ComparisonSubject`].
#[derive(Clone, Debug)]
pub struct RenderedSubject {
    /// Radiance.
    pub beauty: Picture,
    /// Distance along the view axis.
    pub depth: Picture,
    /// Shading normal.
    pub normal: Picture,
    /// The light's visibility.
    pub visibility: Picture,
    /// The same at `scan::FINER` times the size, whose every third row and column are the centres of `sight`.
    pub fine_visibility: Picture,
    /// How shadows were made.
    pub shadows: ShadowSettings,
}

impl RenderedSubject {
    /// Draws the pictures of `subject`, whose scene the renderer has.
    pub fn new(
        renderer: &mut Renderer,
        subject: &ComparisonSubject,
        shadows: ShadowSettings,
    ) -> Result<Self, RenderError> {
        Self::under(renderer, subject, &subject.lights()?, shadows)
    }

    /// The same under `lights`, of which the first should look like the subject's.
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
    /// Compares what the GPU drew.
    pub fn compare(&self, drawn: &RenderedSubject) -> Comparison {
        let judged: Vec<_> =
            (0..self.pixels.len()).into_par_iter().map(|pixel| self.judge(drawn, pixel)).collect();
        let verdicts: Vec<_> = judged.iter().map(|judged| judged.0).collect();
        let count = |verdict| verdicts.iter().filter(|v| **v == verdict).count();
        let in_light = |seen: &&Option<ExpectedPixel>| seen.as_ref().is_some_and(|seen| seen.light.is_some());
        let off_edge_pixels: Vec<_> =
            (0..self.pixels.len()).filter(|&pixel| self.is_off_edge(drawn, pixel)).collect();
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

    /// What a pixel says, and how many texels it is from the shadow's edge if it lies on the wrong side.
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
        // Where nothing would be reflected, nobody can tell light from shadow.
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

    /// Whether the picture has light for shadow, or the other way round, where it would be seen and the reference says
    /// the same of the 5 x 5 pixels around.
    fn is_off_edge(&self, drawn: &RenderedSubject, pixel: usize) -> bool {
        const REACH: usize = 2;
        let lit = |pixel: usize| self.pixels[pixel].as_ref()?.light.map(|light| light.sample.is_visible);
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

/// Relative RMSE of the radiance of `beauty`, which shows a scene under several lights, against the sum of what the
/// reference says of each; and of how many pixels: those that are compared under each of them alone, which `alone` has.
pub(crate) fn radiance_rmse_of_all(
    each: &[ExpectedPicture],
    alone: &[Comparison],
    beauty: &Picture,
) -> (f64, usize) {
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

/// How far, in texels, a filter blends over a straight edge.
fn filter_radius_texels(filter: ShadowFilter) -> f64 {
    let texels = match filter {
        ShadowFilter::Nearest => 0.0,
        ShadowFilter::Bilinear => 1.0,
        ShadowFilter::Pcf3x3 => 2.0,
    };
    texels * std::f64::consts::SQRT_2
}

impl ComparisonSubject {
    /// Its light, checked.
    pub(crate) fn lights(&self) -> Result<Vec<LightInstance>, LightError> {
        LightInstance::numbered([self.light.clone()])
    }
}
