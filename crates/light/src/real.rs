//! One algorithm, two widths: what the model needs of `f32` and `f64` and of glam's vectors over them.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::{DVec3, Vec3};

/// `f32` or `f64`, with the constants of the light model that depend on the width.
pub trait Real:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// glam's vector of this width.
    type Vec3: Copy
        + Debug
        + PartialEq
        + Add<Output = Self::Vec3>
        + Sub<Output = Self::Vec3>
        + Mul<Self, Output = Self::Vec3>
        + Neg<Output = Self::Vec3>;

    /// Newton steps of the solver that reach rounding level from its starting bound.
    const NEWTON_STEPS: usize;
    /// Two roots closer in t than this are one root, seen from both sides of a joint.
    const JOINT_MERGE: Self;
    /// Below this length a direction is rounding noise and the tangent is used.
    const DIRECTION_FLOOR: Self;
    /// Relative growth of a segment's box that keeps rounding from pruning a true root.
    const BOX_INFLATION: Self;

    /// The nearest value of this width.
    #[must_use]
    fn of(x: f64) -> Self;
    /// The same value as `f64`, exactly.
    fn f64(self) -> f64;
    /// The nearest vector of this width.
    fn vec(v: DVec3) -> Self::Vec3;
    /// The same vector as `f64`, exactly.
    fn vec_f64(v: Self::Vec3) -> DVec3;
    /// Scalar product.
    fn dot(a: Self::Vec3, b: Self::Vec3) -> Self;
    /// Vector product.
    fn cross(a: Self::Vec3, b: Self::Vec3) -> Self::Vec3;
    /// Square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Absolute value.
    #[must_use]
    fn abs(self) -> Self;
    /// An upper bound of the cube root of `self > 0`, at most 7 % above it.
    #[must_use]
    fn cbrt_above(self) -> Self;

    /// The smaller one.
    #[must_use]
    fn least(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    /// The larger one.
    #[must_use]
    fn most(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    /// `self` limited to `[low, high]`.
    #[must_use]
    fn within(self, low: Self, high: Self) -> Self {
        self.most(low).least(high)
    }
    /// Unit vector along `v`, or `None` where `v` is zero.
    fn unit(v: Self::Vec3) -> Option<Self::Vec3> {
        let length = Self::dot(v, v).sqrt();
        (length > Self::of(0.0)).then(|| v * (Self::of(1.0) / length))
    }
}

impl Real for f64 {
    type Vec3 = DVec3;
    const NEWTON_STEPS: usize = 5;
    const JOINT_MERGE: Self = 1e-9;
    const DIRECTION_FLOOR: Self = 1e-140;
    const BOX_INFLATION: Self = 1e-13;

    fn of(x: f64) -> Self {
        x
    }
    fn f64(self) -> f64 {
        self
    }
    fn vec(v: DVec3) -> DVec3 {
        v
    }
    fn vec_f64(v: DVec3) -> DVec3 {
        v
    }
    fn dot(a: DVec3, b: DVec3) -> Self {
        a.dot(b)
    }
    fn cross(a: DVec3, b: DVec3) -> DVec3 {
        a.cross(b)
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn abs(self) -> Self {
        self.abs()
    }
    fn cbrt_above(self) -> Self {
        // Correct to a unit in the last place; the margin keeps it a bound.
        libm::cbrt(self) * 1.06
    }
}

impl Real for f32 {
    type Vec3 = Vec3;
    const NEWTON_STEPS: usize = 3;
    const JOINT_MERGE: Self = 1e-5;
    const DIRECTION_FLOOR: Self = 1e-18;
    const BOX_INFLATION: Self = 1e-5;

    fn of(x: f64) -> Self {
        x as f32
    }
    fn f64(self) -> f64 {
        f64::from(self)
    }
    fn vec(v: DVec3) -> Vec3 {
        v.as_vec3()
    }
    fn vec_f64(v: Vec3) -> DVec3 {
        v.as_dvec3()
    }
    fn dot(a: Vec3, b: Vec3) -> Self {
        a.dot(b)
    }
    fn cross(a: Vec3, b: Vec3) -> Vec3 {
        a.cross(b)
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    fn abs(self) -> Self {
        self.abs()
    }
    fn cbrt_above(self) -> Self {
        // A third of the exponent, by the bits: within 6 % below, so 1.06 times it is above (as in solve.wgsl).
        f32::from_bits(self.to_bits() / 3 + 709_921_077) * 1.06
    }
}
