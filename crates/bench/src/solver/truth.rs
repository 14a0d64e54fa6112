//! True roots of a case in 106 bits; the solvers have 24 or 53.
//!
//! Inputs are exact numbers. The cubic's coefficients and every value of it are computed in double-double arithmetic
//! (Dekker, "A floating-point technique for extending the available precision", 1971), so a root is known to about
//! `1e-30 cond`.

use glam::DVec3;
use light::{Curve, Real};
use twofloat::TwoFloat;

/// Distance in u past the ends of a segment up to which roots are searched. A root past an end serves only to explain
/// an answer that a solver rounded to the end.
const BEYOND: f64 = 1.0 / 64.0;

/// An increasing root of `f`.
#[derive(Clone, Copy, Debug)]
pub struct TrueRoot {
    /// Parameter, possibly a little outside of `[0, 1]`.
    pub u: TwoFloat,
    /// Ends, within `[0, 1]`, of the piece on which `f` increases through this root.
    pub piece: [f64; 2],
}

impl TrueRoot {
    /// Returns the distance in u between `u` and the root.
    pub fn error(&self, u: f64) -> f64 {
        (self.u - u).hi().abs()
    }

    /// True if a solver must find the root, because it is on the segment.
    pub fn is_wanted(&self) -> bool {
        self.u >= TwoFloat::from(0.0) && self.u <= TwoFloat::from(1.0)
    }
}

/// The cubic `f(u) = (P(u) - q) . d(u)` of a case, exact to 2^-100, and its roots.
#[derive(Clone, Debug)]
pub struct ExactCubic {
    coefficients: [TwoFloat; 4],
    /// Parameters at which `f'` changes sign from plus to minus and back; equal if it never does.
    pub extrema: [f64; 2],
    /// The root on the left increasing piece, and the one on the right.
    pub roots: [Option<TrueRoot>; 2],
}

impl ExactCubic {
    /// Computes the cubic and its roots for the point `q` and the curve of `b0`, `d0` and `a`.
    pub fn of<F: Real>(curve: &Curve<F>, q: F::Vec3) -> Self {
        let [b0, d0, a, q] = [curve.b0, curve.d0, curve.a, q].map(F::vec_f64);
        let [x, y, z] = [(q.x, b0.x), (q.y, b0.y), (q.z, b0.z)].map(|(q, b0)| TwoFloat::new_sub(q, b0));
        let offset_dot = |v: DVec3| x * v.x + y * v.y + z * v.z;
        let coefficients = [-offset_dot(d0), dot(d0, d0) * 2.0 - offset_dot(a), dot(d0, a) * 3.0, dot(a, a)];
        let turns = extrema_of(coefficients.map(|c| c.hi()));
        let mut truth = Self { coefficients, extrema: turns, roots: [None; 2] };
        let within = |u: f64| u.clamp(0.0, 1.0);
        let pieces = [(-BEYOND, turns[0].min(1.0 + BEYOND)), (turns[1].max(-BEYOND), 1.0 + BEYOND)];
        truth.roots = if turns[0] == turns[1] {
            [truth.between(-BEYOND, 1.0 + BEYOND).map(|u| TrueRoot { u, piece: [0.0, 1.0] }), None]
        } else {
            pieces.map(|(low, high)| {
                let u = truth.between(low, high)?;
                Some(TrueRoot { u, piece: [within(low), within(high)] })
            })
        };
        truth
    }

    /// Returns `f(u)`.
    pub fn value(&self, u: TwoFloat) -> f64 {
        self.exact_value(u).hi()
    }

    fn exact_value(&self, u: TwoFloat) -> TwoFloat {
        let [c0, c1, c2, c3] = self.coefficients;
        ((c3 * u + c2) * u + c1) * u + c0
    }

    /// Returns `f'(u)`.
    pub fn slope(&self, u: f64) -> f64 {
        let [_, c1, c2, c3] = self.coefficients;
        ((c3 * (3.0 * u) + c2 * 2.0) * u + c1).hi()
    }

    /// Finds the root between `low` and `high`, on which `f` increases: in f64, to the last bit by the exact value, and
    /// then by Newton's method on the rest.
    fn between(&self, low: f64, high: f64) -> Option<TwoFloat> {
        let at = |u: f64| self.value(TwoFloat::from(u));
        if low >= high || at(low) > 0.0 || at(high) < 0.0 {
            return None;
        }
        let [c0, c1, c2, c3] = self.coefficients.map(|c| c.hi());
        let slope = |u: f64| (3.0 * c3 * u + 2.0 * c2) * u + c1;
        let near = bracketed(|u| ((c3 * u + c2) * u + c1) * u + c0, slope, [low, high], f64::midpoint(low, high));
        let mut u = TwoFloat::from(bracketed(at, slope, [low, high], near));
        let slope = self.slope(u.hi());
        for _ in 0..2 {
            let step = self.exact_value(u) * (1.0 / slope);
            // If the slope is lost in rounding, the f64 result cannot be improved.
            if step.hi().abs() <= 1e-12 {
                u -= step;
            }
        }
        Some(u)
    }
}

/// Applies Newton's method on an increasing function, with a bisection step if it leaves the bracket, until it stops
/// changing.
fn bracketed(value: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], start: f64) -> f64 {
    let mut u = start;
    for _ in 0..200 {
        let at_u = value(u);
        *(if at_u > 0.0 { &mut high } else { &mut low }) = u;
        let newton = u - at_u / slope(u);
        let next = if newton > low && newton < high { newton } else { f64::midpoint(low, high) };
        if newton == u || next <= low || next >= high {
            break;
        }
        u = next;
    }
    u
}

fn dot(x: DVec3, y: DVec3) -> TwoFloat {
    TwoFloat::new_mul(x.x, y.x) + TwoFloat::new_mul(x.y, y.y) + TwoFloat::new_mul(x.z, y.z)
}

/// Returns the zeros of `f'`, ascending, or twice the parameter of its minimum if it has none.
fn extrema_of([_, c1, c2, c3]: [f64; 4]) -> [f64; 2] {
    let discriminant = c2 * c2 - 3.0 * c3 * c1;
    if discriminant <= 0.0 {
        let inflection = if c3 > 0.0 { -c2 / (3.0 * c3) } else { 0.0 };
        return [inflection; 2];
    }
    let qd = -(c2 + discriminant.sqrt().copysign(c2));
    let (x, y) = (qd / (3.0 * c3), c1 / qd);
    [x.min(y), x.max(y)]
}
