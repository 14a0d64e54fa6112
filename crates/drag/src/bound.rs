//! What a place in a light needs, and how far it is off from what it should be.

use glam::{DVec2, DVec3};

use crate::place::{Place, Placed};
use crate::request::Limit;

/// Least of `1 - kappa r.N`: at 0 ways of the light meet, and light comes from nowhere.
const LEAST_SPREAD: f64 = 0.02;

/// How far inside of the light's edge the place under the cursor stays, in radii.
pub(crate) const INSIDE: f64 = 1e-4;

/// How much farther than the pivot a shadowed place lies, along the light.
const BEHIND: f64 = 1e-6;

/// What is to stay 0 or more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    pub value: f64,
    pub limit: Limit,
    /// How softly it gives way; 0 where it does not.
    pub give: f64,
}

/// A limit that does not give way.
pub(crate) fn hard(value: f64, limit: Limit) -> Bound {
    Bound { value, limit, give: 0.0 }
}

/// What a place needs to have light: ways that do not meet, and no end of the light before it. `fold` and `edge` say what limits,
/// and `give` how softly.
pub(crate) fn bounds_of_place(
    placed: &Placed,
    place: &Place,
    ([fold, edge], give): ([Limit; 2], f64),
    room: f64,
    bounds: &mut Vec<Bound>,
) {
    bounds.extend([
        Bound { value: place.spread - LEAST_SPREAD, limit: fold, give },
        Bound { value: 1.0 - INSIDE - placed.out2(place) + room, limit: edge, give },
        Bound { value: place.from_ends.min(1.0) + room, limit: edge, give },
    ]);
}

/// How much farther along the light a place lies than what shadows it.
pub(crate) fn behind(place: &Place, pivot: &Place, was: &Place) -> f64 {
    (place.t - pivot.t) / was.t.max(f64::MIN_POSITIVE) - BEHIND
}

/// How far a way lies from a place, in radii that the light had where it `was`.
pub(crate) fn across_off(across: DVec2, place: &Place, was: &Place) -> DVec2 {
    (across - place.across) * (place.width / was.width)
}

/// How far light is from arriving along `direction`, in radians across it; `None` where it comes from behind.
pub(crate) fn direction_off(to_light: DVec3, direction: DVec3) -> Option<DVec2> {
    direction_off_about(to_light, direction, direction.any_orthonormal_vector())
}

/// The same with the first of the two on `right`, which is square to `direction`.
pub(crate) fn direction_off_about(to_light: DVec3, direction: DVec3, right: DVec3) -> Option<DVec2> {
    let up = direction.cross(right);
    (to_light.dot(direction) > 0.0).then(|| DVec2::new(to_light.dot(right), to_light.dot(up)))
}
