//! Quadratic pieces of a tube: position and radius over `u`, and the frame's constants.
//!
//! Light model, sections 1 and 2. With `d(u) = d0 + u a`:
//!
//! ```text
//! P(u) = b0 + u (2 d0 + u a)      P'(u) = 2 d(u)      P'' = 2 a
//! R(u) = r0 + u (2 e0 + u ar)     R'(u) = 2 (e0 + u ar)
//! ```

use glam::DVec3;

use crate::Real;
use crate::lanes::{Lanes, Mask, choose};

/// Box around all points that a curve's tube can contain.
#[derive(Clone, Copy, Debug)]
pub struct TubeBox<F: Lanes> {
    pub center: F::Vec3,
    /// Orthonormal axes: along the chord, in the plane of the curve, normal to it.
    pub axes: [F::Vec3; 3],
    /// Half extents along the axes.
    pub half: [F; 3],
}

impl<F: Lanes> TubeBox<F> {
    /// Returns true if `q` lies in the box.
    #[inline(always)]
    pub fn contains(&self, q: F::Vec3) -> F::Mask {
        let p = q - self.center;
        F::dot(p, self.axes[0]).abs().le(self.half[0])
            & F::dot(p, self.axes[1]).abs().le(self.half[1])
            & F::dot(p, self.axes[2]).abs().le(self.half[2])
    }
}

impl TubeBox<f64> {
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|k| {
            let side =
                |axis: usize| self.axes[axis] * if k >> axis & 1 == 1 { self.half[axis] } else { -self.half[axis] };
            self.center + side(0) + side(1) + side(2)
        })
    }
}

/// Quadratic piece of a tube in tube space, prepared in f64 and rounded once.
#[derive(Clone, Copy, Debug)]
pub struct Curve<F: Lanes> {
    /// Start, bit-equal to the `b2` of the piece before.
    pub b0: F::Vec3,
    /// End.
    pub b2: F::Vec3,
    /// Half the derivative at the start, bit-equal to the `d1` of the piece before.
    pub d0: F::Vec3,
    /// Half the derivative at the end.
    pub d1: F::Vec3,
    /// Half the second derivative, `d1 - d0`.
    pub a: F::Vec3,
    /// Unit normal of the curve's plane.
    pub n_hat: F::Vec3,
    /// `v_hat . n_hat`, constant over the piece.
    pub alpha: F,
    /// `v_hat . m`, constant over the piece.
    pub beta: F,
    /// Radius at the start.
    pub r0: F,
    /// Half the radius's derivative at the start.
    pub e0: F,
    /// Half the radius's second derivative.
    pub ar: F,
    /// Box by which points far from the tube are skipped.
    pub bounds: TubeBox<F>,
}

impl<F: Lanes> Curve<F> {
    /// Returns half the derivative, `d(u) = P'(u) / 2`. At the end it is exactly `d1`; near a cusp the sum has lost
    /// those bits.
    #[inline(always)]
    pub fn d(&self, u: F) -> F::Vec3 {
        F::select_vec(u.equals(F::of(1.0)), self.d1, self.d0 + self.a * u)
    }

    /// Returns the position of the centre curve.
    #[inline(always)]
    pub fn position(&self, u: F) -> F::Vec3 {
        self.b0 + (self.d0 * F::of(2.0) + self.a * u) * u
    }

    /// Computes `q - P(u)` so that the large part cancels first.
    #[inline(always)]
    pub fn offset(&self, q: F::Vec3, u: F) -> F::Vec3 {
        (q - self.b0) - (self.d0 * F::of(2.0) + self.a * u) * u
    }

    #[inline(always)]
    pub fn radius(&self, u: F) -> F {
        self.r0 + u * (F::of(2.0) * self.e0 + u * self.ar)
    }

    #[inline(always)]
    pub fn radius_derivative(&self, u: F) -> F {
        F::of(2.0) * (self.e0 + u * self.ar)
    }

    /// Returns the unit tangent; the one-sided limit if `P'` is zero at an end.
    #[inline(always)]
    pub fn u_hat(&self, u: F) -> F::Vec3 {
        let d = self.d(u);
        let speed = F::length(d);
        let moves = speed.gt(F::of(0.0));
        if moves.all() {
            return d * (F::of(1.0) / speed);
        }
        let limit = F::select_vec(u.lt(F::of(0.5)), self.a, -self.a);
        choose!(F::select_vec, moves, d * (F::of(1.0) / speed), F::unit_or(limit, limit))
    }

