//! Textures in f64: bilinear within a level and linear between levels, like the filter of the GPU.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec4};
use scene::{Image, Scene, TextureRef, Wrap};

/// Part of a texture that a pixel covers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Coordinates of the centre.
    pub uv: DVec2,
    /// Change of uv to the next pixel on the right.
    pub dx: DVec2,
    /// Change of uv to the next pixel below.
    pub dy: DVec2,
}

/// Mip level with linear colors.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<DVec4>,
}

/// Mip levels of each image, by the index of the image and a flag. The flag is true if the image is decoded as sRGB.
type Chains = HashMap<(usize, bool), OnceLock<Vec<Level>>>;

/// Textures of a scene.
pub(crate) struct Textures {
    scene: Arc<Scene>,
    /// Cached mip levels, which are computed at first use. `None` if nothing is cached, and each level is
    /// computed only at the needed texels.
    chains: Option<Chains>,
}

impl Textures {
    pub fn new(scene: Arc<Scene>) -> Self {
        let keys = (0..scene.images.len()).flat_map(|image| [(image, true), (image, false)]);
        let chains = keys.map(|key| (key, OnceLock::new())).collect();
        Self { scene, chains: Some(chains) }
    }

    /// Returns textures without a cache, for a few points.
    pub fn uncached(scene: Arc<Scene>) -> Self {
        Self { scene, chains: None }
    }

    /// Samples a color texture: RGB decoded from sRGB to linear, alpha unchanged.
    pub fn srgb(&self, texture: TextureRef, footprint: &Footprint) -> DVec4 {
        self.sample(texture, footprint, true)
    }

    /// Samples a data texture: all channels unchanged.
    pub fn linear(&self, texture: TextureRef, footprint: &Footprint) -> DVec4 {
        self.sample(texture, footprint, false)
    }

    fn sample(&self, texture: TextureRef, footprint: &Footprint, srgb: bool) -> DVec4 {
        let image = &self.scene.images[texture.image];
        let (width, height) = (image.width as usize, image.height as usize);
        let size = DVec2::new(width as f64, height as f64);
        let texels = (footprint.dx * size).length().max((footprint.dy * size).length());
        let last = width.max(height).ilog2() as usize;
        let level = if texels <= 1.0 { 0.0 } else { libm::log2(texels).min(last as f64) };
        let (fine, share) = (level as usize, level.fract());
        let coarse = (fine + 1).min(last);
        let is_nearest = texels <= 1.0 && texture.sampler.nearest;
        let blended = |at: &dyn Fn(usize) -> DVec4| {
            if share == 0.0 { at(fine) } else { at(fine).lerp(at(coarse), share) }
        };
        if let Some(chains) = &self.chains {
            let chain = chains[&(texture.image, srgb)].get_or_init(|| mips(image, srgb));
            let sample = if is_nearest { nearest } else { bilinear };
            return blended(&|level| sample(&chain[level], texture, footprint.uv));
        }
        let table = decoded(srgb);
        blended(&|level| sample_uncached(image, &table, texture, footprint.uv, level, is_nearest))
    }
}

/// Computes the result of [`nearest`] or [`bilinear`] in a level from the full-size texels that it averages.
fn sample_uncached(
    image: &Image,
    table: &[f64],
    texture: TextureRef,
    uv: DVec2,
    level: usize,
    is_nearest: bool,
) -> DVec4 {
    let side = |at: f64, wrap: Wrap, full: usize| {
        let size = (full >> level).max(1);
        if is_nearest {
            return vec![(wrap.texel((at * size as f64).floor(), size), 1.0)];
        }
        let at = at * size as f64 - 0.5;
        let (first, share) = (at.floor(), at - at.floor());
        let mut shares = Vec::new();
        for (texel, weight) in [(first, 1.0 - share), (first + 1.0, share)] {
            let of_full = full_size(wrap.texel(texel, size), full, level);
            shares.extend(of_full.into_iter().map(|(texel, part)| (texel, part * weight)));
        }
        shares
    };
    let columns = side(uv.x, texture.sampler.wrap_u, image.width as usize);
    let rows = side(uv.y, texture.sampler.wrap_v, image.height as usize);
    let texels = image.rgba8.as_chunks::<4>().0;
    weighted_sum(&columns, &rows, |column, row| linear_texel(table, texels[row * image.width as usize + column]))
}

