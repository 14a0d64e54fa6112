//! What a place in a light needs, and how far it is off from what it should be.

use glam::{DVec2, DVec3};

use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::DragLimit;

/// Least of `1 - kappa r.N`: at 0 ways of the light meet, and light comes from nowhere.
const MIN_PATH_SPACING: f64 = 0.02;

/// How far inside of the light's edge the place under the cursor stays, in radii.
pub(crate) const EDGE_MARGIN: f64 = 1e-4;

/// How much farther than the pivot a shadowed place lies, along the light.
const PIVOT_MARGIN: f64 = 1e-6;

/// What is to stay 0 or more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    pub value: f64,
    pub limit: DragLimit,
    /// How softly it gives way; 0 where it does not.
    pub compliance: f64,
}

/// A limit that does not give way.
pub(crate) fn hard_bound(value: f64, limit: DragLimit) -> Bound {
    Bound { value, limit, compliance: 0.0 }
}

/// What a place needs to have light: ways that do not meet, and no end of the light before it. `fold` and `edge` say what limits,
/// and `give` how softly.
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

/// How much farther along the light a place lies than what shadows it.
pub(crate) fn distance_behind(place: &PointInLight, pivot: &PointInLight, was: &PointInLight) -> f64 {
    (place.t - pivot.t) / was.t.max(f64::MIN_POSITIVE) - PIVOT_MARGIN
}

/// How far a way lies from a place, in radii that the light had where it `was`.
pub(crate) fn cross_error(across: DVec2, place: &PointInLight, was: &PointInLight) -> DVec2 {
    (across - place.cross_coords) * (place.width / was.width)
}

/// How far light is from arriving along `direction`, in radians across it; `None` where it comes from behind.
pub(crate) fn direction_error(to_light: DVec3, direction: DVec3) -> Option<DVec2> {
    direction_error_about(to_light, direction, direction.any_orthonormal_vector())
}

/// The same with the first of the two on `right`, which is square to `direction`.
pub(crate) fn direction_error_about(to_light: DVec3, direction: DVec3, right: DVec3) -> Option<DVec2> {
    let up = direction.cross(right);
    (to_light.dot(direction) > 0.0).then(|| DVec2::new(to_light.dot(right), to_light.dot(up)))
}
