//! Nearest points of a curve: the roots of `f(u) = (P(u) - q) . d(u)` on its increasing pieces.
//!
//! Light model, section 5. `f = c3 u^3 + c2 u^2 + c1 u + c0` is half the derivative of the squared distance, so an
//! increasing root is a nearest point of the curve. The leading coefficient `|a|^2` is zero for a straight segment and
//! tiny for a nearly straight one, where every closed form fails.
//!
//! The solver splits `[0, 1]` where `f'` changes sign and expands `f` about the split. All coefficients then have one
//! sign, so Newton's method from an upper bound is monotone and needs no bracketing. A last step is formed from the
//! geometry, so the rounding of the coefficients does not affect it.
//!
//! Accuracy: `|du| <= 16 eps cond` for tubes with `R kappa <= 0.9` and `|P'| >= 0.1 (|d0| + |d1|)`; see
//! [`crate::Tube`].

use crate::lanes::{Lanes, Mask, choose};
use crate::{Curve, Real};

/// Roots of one point in each lane: at most one on the left increasing piece and one on the right. A root whose mask is
/// false has no meaning.
#[derive(Clone, Copy, Debug)]
pub struct Roots<F: Lanes> {
    pub left: F,
    /// Root on the right piece, not less than the left one.
    pub right: F,
    pub has_left: F::Mask,
    pub has_right: F::Mask,
}

impl<F: Lanes> Roots<F> {
    /// Makes roots with both masks false.
    #[inline(always)]
    pub fn none() -> Self {
        let (none, never) = (F::of(0.0), F::Mask::of(false));
        Self { left: none, right: none, has_left: never, has_right: never }
    }
}

impl<F: Real> Roots<F> {
    /// Iterates over the existing roots in ascending order.
    pub fn found(self) -> impl Iterator<Item = F> {
        let Self { left, right, has_left, has_right } = self;
        [has_left.then_some(left), has_right.then_some(right)].into_iter().flatten()
    }
}

/// Computes a quotient limited to +-64, which is never NaN: `0 / 0` is 0, and `n / 0` is 64 with the sign of `n`.
#[inline(always)]
fn sdiv<F: Lanes>(n: F, d: F) -> F {
    let (zero, limit) = (F::of(0.0), F::of(64.0));
    let bounded = n.abs().le(limit * d.abs());
    let beyond = F::select(mask_equal(n.lt(zero), d.lt(zero)), limit, -limit);
    choose!(F::select, bounded, choose!(F::select, d.equals(zero), zero, n / d), beyond)
}

#[inline(always)]
fn mask_equal<M: Mask>(a: M, b: M) -> M {
    (a & b) | !(a | b)
}

/// Coefficients of `f` in the form in which its slope and half its curvature at a point are computed.
#[derive(Clone, Copy)]
struct Cubic<F> {
    c1: F,
    c2: F,
    c3: F,
}

impl<F: Lanes> Cubic<F> {
    #[inline(always)]
    fn slope(&self, u: F) -> F {
        (F::of(3.0) * self.c3 * u + F::of(2.0) * self.c2) * u + self.c1
    }
    #[inline(always)]
    fn half_curvature(&self, u: F) -> F {
        F::of(3.0) * self.c3 * u + self.c2
    }
}

/// Returns the smallest `t >= 0` with `a t^3 + h t^2 + g t = f`, limited to `t_max`. All four coefficients are zero or
/// more.
///
/// The start is the least of the bounds that each term alone gives. The polynomial is convex, so Newton's method
/// descends to the root.
#[inline(always)]
fn climb<F: Lanes>(f: F, g: F, h: F, a: F, t_max: F) -> F {
    let mut t = t_max;
    t = choose!(F::select, f.lt(g * t), f / g, t);
    t = choose!(F::select, f.lt(h * t * t), (f / h).sqrt(), t);
    t = choose!(F::select, f.lt(a * t * t * t), (f / a).cbrt_above().least(t), t);
    for _ in 0..F::NEWTON_STEPS {
        let value = ((a * t + h) * t + g) * t - f;
        let slope = (F::of(3.0) * a * t + F::of(2.0) * h) * t + g;
        t = choose!(F::select, slope.gt(F::of(0.0)), (t - value / slope).within(F::of(0.0), t_max), t);
    }
    t
}

/// Takes one Newton step on `f`, formed from `r = q - P(u)` itself, if the step is a small correction.
#[inline(always)]
fn polish<F: Lanes>(curve: &Curve<F>, q: F::Vec3, u: F, low: F, high: F) -> F {
    let (r, d) = (curve.offset(q, u), curve.d(u));
    let (n, slope) = (F::dot(r, d), F::of(2.0) * F::dot(d, d) - F::dot(r, curve.a));
    // Tested without a division: |step| <= 2^-6. The step must also change the slope by less than half: near a cusp
    // both n and the slope may be rounding noise.
    let half_curvature = F::of(3.0) * F::dot(curve.a, d);
    let short = n.abs().le(slope * F::of(0.015_625))
        & (n * half_curvature).abs().le(F::of(0.25) * slope * slope)
        & slope.gt(F::of(0.0));
    let step = choose!(F::select, short, n / slope, F::of(0.0));
    (u + step).within(low, high)
}

