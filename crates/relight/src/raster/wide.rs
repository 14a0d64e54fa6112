//! Sixteen numbers at once, as plain arrays. Within [`pulp::Arch::dispatch`] each operation is one or two instructions.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined is compiled without the vectors that the caller has"
)]

use std::ops::{Add, BitOr, Div, Mul, Neg, Sub};

/// How many numbers there are at once.
pub(super) const LANES: usize = 16;

/// Sixteen floats.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Floats(pub [f32; LANES]);

/// Sixteen integers, whose sums and products wrap. As a condition, a lane that is not negative holds.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Ints(pub [i32; LANES]);

/// 0, 1, 2 and so on.
pub(super) const LANE_INDICES: Ints = Ints([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);

/// A function of lanes: `name(a: Type, ...) -> Type = what it does to one lane of each`.
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

/// An operator of two lanes of the same type.
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
    /// 0 in each lane.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// The same number in each lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    lanewise! {
        /// `self * factor + term`, rounded once.
        times_plus(x, factor: Self, term: Self) -> Self = x.mul_add(factor, term);
        absolute(x) -> Self = x.abs();
        /// The lesser; `other` where `self` is no number.
        lesser(x, other: Self) -> Self = if x < other { x } else { other };
        /// The greater; `other` where `self` is no number.
        greater(x, other: Self) -> Self = if x > other { x } else { other };
        /// Holds where `self <= other`, and both are numbers.
        at_most(x, other: Self) -> Ints = if x <= other { 0 } else { -1 };
        bits(x) -> Ints = x.to_bits().cast_signed();
    }
}

impl Ints {
    /// 0 in each lane.
    pub const ZERO: Self = Self([0; LANES]);

    /// The same number in each lane.
    #[inline(always)]
    pub fn splat(x: i32) -> Self {
        Self([x; LANES])
    }

    /// Divided by 2^`bits`, rounded down.
    #[inline(always)]
    pub fn shifted_down(self, bits: u32) -> Self {
        let mut out = self;
        for x in &mut out.0 {
            *x >>= bits;
        }
        out
    }

    lanewise! {
        /// Below 2^24 exactly.
        floats(x) -> Floats = x as f32;
        least(x, other: Self) -> Self = x.min(other);
        greatest(x, other: Self) -> Self = x.max(other);
        /// Where the condition `self` holds the one, else the other.
        select(x, held: Self, other: Self) -> Self = if x >= 0 { held } else { other };
        /// Where the condition `self` holds the one, else the other.
        select_floats(x, held: Floats, other: Floats) -> Floats = if x >= 0 { held } else { other };
    }
}
