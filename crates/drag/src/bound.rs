//! Limits on the coordinates of a point in a light, and errors of those coordinates.

use glam::{DVec2, DVec3};

use crate::point_in_light::PointInLight;
use crate::request::DragLimit;

/// Least `1 - kappa r.N` that a drag allows. At 0 the light paths meet, and light has no direction there.
pub(crate) const MIN_PATH_SPACING: f64 = 0.02;

/// Least distance of the point under the cursor from the light's edge, in radii.
pub(crate) const EDGE_MARGIN: f64 = 1e-4;

/// Least distance along the light from the pivot to the point in its shadow, as a share of the point's `t` at the
/// start.
const PIVOT_MARGIN: f64 = 1e-6;

/// Value that must stay 0 or more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    pub value: f64,
    pub limit: DragLimit,
    /// Softness of the limit; 0 for a hard limit.
    pub compliance: f64,
}

/// Makes a limit that is never violated for the sake of the objective.
pub(crate) fn hard_bound(value: f64, limit: DragLimit) -> Bound {
    Bound { value, limit, compliance: 0.0 }
}

/// Computes the distance along the light from the pivot to the point in its shadow, less the required margin. The unit
/// is the point's `t` at the start of the drag.
pub(crate) fn distance_behind(coords: &PointInLight, pivot: &PointInLight, was: &PointInLight) -> f64 {
    (coords.t - pivot.t) / was.t.max(f64::MIN_POSITIVE) - PIVOT_MARGIN
}

/// Computes the distance between the light path at `across` and the point `coords`, across the light. The unit is the
/// radius of the light at `was`.
pub(crate) fn cross_error(across: DVec2, coords: &PointInLight, was: &PointInLight) -> DVec2 {
    (across - coords.cross_coords) * (coords.width / was.width)
}

/// Computes the angle between the direction to the light and `direction`, in radians along two axes across `direction`.
/// `None` if light arrives from behind.
pub(crate) fn direction_error(to_light: DVec3, direction: DVec3) -> Option<DVec2> {
    direction_error_about(to_light, direction, direction.any_orthonormal_vector())
}

/// Does the same as `direction_error`, with the first axis along `right`, which is orthogonal to `direction`.
pub(crate) fn direction_error_about(to_light: DVec3, direction: DVec3, right: DVec3) -> Option<DVec2> {
    let up = direction.cross(right);
    (to_light.dot(direction) > 0.0).then(|| DVec2::new(to_light.dot(right), to_light.dot(up)))
}
