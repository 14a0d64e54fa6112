//! Vectors of sixteen numbers.
//!
//! They are plain arrays, and operations are loops over them. Inlined into a function that [`crate::simd::run`]
//! compiled for the present processor they become its vectors, two or four where those are shorter. Each lane has the
//! bits of `f32` code.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Number of lanes.
pub(crate) const LANES: usize = 16;

/// One float per lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct F32s(pub [f32; LANES]);

/// One unsigned integer per lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct U32s(pub [u32; LANES]);

/// One vector per lane.
#[derive(Clone, Copy, Debug)]
pub struct Vec3s {
    pub x: F32s,
    pub y: F32s,
    pub z: F32s,
}

/// One truth value per lane: all bits set, or none.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Masks(pub [u32; LANES]);

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

/// Defines functions of lanes: `fn name(a, b: Type, ...) -> Type = expression for one lane of each`, where `a` is
/// `self`.
macro_rules! lanewise {
    ($(
        $(#[$doc:meta])*
        $vis:vis fn $name:ident($first:ident $(, $other:ident: $type:ty)*) -> $out:ident = $lane:expr;
    )*) => {$(
        $(#[$doc])*
        #[inline(always)]
        $vis fn $name(self $(, $other: $type)*) -> $out {
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

pub(crate) use {lanewise, operator};

operator!(F32s, Add, add, a, b, a + b);
operator!(F32s, Sub, sub, a, b, a - b);
operator!(F32s, Mul, mul, a, b, a * b);
operator!(F32s, Div, div, a, b, a / b);
operator!(Masks, BitAnd, bitand, a, b, a & b);
operator!(Masks, BitOr, bitor, a, b, a | b);
operator!(U32s, BitAnd, bitand, a, b, a & b);
operator!(U32s, BitOr, bitor, a, b, a | b);
operator!(U32s, Add, add, a, b, a.wrapping_add(b));
operator!(U32s, Mul, mul, a, b, a.wrapping_mul(b));

impl Neg for F32s {
    type Output = Self;
    lanewise! { fn neg(x) -> Self = -x; }
}

impl Not for Masks {
    type Output = Self;
    lanewise! { fn not(x) -> Self = !x; }
}

impl Masks {
    pub const ZERO: Self = Self([0; LANES]);

    /// Returns the value of one lane.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> bool {
        self.0[lane] != 0
    }
}

impl F32s {
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    lanewise! {
        /// Rounds down, for values that fit into 31 bits.
        pub fn floor(x) -> Self = x.floor();
        /// Rounds values from 0 to 2^22 to the nearest integers, ties to even. A cast handles every number and does not
        /// vectorize. From 2^23 on the last bit of a float is 1.
        pub fn to_u32(x) -> U32s = (x + 8_388_608.0).to_bits().wrapping_sub(0x4b00_0000);
        pub fn to_bits(x) -> U32s = x.to_bits();
    }
}

impl U32s {
    pub const ZERO: Self = Self([0; LANES]);

    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: u32) -> Self {
        Self([x; LANES])
    }

    lanewise! {
        /// Returns the floats with these bits.
        pub fn to_floats(bits) -> F32s = f32::from_bits(bits);
        /// Returns the lanes with equal numbers.
        pub fn equals(x, other: Self) -> Masks = if x == other { u32::MAX } else { 0 };
    }

    /// Selects `yes` in the lanes of `mask`, else `no`.
    #[inline(always)]
    pub fn select(mask: Masks, yes: Self, no: Self) -> Self {
        let mut out = no;
        for i in 0..LANES {
            out.0[i] = if mask.0[i] != 0 { yes.0[i] } else { no.0[i] };
        }
        out
    }
}

impl Vec3s {
    /// Puts the same vector into every lane.
    #[inline(always)]
    pub fn splat([x, y, z]: [f32; 3]) -> Self {
        Self { x: F32s::splat(x), y: F32s::splat(y), z: F32s::splat(z) }
    }
    /// Returns the vector of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> glam::Vec3 {
        glam::Vec3::new(self.x.0[lane], self.y.0[lane], self.z.0[lane])
    }
}

/// Implements an operator of vectors with `other`.
macro_rules! vector_operator {
    ($trait:ident, $name:ident, $type:ident, $a:ident, $other:ident, $vector:expr) => {
        impl $trait<$type> for Vec3s {
            type Output = Self;
            #[inline(always)]
            fn $name(self, $other: $type) -> Self {
                let $a = self;
                $vector
            }
        }
    };
}

vector_operator!(Add, add, Self, a, b, Self { x: a.x + b.x, y: a.y + b.y, z: a.z + b.z });
vector_operator!(Sub, sub, Self, a, b, Self { x: a.x - b.x, y: a.y - b.y, z: a.z - b.z });
vector_operator!(Mul, mul, Self, a, b, Self { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z });
vector_operator!(Mul, mul, F32s, a, by, Self { x: a.x * by, y: a.y * by, z: a.z * by });

impl Neg for Vec3s {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
