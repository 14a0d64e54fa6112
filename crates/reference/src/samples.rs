//! Sample positions in a pixel.

use glam::DVec2;

/// Returns the position of sample `index` of `count` in a pixel, from its top left corner. The samples form a
/// centred Fibonacci lattice, so a single sample lies at the pixel's centre.
pub(crate) fn sample_in_pixel(index: u32, count: u32) -> DVec2 {
    const INVERSE_GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    let from_middle = f64::from(index) + 0.5 - f64::from(count) / 2.0;
    let across = (0.5 + from_middle * INVERSE_GOLDEN_RATIO).rem_euclid(1.0);
    DVec2::new(0.5 + from_middle / f64::from(count), across)
}
