//! Alpha tests: where triangles have holes. The twin of `alpha_test.wgsl`, with what samplers do done by hand: bilinear
//! in a level, linear between levels.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined is compiled without the vectors that the caller has"
)]

#[cfg(test)]
impl AlphaTest {
    /// Of a picture of one texel, for tests to make theirs of.
    pub(crate) const OF_ONE_TEXEL: Self = Self {
        first_triangle: 0,
        first_index: 0,
        cutoff: 0.5,
        factor: 1.0,
        offset: 0,
        width: 1,
        height: 1,
        levels: 1,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        nearest: false,
    };
}

#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};

/// What becomes of a picture beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It begins again.
    #[default]
    Repeat,
    /// It begins again, every other time turned over.
    Mirror,
    /// Its edge goes on.
    Edge,
}

/// The alpha test of one material's triangles, and the picture it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaTest {
    /// Among the triangles with an alpha test, the first that has this one.
    pub first_triangle: u32,
    /// Where the corners of that one begin in the scene's indices.
    pub first_index: u32,
    /// What there is less of is a hole; 0 has none.
    pub cutoff: f32,
    /// The material's share of what is compared; corners and texels have the others.
    pub factor: f32,
    /// Of the finest level's first texel; the other levels follow, each half as wide and half as high, rounded down,
    /// and at least 1.
    pub offset: u32,
    /// Texels of the finest level.
    pub width: u32,
    /// Texels of the finest level.
    pub height: u32,
    /// How many levels there are, 1 or more.
    pub levels: u32,
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// Magnified texels are not blended.
    pub nearest: bool,
}

/// All alpha tests of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct AlphaTests<'a> {
    /// By their triangles.
    pub tests: &'a [AlphaTest],
    /// Alpha of all pictures; 255 is 1.
    pub texels: &'a [u8],
}

/// A level of a picture.
#[derive(Clone, Copy)]
struct Level {
    offset: usize,
    width: usize,
    height: usize,
}

impl AlphaTest {
    #[inline(always)]
    fn level(&self, level: u32) -> Level {
        let mut found =
            Level { offset: self.offset as usize, width: self.width as usize, height: self.height as usize };
        for _ in 0..level {
            found.offset += found.width * found.height;
            found.width = (found.width / 2).max(1);
            found.height = (found.height / 2).max(1);
        }
        found
    }

    #[inline(always)]
    fn size(&self) -> Vec2 {
        Vec2::new(self.width as f32, self.height as f32)
    }
}

impl AlphaTests<'_> {
    /// Which test a triangle has: the last that begins at or before it. Triangles are counted from the first that has a
    /// test.
    pub fn test_of(&self, triangle: u32) -> usize {
        self.tests.partition_point(|test| test.first_triangle <= triangle).saturating_sub(1)
    }

    /// Which of the scene's triangles one of those with a test is.
    pub(crate) fn scene_triangle(&self, triangle: u32) -> u32 {
        let test = &self.tests[self.test_of(triangle)];
        test.first_index / 3 + (triangle - test.first_triangle)
    }

    /// Whether light that meets a triangle at a point finds a hole there: in full detail, since light that passes has
    /// no pixels. `corners` are (u, v, alpha), `weights` the corners' shares of the point.
    pub fn has_hole(&self, triangle: u32, corners: [Vec3; 3], weights: Vec3) -> bool {
        let here = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
        self.is_hole(self.test_of(triangle), here, Vec2::ZERO, Vec2::ZERO)
    }

    /// Whether there is a hole by a test where (u, v, alpha) are `here`. Uv changes by `dx` and `dy` to the next texels
    /// of the map.
    #[inline(always)]
    pub fn is_hole(&self, test: usize, here: Vec3, dx: Vec2, dy: Vec2) -> bool {
        let test = &self.tests[test];
        test.factor * here.z * self.texel_alpha(test, here.truncate(), dx, dy) < test.cutoff
    }

    /// The picture's alpha at `uv`, which changes by `dx` and `dy` to the next texels of the map.
    ///
    /// The level is that of the shorter way across what a texel of the map covers: by the longer one, as pictures have
    /// it, a card that light grazes would lose its holes.
    #[inline(always)]
    pub fn texel_alpha(&self, test: &AlphaTest, uv: Vec2, dx: Vec2, dy: Vec2) -> f32 {
        let size = test.size();
        // The standard library's roots and floors: others are calls to code without vectors, or as slow.
        let longer = (dx * size).length_squared().max((dy * size).length_squared()).sqrt();
        let area = (dx.x * dy.y - dx.y * dy.x).abs() * size.x * size.y;
        let coarsest = (test.levels - 1) as f32;
        let level = libm::log2f(area.max(1e-30) / longer.max(1e-30)).clamp(0.0, coarsest);
        let fine = test.level(level as u32);
        if level == 0.0 && test.nearest {
            let at = uv * size;
            let column = wrapped(at.x.floor(), fine.width, test.wrap_u);
            return self.texel(fine, column, wrapped(at.y.floor(), fine.height, test.wrap_v));
        }
        let alpha = self.bilinear(test, fine, uv);
        let share = level.fract();
        if share == 0.0 {
            return alpha;
        }
        mix(alpha, self.bilinear(test, test.level(level as u32 + 1), uv), share)
    }

    #[inline(always)]
    fn bilinear(&self, test: &AlphaTest, level: Level, uv: Vec2) -> f32 {
        let at = uv * Vec2::new(level.width as f32, level.height as f32) - 0.5;
        let first = Vec2::new(at.x.floor(), at.y.floor());
        let share = at - first;
        let left = wrapped(first.x, level.width, test.wrap_u);
        let right = wrapped(first.x + 1.0, level.width, test.wrap_u);
        let upper = wrapped(first.y, level.height, test.wrap_v);
        let lower = wrapped(first.y + 1.0, level.height, test.wrap_v);
        let top = mix(self.texel(level, left, upper), self.texel(level, right, upper), share.x);
        let bottom = mix(self.texel(level, left, lower), self.texel(level, right, lower), share.x);
        mix(top, bottom, share.y)
    }

    #[inline(always)]
    fn texel(&self, level: Level, column: usize, row: usize) -> f32 {
        f32::from(self.texels[level.offset + row * level.width + column]) / 255.0
    }
}

/// The texel that a whole number along one axis stands for.
#[inline(always)]
fn wrapped(x: f32, size: usize, wrap: Wrap) -> usize {
    let size = size as f32;
    let period = if wrap == Wrap::Mirror { 2.0 * size } else { size };
    let inside = x - period * ((x + 0.5) / period).floor();
    let found = match wrap {
        Wrap::Repeat => inside,
        Wrap::Mirror => inside.min(period - 1.0 - inside),
        Wrap::Edge => x,
    };
    found.clamp(0.0, size - 1.0) as usize
}

#[inline(always)]
fn mix(a: f32, b: f32, share: f32) -> f32 {
    a * (1.0 - share) + b * share
}
