//! Depth rules: the depth that a texel stores, and the comparison by which one of two wins.

use super::wide::{F32s, Ints};

/// One of [`super::DepthRule`], in the form of the innermost loops.
///
/// They interpolate two numbers that are linear on the face: N, which set-up computes from a corner's value, and D = 1
/// / w.
pub(super) trait DepthTest: Copy + Send + Sync {
    /// Depth of a texel that no triangle covers.
    const CLEARED: f32;

    /// Factor by which D is multiplied in a row of texels.
    #[inline(always)]
    fn row_factor(self, _row: usize) -> f32 {
        1.0
    }

    /// Computes the new depths of texels that stored `old`, after a triangle that covers the lanes of `covered`.
    fn updated_depths(self, covered: Ints, n: F32s, d: F32s, in_row: f32, old: F32s) -> F32s;
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
    fn updated_depths(self, covered: Ints, n: F32s, d: F32s, in_row: f32, old: F32s) -> F32s {
        let depth = (n / (d * F32s::splat(in_row))).greater(F32s::ZERO);
        covered.select_floats(depth, old).lesser(old)
    }
}

impl DepthTest for PerspectiveDepthTest {
    const CLEARED: f32 = 0.0;

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: F32s, _d: F32s, _in_row: f32, old: F32s) -> F32s {
        // With rounding, near / near may be more than 1.
        covered.select_floats(n.lesser(F32s::splat(1.0)), old).greater(old)
    }
}

impl DepthTest for OrthographicDepthTest {
    const CLEARED: f32 = 0.0;

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: F32s, _d: F32s, _in_row: f32, old: F32s) -> F32s {
        let covered = covered | n.at_most(F32s::splat(1.0));
        covered.select_floats(n, old).greater(old)
    }
}
