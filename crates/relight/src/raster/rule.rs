//! Depth rules: the depth that a texel stores, and the comparison by which one of two wins.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined is compiled without the vectors that the caller has"
)]

use super::wide::{Floats, Ints};

/// One of [`super::DepthRule`], in the form of the innermost loops.
///
/// They interpolate two numbers that are linear on the face: N, which set-up computes from a corner's value, and D = 1
/// / w.
pub(super) trait DepthTest: Copy + Send + Sync {
    /// Depth of a texel that no triangle covers.
    const CLEARED: f32;

    /// Factor by which D is multiplied in a row of texels.
    fn row_factor(self, row: usize) -> f32;

    /// Computes the new depths of texels that stored `old`, after a triangle that covers the lanes of `covered`.
    fn updated_depths(self, covered: Ints, n: Floats, d: Floats, in_row: f32, old: Floats) -> Floats;
}

/// N is value / w. The least N / (D * row divisor) wins.
#[derive(Clone, Copy)]
pub(super) struct BentDepthTest<'a> {
    pub rows: &'a [f32],
}

/// N is near / w. The greatest wins.
#[derive(Clone, Copy)]
pub(super) struct PerspectiveDepthTest;

/// N is the value. The greatest that is at most 1 wins.
#[derive(Clone, Copy)]
pub(super) struct OrthographicDepthTest;

impl DepthTest for BentDepthTest<'_> {
    const CLEARED: f32 = 1.0;

    #[inline(always)]
    fn row_factor(self, row: usize) -> f32 {
        self.rows[row]
    }

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: Floats, d: Floats, in_row: f32, old: Floats) -> Floats {
        let depth = (n / (d * Floats::splat(in_row))).greater(Floats::splat(0.0));
        covered.select_floats(depth, old).lesser(old)
    }
}

impl DepthTest for PerspectiveDepthTest {
    const CLEARED: f32 = 0.0;

    #[inline(always)]
    fn row_factor(self, _row: usize) -> f32 {
        1.0
    }

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: Floats, _d: Floats, _in_row: f32, old: Floats) -> Floats {
        // With rounding, near / near may be more than 1.
        covered.select_floats(n.lesser(Floats::splat(1.0)), old).greater(old)
    }
}

impl DepthTest for OrthographicDepthTest {
    const CLEARED: f32 = 0.0;

    #[inline(always)]
    fn row_factor(self, _row: usize) -> f32 {
        1.0
    }

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: Floats, _d: Floats, _in_row: f32, old: Floats) -> Floats {
        let covered = covered | n.at_most(Floats::splat(1.0));
        covered.select_floats(n, old).greater(old)
    }
}
