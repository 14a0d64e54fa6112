//! Mip levels by area averaging, in linear light where the picture is sRGB.

/// How the bytes of a picture are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Encoding {
    /// Colour: sRGB-encoded RGB, linear alpha.
    Srgb,
    /// Data: all channels linear.
    Linear,
}

/// Mip levels of an RGBA8 picture.
#[derive(Debug)]
pub(crate) struct MipChain {
    /// One level after the other, from the full size down.
    pub rgba8: Vec<u8>,
    pub levels: u32,
}

/// The mip levels of an RGBA8 picture, down to one pixel.
pub(crate) fn mip_chain(width: u32, height: u32, rgba8: &[u8], encoding: Encoding) -> MipChain {
    let decode = decoding_table(encoding);
    let mut chain = MipChain { rgba8: rgba8.to_vec(), levels: 1 };
    let (mut width, mut height) = (width as usize, height as usize);
    let mut level: Vec<[f32; 4]> = rgba8
        .chunks_exact(4)
        .map(|p| std::array::from_fn(|c| if c == 3 { p[3] as f32 / 255.0 } else { decode[p[c] as usize] }))
        .collect();
    while width > 1 || height > 1 {
        (level, width, height) = halved(&level, width, height);
        for pixel in &level {
            let [r, g, b, a] = *pixel;
            chain.rgba8.extend([
                encode(r, encoding),
                encode(g, encoding),
                encode(b, encoding),
                encode(a, Encoding::Linear),
            ]);
        }
        chain.levels += 1;
    }
    chain
}

/// The next level: half the size, rounded down, at least 1.
fn halved(level: &[[f32; 4]], width: usize, height: usize) -> (Vec<[f32; 4]>, usize, usize) {
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(half_width * half_height);
    for y in 0..half_height {
        let rows = taps(y, height, half_height);
        for x in 0..half_width {
            let mut sum = [0.0; 4];
            for (row, row_weight) in rows {
                for (column, column_weight) in taps(x, width, half_width) {
                    let pixel = level[row * width + column];
                    for c in 0..4 {
                        sum[c] += row_weight * column_weight * pixel[c];
                    }
                }
            }
            out.push(sum);
        }
    }
    (out, half_width, half_height)
}

/// The texels that texel `index` of `half` covers among `full` and the share of it that each fills.
///
/// `full` is `2 half`, `2 half + 1`, or 1 with `half` 1.
fn taps(index: usize, full: usize, half: usize) -> [(usize, f32); 3] {
    if full == half {
        return [(index, 1.0), (index, 0.0), (index, 0.0)];
    }
    let width = full as f32 / half as f32;
    let start = index as f32 * width;
    let first = 2 * index;
    std::array::from_fn(|k| {
        let (low, high) = ((first + k) as f32, (first + k + 1) as f32);
        let overlap = (high.min(start + width) - low.max(start)).max(0.0);
        ((first + k).min(full - 1), overlap / width)
    })
}

fn decoding_table(encoding: Encoding) -> [f32; 256] {
    std::array::from_fn(|i| {
        let c = i as f32 / 255.0;
        match encoding {
            Encoding::Linear => c,
            Encoding::Srgb if c <= 0.04045 => c / 12.92,
            Encoding::Srgb => ((c + 0.055) / 1.055).powf(2.4),
        }
    })
}

fn encode(c: f32, encoding: Encoding) -> u8 {
    let encoded = match encoding {
        Encoding::Linear => c,
        Encoding::Srgb if c <= 0.003_130_8 => 12.92 * c,
        Encoding::Srgb => 1.055 * c.powf(1.0 / 2.4) - 0.055,
    };
    (encoded * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u32, height: u32, rgba8: &[u8], encoding: Encoding) -> Vec<u8> {
        let chain = mip_chain(width, height, rgba8, encoding);
        assert_eq!(chain.levels, width.max(height).ilog2() + 1);
        chain.rgba8
    }

    #[test]
    fn odd_sizes_share_the_middle_texel() {
        // Three texels into one: a third each.
        assert_eq!(plain(3, 1, &[[30; 4], [60; 4], [90; 4]].concat(), Encoding::Linear)[12..], [60; 4]);
        // Five into two: 2.5 texels each, the middle one in both: (10 + 20 + 30 / 2) / 2.5 and (30 / 2 + 40 +
        // 50) / 2.5.
        let row: Vec<u8> = [10, 20, 30, 40, 50].into_iter().flat_map(|v| [v; 4]).collect();
        let chain = plain(5, 1, &row, Encoding::Linear);
        assert_eq!(chain[20..28], [18, 18, 18, 18, 42, 42, 42, 42]);
        assert_eq!(chain.len(), 4 * (5 + 2 + 1));
    }

    #[test]
    fn colours_average_in_linear_light() {
        let checker = [[0, 0, 0, 255], [255, 255, 255, 255], [255, 255, 255, 255], [0, 0, 0, 255]].concat();
        // Half the light is 188 in sRGB; averaging the bytes, the fault, would give 128.
        assert_eq!(plain(2, 2, &checker, Encoding::Srgb)[16..], [188, 188, 188, 255]);
        assert_eq!(plain(2, 2, &checker, Encoding::Linear)[16..], [128, 128, 128, 255]);
    }

    #[test]
    fn a_plain_colour_stays() {
        for (width, height) in [(1, 1), (7, 3), (16, 16), (1, 9)] {
            let picture = [200, 3, 77, 128].repeat(width * height);
            let chain = plain(width as u32, height as u32, &picture, Encoding::Srgb);
            assert!(chain.chunks_exact(4).all(|p| p == [200, 3, 77, 128]));
        }
    }
}
