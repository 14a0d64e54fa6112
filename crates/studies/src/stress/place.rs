//! Test points for a light, and the conditioning of their coordinates.

use std::f64::consts::TAU;

use glam::DVec3;
use light::{FrameMode, Real, Tube, TubeRoot};
use proptest::prelude::*;

use super::light::unit_cube;

/// Point that is given by coordinates relative to a light.
#[derive(Clone, Copy, Debug)]
pub enum PointSpec {
    /// Point at a share of the light's length, at `rho` radii from the curve in a direction perpendicular to the curve.
    InTube {
        /// Share from 0 to 1. More than 1 is on the extension.
        share: f64,
        /// Distance from the curve in radii: 1 is the rim of the tube.
        rho: f64,
        /// Angle in radians from `v_hat`.
        angle: f64,
    },
    /// Point on the plane through a joint of two segments.
    AtJoint {
        /// Index of the joint, taken modulo the number of joints.
        joint: usize,
        /// Distance from the curve in radii: 1 is the rim of the tube.
        rho: f64,
        /// Angle in radians from `v_hat`.
        angle: f64,
    },
    /// Point between the curve and its center of curvature, at any distance from the curve in radii.
    NearEvolute {
        /// Share along the curve, from 0 to 1.
        share: f64,
        /// Share of the distance to the center of curvature: 1 is the center.
        share_to_centre: f64,
    },
    /// Any point, in tube units.
    Free(DVec3),
}

impl PointSpec {
    /// Computes the point in tube space.
    pub fn in_tube_space(self, tube: &Tube<f64>) -> DVec3 {
        let n = tube.n as f64;
        match self {
            Self::InTube { share, rho, angle } => point_at(tube, share * n, rho * angle.cos(), rho * angle.sin()),
            Self::AtJoint { joint, rho, angle } => {
                point_at(tube, (joint % (tube.n + 1)) as f64, rho * angle.cos(), rho * angle.sin())
            }
            Self::NearEvolute { share, share_to_centre } => {
                let (i, u) = split(tube, share * n);
                let segment = &tube.segments[i].curve;
                let u_hat = segment.u_hat(u);
                let curvature = segment.u_hat_derivative(u, u_hat) / (2.0 * segment.d(u).length());
                let normal = curvature / curvature.length_squared();
                segment.position(u) + if normal.is_finite() { normal * share_to_centre } else { DVec3::ZERO }
            }
            Self::Free(q) => q,
        }
    }
}

/// Generates points of every kind.
pub fn places() -> impl Strategy<Value = PointSpec> {
    let decade = prop_oneof![3 => -1.0..1.0, 1 => -4.0..6.0];
    let near = (decade, unit_cube()).prop_map(|(decade, q)| PointSpec::Free(q * 10_f64.powf(decade)));
    let evolute =
        (0.0..1.0, 0.9..1.1).prop_map(|(share, share_to_centre)| PointSpec::NearEvolute { share, share_to_centre });
    prop_oneof![4 => in_tube(1.2), 2 => at_joint(), 2 => near, 1 => evolute]
}

/// Generates points in a tube and a little around it.
pub fn in_tube(rho_max: f64) -> impl Strategy<Value = PointSpec> {
    let rho = prop_oneof![4 => (0.0..rho_max).boxed(), 1 => Just(0.0).boxed()];
    (0.0..1.0, rho, 0.0..TAU).prop_map(|(share, rho, angle)| PointSpec::InTube { share, rho, angle })
}

/// Generates points on the planes at which segments meet.
pub fn at_joint() -> impl Strategy<Value = PointSpec> {
    (0..64_usize, 0.0..1.0, 0.0..TAU).prop_map(|(joint, rho, angle)| PointSpec::AtJoint { joint, rho, angle })
}

/// Returns the index of the segment that contains `t`, and the parameter in it. A joint belongs to the lower segment.
pub fn split(tube: &Tube<f64>, t: f64) -> (usize, f64) {
    let i = (t.ceil() as usize).saturating_sub(1).min(tube.segments.len() - 1);
    (i, t - i as f64)
}

/// Returns the tube-space point at `(t, v, w)`: `P + R (v v_hat + w w_hat)`.
pub fn point_at(tube: &Tube<f64>, t: f64, v: f64, w: f64) -> DVec3 {
    let (i, u) = split(tube, t);
    point_in(tube, i, u, v, w)
}

