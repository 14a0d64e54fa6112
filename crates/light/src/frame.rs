//! The frame across a curve (light model, section 2): its constants, and `up` where that orients it.

use glam::DVec3;

use crate::{Curve, Real};

/// Below this sine of the angle between the end tangents a segment's plane is rounding noise.
pub const STRAIGHT: f64 = 1e-13;

/// `(u_hat, v_hat)` at the end of a curve, for the next one to go on from.
pub type Carried = (DVec3, DVec3);

/// Sets the frame's constants (light model, section 2) and returns what the next segment starts from.
pub fn orient(curve: &mut Curve<f64>, carried: Option<Carried>, up: DVec3) -> Carried {
    let u_hat = curve.u_hat(0.0);
    let v_hat = match carried {
        None => perpendicular_up::<f64>(up, u_hat).cross(u_hat),
        Some((u_before, v_before)) => minimal_rotation(u_before, u_hat, v_before),
    };
    let v_hat = (v_hat - u_hat * v_hat.dot(u_hat)).normalize();
    let normal = curve.d0.cross(curve.d1);
    let bent = normal.length() > STRAIGHT * curve.d0.length() * curve.d1.length();
    let n = if bent { normal.normalize() } else { u_hat.cross(v_hat) };
    curve.n_hat = (n - u_hat * n.dot(u_hat)).normalize();
    let (alpha, beta) = (v_hat.dot(curve.n_hat), v_hat.dot(curve.n_hat.cross(u_hat)));
    let length = libm::hypot(alpha, beta);
    (curve.alpha, curve.beta) = (alpha / length, beta / length);
    let u_end = curve.u_hat(1.0);
    (u_end, curve.rotation_minimizing(u_end).0)
}

/// `w_hat` from the unit vector `up`: its part across `u_hat`, or the least-aligned axis's where they are
/// parallel.
pub fn perpendicular_up<F: Real>(up: F::Vec3, u_hat: F::Vec3) -> F::Vec3 {
    let across = |v: F::Vec3| v - u_hat * F::dot(v, u_hat);
    let perp = across(up);
    if F::dot(perp, perp) >= F::of(1e-12) {
        // Once more: what rounding left along `u_hat` is large against a small `perp`.
        let perp = across(F::unit(perp).unwrap_or(perp));
        return F::unit(perp).unwrap_or(perp);
    }
    let axis = across(F::vec(least_aligned_axis(F::vec_f64(u_hat))));
    F::unit(axis).unwrap_or(axis)
}

/// The coordinate axis that leans least towards `v`.
fn least_aligned_axis(v: DVec3) -> DVec3 {
    let magnitude = v.abs();
    if magnitude.x <= magnitude.y && magnitude.x <= magnitude.z {
        DVec3::X
    } else if magnitude.y <= magnitude.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// `v` turned by the smallest rotation that takes the unit vector `from` to `to`: nothing where the curve is
/// C1, and the turn at a corner where two control points coincide.
fn minimal_rotation(from: DVec3, to: DVec3, v: DVec3) -> DVec3 {
    let (cos, axis) = (from.dot(to), from.cross(to));
    if cos <= -1.0 + 1e-12 {
        return v;
    }
    v * cos + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cos))
}
