//! Solvers that are compared.

use light::Curve;
use serde::{Deserialize, Serialize};

use super::closed_form::RealRoots;
use super::cubic::Cubic;
use super::found::FoundRoots;
use super::width::FloatWidth;
use super::{blinn, closed_form, iterative};

/// Method to find the parameters at which a curve is perpendicular to the direction of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Method {
    /// The product's solver: [`light::increasing_roots`].
    Ours,
    /// The general cubic formula.
    Naive,
    /// Cardano's method as the paper has it.
    Cardano,
    /// Trigonometric and hyperbolic.
    Viete,
    /// Blinn's homogeneous cubic.
    Blinn,
    /// Newton's method between brackets.
    Yuksel,
    /// Newton's method, fixed steps.
    Newton,
    /// Halley's method, fixed steps.
    Halley,
    /// The cubic of a well-known distance to a Bezier curve.
    Quilez,
}

/// All methods, in the order of reports.
pub const METHODS: [Method; 9] = [
    Method::Ours,
    Method::Naive,
    Method::Cardano,
    Method::Viete,
    Method::Blinn,
    Method::Yuksel,
    Method::Newton,
    Method::Halley,
    Method::Quilez,
];

/// Solver function. It returns the parameters on the segment at which the distance to the point has a minimum.
pub type SolverFn<F> = fn(&Curve<F>, <F as light::Lanes>::Vec3) -> FoundRoots<F>;

impl Method {
    /// Returns the function of this method in precision `F`.
    pub fn solver<F: FloatWidth>(self) -> SolverFn<F> {
        match self {
            Self::Ours => ours,
            Self::Naive => |s, q| from_cubic(s, q, closed_form::naive),
            Self::Cardano => |s, q| from_cubic(s, q, closed_form::cardano),
            Self::Viete => |s, q| from_cubic(s, q, closed_form::viete),
            Self::Blinn => |s, q| from_cubic(s, q, blinn::blinn),
            Self::Yuksel => |s, q| from_cubic(s, q, iterative::yuksel),
            Self::Newton => |s, q| from_cubic(s, q, iterative::newton),
            Self::Halley => |s, q| from_cubic(s, q, iterative::halley),
            Self::Quilez => |s, q| from_cubic(s, q, closed_form::quilez),
        }
    }
}

fn ours<F: FloatWidth>(curve: &Curve<F>, q: F::Vec3) -> FoundRoots<F> {
    let f0 = -F::dot(q - curve.b0, curve.d0);
    let f1 = -F::dot(q - curve.b2, curve.d1);
    light::increasing_roots(curve, q, f0, f1).found().collect()
}

/// Applies the method to the cubic of a curve and a point. Inlined, so that each method compiles to one piece of code.
#[inline]
fn from_cubic<F: FloatWidth>(
    curve: &Curve<F>,
    q: F::Vec3,
    roots: impl FnOnce(&Cubic<F>) -> RealRoots<F>,
) -> FoundRoots<F> {
    let cubic = Cubic::of(curve, q);
    cubic.minima_on_segment(roots(&cubic).into_iter().flatten())
}
