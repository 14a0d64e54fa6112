//! Draws a pose as pictures, for inspection.

use glam::DVec3;
use image::{Rgb, RgbImage};
use render::Picture;

use super::judge::JudgedView;

/// Size in pixels at which each pixel is drawn.
const ENLARGED: u32 = 3;

/// Draws the reference's picture and then each backend's with its wrong pixels in red, each with its unstable pixels in
/// blue to the right.
pub(super) fn panels(
    [width, height]: [u32; 2],
    reference: &[DVec3],
    judged: &JudgedView,
    drawn: &[(Picture, Vec<usize>)],
) -> RgbImage {
    let mut is_stable = vec![false; (width * height) as usize];
    judged.stable.iter().for_each(|stable| is_stable[stable.pixel] = true);
    let brightest = reference.iter().map(|pixel| pixel.max_element()).fold(f64::MIN_POSITIVE, f64::max);
    let shown = |[r, g, b]: [f64; 3]| {
        Rgb([r, g, b].map(|x| ((x / brightest).clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8))
    };
    let of = |panel: usize, pixel: usize| {
        let radiance = reference[pixel].to_array();
        match panel {
            0 => shown(radiance),
            1 if is_stable[pixel] => shown(radiance),
            1 => Rgb([40, 60, 200]),
            _ => {
                let (picture, wrong) = &drawn[panel - 2];
                let [r, g, b, _] = picture.pixels[pixel].map(f64::from);
                if wrong.contains(&pixel) { Rgb([255, 0, 0]) } else { shown([r, g, b]) }
            }
        }
    };
    let panels = 2 + drawn.len() as u32;
    RgbImage::from_fn(panels * width * ENLARGED, height * ENLARGED, |x, y| {
        let (x, y) = (x / ENLARGED, y / ENLARGED);
        of((x / width) as usize, (y * width + x % width) as usize)
    })
}
