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

/// Implements a binary operator lane by lane.
macro_rules! binary {
    ($trait:ident, $name:ident, $lanes:ident, $op:tt) => {
        impl $trait for $lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let mut out = self;
                for i in 0..LANES {
                    out.0[i] = self.0[i] $op other.0[i];
                }
                out
            }
        }
    };
}

binary!(Add, add, F32s, +);
binary!(Sub, sub, F32s, -);
binary!(Mul, mul, F32s, *);
binary!(Div, div, F32s, /);
binary!(BitAnd, bitand, Masks, &);
binary!(BitOr, bitor, Masks, |);
binary!(BitAnd, bitand, U32s, &);
binary!(BitOr, bitor, U32s, |);

/// Implements a wrapping integer operator lane by lane.
macro_rules! wrapping {
    ($trait:ident, $name:ident, $op:ident) => {
        impl $trait for U32s {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let mut out = self;
                for i in 0..LANES {
                    out.0[i] = self.0[i].$op(other.0[i]);
                }
                out
            }
        }
    };
}

wrapping!(Add, add, wrapping_add);
wrapping!(Sub, sub, wrapping_sub);
wrapping!(Mul, mul, wrapping_mul);

impl Neg for F32s {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = -self.0[i];
        }
        out
    }
}

impl Not for Masks {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = !self.0[i];
        }
        out
    }
}

impl Masks {
    /// Returns the value of one lane.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> bool {
        self.0[lane] != 0
    }
}

impl F32s {
    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self([x; LANES])
    }
    /// Rounds down, for values that fit into 31 bits.
    #[inline(always)]
    pub fn floor(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].floor();
        }
        out
    }
    /// Rounds values from 0 to 2^22 to the nearest integers, ties to even. A cast handles every number and does not
    /// vectorize.
    #[inline(always)]
    pub fn to_u32(self) -> U32s {
        let mut out = U32s([0; LANES]);
        for i in 0..LANES {
            // From 2^23 on the last bit of a float is 1.
            out.0[i] = (self.0[i] + 8_388_608.0).to_bits().wrapping_sub(0x4b00_0000);
        }
        out
    }
    #[inline(always)]
    pub fn to_bits(self) -> U32s {
        let mut out = U32s([0; LANES]);
        for i in 0..LANES {
            out.0[i] = self.0[i].to_bits();
        }
        out
    }
    #[inline(always)]
    pub fn from_bits(bits: U32s) -> Self {
        let mut out = Self([0.0; LANES]);
        for i in 0..LANES {
            out.0[i] = f32::from_bits(bits.0[i]);
        }
        out
    }
}

impl U32s {
    /// Puts the same number into every lane.
    #[inline(always)]
    pub fn splat(x: u32) -> Self {
        Self([x; LANES])
    }
    /// Returns the lanes with equal numbers.
    #[inline(always)]
    pub fn equals(self, other: Self) -> Masks {
        let mut out = Masks([0; LANES]);
        for i in 0..LANES {
            out.0[i] = if self.0[i] == other.0[i] { u32::MAX } else { 0 };
        }
        out
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

impl Add for Vec3s {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Vec3s {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul<F32s> for Vec3s {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: F32s) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl Mul for Vec3s {
    type Output = Self;
    #[inline(always)]
    fn mul(self, by: Self) -> Self {
        Self { x: self.x * by.x, y: self.y * by.y, z: self.z * by.z }
    }
}

impl Neg for Vec3s {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