/// Returns the sum of texels by the weights of their columns and rows.
fn weighted_sum(columns: &[(usize, f64)], rows: &[(usize, f64)], texel: impl Fn(usize, usize) -> DVec4) -> DVec4 {
    let mut sum = DVec4::ZERO;
    for &(row, row_share) in rows {
        for &(column, column_share) in columns {
            sum += texel(column, row) * (row_share * column_share);
        }
    }
    sum
}

/// Decodes a texel by the values of the bytes of its colors.
fn linear_texel(table: &[f64], [r, g, b, a]: [u8; 4]) -> DVec4 {
    let [r, g, b] = [r, g, b].map(|byte| table[usize::from(byte)]);
    DVec4::new(r, g, b, f64::from(a) / 255.0)
}

/// Returns the full-size texels along a side that a texel of a level averages, with the weight of each. The
/// weights are those of repeated halving.
fn full_size(texel: usize, full: usize, level: usize) -> Vec<(usize, f64)> {
    let mut shares = vec![(texel, 1.0)];
    for finer in (0..level).rev() {
        let (size, half) = ((full >> finer).max(1), (full >> (finer + 1)).max(1));
        let mut made: Vec<(usize, f64)> = Vec::with_capacity(2 * shares.len() + 1);
        for (coarse, share) in shares {
            for (fine, part) in covered(coarse, size, half) {
                match made.last_mut().filter(|(last, _)| *last == fine) {
                    Some((_, sum)) => *sum += part * share,
                    None => made.push((fine, part * share)),
                }
            }
        }
        shares = made;
    }
    shares
}

fn nearest(level: &Level, texture: TextureRef, uv: DVec2) -> DVec4 {
    let (x, y) = (uv.x * level.width as f64, uv.y * level.height as f64);
    texel(level, texture, x.floor(), y.floor())
}

fn bilinear(level: &Level, texture: TextureRef, uv: DVec2) -> DVec4 {
    let at = uv * DVec2::new(level.width as f64, level.height as f64) - 0.5;
    let (first, share) = (at.floor(), at - at.floor());
    let row = |y: f64| texel(level, texture, first.x, y).lerp(texel(level, texture, first.x + 1.0, y), share.x);
    row(first.y).lerp(row(first.y + 1.0), share.y)
}

fn texel(level: &Level, texture: TextureRef, x: f64, y: f64) -> DVec4 {
    let column = texture.sampler.wrap_u.texel(x, level.width);
    let row = texture.sampler.wrap_v.texel(y, level.height);
    level.texels[row * level.width + column]
}

/// Returns the value of each byte, decoded as sRGB or as data.
fn decoded(srgb: bool) -> Vec<f64> {
    let decode = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        match srgb {
            false => c,
            true if c <= 0.04045 => c / 12.92,
            true => libm::pow((c + 0.055) / 1.055, 2.4),
        }
    };
    (0..=255).map(decode).collect()
}

/// Returns all levels from the full size down to one texel. Each is the area average of the one before.
fn mips(image: &Image, srgb: bool) -> Vec<Level> {
    let table = decoded(srgb);
    let texels = image.rgba8.as_chunks::<4>().0.iter().map(|&rgba| linear_texel(&table, rgba));
    let first = Level { width: image.width as usize, height: image.height as usize, texels: texels.collect() };
    let next = |level: &Level| (level.width > 1 || level.height > 1).then(|| halved(level));
    std::iter::successors(Some(first), next).collect()
}

/// Halves a level. Its size is rounded down, to at least 1.
fn halved(level: &Level) -> Level {
    let (width, height) = ((level.width / 2).max(1), (level.height / 2).max(1));
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let (columns, rows) = (covered(x, level.width, width), covered(y, level.height, height));
            texels.push(weighted_sum(&columns, &rows, |column, row| level.texels[row * level.width + column]));
        }
    }
    Level { width, height, texels }
}

/// Returns the texels among `full` that texel `index` of `half` covers, with the weight of each.
fn covered(index: usize, full: usize, half: usize) -> Vec<(usize, f64)> {
    let scale = full as f64 / half as f64;
    let (low, high) = (index as f64 * scale, (index + 1) as f64 * scale);
    (low as usize..full.min(high.ceil() as usize))
        .map(|k| (k, (high.min(k as f64 + 1.0) - low.max(k as f64)) / scale))
        .collect()
}

impl std::fmt::Debug for Textures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Textures({})", self.scene.images.len())
    }
}
