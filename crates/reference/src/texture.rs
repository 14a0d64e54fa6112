//! Textures in f64: bilinear in a level, linear between levels, as the GPU is asked to filter them.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec4};
use scene::{Image, Scene, TextureRef};

/// The part of a texture that a pixel covers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Its middle.
    pub uv: DVec2,
    /// Change of uv to the next pixel on the right.
    pub dx: DVec2,
    /// Change of uv to the next pixel below.
    pub dy: DVec2,
}

/// A mip level in linear light.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<DVec4>,
}

/// The pictures of a scene with their mip levels, decoded as sRGB or as data when first asked for.
pub(crate) struct Textures {
    scene: Arc<Scene>,
    chains: HashMap<(usize, bool), OnceLock<Vec<Level>>>,
}

impl Textures {
    pub fn new(scene: Arc<Scene>) -> Self {
        let keys = (0..scene.images.len()).flat_map(|image| [(image, true), (image, false)]);
        let chains = keys.map(|key| (key, OnceLock::new())).collect();
        Self { scene, chains }
    }

    /// A colour: sRGB decoded to linear, alpha as it is.
    pub fn srgb(&self, texture: TextureRef, footprint: &Footprint) -> DVec4 {
        self.sample(texture, footprint, true)
    }

    /// Data: all channels as they are.
    pub fn linear(&self, texture: TextureRef, footprint: &Footprint) -> DVec4 {
        self.sample(texture, footprint, false)
    }

    fn sample(&self, texture: TextureRef, footprint: &Footprint, srgb: bool) -> DVec4 {
        let chain =
            self.chains[&(texture.image, srgb)].get_or_init(|| mips(&self.scene.images[texture.image], srgb));
        let size = DVec2::new(chain[0].width as f64, chain[0].height as f64);
        let texels = (footprint.dx * size).length().max((footprint.dy * size).length());
        if texels <= 1.0 {
            return if texture.sampler.nearest {
                nearest(&chain[0], texture, footprint.uv)
            } else {
                bilinear(&chain[0], texture, footprint.uv)
            };
        }
        let level = libm::log2(texels).min((chain.len() - 1) as f64);
        let (fine, share) = (level as usize, level.fract());
        let coarse = (fine + 1).min(chain.len() - 1);
        let at = |level: usize| bilinear(&chain[level], texture, footprint.uv);
        at(fine).lerp(at(coarse), share)
    }
}

fn nearest(level: &Level, texture: TextureRef, uv: DVec2) -> DVec4 {
    let (x, y) = (uv.x * level.width as f64, uv.y * level.height as f64);
    texel(level, texture, x.floor(), y.floor())
}

fn bilinear(level: &Level, texture: TextureRef, uv: DVec2) -> DVec4 {
    let at = uv * DVec2::new(level.width as f64, level.height as f64) - 0.5;
    let (first, share) = (at.floor(), at - at.floor());
    let row =
        |y: f64| texel(level, texture, first.x, y).lerp(texel(level, texture, first.x + 1.0, y), share.x);
    row(first.y).lerp(row(first.y + 1.0), share.y)
}

fn texel(level: &Level, texture: TextureRef, x: f64, y: f64) -> DVec4 {
    let column = texture.sampler.wrap_u.texel(x, level.width);
    let row = texture.sampler.wrap_v.texel(y, level.height);
    level.texels[row * level.width + column]
}

/// All levels from the full size down to one texel, each the area average of the one before.
fn mips(image: &Image, srgb: bool) -> Vec<Level> {
    let decode = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        match srgb {
            false => c,
            true if c <= 0.04045 => c / 12.92,
            true => libm::pow((c + 0.055) / 1.055, 2.4),
        }
    };
    let table: Vec<f64> = (0..=255).map(decode).collect();
    let texels = image.rgba8.as_chunks::<4>().0.iter().map(|&[r, g, b, a]| {
        let [r, g, b] = [r, g, b].map(|byte| table[byte as usize]);
        DVec4::new(r, g, b, f64::from(a) / 255.0)
    });
    let first =
        Level { width: image.width as usize, height: image.height as usize, texels: texels.collect() };
    let next = |level: &Level| (level.width > 1 || level.height > 1).then(|| halved(level));
    std::iter::successors(Some(first), next).collect()
}

/// Half the size, rounded down, at least 1.
fn halved(level: &Level) -> Level {
    let (width, height) = ((level.width / 2).max(1), (level.height / 2).max(1));
    let mut texels = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            let (columns, rows) = (covered(x, level.width, width), covered(y, level.height, height));
            let mut sum = DVec4::ZERO;
            for &(row, row_share) in &rows {
                for &(column, column_share) in &columns {
                    sum += level.texels[row * level.width + column] * (row_share * column_share);
                }
            }
            texels.push(sum);
        }
    }
    Level { width, height, texels }
}

/// The texels among `full` that texel `index` of `half` covers, and the share of it that each fills.
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
