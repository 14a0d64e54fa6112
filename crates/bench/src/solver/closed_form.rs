//! Closed forms for the roots of a cubic, each as its source gives it.
//!
//! All divide by the leading coefficient, which is zero for a straight segment. The paper and the distance to a Bezier
//! curve have no guard against that. The others get the obvious guard: the linear equation if the coefficient is
//! exactly zero. Nearly straight segments remain a problem.

use std::f64::consts::TAU;

use num_complex::Complex;
use num_traits::Float;

use super::cubic::Cubic;

/// Up to three roots.
pub type RealRoots<F> = [Option<F>; 3];

fn number<F: Float>(x: f64) -> F {
    F::from(x).expect("every f64 has a nearest f32")
}

/// Returns the roots by the general cubic formula in complex arithmetic: `-(c2 + xi C + D0 / (xi C)) / (3 c3)` with
/// `xi` the cube roots of one (Wikipedia, "Cubic equation", general cubic formula). Returns the roots that are real up
/// to rounding.
pub fn naive<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    let Cubic { c0, c1, c2, c3 } = *cubic;
    if c3 == F::zero() {
        return [Some(-c0 / c1), None, None];
    }
    let [two, three] = [2.0, 3.0].map(number::<F>);
    let d0 = c2 * c2 - three * c3 * c1;
    let d1 = two * c2 * c2 * c2 - number::<F>(9.0) * c3 * c2 * c1 + number::<F>(27.0) * c3 * c3 * c0;
    let root = Complex::from(d1 * d1 - number::<F>(4.0) * d0 * d0 * d0).sqrt();
    let (plus, minus) = (root + d1, -root + d1);
    let c = (if plus.norm_sqr() > minus.norm_sqr() { plus } else { minus } / two).cbrt();
    let third = Complex::from_polar(F::one(), number::<F>(TAU) / three);
    [Complex::from(F::one()), third, third * third].map(|xi| {
        let x = -((xi * c) + Complex::from(d0) / (xi * c) + c2) / (three * c3);
        let is_complex = x.im.abs() > F::epsilon().sqrt() * (F::one() + x.re.abs());
        (!is_complex).then_some(x.re)
    })
}

/// `u^3 + a u^2 + b u + c` shifted by `a / 3`: `t^3 + p t + q`.
struct Depressed<F> {
    shift: F,
    p: F,
    q: F,
}

impl<F: Float> Depressed<F> {
    fn of(cubic: &Cubic<F>) -> Self {
        let [two, three, nine, twenty_seven] = [2.0, 3.0, 9.0, 27.0].map(number::<F>);
        let [a, b, c] = [cubic.c2, cubic.c1, cubic.c0].map(|c| c / cubic.c3);
        Self { shift: a / three, p: b - a * a / three, q: c + (two * a * a * a - nine * a * b) / twenty_seven }
    }
}

/// Computes the roots by Cardano's method as the paper has it, eq. 10: no guard, complex if `lambda` is.
pub fn cardano<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    let [two, four, twenty_seven] = [2.0, 4.0, 27.0].map(number::<F>);
    let Depressed { shift, p, q } = Depressed::of(cubic);
    let under_root = q * q / four + p * p * p / twenty_seven;
    if under_root >= F::zero() {
        let lambda = under_root.sqrt();
        return [Some((-q / two + lambda).cbrt() + (-q / two - lambda).cbrt() - shift), None, None];
    }
    // The two cube roots are conjugate, so each sum is twice a real part.
    let s = Complex::new(-q / two, (-under_root).sqrt()).cbrt();
    let turn = Complex::new(-F::one() / two, number::<F>(3.0).sqrt() / two);
    [s, s * turn, s * turn.conj()].map(|s| Some(two * s.re - shift))
}

/// Returns Viete's trigonometric roots, and the hyperbolic one if only one root is real (Wikipedia, "Cubic equation",
/// trigonometric and hyperbolic solutions).
pub fn viete<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    if cubic.c3 == F::zero() {
        return [Some(-cubic.c0 / cubic.c1), None, None];
    }
    let [two, three, four, twenty_seven] = [2.0, 3.0, 4.0, 27.0].map(number::<F>);
    let Depressed { shift, p, q } = Depressed::of(cubic);
    if p == F::zero() {
        return [Some((-q).cbrt() - shift), None, None];
    }
    let scale = two * (p.abs() / three).sqrt();
    let argument = three * q / (p * scale);
    if four * p * p * p + twenty_seven * q * q <= F::zero() {
        let angle = argument.max(-F::one()).min(F::one()).acos() / three;
        return [F::zero(), number::<F>(TAU) / three, number::<F>(TAU) * two / three]
            .map(|turn| Some(scale * (angle - turn).cos() - shift));
    }
    let t = if p < F::zero() {
        -q.signum() * scale * (argument.abs().acosh() / three).cosh()
    } else {
        -scale * (argument.asinh() / three).sinh()
    };
    [Some(t - shift), None, None]
}

/// Returns the cubic of Quilez's distance to a quadratic Bezier curve (iquilezles.org, "distance to a quadratic bezier
/// curve", 2018): Cardano's sum or a cosine. Of three roots it has only the outer two, since the middle one is
/// farthest.
pub fn quilez<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    let [two, three, four] = [2.0, 3.0, 4.0].map(number::<F>);
    let scale = F::one() / cubic.c3;
    let (kx, ky, kz) = (scale * cubic.c2 / three, scale * cubic.c1 / three, scale * cubic.c0);
    let p = ky - kx * kx;
    let q = kx * (two * kx * kx - three * ky) + kz;
    let h = q * q + four * p * p * p;
    if h >= F::zero() {
        let h = h.sqrt();
        return [Some(((h - q) / two).cbrt() + ((-h - q) / two).cbrt() - kx), None, None];
    }
    let z = (-p).sqrt();
    let (sin, cos) = ((q / (p * z * two)).acos() / three).sin_cos();
    [Some(two * cos * z - kx), Some((-sin * three.sqrt() - cos) * z - kx), None]
}
