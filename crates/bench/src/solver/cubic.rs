//! The cubic as other methods need it: four coefficients, and a selection of the roots that count.

use light::Curve;
use num_traits::Float;

use super::found::FoundRoots;
use super::width::FloatWidth;

/// `c3 u^3 + c2 u^2 + c1 u + c0`, half the derivative of the squared distance from the curve to a point.
#[derive(Clone, Copy, Debug)]
pub struct Cubic<F> {
    pub c0: F,
    pub c1: F,
    pub c2: F,
    pub c3: F,
}

impl<F: FloatWidth> Cubic<F> {
    /// Makes the cubic of a segment and a point (light model, section 5).
    pub fn of(curve: &Curve<F>, q: F::Vec3) -> Self {
        let (d0, a, from_start) = (curve.d0, curve.a, q - curve.b0);
        Self {
            c0: -F::dot(from_start, d0),
            c1: F::of(2.0) * F::dot(d0, d0) - F::dot(from_start, a),
            c2: F::of(3.0) * F::dot(d0, a),
            c3: F::dot(a, a),
        }
    }

    /// Selects the roots that a solver should report: those on the segment at which the distance has a minimum. Keeps
    /// NaN.
    pub fn minima_on_segment(&self, roots: impl IntoIterator<Item = F>) -> FoundRoots<F> {
        let slack = F::of(F::END_SLACK);
        let outside = |u: F| u < -slack || u > F::one() + slack;
        let is_maximum = |u: F| self.slope(u) < F::zero();
        roots.into_iter().filter(|&u| !outside(u) && !is_maximum(u)).map(clamp01).collect()
    }
}

/// Clamps a parameter to the segment. NaN stays NaN; `min` and `max` would replace it.
pub fn clamp01<F: Float>(u: F) -> F {
    if u < F::zero() {
        F::zero()
    } else if u > F::one() {
        F::one()
    } else {
        u
    }
}

impl<F: Float> Cubic<F> {
    /// Returns the value at `u`.
    pub fn value(&self, u: F) -> F {
        ((self.c3 * u + self.c2) * u + self.c1) * u + self.c0
    }

    /// Returns the slope at `u`.
    pub fn slope(&self, u: F) -> F {
        let two = F::one() + F::one();
        ((two + F::one()) * self.c3 * u + two * self.c2) * u + self.c1
    }

    /// Returns the second derivative at `u`.
    pub fn bend(&self, u: F) -> F {
        let two = F::one() + F::one();
        two * ((two + F::one()) * self.c3 * u + self.c2)
    }
}
