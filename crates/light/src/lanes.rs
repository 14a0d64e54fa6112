//! Number types with any number of lanes, for one generic algorithm.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;

/// Result of a comparison, one bool for each lane.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Makes a mask with the same value in every lane.
    #[must_use]
    fn of(answer: bool) -> Self;
    /// Returns true if any lane is true.
    fn any(self) -> bool;
    /// Returns true if every lane is true.
    fn all(self) -> bool;
    /// Returns the value if the type has one lane, so that code may branch. `None` if lanes may differ and both sides
    /// have to be computed.
    fn decided(self) -> Option<bool>;
}

/// `f32`, `f64`, or several `f32` side by side, with the constants of the light model that depend on the precision.
///
/// Instead of branches code uses a [`Mask`] and selects. The value in a lane that is not selected may be infinite or
/// NaN.
pub trait Lanes:
    Copy + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Vector of three coordinates in each lane.
    type Vec3: Copy
        + Debug
        + Add<Output = Self::Vec3>
        + Sub<Output = Self::Vec3>
        + Mul<Self, Output = Self::Vec3>
        + Neg<Output = Self::Vec3>;
    /// Mask that comparisons return.
    type Mask: Mask;

    /// Newton steps in which the solver reaches rounding level from its starting bound.
    const NEWTON_STEPS: usize;
    /// Length below which a direction is rounding noise and the tangent replaces it.
    const DIRECTION_FLOOR: Self;

    /// Converts a number to this precision, in every lane.
    #[must_use]
    fn of(x: f64) -> Self;
    /// Converts a vector to this precision, in every lane.
    fn vec(v: DVec3) -> Self::Vec3;
    /// Makes a vector from its coordinates.
    fn vec3(coordinates: [Self; 3]) -> Self::Vec3;
    fn coordinates(v: Self::Vec3) -> [Self; 3];
    fn dot(a: Self::Vec3, b: Self::Vec3) -> Self;
    fn cross(a: Self::Vec3, b: Self::Vec3) -> Self::Vec3;
    /// Returns the square root, correctly rounded.
    #[must_use]
    fn sqrt(self) -> Self;
    #[must_use]
    fn abs(self) -> Self;
    /// Returns an upper bound of the cube root of `self > 0`, at most 7 % above it.
    #[must_use]
    fn cbrt_above(self) -> Self;
    /// Raises `self >= 0` to the power of `exponent`.
    #[must_use]
    fn pow(self, exponent: f64) -> Self;

    /// Returns the angle of the vector `(x, self)` from the first axis, from -pi to pi, in radians.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// Tests `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Tests `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// Tests `self == other`.
    fn equals(self, other: Self) -> Self::Mask;
    /// Selects `yes` in lanes where `mask` is true, else `no`.
    #[must_use]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Selects vectors.
    fn select_vec(mask: Self::Mask, yes: Self::Vec3, no: Self::Vec3) -> Self::Vec3;

    /// Tests `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// Tests `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// Returns the smaller of two numbers.
    #[must_use]
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }
    /// Returns the larger of two numbers.
    #[must_use]
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self::select(other.gt(self), other, self)
    }
    /// Clamps `self` to `[low, high]`.
    #[must_use]
    #[inline(always)]
    fn within(self, low: Self, high: Self) -> Self {
        self.most(low).least(high)
    }
    #[inline(always)]
    fn length(v: Self::Vec3) -> Self {
        Self::dot(v, v).sqrt()
    }
    /// Returns the unit vector along `v`, or `other` if `v` is zero.
    #[inline(always)]
    fn unit_or(v: Self::Vec3, other: Self::Vec3) -> Self::Vec3 {
        let length = Self::length(v);
        choose!(Self::select_vec, length.gt(Self::of(0.0)), v * (Self::of(1.0) / length), other)
    }
}

/// `choose!(F::select, mask, yes, no)` selects one of two numbers, and with `F::select_vec` one of two vectors. With
/// one lane only the selected side is computed, with many lanes both are.
macro_rules! choose {
    ($select:path, $mask:expr, $yes:expr, $no:expr) => {{
        let mask = $mask;
        match $crate::lanes::Mask::decided(mask) {
            Some(true) => $yes,
            Some(false) => $no,
            None => $select(mask, $yes, $no),
        }
    }};
}

pub(crate) use choose;

impl Mask for bool {
    #[inline(always)]
    fn of(answer: bool) -> Self {
        answer
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn decided(self) -> Option<bool> {
        Some(self)
    }
}
