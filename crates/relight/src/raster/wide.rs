//! Vectors of sixteen numbers, as plain arrays. Within [`pulp::Arch::dispatch`] each operation is one or two
//! instructions.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined is compiled without the vectors that the caller has"
)]

use std::ops::{Add, BitOr, Div, Mul, Neg, Sub};

/// Number of lanes.
pub(super) const LANES: usize = 16;

/// Sixteen floats.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Floats(pub [f32; LANES]);

/// Sixteen integers with wrapping sums and products. As a condition, a lane holds if it is not negative.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Ints(pub [i32; LANES]);

pub(super) const LANE_INDICES: Ints = Ints([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);

/// Defines functions of lanes: `name(a: Type, ...) -> Type = expression for one lane of each`.
macro_rules! lanewise {
    ($($(#[$doc:meta])* $name:ident($first:ident $(, $other:ident: $type:ty)*) -> $out:ident = $lane:expr;)*) => {$(
        $(#[$doc])*
        #[inline(always)]
        pub fn $name(self $(, $other: $type)*) -> $out {
            let mut out = $out::ZERO;
            for i in 0..LANES {
                let $first = self.0[i];
                $(let $other = $other.0[i];)*
                out.0[i] = $lane;
            }
            out
        }
    )*};
}

/// Implements an operator on two lanes of the same type.
macro_rules! operator {
    ($type:ident, $trait:ident, $name:ident, $a:ident, $b:ident, $lane:expr) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let mut out = Self::ZERO;
                for i in 0..LANES {
                    let ($a, $b) = (self.0[i], other.0[i]);
                    out.0[i] = $lane;
                }
                out
            }
        }
    };
}

operator!(Floats, Add, add, a, b, a + b);
operator!(Floats, Sub, sub, a, b, a - b);
operator!(Floats, Mul, mul, a, b, a * b);
operator!(Floats, Div, div, a, b, a / b);
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

impl Floats {
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    lanewise! {
        /// Computes `self * factor + term`, rounded once.
        times_plus(x, factor: Self, term: Self) -> Self = x.mul_add(factor, term);
        absolute(x) -> Self = x.abs();
        /// Returns the lesser; `other` if `self` is NaN.
        lesser(x, other: Self) -> Self = if x < other { x } else { other };
        /// Returns the greater; `other` if `self` is NaN.
        greater(x, other: Self) -> Self = if x > other { x } else { other };
        /// Condition that holds if `self <= other`, and neither is NaN.
        at_most(x, other: Self) -> Ints = if x <= other { 0 } else { -1 };
        bits(x) -> Ints = x.to_bits().cast_signed();
    }
}

impl Ints {
    pub const ZERO: Self = Self([0; LANES]);

    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: i32) -> Self {
        Self([x; LANES])
    }

    /// Divides by 2^`bits`, rounded down.
    #[inline(always)]
    pub fn shifted_down(self, bits: u32) -> Self {
        let mut out = self;
        for x in &mut out.0 {
            *x >>= bits;
        }
        out
    }

    lanewise! {
        /// Converts to floats, exactly below 2^24.
        floats(x) -> Floats = x as f32;
        least(x, other: Self) -> Self = x.min(other);
        greatest(x, other: Self) -> Self = x.max(other);
        /// Selects `held` where the condition `self` holds, else `other`.
        select(x, held: Self, other: Self) -> Self = if x >= 0 { held } else { other };
        /// Selects `held` where the condition `self` holds, else `other`.
        select_floats(x, held: Floats, other: Floats) -> Floats = if x >= 0 { held } else { other };
    }
}
