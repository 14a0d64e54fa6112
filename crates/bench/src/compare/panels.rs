//! Draws a comparison as a picture.

use glam::DVec3;
use image::{Rgb, RgbImage};

use super::expected::ExpectedPixel;
use super::{Comparison, ExpectedPicture, PixelVerdict, RenderedSubject, rgb};

/// Factor of a difference, relative to the brightest radiance of the reference.
const AMPLIFIED: f64 = 50.0;

/// Mask color of wrong pixels that have no edge near in pixels.
const OFF_EDGE: [u8; 3] = [60, 255, 60];

impl PixelVerdict {
    /// Returns the color in the mask.
    fn color(self) -> [u8; 3] {
        match self {
            Self::Background => [0, 0, 0],
            Self::Compared => [90, 90, 90],
            Self::Silhouette => [255, 220, 0],
            Self::Coincident => [255, 140, 0],
            Self::Rim => [0, 200, 220],
            Self::Boundary => [40, 90, 255],
            Self::Missed => [255, 40, 30],
            Self::False => [255, 40, 255],
            Self::NotFinite => [255, 255, 255],
        }
    }
}

impl ExpectedPicture<'_> {
    /// Draws four panels: the GPU's picture and the reference's above; below, their difference (grey if equal, brighter
    /// if the GPU is, full at 1/50 of the brightest radiance) and the verdicts on the pixels.
    ///
    /// In the last panel, compared pixels are grey. Excluded are silhouettes (yellow), coincident surfaces (orange),
    /// the rim of the light (cyan) and shadow edges (blue). Missed shadow is red, false shadow magenta, wrong pixels
    /// without an edge within two pixels green, and numbers that are not finite white.
    pub fn panels(&self, drawn: &RenderedSubject, comparison: &Comparison) -> RgbImage {
        let (width, height) = self.size();
        let reference = |pixel: usize| self.pixels[pixel].as_ref().map_or(DVec3::ZERO, ExpectedPixel::radiance);
        let brightest = (0..width * height).map(|pixel| reference(pixel).max_element()).fold(0.0, f64::max);
        let shown = |radiance: DVec3| display(radiance / brightest.max(f64::MIN_POSITIVE));
        let panel = |index: u32, pixel: usize| {
            let drawn = rgb(&drawn.beauty, pixel);
            match index {
                0 => shown(drawn),
                1 => shown(reference(pixel)),
                2 => {
                    let difference = (drawn - reference(pixel)) / brightest.max(f64::MIN_POSITIVE);
                    let share = difference * (0.5 * AMPLIFIED) + 0.5;
                    Rgb(share.to_array().map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8))
                }
                _ if comparison.off_edge_pixels.contains(&pixel) => Rgb(OFF_EDGE),
                _ => Rgb(comparison.verdicts[pixel].color()),
            }
        };
        RgbImage::from_fn(2 * width as u32, 2 * height as u32, |x, y| {
            let (column, row) = (x / width as u32, y / height as u32);
            let pixel = (y % height as u32) as usize * width + (x % width as u32) as usize;
            panel(2 * row + column, pixel)
        })
    }
}

/// Maps radiance, as a share of the brightest, to a display value by a power close to that of sRGB.
fn display(share: DVec3) -> Rgb<u8> {
    Rgb(share.to_array().map(|x| (x.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8))
}
