//! Sixteen numbers side by side.
//!
//! Plain arrays and loops over them. Inlined into a function that [`crate::simd::run`] compiled for the processor at hand they
//! become its vectors, two or four where its own are shorter. Each lane has the bits that `f32` code has.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;
use light::{Lanes, Mask};

/// How many there are.
pub(crate) const LANES: usize = 16;

/// A number a lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct F32s(pub [f32; LANES]);

/// A whole number a lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct U32s(pub [u32; LANES]);

/// A vector a lane.
#[derive(Clone, Copy, Debug)]
pub struct Vec3s {
    pub x: F32s,
    pub y: F32s,
    pub z: F32s,
}

/// An answer a lane: all bits or none.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Masks(pub [u32; LANES]);

/// A binary operation of each lane.
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

impl Mask for Masks {
    #[inline(always)]
    fn of(answer: bool) -> Self {
        Self([if answer { u32::MAX } else { 0 }; LANES])
    }
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = 0;
        for i in 0..LANES {
            any |= self.0[i];
        }
        any != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        let mut all = u32::MAX;
        for i in 0..LANES {
            all &= self.0[i];
        }
        all == u32::MAX
    }
    #[inline(always)]
    fn decided(self) -> Option<bool> {
        None
    }
}

impl Masks {
    /// One lane's answer.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> bool {
        self.0[lane] != 0
    }
}

/// A comparison of each lane.
macro_rules! compare {
    ($name:ident, $op:tt) => {
        #[inline(always)]
        fn $name(self, other: Self) -> Masks {
            let mut out = Masks([0; LANES]);
            for i in 0..LANES {
                out.0[i] = if self.0[i] $op other.0[i] { u32::MAX } else { 0 };
            }
            out
        }
    };
}

impl Lanes for F32s {
    type Vec3 = Vec3s;
    type Mask = Masks;
    const NEWTON_STEPS: usize = <f32 as Lanes>::NEWTON_STEPS;
    const DIRECTION_FLOOR: Self = Self([<f32 as Lanes>::DIRECTION_FLOOR; LANES]);

    compare!(lt, <);
    compare!(le, <=);
    compare!(equals, ==);

    #[inline(always)]
    fn of(x: f64) -> Self {
        Self::splat(x as f32)
    }
    #[inline(always)]
    fn vec(v: DVec3) -> Vec3s {
        Vec3s::splat(v.as_vec3().to_array())
    }
    #[inline(always)]
    fn vec3([x, y, z]: [Self; 3]) -> Vec3s {
        Vec3s { x, y, z }
    }
    #[inline(always)]
    fn coordinates(v: Vec3s) -> [Self; 3] {
        [v.x, v.y, v.z]
    }
    #[inline(always)]
    fn dot(a: Vec3s, b: Vec3s) -> Self {
        a.x * b.x + a.y * b.y + a.z * b.z
    }
    #[inline(always)]
    fn cross(a: Vec3s, b: Vec3s) -> Vec3s {
        Vec3s { x: a.y * b.z - b.y * a.z, y: a.z * b.x - b.z * a.x, z: a.x * b.y - b.x * a.y }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].sqrt();
        }
        out
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].abs();
        }
        out
    }
    #[inline(always)]
    fn cbrt_above(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].cbrt_above();
        }
        out
    }
    #[inline(always)]
    fn pow(self, exponent: f64) -> Self {
        crate::elementary::pow(self, exponent as f32)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        crate::elementary::atan2(self, x)
    }
    #[inline(always)]
    fn select(mask: Masks, yes: Self, no: Self) -> Self {
        let mut out = no;
        for i in 0..LANES {
            out.0[i] = if mask.0[i] != 0 { yes.0[i] } else { no.0[i] };
        }
        out
    }
    #[inline(always)]
    fn select_vec(mask: Masks, yes: Vec3s, no: Vec3s) -> Vec3s {
        Vec3s {
            x: Self::select(mask, yes.x, no.x),
            y: Self::select(mask, yes.y, no.y),
            z: Self::select(mask, yes.z, no.z),
        }
    }
}

impl F32s {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: f32) -> Self {
        Self([x; LANES])
    }
    /// Sixteen numbers from the beginning of some.
    #[inline(always)]
    pub fn load(from: &[f32; LANES]) -> Self {
        Self(*from)
    }
    /// The largest whole number that is no larger, for what fits into 31 bits.
    #[inline(always)]
    pub fn floor(self) -> Self {
        let mut out = self;
        for i in 0..LANES {
            out.0[i] = self.0[i].floor();
        }
        out
    }
    /// The whole numbers towards zero; what is below zero becomes 0.
    #[inline(always)]
    pub fn to_u32(self) -> U32s {
        let mut out = U32s([0; LANES]);
        for i in 0..LANES {
            // As i32, which processors convert to at once.
            out.0[i] = self.0[i].max(0.0) as i32 as u32;
        }
        out
    }
    /// The bits.
    #[inline(always)]
    pub fn to_bits(self) -> U32s {
        let mut out = U32s([0; LANES]);
        for i in 0..LANES {
            out.0[i] = self.0[i].to_bits();
        }
        out
    }
    /// What bits stand for.
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
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(x: u32) -> Self {
        Self([x; LANES])
    }
    /// As floats; exact below 2^24, taken as signed.
    #[inline(always)]
    pub fn to_f32(self) -> F32s {
        let mut out = F32s([0.0; LANES]);
        for i in 0..LANES {
            out.0[i] = self.0[i] as i32 as f32;
        }
        out
    }
    /// Which lanes have the same number.
    #[inline(always)]
    pub fn equals(self, other: Self) -> Masks {
        let mut out = Masks([0; LANES]);
        for i in 0..LANES {
            out.0[i] = if self.0[i] == other.0[i] { u32::MAX } else { 0 };
        }
        out
    }
    /// `yes` where `mask` says so, else `no`.
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
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat([x, y, z]: [f32; 3]) -> Self {
        Self { x: F32s::splat(x), y: F32s::splat(y), z: F32s::splat(z) }
    }
    /// One lane's vector.
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
