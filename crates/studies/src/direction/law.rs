//! The ways to say where light comes from.

use glam::DVec3;
use light::{Real, Root, Tube};
use serde::Serialize;

/// How the direction of arrival follows from a place in the tube (light model, section 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Law {
    /// `T = P' + (R'/R) r`: the centre's tangent and the spread.
    Tube,
    /// `T = (|P'| - r . u_hat') u_hat + (R'/R) r`: the tangent of the curve that light travels along.
    Path,
    /// The paper's eq. 9 with its second term as printed, `Q` read for `Q'`: the spread has the wrong sign.
    Printed,
    /// [`Law::Path`] with `u_hat'` made continuous: within `WINDOW` of a joint it goes linearly to the mean of what
    /// it is on both sides.
    Blended,
}

/// All of them.
pub const LAWS: [Law; 4] = [Law::Tube, Law::Path, Law::Printed, Law::Blended];

/// How far from a joint, in u, [`Law::Blended`] leaves the path: half of each segment is still exact.
pub const WINDOW: f64 = 0.25;

impl Law {
    /// Unit vector in tube space from the point of `root` to where its light comes from, for a light whose frame is
    /// rotation-minimising.
    pub fn direction(self, tube: &Tube<f64>, root: &Root<f64>) -> DVec3 {
        let s = &tube.segments[root.segment].curve;
        // Times R, so that an apex needs no care.
        let spread = root.r * s.radius_derivative(root.u);
        let along = s.d(root.u) * (2.0 * root.radius);
        let path = |turn: DVec3| along - root.u_hat * (root.r.dot(turn) * root.radius) + spread;
        let tangent = match self {
            Self::Tube => along + spread,
            Self::Printed => along - spread,
            Self::Path => path(s.u_hat_derivative(root.u, root.u_hat)),
            Self::Blended => path(blended_turn(tube, root)),
        };
        f64::unit(-tangent).unwrap_or(-root.u_hat)
    }
}

/// `u_hat'`, continuous over joints.
fn blended_turn(tube: &Tube<f64>, root: &Root<f64>) -> DVec3 {
    let turn_at = |segment: usize, u: f64| {
        let s = &tube.segments[segment].curve;
        s.u_hat_derivative(u, s.u_hat(u))
    };
    let (i, u) = (root.segment, root.u);
    let mut turn = turn_at(i, u);
    if i > 0 && u < WINDOW {
        turn += (turn_at(i - 1, 1.0) - turn_at(i, 0.0)) * (0.5 * (1.0 - u / WINDOW));
    }
    if i + 1 < tube.segments.len() && u > 1.0 - WINDOW {
        turn += (turn_at(i + 1, 0.0) - turn_at(i, 1.0)) * (0.5 * (1.0 - (1.0 - u) / WINDOW));
    }
    turn
}