    /// Returns the rotation-minimising `(v_hat, w_hat)` about the unit tangent `u_hat`.
    #[inline(always)]
    pub fn rotation_minimizing(&self, u_hat: F::Vec3) -> (F::Vec3, F::Vec3) {
        let m = F::cross(self.n_hat, u_hat);
        (self.n_hat * self.alpha + m * self.beta, self.n_hat * self.beta - m * self.alpha)
    }

    /// Returns the derivative of the unit tangent, `(P'' - (P''.u_hat) u_hat) / |P'|`; zero if `P'` is zero.
    #[inline(always)]
    pub fn u_hat_derivative(&self, u: F, u_hat: F::Vec3) -> F::Vec3 {
        let d = self.d(u);
        let speed = F::dot(d, d).sqrt();
        let across = self.a - u_hat * F::dot(self.a, u_hat);
        choose!(F::select_vec, speed.gt(F::of(0.0)), across * (F::of(1.0) / speed), self.a * F::of(0.0))
    }
}

impl Curve<f64> {
    /// Returns the piece over `[start, end]` as a curve whose parameter runs from 0 to 1.
    ///
    /// The range may reach past `[0, 1]`, where the polynomials continue.
    #[must_use]
    pub fn subcurve(&self, start: f64, end: f64) -> Self {
        let h = end - start;
        let mut piece = Self {
            b0: self.position(start),
            b2: self.position(end),
            d0: self.d(start) * h,
            d1: self.d(end) * h,
            a: self.a * (h * h),
            r0: self.radius(start),
            e0: (self.e0 + start * self.ar) * h,
            ar: self.ar * (h * h),
            ..*self
        };
        piece.bounds = piece.tube_box();
        piece
    }

    /// Computes the box around `P(u) +- R(u)` in axes chord, in-plane, normal, from the exact extrema of each
    /// quadratic.
    pub fn tube_box(&self) -> TubeBox<f64> {
        let chord = f64::unit(self.b2 - self.b0).unwrap_or_else(|| self.u_hat(0.0));
        // The normal is orthogonal to the chord only up to rounding.
        let across = self.n_hat.cross(chord);
        let across = f64::unit(across).unwrap_or_else(|| chord.any_orthonormal_vector());
        let axes = [chord, across, chord.cross(across)];
        let (mut center, mut half) = (DVec3::ZERO, [0.0; 3]);
        for (k, &axis) in axes.iter().enumerate() {
            let (p0, dp, ap) = (self.b0.dot(axis), self.d0.dot(axis), self.a.dot(axis));
            let (_, high) = quadratic_range(p0 + self.r0, dp + self.e0, ap + self.ar);
            let (low, _) = quadratic_range(p0 - self.r0, dp - self.e0, ap - self.ar);
            center += axis * f64::midpoint(low, high);
            half[k] = (high - low) / 2.0;
        }
        let slack = self.box_slack(f64::BOX_INFLATION);
        TubeBox { center, axes, half: half.map(|h| h + slack) }
    }

    fn box_slack(&self, inflation: f64) -> f64 {
        let (_, r_max) = quadratic_range(self.r0, self.e0, self.ar);
        inflation * (self.d0.length() + self.d1.length() + r_max + self.b0.length())
    }

    /// Converts to f32. Each field is rounded once, and the box grows by the distance that f32 rounding can move a
    /// point.
    pub fn to_f32(&self) -> Curve<f32> {
        let slack = self.box_slack(f64::from(f32::BOX_INFLATION));
        let bounds = TubeBox {
            center: self.bounds.center.as_vec3(),
            axes: self.bounds.axes.map(DVec3::as_vec3),
            half: self.bounds.half.map(|h| (h + slack) as f32),
        };
        Curve {
            b0: self.b0.as_vec3(),
            b2: self.b2.as_vec3(),
            d0: self.d0.as_vec3(),
            d1: self.d1.as_vec3(),
            a: self.a.as_vec3(),
            n_hat: self.n_hat.as_vec3(),
            alpha: self.alpha as f32,
            beta: self.beta as f32,
            r0: self.r0 as f32,
            e0: self.e0 as f32,
            ar: self.ar as f32,
            bounds,
        }
    }
}

/// Returns the smallest and largest value over `[0, 1]` of `p + u (2 d + u a)`.
pub fn quadratic_range(p: f64, d: f64, a: f64) -> (f64, f64) {
    let end = p + 2.0 * d + a;
    let (mut low, mut high) = (p.min(end), p.max(end));
    // The derivative 2 (d + u a) is zero at -d / a.
    if a != 0.0 && (0.0..=1.0).contains(&(-d / a)) {
        let extremum = p - d * d / a;
        (low, high) = (low.min(extremum), high.max(extremum));
    }
    (low, high)
}
