//! Alpha-tested pictures: a leaf, a lattice and pierced metal.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use scene::Image;

/// Texels over which alpha rises from 0 to 1 at an edge. There it encodes the distance from the edge.
const EDGE_TEXELS: f64 = 8.0;

/// Returns a vine leaf with five lobes, its tip at the top, and two bite holes.
pub fn leaf(side: u32) -> Image {
    picture(side, |at| {
        let from_middle = at - DVec2::new(0.5, 0.54);
        // Angle from the tip, mirrored at the axis.
        let angle = libm::atan2(from_middle.x.abs(), -from_middle.y);
        let lobes = 0.5 + 0.5 * libm::cos(5.0 * angle);
        let teeth = 0.5 + 0.5 * libm::cos(40.0 * angle);
        let notch = 0.30 * libm::exp(-8.0 * (angle - TAU / 2.0) * (angle - TAU / 2.0));
        let reach = 0.27 + 0.15 * lobes + 0.015 * teeth + 0.03 * libm::cos(angle) - notch;
        let stalk = 0.016 - from_middle.x.abs();
        let stalk = if from_middle.y > 0.0 && at.y < 0.97 { stalk } else { -1.0 };
        let bitten =
            [(0.61, 0.36, 0.045), (0.36, 0.61, 0.035)].map(|(x, y, radius)| at.distance(DVec2::new(x, y)) - radius);
        let inside = (reach - from_middle.length()).max(stalk).min(bitten[0]).min(bitten[1]);

        let vein = libm::exp(-900.0 * libm::pow(libm::sin(2.5 * angle) * from_middle.length(), 2.0));
        let blade = DVec3::new(0.20, 0.42, 0.10).lerp(DVec3::new(0.33, 0.52, 0.14), at.y);
        (blade.lerp(DVec3::new(0.52, 0.66, 0.28), 0.7 * vein), inside)
    })
}

/// Returns two crossing laths, which repeat as a diagonal lattice.
pub fn lattice(side: u32) -> Image {
    picture(side, |at| {
        let from_lath = |along: f64| {
            let across = (along - libm::floor(along) - 0.5).abs();
            // The diagonal of the picture crosses two laths.
            0.15 - across * std::f64::consts::FRAC_1_SQRT_2
        };
        let (rising, falling) = (from_lath(at.x + at.y), from_lath(at.x - at.y));
        let wood = DVec3::new(0.74, 0.62, 0.46);
        let grain = 0.92 + 0.08 * libm::sin(TAU * 6.0 * if rising > falling { at.x - at.y } else { at.x + at.y });
        (wood * grain * if rising > falling { 1.0 } else { 0.85 }, rising.max(falling))
    })
}

/// Returns a quarter of a rosette of holes, to be mirrored.
pub fn pierced(side: u32) -> Image {
    picture(side, |at| {
        let holes = [(0.0, 0.0, 0.20), (0.50, 0.50, 0.17), (1.0, 1.0, 0.14), (0.44, 0.07, 0.09), (0.07, 0.44, 0.09)];
        let nearest = holes.into_iter().map(|(x, y, radius)| at.distance(DVec2::new(x, y)) - radius);
        (DVec3::splat(0.95), nearest.fold(f64::INFINITY, f64::min))
    })
}

/// Draws a picture from a function of the position, from (0, 0) at the top left to (1, 1). It returns the sRGB
/// color and the signed distance to the edge, positive inside.
fn picture(side: u32, look: impl Fn(DVec2) -> (DVec3, f64)) -> Image {
    let texels = (0..side * side).flat_map(|k| {
        let at = (DVec2::new(f64::from(k % side), f64::from(k / side)) + 0.5) / f64::from(side);
        let (color, inside) = look(at);
        let alpha = 0.5 + inside * f64::from(side) / EDGE_TEXELS;
        let byte = |x: f64| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        [byte(color.x), byte(color.y), byte(color.z), byte(alpha)]
    });
    Image { width: side, height: side, rgba8: texels.collect() }
}
