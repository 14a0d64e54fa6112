//! Where the curve is square to a point: the roots of `f(u) = (P(u) - q) . d(u)` on its increasing pieces.
//!
//! Light model, section 5. `f = c3 u^3 + c2 u^2 + c1 u + c0` is half the derivative of the squared distance, so
//! an increasing root is a nearest point of the curve. Its leading coefficient `|a|^2` is zero for a straight
//! segment and tiny for a nearly straight one, where every closed form fails. Instead: split `[0, 1]` where
//! `f'` changes sign, expand `f` about the split (all coefficients then have one sign, so Newton from an
//! upper bound is monotone and needs no bracketing), and finish with one step formed from the geometry, which
//! the rounding of the coefficients does not touch.
//!
//! Accuracy: `|du| <= 16 eps cond` for tubes with `R kappa <= 0.9` and `|P'| >= 0.1 (|d0| + |d1|)`; see
//! [`crate::Tube`].

use crate::{Curve, Real};

/// At most one root on the left increasing piece and one on the right, in ascending order.
pub type Roots<F> = [Option<F>; 2];

/// Quotient limited to +-64 and never NaN: `0 / 0` is 0, `n / 0` is 64 with the sign of `n`.
fn sdiv<F: Real>(n: F, d: F) -> F {
    let (zero, limit) = (F::of(0.0), F::of(64.0));
    if n.abs() <= limit * d.abs() {
        return if d == zero { zero } else { n / d };
    }
    if (n < zero) == (d < zero) { limit } else { -limit }
}

/// The coefficients of `f` that give its slope and half its curvature anywhere.
#[derive(Clone, Copy)]
struct Cubic<F> {
    c1: F,
    c2: F,
    c3: F,
}

impl<F: Real> Cubic<F> {
    fn slope(&self, u: F) -> F {
        (F::of(3.0) * self.c3 * u + F::of(2.0) * self.c2) * u + self.c1
    }
    fn half_curvature(&self, u: F) -> F {
        F::of(3.0) * self.c3 * u + self.c2
    }
}

/// The smallest `t >= 0` with `a t^3 + h t^2 + g t = f`, limited to `t_max`; all four are zero or more.
///
/// Starts at the least of the bounds that each term alone gives; the polynomial is convex, so Newton descends
/// to the root.
fn climb<F: Real>(f: F, g: F, h: F, a: F, t_max: F) -> F {
    let mut t = t_max;
    if f < g * t {
        t = f / g;
    }
    if f < h * t * t {
        t = (f / h).sqrt();
    }
    if f < a * t * t * t {
        t = (f / a).cbrt_above().least(t);
    }
    for _ in 0..F::NEWTON_STEPS {
        let value = ((a * t + h) * t + g) * t - f;
        let slope = (F::of(3.0) * a * t + F::of(2.0) * h) * t + g;
        if slope > F::of(0.0) {
            t = (t - value / slope).within(F::of(0.0), t_max);
        }
    }
    t
}

/// One Newton step on `f` formed from `r = q - P(u)` itself; taken only where it is a correction.
fn polish<F: Real>(curve: &Curve<F>, q: F::Vec3, u: F, low: F, high: F) -> F {
    let (r, d) = (curve.offset(q, u), curve.d(u));
    let (n, slope) = (F::dot(r, d), F::of(2.0) * F::dot(d, d) - F::dot(r, curve.a));
    // |step| <= 2^-6, asked without dividing; and so short that the slope changes by less than half, for near a cusp
    // both n and the slope may be rounding noise.
    let half_curvature = F::of(3.0) * F::dot(curve.a, d);
    let short = n.abs() <= slope * F::of(0.015_625)
        && (n * half_curvature).abs() <= F::of(0.25) * slope * slope
        && slope > F::of(0.0);
    let step = if short { n / slope } else { F::of(0.0) };
    (u + step).within(low, high)
}

/// Half the derivative of the squared distance.
fn f_at<F: Real>(curve: &Curve<F>, q: F::Vec3, u: F) -> F {
    -F::dot(curve.offset(q, u), curve.d(u))
}

/// The value that a piece's split point has: the caller's at an end, the cubic's inside.
fn at_split<F: Real>(u: F, start: F, end: F, inside: F) -> F {
    if u == F::of(0.0) {
        start
    } else if u == F::of(1.0) {
        end
    } else {
        inside
    }
}

/// The increasing roots of `f` on `[0, 1]`.
///
/// `f0` and `f1` are `f` at the ends, computed by the caller from the geometry, once a joint: both segments
/// that meet there then agree on the side a point lies on. Where `f` vanishes with `P'` at an end, the sign
/// comes from the one-sided tangent.
pub fn increasing_roots<F: Real>(curve: &Curve<F>, q: F::Vec3, f0: F, f1: F) -> Roots<F> {
    let (zero, one) = (F::of(0.0), F::of(1.0));
    let (d0, a) = (curve.d0, curve.a);
    let from_start = q - curve.b0;
    let cubic = Cubic {
        c1: F::of(2.0) * F::dot(d0, d0) - F::dot(from_start, a),
        c2: F::of(3.0) * F::dot(d0, a),
        c3: F::dot(a, a),
    };
    let e0 = if F::dot(d0, d0) > zero { f0 } else { -F::dot(from_start, a) };
    let e1 = if F::dot(curve.d1, curve.d1) > zero { f1 } else { F::dot(q - curve.b2, a) };

    // Where f' changes sign, or the inflection where it never does.
    let clamp01 = |x: F| x.within(zero, one);
    let discriminant = cubic.c2 * cubic.c2 - F::of(3.0) * cubic.c3 * cubic.c1;
    let (cl, ch) = if discriminant > zero {
        let root = discriminant.sqrt();
        let qd = -(cubic.c2 + if cubic.c2 < zero { -root } else { root });
        let (x, y) = (sdiv(qd, F::of(3.0) * cubic.c3), sdiv(cubic.c1, qd));
        (clamp01(x.least(y)), clamp01(x.most(y)))
    } else {
        let inflection = clamp01(sdiv(-cubic.c2, F::of(3.0) * cubic.c3));
        (inflection, inflection)
    };

    // From the geometry: near P' = 0 the roots lie so close together that the rounding of the coefficients is
    // larger than all of `f` between them.
    let fl = at_split(cl, f0, f1, f_at(curve, q, cl));
    let fh = at_split(ch, f0, f1, f_at(curve, q, ch).least(fl));
    let sl = at_split(cl, e0, e1, fl);
    let sh = at_split(ch, e0, e1, fh);

    // A piece without length counts only where f rises: a point exactly on the plane across an end has f = 0 there, and may
    // be farthest from it.
    let mut roots = [None, None];
    if e0 <= zero && zero <= sl && (cl > zero || cubic.slope(cl) >= zero) {
        let (g, h) = (cubic.slope(cl).most(zero), (-cubic.half_curvature(cl)).most(zero));
        let u = cl - climb(fl.abs(), g, h, cubic.c3, cl);
        roots[0] = Some(polish(curve, q, u, zero, cl));
    }
    if sh <= zero && zero <= e1 && (ch < one || cubic.slope(ch) >= zero) {
        let (g, h) = (cubic.slope(ch).most(zero), cubic.half_curvature(ch).most(zero));
        let u = ch + climb(fh.abs(), g, h, cubic.c3, one - ch);
        roots[1] = Some(polish(curve, q, u, ch, one));
    }
    roots
}
