//! Where in a pixel it is looked at.

use glam::DVec2;

/// Where sample `index` of `count` lies in a pixel, from its top left corner: a Fibonacci lattice, centred, so
/// that one sample is the pixel's centre.
pub(crate) fn sample_in_pixel(index: u32, count: u32) -> DVec2 {
    const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    let from_middle = f64::from(index) + 0.5 - f64::from(count) / 2.0;
    let across = (0.5 + from_middle * INVERSE_GOLDEN_RATIO).rem_euclid(1.0);
    DVec2::new(0.5 + from_middle / f64::from(count), across)
}
