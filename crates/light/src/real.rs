//! Number types with one lane, in two precisions.

use std::fmt::Debug;

use glam::{DVec3, Vec3};

use crate::lanes::Lanes;

/// `f32` or `f64`.
pub trait Real: Lanes<Mask = bool, Vec3: PartialEq> + PartialOrd + Debug {
    /// Distance in t below which two roots are one, seen from both sides of a joint.
    const JOINT_MERGE: Self;
    /// Relative growth of a segment's box that keeps rounding from pruning a true root.
    const BOX_INFLATION: Self;

    /// Converts to `f64`, exactly.
    fn f64(self) -> f64;
    /// Converts to an `f64` vector, exactly.
    fn vec_f64(v: Self::Vec3) -> DVec3;

    /// Returns the unit vector along `v`; `None` if `v` is zero.
    fn unit(v: Self::Vec3) -> Option<Self::Vec3> {
        let length = Self::length(v);
        (length > Self::of(0.0)).then(|| v * (Self::of(1.0) / length))
    }
}

/// Implementations that are written alike for both precisions.
macro_rules! one_lane {
    ($number:ident, $vector:ident) => {
        type Vec3 = $vector;
        type Mask = bool;

        #[inline(always)]
        fn vec3([x, y, z]: [Self; 3]) -> $vector {
            $vector { x, y, z }
        }
        #[inline(always)]
        fn coordinates(v: $vector) -> [Self; 3] {
            v.to_array()
        }
        #[inline(always)]
        fn dot(a: $vector, b: $vector) -> Self {
            a.dot(b)
        }
        #[inline(always)]
        fn cross(a: $vector, b: $vector) -> $vector {
            a.cross(b)
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            $number::sqrt(self)
        }
        #[inline(always)]
        fn abs(self) -> Self {
            $number::abs(self)
        }
        #[inline(always)]
        fn lt(self, other: Self) -> bool {
            self < other
        }
        #[inline(always)]
        fn le(self, other: Self) -> bool {
            self <= other
        }
        #[inline(always)]
        fn equals(self, other: Self) -> bool {
            self == other
        }
        #[inline(always)]
        fn select(mask: bool, yes: Self, no: Self) -> Self {
            if mask { yes } else { no }
        }
        #[inline(always)]
        fn select_vec(mask: bool, yes: $vector, no: $vector) -> $vector {
            if mask { yes } else { no }
        }
    };
}

impl Lanes for f64 {
    one_lane!(f64, DVec3);
    const NEWTON_STEPS: usize = 5;
    const DIRECTION_FLOOR: Self = 1e-140;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn vec(v: DVec3) -> DVec3 {
        v
    }
    fn cbrt_above(self) -> Self {
        // The cube root is correct to a unit in the last place. The margin keeps it a bound.
        libm::cbrt(self) * 1.06
    }
    fn pow(self, exponent: f64) -> Self {
        libm::pow(self, exponent)
    }
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
}

impl Real for f64 {
    const JOINT_MERGE: Self = 1e-9;
    const BOX_INFLATION: Self = 1e-13;

    fn f64(self) -> f64 {
        self
    }
    fn vec_f64(v: DVec3) -> DVec3 {
        v
    }
}

impl Lanes for f32 {
    one_lane!(f32, Vec3);
    const NEWTON_STEPS: usize = 3;
    const DIRECTION_FLOOR: Self = 1e-18;

    #[inline(always)]
    fn of(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn vec(v: DVec3) -> Vec3 {
        v.as_vec3()
    }
    #[inline(always)]
    fn cbrt_above(self) -> Self {
        // Divides the exponent by three in the bits. That is at most 6 % too low, so 1.06 times it is an upper bound
        // (as in solve.wgsl).
        f32::from_bits(self.to_bits() / 3 + 709_921_077) * 1.06
    }
    fn pow(self, exponent: f64) -> Self {
        libm::powf(self, exponent as f32)
    }
    fn atan2(self, x: Self) -> Self {
        libm::atan2f(self, x)
    }
}

impl Real for f32 {
    const JOINT_MERGE: Self = 1e-5;
    const BOX_INFLATION: Self = 1e-5;

    fn f64(self) -> f64 {
        f64::from(self)
    }
    fn vec_f64(v: Vec3) -> DVec3 {
        v.as_dvec3()
    }
}
