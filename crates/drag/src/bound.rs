//! Limits on the coordinates of a point in a light, and errors of those coordinates.

use glam::{DVec2, DVec3};

use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::DragLimit;

/// Least allowed `1 - kappa r.N`. At 0 the light paths meet, and the light has no direction.
const MIN_PATH_SPACING: f64 = 0.02;

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
    /// Softness of the limit; 0 for a hard one.
    pub compliance: f64,
}

/// Makes a limit that never yields.
pub(crate) fn hard_bound(value: f64, limit: DragLimit) -> Bound {
    Bound { value, limit, compliance: 0.0 }
}

/// Adds the limits that a point needs in order to receive light: paths that do not meet there, a position within the
/// light's cross-section, and one between the light's ends.
///
/// `fold` and `edge` name the limits in a result, `give` is their softness, and `room` widens the last two.
pub(crate) fn bounds_at(
    placed: &SceneLight,
    place: &PointInLight,
    ([fold, edge], give): ([DragLimit; 2], f64),
    room: f64,
    bounds: &mut Vec<Bound>,
) {
    bounds.extend([
        Bound { value: place.path_spacing - MIN_PATH_SPACING, limit: fold, compliance: give },
        Bound { value: 1.0 - EDGE_MARGIN - placed.rho2(place) + room, limit: edge, compliance: give },
        Bound { value: place.distance_to_ends.min(1.0) + room, limit: edge, compliance: give },
    ]);
}

/// Computes the distance along the light from the pivot to the point in its shadow, as a share of the point's `t` at
/// the start, less the margin.
pub(crate) fn distance_behind(place: &PointInLight, pivot: &PointInLight, was: &PointInLight) -> f64 {
    (place.t - pivot.t) / was.t.max(f64::MIN_POSITIVE) - PIVOT_MARGIN
}

/// Computes the distance of a light path from a point across the light, in radii of the light at `was`.
pub(crate) fn cross_error(across: DVec2, place: &PointInLight, was: &PointInLight) -> DVec2 {
    (across - place.cross_coords) * (place.width / was.width)
}

/// Computes the deviation of the light's direction from `direction`, in radians along two axes across it. `None` if
/// light arrives from behind.
pub(crate) fn direction_error(to_light: DVec3, direction: DVec3) -> Option<DVec2> {
    direction_error_about(to_light, direction, direction.any_orthonormal_vector())
}

/// Computes the same deviation with the first axis along `right`, which is orthogonal to `direction`.
pub(crate) fn direction_error_about(to_light: DVec3, direction: DVec3, right: DVec3) -> Option<DVec2> {
    let up = direction.cross(right);
    (to_light.dot(direction) > 0.0).then(|| DVec2::new(to_light.dot(right), to_light.dot(up)))
}