/// Returns the tube-space point at the parameter `u` of segment `i`.
pub fn point_in(tube: &Tube<f64>, i: usize, u: f64, v: f64, w: f64) -> DVec3 {
    let segment = &tube.segments[i].curve;
    let (v_hat, w_hat) = tube.cross_section(segment, segment.u_hat(u));
    segment.position(u) + (v_hat * v + w_hat * w) * segment.radius(u)
}

/// Returns the root of the light model for `q` at the known parameter `u` of a segment.
pub fn root_at(tube: &Tube<f64>, segment: usize, u: f64, q: DVec3) -> TubeRoot<f64> {
    let s = &tube.segments[segment].curve;
    let (u_hat, r) = (s.u_hat(u), s.offset(q, u));
    let (v_hat, w_hat) = tube.cross_section(s, u_hat);
    TubeRoot { segment, u, r, v_len: r.dot(v_hat), w_len: r.dot(w_hat), radius: s.radius(u), v_hat, u_hat }
}

/// Bounds on the errors of values at a root, in tube units (light model, section 5).
#[derive(Clone, Copy, Debug)]
pub struct RootBounds {
    /// Error of the parameter.
    pub t: f64,
    /// Error of `V` and `W`, as lengths.
    pub across: f64,
    /// Error of the radius.
    pub radius: f64,
    /// Error of the "tube" direction.
    pub direction: f64,
    /// Change of the parameter per length, for a point that moves along the curve.
    pub rate: f64,
}

/// Computes the bounds at `q` for a computation with relative precision `eps` and a further error `dq` of the point.
/// `None` if the errors are so large that the derivatives at the root do not describe them.
///
/// A displacement `e` of a point moves the root by `e / sigma`, `sigma = |P'| (1 - kappa r.N)`, and by half of
/// `H_t e^2` (section 4). The numbers of point and segment are rounded at the size of `|q| + |r| + L`. Each direction
/// is accurate to `eps L / |d|`, because `d` is a difference of vectors of length `L`. `V` does not change with u in
/// the rotation-minimizing frame, and rotates by `tau` in the other one.
pub fn bounds(tube: &Tube<f64>, root: &TubeRoot<f64>, q: DVec3, eps: f64, dq: f64) -> Option<RootBounds> {
    let (s, u) = (&tube.segments[root.segment].curve, root.u);
    let (d, turn) = (s.d(u).length(), s.u_hat_derivative(u, root.u_hat));
    let (rho, length) = (root.r.length(), s.d0.length() + s.d1.length());
    let sigma = 2.0 * d - root.r.dot(turn);
    let rounding = 16.0 * eps * (rho + length + q.length() + s.b0.length());
    let off = rounding + dq;
    let h_t = (2.0 * turn.length() + 2.0 * s.a.length() * (1.0 + rho * turn.length() / d) / sigma) / (sigma * sigma);
    // An angular error of the direction moves the plane perpendicular to the curve by that angle times the distance
    // `r`.
    let along = off + 16.0 * eps * rho * length / d;
    let bent = h_t * along * along;
    let t = along / sigma + bent;
    // The bounds hold if they are mostly first order, small relative to the radius of curvature and the segment, and
    // smaller than the tube.
    let known = sigma > 0.0 && bent < 0.1 * t && t < 0.02 && t * s.a.length() < 0.02 * d && root.radius > 8.0 * off;
    if !known {
        return None;
    }
    let frame = 32.0 * eps * (1.0 + length / d);
    let twist = if tube.frame == FrameMode::Up {
        let lean = (tube.up - root.u_hat * tube.up.dot(root.u_hat)).length().max(1e-6);
        (turn.length() * t + frame) / lean
    } else {
        0.0
    };
    let across = off + (frame + twist) * rho;
    let slope = s.radius_derivative(u).abs();
    let radius = (slope + s.ar.abs() * t) * t + 16.0 * eps * (root.radius + s.r0.abs() + s.e0.abs());
    // T = P' + (R'/R) r, with the change of each factor in turn.
    let per_radius = 1.0 / root.radius.max(f64::MIN_POSITIVE);
    let spread = rho * per_radius * (2.0 * s.ar.abs() * t + slope * radius * per_radius) + slope * per_radius * across;
    let tangent = s.d(u) * 2.0 + root.r * (s.radius_derivative(u) * per_radius);
    let direction = (2.0 * s.a.length() * t + spread) / tangent.length() + frame;
    Some(RootBounds { t, across, radius, direction, rate: 1.0 / sigma })
}

/// Returns 2^-52 or 2^-24, as in the light model's bounds.
pub fn eps<F: Real>() -> f64 {
    if size_of::<F>() == 8 { f64::EPSILON } else { f64::from(f32::EPSILON) / 2.0 }
}
