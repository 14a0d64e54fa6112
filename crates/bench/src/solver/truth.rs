//! The true roots of a case, from the inputs as they are: 106 bits, where the solvers have 24 or 53.
//!
//! Inputs are taken as exact numbers. The cubic's coefficients and every value of it are formed in double-double
//! arithmetic (Dekker, "A floating-point technique for extending the available precision", 1971), so a root is
//! known to about `1e-30 cond`.

use glam::DVec3;
use light::{Curve, Real};
use twofloat::TwoFloat;

/// How far past its ends a segment's roots are looked for. Those count only as what a solver that rounds to the end
/// must have meant.
const BEYOND: f64 = 1.0 / 64.0;

/// An increasing root of `f`.
#[derive(Clone, Copy, Debug)]
pub struct TrueRoot {
    /// Where; a little beyond `[0, 1]` perhaps.
    pub u: TwoFloat,
    /// The ends, within `[0, 1]`, of the piece on which `f` increases through this root.
    pub piece: [f64; 2],
}

impl TrueRoot {
    /// How far `u` is from it.
    pub fn error(&self, u: f64) -> f64 {
        (self.u - u).hi().abs()
    }

    /// Whether it must be found.
    pub fn is_wanted(&self) -> bool {
        self.u >= TwoFloat::from(0.0) && self.u <= TwoFloat::from(1.0)
    }
}

/// A case's cubic `f(u) = (P(u) - q) . d(u)`, exact but for 2^-100, and its roots.
#[derive(Clone, Debug)]
pub struct ExactCubic {
    coefficients: [TwoFloat; 4],
    /// Where `f'` changes sign from plus to minus and back; equal where it never does.
    pub extrema: [f64; 2],
    /// The root on the left increasing piece and the one on the right.
    pub roots: [Option<TrueRoot>; 2],
}

impl ExactCubic {
    /// The truth about the point `q`; the curve is that of `b0`, `d0` and `a`.
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

    /// `f(u)`.
    pub fn value(&self, u: TwoFloat) -> f64 {
        self.exact_value(u).hi()
    }

    fn exact_value(&self, u: TwoFloat) -> TwoFloat {
        let [c0, c1, c2, c3] = self.coefficients;
        ((c3 * u + c2) * u + c1) * u + c0
    }

    /// `f'(u)`.
    pub fn slope(&self, u: f64) -> f64 {
        let [_, c1, c2, c3] = self.coefficients;
        ((c3 * (3.0 * u) + c2 * 2.0) * u + c1).hi()
    }

    /// The root between `low` and `high`, on which `f` increases: in f64 first, then to the last bit of f64 by the exact
    /// value, then by Newton's method on what is left.
    fn between(&self, low: f64, high: f64) -> Option<TwoFloat> {
        let at = |u: f64| self.value(TwoFloat::from(u));
        if low >= high || at(low) > 0.0 || at(high) < 0.0 {
            return None;
        }
        let [c0, c1, c2, c3] = self.coefficients.map(|c| c.hi());
        let slope = |u: f64| (3.0 * c3 * u + 2.0 * c2) * u + c1;
        let near =
            bracketed(|u| ((c3 * u + c2) * u + c1) * u + c0, slope, [low, high], f64::midpoint(low, high));
        let mut u = TwoFloat::from(bracketed(at, slope, [low, high], near));
        let slope = self.slope(u.hi());
        for _ in 0..2 {
            let step = self.exact_value(u) * (1.0 / slope);
            // Where the slope is lost in rounding, f64 is as good as it gets.
            if step.hi().abs() <= 1e-12 {
                u -= step;
            }
        }
        Some(u)
    }
}

/// Newton's method on an increasing function, halving where it leaves the bracket, until it stands still.
fn bracketed(
    value: impl Fn(f64) -> f64,
    slope: impl Fn(f64) -> f64,
    [mut low, mut high]: [f64; 2],
    start: f64,
) -> f64 {
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

/// The zeros of `f'`, ascending, or its least value twice where it has none.
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
