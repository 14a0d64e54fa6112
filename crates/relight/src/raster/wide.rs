//! Vectors of sixteen numbers, as plain arrays. Within [`pulp::Arch::dispatch`] each operation is one or two
//! instructions.

use std::ops::{Add, BitOr, Mul, Neg, Sub};

pub(super) use crate::lanes::{F32s, LANES};
use crate::lanes::{lanewise, operator};

/// Sixteen integers with wrapping sums and products. As a condition, a lane holds if it is not negative.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Ints(pub [i32; LANES]);

pub(super) const LANE_INDICES: Ints = Ints([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);

operator!(Ints, Add, add, a, b, a.wrapping_add(b));
operator!(Ints, Sub, sub, a, b, a.wrapping_sub(b));
operator!(Ints, Mul, mul, a, b, a.wrapping_mul(b));
operator!(Ints, BitOr, bitor, a, b, a | b);

impl Neg for Ints {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::ZERO - self
    }
}

impl F32s {
    lanewise! {
        /// Computes `self * factor + term`, rounded once.
        pub(super) fn times_plus(x, factor: Self, term: Self) -> Self = x.mul_add(factor, term);
        /// Returns the lesser; `other` if `self` is NaN.
        pub(super) fn lesser(x, other: Self) -> Self = if x < other { x } else { other };
        /// Returns the greater; `other` if `self` is NaN.
        pub(super) fn greater(x, other: Self) -> Self = if x > other { x } else { other };
        /// Condition that holds if `self <= other`, and neither is NaN.
        pub(super) fn at_most(x, other: Self) -> Ints = if x <= other { 0 } else { -1 };
        pub(super) fn bits(x) -> Ints = x.to_bits().cast_signed();
    }
}

impl Ints {
    pub const ZERO: Self = Self([0; LANES]);

    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: i32) -> Self {
        Self([x; LANES])
    }

    lanewise! {
        /// Converts to floats, exactly below 2^24.
        pub fn floats(x) -> F32s = x as f32;
        /// Divides by 256, the number of steps in a texel, and rounds down.
        pub fn whole_texels(x) -> Self = x >> 8;
        pub fn least(x, other: Self) -> Self = x.min(other);
        pub fn greatest(x, other: Self) -> Self = x.max(other);
        /// Selects `held` where the condition `self` holds, else `other`.
        pub fn select(x, held: Self, other: Self) -> Self = if x >= 0 { held } else { other };
        /// Selects `held` where the condition `self` holds, else `other`.
        pub fn select_floats(x, held: F32s, other: F32s) -> F32s = if x >= 0 { held } else { other };
    }
}
