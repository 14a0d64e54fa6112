//! `f32` and `f64`, with what the comparison needs beyond the model's own [`light::Real`].

use light::{Curve, Real};
use num_traits::Float;
use serde::Serialize;

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single.
    F32,
    /// Double.
    F64,
}

impl Precision {
    /// The bars' eps (light model, section 5): 2^-24 or 2^-52.
    pub fn eps(self) -> f64 {
        match self {
            Self::F32 => 1.0 / (1_u64 << 24) as f64,
            Self::F64 => f64::EPSILON,
        }
    }
}

/// A width of float that solvers are compared in.
pub trait FloatWidth: Real + Float + Send + Sync + 'static {
    /// As answers call it.
    const PRECISION: Precision;
    /// The bar `K` on the backward error (light model, section 5), ordinarily and where `P'` may all but vanish.
    const BACKWARD_ERROR_BOUNDS: [f64; 2];
    /// How far past an end the others' roots may lie and still be taken for one at the end: what rounding moves an
    /// ordinary root by, so that none is lost between two segments. The best of three that were tried.
    const END_SLACK: f64;

    /// The curve with each number rounded to this width.
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
