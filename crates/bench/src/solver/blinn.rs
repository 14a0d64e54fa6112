//! Blinn's solver for homogeneous cubics: "How to Solve a Cubic Equation, Part 5: Back to Numerics", IEEE Computer
//! Graphics and Applications 27(3), 2007.
//!
//! Roots are ratios `x / w`, so that a vanishing leading coefficient sends one of them to infinity and leaves the
//! others unchanged. Each root is computed from the end of the cubic that is better conditioned for it.

use num_traits::Float;

use super::closed_form::RealRoots;
use super::cubic::Cubic;

/// Returns the roots of `A x^3 + 3 B x^2 w + 3 C x w^2 + D w^3`.
pub fn blinn<F: Float>(cubic: &Cubic<F>) -> RealRoots<F> {
    if cubic.c3 == F::zero() {
        return [Some(-cubic.c0 / cubic.c1), None, None];
    }
    let two = F::one() + F::one();
    let three = two + F::one();
    let (a, b, c, d) = (cubic.c3, cubic.c2 / three, cubic.c1 / three, cubic.c0);
    let hessian = [a * c - b * b, a * d - b * c, b * d - c * c];
    let discriminant = two * two * hessian[0] * hessian[2] - hessian[1] * hessian[1];
    // Depressed from the side of the leading coefficient, and from that of the last.
    let leading = BlinnCubic { outer: a, bar_c: hessian[0], bar_d: -two * b * hessian[0] + a * hessian[1] };
    let trailing = BlinnCubic { outer: d, bar_c: hessian[2], bar_d: -d * hessian[1] + two * c * hessian[2] };
    if discriminant <= F::zero() {
        return if b * b * b * d >= a * c * c * c {
            [Some((leading.single(discriminant) - b) / a), None, None]
        } else {
            [Some(-d / (trailing.single(discriminant) + c)), None, None]
        };
    }
    let root = discriminant.sqrt();
    let [x1, x3] = leading.outer_pair(root);
    let large = [if x1 + x3 > two * b { x1 } else { x3 } - b, a];
    let [x1, x3] = trailing.outer_pair(root);
    let small = [-d, if x1 + x3 < two * c { x1 } else { x3 } + c];
    // The third root follows from the other two: the cubic divided by their factors.
    let e = large[1] * small[1];
    let f = -large[0] * small[1] - large[1] * small[0];
    let g = large[0] * small[0];
    let middle = [c * f - b * g, c * e - b * f];
    [large, middle, small].map(|[x, w]| Some(x / w))
}

/// Depressed cubic `t^3 + 3 bar_c t + bar_d`.
struct BlinnCubic<F> {
    outer: F,
    bar_c: F,
    bar_d: F,
}

impl<F: Float> BlinnCubic<F> {
    /// Returns the only real root.
    fn single(&self, discriminant: F) -> F {
        let two = F::one() + F::one();
        let t0 = -self.bar_d.signum() * self.outer.abs() * (-discriminant).sqrt();
        let t1 = t0 - self.bar_d;
        let p = (t1 / two).cbrt();
        let q = if t1 == t0 { -p } else { -self.bar_c / p };
        if self.bar_c <= F::zero() { p + q } else { -self.bar_d / (p * p + q * q + self.bar_c) }
    }

    /// Returns the largest and the smallest of three roots.
    fn outer_pair(&self, root: F) -> [F; 2] {
        let two = F::one() + F::one();
        let three = two + F::one();
        let angle = (self.outer * root).atan2(-self.bar_d).abs() / three;
        let (sin, cos) = angle.sin_cos();
        let scale = two * (-self.bar_c).sqrt();
        [scale * cos, scale * (-cos / two - three.sqrt() / two * sin)]
    }
}
