//! Textures of surfaces, sampled as a GPU samples them: bilinearly in each mip level, and linearly between two levels.

use glam::Vec2;

use crate::alpha_test::{TexelWrap, wrapped};

/// Picture with its mip levels, with linear values.
#[derive(Clone, Debug)]
pub struct Texture {
    levels: Vec<TextureLevel>,
    texels: Texels,
}

/// RGBA of all levels, from the full size down, rows from the top.
#[derive(Clone, Debug)]
pub enum Texels {
    /// 255 is 1.
    Unorm8(Vec<[u8; 4]>),
    /// 65535 is 1.
    Unorm16(Vec<[u16; 4]>),
}

#[derive(Clone, Copy, Debug)]
struct TextureLevel {
    width: usize,
    height: usize,
    /// Index of the first texel.
    first: usize,
}

/// Texture of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampledTexture {
    /// Index in [`crate::SurfaceMaterials::textures`].
    pub texture: usize,
    pub wrap_u: TexelWrap,
    pub wrap_v: TexelWrap,
    /// True if texels are not blended where they are larger than pixels.
    pub nearest: bool,
}

impl Texture {
    /// Makes a texture of this size. Each level has half the size of the one before, rounded down and at least 1, down to
    /// one texel.
    pub fn new([width, height]: [u32; 2], texels: Texels) -> Self {
        let (mut width, mut height, mut first) = (width as usize, height as usize, 0);
        let mut levels = vec![TextureLevel { width, height, first }];
        while width > 1 || height > 1 {
            first += width * height;
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            levels.push(TextureLevel { width, height, first });
        }
        Self { levels, texels }
    }

    /// Returns the size in bytes.
    pub fn bytes(&self) -> u64 {
        match &self.texels {
            Texels::Unorm8(texels) => size_of_val(&texels[..]) as u64,
            Texels::Unorm16(texels) => size_of_val(&texels[..]) as u64,
        }
    }

    /// Samples the texture at `uv`, for a pixel over which uv changes by `uv_dx` to the right and `uv_dy` down.
    ///
    /// The level of detail is the logarithm of the longer change in texels, as Vulkan defines it.
    pub(crate) fn sample(&self, how: &SampledTexture, uv: Vec2, uv_dx: Vec2, uv_dy: Vec2) -> [f32; 4] {
        let TextureLevel { width, height, .. } = self.levels[0];
        let size = Vec2::new(width as f32, height as f32);
        let texels_squared = (uv_dx * size).length_squared().max((uv_dy * size).length_squared());
        if texels_squared <= 1.0 {
            return self.sample_level(0, how, uv, how.nearest);
        }
        let last = self.levels.len() - 1;
        let level = (0.5 * libm::log2f(texels_squared)).min(last as f32);
        // A surface that is seen edge on has changes that are not finite.
        let level = if level >= 0.0 { level } else { last as f32 };
        let (lower, share) = (level as usize, level.fract());
        let near = self.sample_level(lower, how, uv, false);
        if share == 0.0 {
            return near;
        }
        let far = self.sample_level((lower + 1).min(last), how, uv, false);
        std::array::from_fn(|c| near[c] + (far[c] - near[c]) * share)
    }

    fn sample_level(&self, level: usize, how: &SampledTexture, uv: Vec2, nearest: bool) -> [f32; 4] {
        let TextureLevel { width, height, .. } = self.levels[level];
        let at = uv * Vec2::new(width as f32, height as f32);
        let column = |x: f32| wrapped(x, width, how.wrap_u);
        let row = |y: f32| wrapped(y, height, how.wrap_v);
        if nearest {
            return self.texel(level, column(at.x.floor()), row(at.y.floor()));
        }
        let at = at - 0.5;
        let first = Vec2::new(at.x.floor(), at.y.floor());
        let share = at - first;
        let (left, right) = (column(first.x), column(first.x + 1.0));
        let (upper, lower) = (row(first.y), row(first.y + 1.0));
        let [a, b] = [self.texel(level, left, upper), self.texel(level, right, upper)];
        let [c, d] = [self.texel(level, left, lower), self.texel(level, right, lower)];
        std::array::from_fn(|k| {
            let (top, bottom) = (a[k] + (b[k] - a[k]) * share.x, c[k] + (d[k] - c[k]) * share.x);
            top + (bottom - top) * share.y
        })
    }

    fn texel(&self, level: usize, column: usize, row: usize) -> [f32; 4] {
        let TextureLevel { width, first, .. } = self.levels[level];
        let index = first + row * width + column;
        match &self.texels {
            Texels::Unorm8(texels) => texels[index].map(|channel| f32::from(channel) / 255.0),
            Texels::Unorm16(texels) => texels[index].map(|channel| f32::from(channel) / 65535.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOW: SampledTexture =
        SampledTexture { texture: 0, wrap_u: TexelWrap::Repeat, wrap_v: TexelWrap::ClampToEdge, nearest: false };

    /// Two by two texels whose red is 0, 1, 2 and 3, over one of red 9.
    fn texture() -> Texture {
        Texture::new([2, 2], Texels::Unorm8([0, 1, 2, 3, 9].map(|red| [red, 0, 0, 255]).to_vec()))
    }

    fn red(how: &SampledTexture, [u, v]: [f32; 2], footprint: f32) -> f32 {
        let [red, ..] = texture().sample(how, Vec2::new(u, v), Vec2::X * footprint, Vec2::Y * footprint);
        red * 255.0
    }

    #[test]
    fn texels_are_blended_between_their_centers_and_wrapped_beyond() {
        for (uv, expected) in [
            ([0.25, 0.25], 0.0),
            ([0.75, 0.25], 1.0),
            ([0.5, 0.5], 1.5),
            // Beyond the right edge comes the left one again, and beyond the lower edge the last row.
            ([1.0, 0.25], 0.5),
            ([0.25, 7.0], 2.0),
            ([0.25, -7.0], 0.0),
        ] {
            assert!((red(&HOW, uv, 0.1) - expected).abs() < 1e-4, "{uv:?}");
        }
        let nearest = SampledTexture { nearest: true, ..HOW };
        assert!((red(&nearest, [0.45, 0.45], 0.1) - 0.0).abs() < 1e-4);
        let mirrored = SampledTexture { wrap_u: TexelWrap::MirroredRepeat, ..HOW };
        assert!((red(&mirrored, [1.25, 0.25], 0.1) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn levels_follow_the_footprint() {
        // A pixel as wide as a texel, as wide as the square root of two texels, as the whole, and wider.
        for (footprint, expected) in [(0.5, 1.5), (0.5 * 2.0_f32.sqrt(), 5.25), (1.0, 9.0), (40.0, 9.0)] {
            assert!((red(&HOW, [0.5, 0.5], footprint) - expected).abs() < 1e-3, "{footprint}");
        }
        // A surface that is seen edge on has no finite footprint.
        assert!((red(&HOW, [0.5, 0.5], f32::NAN) - 9.0).abs() < 1e-4);
        assert!((red(&HOW, [0.5, 0.5], f32::INFINITY) - 9.0).abs() < 1e-4);
    }
}
