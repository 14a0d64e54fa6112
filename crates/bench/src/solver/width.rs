//! `f32` and `f64`, with functions that the comparison needs beyond [`light::Real`].

use light::{Curve, Real};
use num_traits::Float;
use serde::Serialize;

/// Floating-point precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    F32,
    F64,
}

impl Precision {
    /// Returns the eps of the bounds (light model, section 5): 2^-24 or 2^-52.
    pub fn eps(self) -> f64 {
        match self {
            Self::F32 => 1.0 / (1_u64 << 24) as f64,
            Self::F64 => f64::EPSILON,
        }
    }
}

/// Floating-point type in which solvers are compared.
pub trait FloatWidth: Real + Float + Send + Sync + 'static {
    /// Value of this type in reports.
    const PRECISION: Precision;
    /// The bound `K` on the backward error (light model, section 5): the usual one, and the one for families whose `P'`
    /// almost vanishes.
    const BACKWARD_ERROR_BOUNDS: [f64; 2];
    /// Distance past an end of the segment within which other methods' roots count as roots at the end. It is the
    /// amount by which rounding moves an ordinary root, so that no root is lost between two segments. Of three values
    /// that were tried, this one is best.
    const END_SLACK: f64;

    /// Rounds each number of a curve to this type.
    fn curve(curve: &Curve<f64>) -> Curve<Self>;
}

impl FloatWidth for f32 {
    const PRECISION: Precision = Precision::F32;
    const BACKWARD_ERROR_BOUNDS: [f64; 2] = [16.0, 64.0];
    const END_SLACK: f64 = 1e-6;

    fn curve(curve: &Curve<f64>) -> Curve<Self> {
        curve.to_f32()
    }
}

impl FloatWidth for f64 {
    const PRECISION: Precision = Precision::F64;
    const BACKWARD_ERROR_BOUNDS: [f64; 2] = [4.0, 4.0];
    const END_SLACK: f64 = 1e-15;

    fn curve(curve: &Curve<f64>) -> Curve<Self> {
        *curve
    }
}