/// Computes `f` at `u`, which is half the derivative of the squared distance to the curve.
#[inline(always)]
fn f_at<F: Lanes>(curve: &Curve<F>, q: F::Vec3, u: F) -> F {
    -F::dot(curve.offset(q, u), curve.d(u))
}

/// Returns the value of `f` at the split point of a piece: the caller's value at an end of the segment, and the cubic's
/// inside.
#[inline(always)]
fn at_split<F: Lanes>(u: F, start: F, end: F, inside: F) -> F {
    F::select(u.equals(F::of(0.0)), start, F::select(u.equals(F::of(1.0)), end, inside))
}

/// Finds the increasing roots of `f` on `[0, 1]`.
///
/// `f0` and `f1` are `f` at the ends. The caller computes them from the geometry, once for each joint, so that both
/// segments at the joint agree on the side on which a point lies. If `f` vanishes with `P'` at an end, the sign comes
/// from the one-sided tangent.
#[inline(always)]
pub fn increasing_roots<F: Lanes>(curve: &Curve<F>, q: F::Vec3, f0: F, f1: F) -> Roots<F> {
    let (zero, one) = (F::of(0.0), F::of(1.0));
    let (d0, a) = (curve.d0, curve.a);
    let from_start = q - curve.b0;
    let cubic = Cubic {
        c1: F::of(2.0) * F::dot(d0, d0) - F::dot(from_start, a),
        c2: F::of(3.0) * F::dot(d0, a),
        c3: F::dot(a, a),
    };
    let e0 = choose!(F::select, F::dot(d0, d0).gt(zero), f0, -F::dot(from_start, a));
    let e1 = choose!(F::select, F::dot(curve.d1, curve.d1).gt(zero), f1, F::dot(q - curve.b2, a));
    let (cl, ch) = splits(&cubic);

    // Computed from the geometry: near P' = 0 the roots lie so close together that the rounding of the coefficients is
    // larger than all of `f` between them.
    let fl = at_split(cl, f0, f1, f_at(curve, q, cl));
    let fh = at_split(ch, f0, f1, f_at(curve, q, ch).least(fl));
    let sl = at_split(cl, e0, e1, fl);
    let sh = at_split(ch, e0, e1, fh);

    // A piece without length counts only if f increases: a point exactly on the plane across an end has f = 0 there,
    // and may be farthest from it.
    let mut roots = Roots::<F>::none();
    roots.has_left = e0.le(zero) & zero.le(sl) & (cl.gt(zero) | cubic.slope(cl).ge(zero));
    if roots.has_left.any() {
        let (g, h) = (cubic.slope(cl).most(zero), (-cubic.half_curvature(cl)).most(zero));
        let u = cl - climb(fl.abs(), g, h, cubic.c3, cl);
        roots.left = polish(curve, q, u, zero, cl);
    }
    roots.has_right = sh.le(zero) & zero.le(e1) & (ch.lt(one) | cubic.slope(ch).ge(zero));
    if roots.has_right.any() {
        let (g, h) = (cubic.slope(ch).most(zero), cubic.half_curvature(ch).most(zero));
        let u = ch + climb(fh.abs(), g, h, cubic.c3, one - ch);
        roots.right = polish(curve, q, u, ch, one);
    }
    roots
}

/// Returns the points where `f'` changes sign, or the inflection twice if it never does, clamped to `[0, 1]`.
#[inline(always)]
fn splits<F: Lanes>(cubic: &Cubic<F>) -> (F, F) {
    let (zero, one, three) = (F::of(0.0), F::of(1.0), F::of(3.0));
    let discriminant = cubic.c2 * cubic.c2 - three * cubic.c3 * cubic.c1;
    let turns = discriminant.gt(zero);
    if turns.decided() == Some(false) {
        let inflection = sdiv(-cubic.c2, three * cubic.c3).within(zero, one);
        return (inflection, inflection);
    }
    let root = discriminant.sqrt();
    let qd = -(cubic.c2 + F::select(cubic.c2.lt(zero), -root, root));
    let (x, y) = (sdiv(qd, three * cubic.c3), sdiv(cubic.c1, qd));
    let (low, high) = (x.least(y).within(zero, one), x.most(y).within(zero, one));
    if turns.all() {
        return (low, high);
    }
    let inflection = sdiv(-cubic.c2, three * cubic.c3).within(zero, one);
    (F::select(turns, low, inflection), F::select(turns, high, inflection))
}
