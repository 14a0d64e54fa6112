//! One algorithm, any number of lanes: what the model needs of a number, or of as many as a processor computes at once.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::DVec3;

/// The answer to a comparison, a lane each.
pub trait Mask: Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The same answer in every lane.
    #[must_use]
    fn of(answer: bool) -> Self;
    /// Whether any lane says yes.
    fn any(self) -> bool;
    /// Whether every lane does.
    fn all(self) -> bool;
    /// The answer where the type has one lane, so that code may branch; `None` where lanes may differ, and both sides have
    /// to be computed.
    fn decided(self) -> Option<bool>;
}

/// `f32`, `f64`, or some `f32` side by side, with the constants of the light model that depend on the width of a number.
///
/// Where code would branch, it asks for a [`Mask`] and chooses. What is computed in a lane that is not chosen may be infinite
/// or no number.
pub trait Lanes:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A vector in each lane.
    type Vec3: Copy
        + Debug
        + Add<Output = Self::Vec3>
        + Sub<Output = Self::Vec3>
        + Mul<Self, Output = Self::Vec3>
        + Neg<Output = Self::Vec3>;
    /// What comparisons give.
    type Mask: Mask;

    /// Newton steps of the solver that reach rounding level from its starting bound.
    const NEWTON_STEPS: usize;
    /// Below this length a direction is rounding noise and the tangent is used.
    const DIRECTION_FLOOR: Self;

    /// The nearest value of this width, in every lane.
    #[must_use]
    fn of(x: f64) -> Self;
    /// The nearest vector of this width, in every lane.
    fn vec(v: DVec3) -> Self::Vec3;
    /// A vector by its coordinates.
    fn vec3(coordinates: [Self; 3]) -> Self::Vec3;
    /// A vector's coordinates.
    fn coordinates(v: Self::Vec3) -> [Self; 3];
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
    /// `self >= 0` to the power of `exponent`.
    #[must_use]
    fn pow(self, exponent: f64) -> Self;

    /// Angle of the vector `(x, self)` from the first axis, from -pi to pi.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// `self < other`
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`
    fn equals(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` says so, else `no`.
    #[must_use]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The same for vectors.
    fn select_vec(mask: Self::Mask, yes: Self::Vec3, no: Self::Vec3) -> Self::Vec3;

    /// `self > other`
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// The smaller one.
    #[must_use]
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }
    /// The larger one.
    #[must_use]
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        Self::select(other.gt(self), other, self)
    }
    /// `self` limited to `[low, high]`.
    #[must_use]
    #[inline(always)]
    fn within(self, low: Self, high: Self) -> Self {
        self.most(low).least(high)
    }
    /// Length of a vector.
    #[inline(always)]
    fn length(v: Self::Vec3) -> Self {
        Self::dot(v, v).sqrt()
    }
    /// Unit vector along `v`, or `other` where `v` is zero.
    #[inline(always)]
    fn unit_or(v: Self::Vec3, other: Self::Vec3) -> Self::Vec3 {
        let length = Self::length(v);
        choose_vec!(Self, length.gt(Self::of(0.0)), v * (Self::of(1.0) / length), other)
    }
}

/// `choose!(F, mask, yes, no)`: one of two numbers. Of one lane only the chosen side is computed, of many both are.
macro_rules! choose {
    ($lanes:ty, $mask:expr, $yes:expr, $no:expr) => {{
        let mask = $mask;
        match $crate::lanes::Mask::decided(mask) {
            Some(true) => $yes,
            Some(false) => $no,
            None => <$lanes as $crate::lanes::Lanes>::select(mask, $yes, $no),
        }
    }};
}

/// The same for vectors.
macro_rules! choose_vec {
    ($lanes:ty, $mask:expr, $yes:expr, $no:expr) => {{
        let mask = $mask;
        match $crate::lanes::Mask::decided(mask) {
            Some(true) => $yes,
            Some(false) => $no,
            None => <$lanes as $crate::lanes::Lanes>::select_vec(mask, $yes, $no),
        }
    }};
}

pub(crate) use {choose, choose_vec};

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
