//! Mip levels by area averaging, in linear light for sRGB images.

use half::f16;

/// Encoding of an image's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Encoding {
    /// Color: sRGB-encoded RGB, linear alpha.
    Srgb,
    /// Data: all channels linear.
    Linear,
}

/// Numbers of a texel, four per texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TexelFormat {
    Unorm8,
    Unorm16,
    Half,
}

/// Image and its mip levels, in the bytes of a texture format.
#[derive(Debug)]
pub(crate) struct MipChain {
    /// Levels in order, from the full size down.
    pub bytes: Vec<u8>,
    pub format: TexelFormat,
    pub levels: u32,
}

/// Computes the mip levels of an RGBA8 image, down to one pixel. All are linear, and each is rounded once.
pub(crate) fn mip_chain(
    (width, height): (u32, u32),
    rgba8: &[u8],
    encoding: Encoding,
    format: TexelFormat,
) -> MipChain {
    let decode = decoding_table(encoding);
    let (mut width, mut height) = (width as usize, height as usize);
    let mut level: Vec<[f32; 4]> = rgba8
        .chunks_exact(4)
        .map(|p| std::array::from_fn(|c| if c == 3 { p[3] as f32 / 255.0 } else { decode[p[c] as usize] }))
        .collect();
    let mut chain = MipChain { bytes: encode_level(&level, format), format, levels: 1 };
    while width > 1 || height > 1 {
        (level, width, height) = halved(&level, width, height);
        chain.bytes.extend(encode_level(&level, format));
        chain.levels += 1;
    }
    chain
}

fn encode_level(level: &[[f32; 4]], format: TexelFormat) -> Vec<u8> {
    let channels = level.as_flattened().iter();
    match format {
        TexelFormat::Unorm8 => channels.map(|c| (c * 255.0 + 0.5) as u8).collect(),
        TexelFormat::Unorm16 => channels.flat_map(|c| ((c * 65535.0 + 0.5) as u16).to_ne_bytes()).collect(),
        TexelFormat::Half => channels.flat_map(|c| f16::from_f32(*c).to_ne_bytes()).collect(),
    }
}

/// Computes the next mip level: half the size, rounded down, at least 1.
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

/// Returns the texels of `full` that texel `index` of `half` covers, each with its share.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(width: u32, height: u32, rgba8: &[u8]) -> Vec<u8> {
        let chain = mip_chain((width, height), rgba8, Encoding::Linear, TexelFormat::Unorm8);
        assert_eq!(chain.levels, width.max(height).ilog2() + 1);
        chain.bytes
    }

    fn colours(width: u32, height: u32, rgba8: &[u8]) -> Vec<u16> {
        let chain = mip_chain((width, height), rgba8, Encoding::Srgb, TexelFormat::Unorm16);
        chain.bytes.chunks_exact(2).map(|c| u16::from_ne_bytes([c[0], c[1]])).collect()
    }

    #[test]
    fn odd_sizes_share_the_middle_texel() {
        // Three texels into one: a third each.
        assert_eq!(bytes(3, 1, &[[30; 4], [60; 4], [90; 4]].concat())[12..], [60; 4]);
        // Five into two: 2.5 texels each, the middle one in both: (10 + 20 + 30 / 2) / 2.5 and (30 / 2 + 40 + 50) /
        // 2.5.
        let row: Vec<u8> = [10, 20, 30, 40, 50].into_iter().flat_map(|v| [v; 4]).collect();
        let chain = bytes(5, 1, &row);
        assert_eq!(chain[20..28], [18, 18, 18, 18, 42, 42, 42, 42]);
        assert_eq!(chain.len(), 4 * (5 + 2 + 1));
    }

    #[test]
    fn colours_average_in_linear_light() {
        let checker = [[0, 0, 0, 255], [255, 255, 255, 255], [255, 255, 255, 255], [0, 0, 0, 255]].concat();
        // The fault, averaging encoded values, would give 0.214 of the light.
        assert_eq!(colours(2, 2, &checker)[16..], [32768, 32768, 32768, 65535]);
        assert_eq!(bytes(2, 2, &checker)[16..], [128, 128, 128, 255]);
    }

    #[test]
    fn a_plain_colour_stays() {
        // Expected values from sRGB's formula in f64.
        let stored = [37852, 60, 4864, 32896];
        for (width, height) in [(1, 1), (7, 3), (16, 16), (1, 9)] {
            let picture = [200, 3, 77, 128].repeat(width * height);
            let chain = colours(width as u32, height as u32, &picture);
            assert!(chain.chunks_exact(4).all(|p| p == stored), "{:?}", &chain[..4]);
        }
    }

    /// Includes halves, which have 11 bits.
    #[test]
    fn formats_hold_colours_to_their_steps() {
        let picture: Vec<u8> = (0..=255).flat_map(|byte| [byte; 4]).collect();
        let halves = mip_chain((256, 1), &picture, Encoding::Srgb, TexelFormat::Half).bytes;
        let shorts = colours(256, 1, &picture);
        for (byte, linear) in decoding_table(Encoding::Srgb).into_iter().enumerate() {
            let half = f16::from_ne_bytes([halves[8 * byte], halves[8 * byte + 1]]).to_f32();
            let short = f32::from(shorts[4 * byte]) / 65535.0;
            assert!((half - linear).abs() <= linear / 2048.0, "{half} for {linear}");
            assert!((short - linear).abs() <= 0.51 / 65535.0, "{short} for {linear}");
            assert_eq!(usize::from(shorts[4 * byte + 3]), 257 * byte);
        }
    }
}
