//! Iterations for the roots of a cubic: bracketed, and with a fixed number of steps.

use num_traits::Float;

use super::closed_form::RealRoots;
use super::cubic::{Cubic, clamp01};

/// Computes the roots by Yuksel's bracketed Newton: between the cubic's extrema each piece has at most one root.
/// Newton's method finds it from the middle of the piece, with a bisection step if it leaves the bracket
/// ("High-Performance Polynomial Root Finding for Graphics", Proceedings of the ACM on Computer Graphics and
/// Interactive Techniques 5(3), 2022).
pub fn yuksel<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    let three = F::one() + F::one() + F::one();
    let (zero, one) = (F::zero(), F::one());
    let discriminant = cubic.c2 * cubic.c2 - three * cubic.c3 * cubic.c1;
    if discriminant <= zero {
        return [bracketed(cubic, zero, one), None, None];
    }
    let q = -(cubic.c2 + cubic.c2.signum() * discriminant.sqrt());
    let (x, y) = (q / (three * cubic.c3), cubic.c1 / q);
    let (left, right) = (x.min(y), x.max(y));
    [bracketed(cubic, zero, left.min(one)), bracketed(cubic, right.max(zero), one), None]
}

/// Finds the root of an increasing piece.
fn bracketed<F: Float>(cubic: &Cubic<F>, mut low: F, mut high: F) -> Option<F> {
    let two = F::one() + F::one();
    if low > high || cubic.value(low) > F::zero() || cubic.value(high) < F::zero() {
        return None;
    }
    let mut u = (low + high) / two;
    // Bisection alone would need fewer steps.
    for _ in 0..64 {
        let value = cubic.value(u);
        *(if value > F::zero() { &mut high } else { &mut low }) = u;
        let newton = u - value / cubic.slope(u);
        let next = if newton > low && newton < high { newton } else { (low + high) / two };
        if (next - u).abs() <= F::epsilon() {
            return Some(next);
        }
        u = next;
    }
    Some(u)
}

/// Start values of methods with a fixed number of steps: both ends and the middle, so that neither of two roots is
/// missed.
const STARTS: [f64; 3] = [0.0, 0.5, 1.0];

/// Computes the roots by Newton's method, six steps from each start.
pub fn newton<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    from_each_start::<F, 6>(|u| cubic.value(u) / cubic.slope(u))
}

/// Computes the roots by Halley's method, four steps from each start: `2 f f' / (2 f'^2 - f f'')`.
pub fn halley<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    let two = F::one() + F::one();
    from_each_start::<F, 4>(|u| {
        let (f, slope) = (cubic.value(u), cubic.slope(u));
        two * f * slope / (two * slope * slope - f * cubic.bend(u))
    })
}

/// Returns the result of `N` steps from each start, if it is on the segment. `None` for a start from which the last
/// step was still large.
fn from_each_start<F: Float, const N: usize>(step: impl Fn(F) -> F) -> RealRoots<F> {
    let settled = F::from(1e-3).expect("f32 has it");
    STARTS.map(|start| {
        let mut u = F::from(start).expect("f32 has it");
        let mut last = F::zero();
        for _ in 0..N {
            last = step(u);
            u = clamp01(u - last);
        }
        let is_moving = last.abs() > settled;
        (!is_moving).then_some(u)
    })
}
