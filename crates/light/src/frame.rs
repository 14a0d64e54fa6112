//! Frame of the cross-section (light model, section 2): constants of a segment, and the `up` mode.

use glam::DVec3;

use crate::Curve;
use crate::lanes::{Lanes, Mask};

/// Sine of the angle between the end tangents below which a segment's plane is rounding noise.
pub const STRAIGHT_SINE: f64 = 1e-13;

/// `(u_hat, v_hat)` at the end of a curve, with which the frame of the next curve begins.
pub type EndFrame = (DVec3, DVec3);

/// Sets the frame's constants (light model, section 2) and returns the frame at the end.
pub fn set_frame(curve: &mut Curve<f64>, before: Option<EndFrame>, up: DVec3) -> EndFrame {
    let u_hat = curve.u_hat(0.0);
    let v_hat = match before {
        None => perpendicular_up::<f64>(up, u_hat).cross(u_hat),
        Some((u_before, v_before)) => minimal_rotation(u_before, u_hat, v_before),
    };
    let v_hat = (v_hat - u_hat * v_hat.dot(u_hat)).normalize();
    let normal = curve.d0.cross(curve.d1);
    let bent = normal.length() > STRAIGHT_SINE * curve.d0.length() * curve.d1.length();
    let n = if bent { normal.normalize() } else { u_hat.cross(v_hat) };
    curve.n_hat = (n - u_hat * n.dot(u_hat)).normalize();
    let (alpha, beta) = (v_hat.dot(curve.n_hat), v_hat.dot(curve.n_hat.cross(u_hat)));
    let length = libm::hypot(alpha, beta);
    (curve.alpha, curve.beta) = (alpha / length, beta / length);
    let u_end = curve.u_hat(1.0);
    (u_end, curve.rotation_minimizing(u_end).0)
}

/// Returns `w_hat` from the unit vector `up`: its part across `u_hat`. If they are parallel, the least-aligned axis
/// replaces `up`.
#[inline(always)]
pub fn perpendicular_up<F: Lanes>(up: F::Vec3, u_hat: F::Vec3) -> F::Vec3 {
    let perp = across::<F>(up, u_hat);
    let leans = F::dot(perp, perp).ge(F::of(1e-12));
    // Projected twice: the part along `u_hat` that rounding left is large against a small `perp`.
    let twice = across::<F>(F::unit_or(perp, perp), u_hat);
    let w_hat = F::unit_or(twice, twice);
    if leans.all() {
        return w_hat;
    }
    let axis = across::<F>(least_aligned_axis::<F>(u_hat), u_hat);
    F::select_vec(leans, w_hat, F::unit_or(axis, axis))
}

/// Returns the part of `v` across the unit vector `u_hat`.
#[inline(always)]
fn across<F: Lanes>(v: F::Vec3, u_hat: F::Vec3) -> F::Vec3 {
    v - u_hat * F::dot(v, u_hat)
}

/// Returns the coordinate axis with the smallest component along `v`.
#[inline(always)]
fn least_aligned_axis<F: Lanes>(v: F::Vec3) -> F::Vec3 {
    let [x, y, z] = F::coordinates(v).map(F::abs);
    let is_x = x.le(y) & x.le(z);
    let y_or_z = F::select_vec(y.le(z), F::vec(DVec3::Y), F::vec(DVec3::Z));
    F::select_vec(is_x, F::vec(DVec3::X), y_or_z)
}

/// Turns `v` by the smallest rotation that takes the unit vector `from` to `to`. The rotation is the identity where the
/// curve is C1. At a corner, where two control points coincide, it is the turn of the corner.
fn minimal_rotation(from: DVec3, to: DVec3, v: DVec3) -> DVec3 {
    let (cos, axis) = (from.dot(to), from.cross(to));
    if cos <= -1.0 + 1e-12 {
        return v;
    }
    v * cos + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cos))
}
