//! How much of a picture passes an alpha test, and mip levels that keep it.
//!
//! Averages lie nearer to the middle than what they are made of: under an alpha test thin leaves thin out with
//! distance, and dense ones close. So each level's alpha is scaled until bilinear look-ups pass as often as at full
//! size (Castano 2010, "Computing Alpha Mipmaps"). Pictures are taken as repeating.

/// A level's share may differ from the picture's by this much of what passes times what does not.
const TOLERANCE: f64 = 0.1;
/// Alpha has 8 bits: no scale beyond this tells more of them apart.
const LARGEST_SCALE: f32 = 256.0;
/// Halvings of a factor 2: the scale is then known to less than a step of 8 bits.
const HALVINGS: usize = 10;
/// Lines in a cell of four texels along which its area is measured.
const LINES: usize = 8;

/// The share of all points at which a bilinear look-up has at least `cutoff`.
pub(crate) fn share(alpha: &[f32], width: usize, height: usize, cutoff: f32) -> f64 {
    let mut passing = 0.0;
    for y in 0..height {
        let (row, below) = (&alpha[y * width..][..width], &alpha[(y + 1) % height * width..][..width]);
        for x in 0..width {
            let next = (x + 1) % width;
            let (top, bottom) = ([row[x], row[next]], [below[x], below[next]]);
            let passes = top.iter().chain(&bottom).filter(|a| **a >= cutoff).count();
            passing += match passes {
                0 => 0.0,
                4 => 1.0,
                _ => share_of_cell(top, bottom, cutoff),
            };
        }
    }
    passing / (width * height) as f64
}

/// The same between four texels' centres, whose look-ups are linear along each line.
fn share_of_cell(top: [f32; 2], bottom: [f32; 2], cutoff: f32) -> f64 {
    let line = |k: usize| {
        let down = (k as f32 + 0.5) / LINES as f32;
        let [a, b] = [0, 1].map(|side| top[side] + (bottom[side] - top[side]) * down - cutoff);
        match (a >= 0.0, b >= 0.0) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            _ => f64::from(a.max(b) / (a - b).abs()),
        }
    };
    (0..LINES).map(line).sum::<f64>() / LINES as f64
}

/// What a level's alpha is to be multiplied by so that `kept` of it passes, or `None` where nothing does that.
pub(crate) fn scale(alpha: &[f32], width: usize, height: usize, cutoff: f32, kept: f64) -> Option<f32> {
    // Averages of what passes pass, and averages of what does not do not.
    if kept == 0.0 || kept == 1.0 {
        return Some(1.0);
    }
    let passing = |scale: f32| {
        let alpha: Vec<f32> = alpha.iter().map(|&a| f32::from(scaled(a, scale)) / 255.0).collect();
        share(&alpha, width, height, cutoff)
    };
    // More passes the larger the scale: two powers of two with what is kept between them, then halves.
    let mut high = 1.0;
    if passing(high) < kept {
        while high < LARGEST_SCALE && passing(high) < kept {
            high *= 2.0;
        }
    } else {
        while high > LARGEST_SCALE.recip() && passing(high / 2.0) >= kept {
            high /= 2.0;
        }
    }
    let mut low = high / 2.0;
    for _ in 0..HALVINGS {
        let middle = f32::midpoint(low, high);
        if passing(middle) < kept { low = middle } else { high = middle }
    }
    let off = |scale: f32| (passing(scale) - kept).abs();
    let best = if off(low) < off(high) { low } else { high };
    (off(best) <= TOLERANCE * kept * (1.0 - kept)).then_some(best)
}

/// Alpha times `scale`, as a level stores it.
pub(crate) fn scaled(alpha: f32, scale: f32) -> u8 {
    (alpha * scale * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_areas() {
        // Between 0 and 1 along x: half of each of two cells has at least 0.5, a quarter at least 0.75.
        assert!((share(&[0.0, 1.0], 2, 1, 0.5) - 0.5).abs() < 1e-6);
        assert!((share(&[0.0, 1.0], 2, 1, 0.75) - 0.25).abs() < 1e-6);
        // One texel of four: a cell has x y >= 1/2 over (1 - ln 2) / 2 of it, measured along 8 lines.
        let area = 0.5 * (1.0 - std::f64::consts::LN_2);
        assert!((share(&[0.0, 0.0, 0.0, 1.0], 2, 2, 0.5) - area).abs() < 1e-3);
        assert_eq!(share(&[0.5; 6], 3, 2, 0.5), 1.0);
        assert_eq!(share(&[0.5; 6], 3, 2, 0.6), 0.0);
    }
}
