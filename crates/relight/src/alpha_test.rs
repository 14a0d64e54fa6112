//! Alpha tests of triangles, like `alpha_test.wgsl`: textures are sampled at full size, bilinearly.

#[cfg(test)]
impl AlphaTest {
    /// Test on a texture of one texel, as a base for tests.
    pub(crate) const OF_ONE_TEXEL: Self = Self {
        first_triangle: 0,
        first_index: 0,
        cutoff: 0.5,
        factor: 1.0,
        offset: 0,
        width: 1,
        height: 1,
        wrap_u: TexelWrap::Repeat,
        wrap_v: TexelWrap::Repeat,
        nearest: false,
    };
}

#[cfg(test)]
mod tests;

use glam::{Vec2, Vec3};

/// Texture lookup beyond the edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TexelWrap {
    #[default]
    Repeat,
    /// Repeats the texture, every other time mirrored.
    MirroredRepeat,
    ClampToEdge,
}

/// Alpha test of one material's triangles, with its texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaTest {
    /// First triangle with this test, counted among the triangles with an alpha test.
    pub first_triangle: u32,
    /// Position of that triangle's first corner in the scene's indices.
    pub first_index: u32,
    /// Least alpha that is solid. With 0 there are no holes.
    pub cutoff: f32,
    /// Factor of alpha in the material. Vertices and texels have further factors.
    pub factor: f32,
    /// Index of the texture's first texel in `AlphaTests::texels`.
    pub offset: u32,
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    pub wrap_u: TexelWrap,
    pub wrap_v: TexelWrap,
    /// True if texels are not blended.
    pub nearest: bool,
}

/// All alpha tests of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct AlphaTests<'a> {
    /// Sorted by first triangle.
    pub tests: &'a [AlphaTest],
    /// Alpha of all textures; 255 is 1.
    pub texels: &'a [u8],
}

impl AlphaTests<'_> {
    /// Returns the index of a triangle's test: the last test that begins at or before the triangle. Triangles count
    /// from the first that has a test.
    pub fn test_of(&self, triangle: u32) -> usize {
        self.tests.partition_point(|test| test.first_triangle <= triangle).saturating_sub(1)
    }

    /// Returns the scene's index of a triangle with a test.
    pub(crate) fn scene_triangle(&self, triangle: u32) -> u32 {
        let test = &self.tests[self.test_of(triangle)];
        test.first_index / 3 + (triangle - test.first_triangle)
    }

    /// True if a triangle has a hole at a point. `corners` are (u, v, alpha), and `weights` the barycentrics of the
    /// point.
    pub fn has_hole(&self, triangle: u32, corners: [Vec3; 3], weights: Vec3) -> bool {
        let here = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
        self.is_hole(self.test_of(triangle), here)
    }

    /// True if a test makes a hole at the point `here`, which is (u, v, alpha).
    #[inline(always)]
    pub fn is_hole(&self, test: usize, here: Vec3) -> bool {
        let test = &self.tests[test];
        test.factor * here.z * self.texel_alpha(test, here.truncate()) < test.cutoff
    }

    /// Samples the texture's alpha at `uv`.
    #[inline(always)]
    pub fn texel_alpha(&self, test: &AlphaTest, uv: Vec2) -> f32 {
        let at = uv * Vec2::new(test.width as f32, test.height as f32);
        // Uses the floor of the standard library. Others call code without vectors, or are as slow.
        let column = |x: f32| wrapped(x, test.width as usize, test.wrap_u);
        let row = |y: f32| wrapped(y, test.height as usize, test.wrap_v);
        if test.nearest {
            return self.texel(test, column(at.x.floor()), row(at.y.floor()));
        }
        let at = at - 0.5;
        let first = Vec2::new(at.x.floor(), at.y.floor());
        let share = at - first;
        let (left, right) = (column(first.x), column(first.x + 1.0));
        let (upper, lower) = (row(first.y), row(first.y + 1.0));
        let top = mix(self.texel(test, left, upper), self.texel(test, right, upper), share.x);
        let bottom = mix(self.texel(test, left, lower), self.texel(test, right, lower), share.x);
        mix(top, bottom, share.y)
    }

    #[inline(always)]
    fn texel(&self, test: &AlphaTest, column: usize, row: usize) -> f32 {
        f32::from(self.texels[test.offset as usize + row * test.width as usize + column]) / 255.0
    }
}

/// Returns the texel for an integer coordinate along one axis.
#[inline(always)]
pub(crate) fn wrapped(x: f32, size: usize, wrap: TexelWrap) -> usize {
    let size = size as f32;
    let period = if wrap == TexelWrap::MirroredRepeat { 2.0 * size } else { size };
    let inside = x - period * ((x + 0.5) / period).floor();
    let found = match wrap {
        TexelWrap::Repeat => inside,
        TexelWrap::MirroredRepeat => inside.min(period - 1.0 - inside),
        TexelWrap::ClampToEdge => x,
    };
    found.clamp(0.0, size - 1.0) as usize
}

#[inline(always)]
fn mix(a: f32, b: f32, share: f32) -> f32 {
    a * (1.0 - share) + b * share
}
