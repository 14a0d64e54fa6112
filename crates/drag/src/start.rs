//! Rigid placement of a light in closed form, with the feature under the cursor.

use glam::{DQuat, DVec3};
use light::LightRays;
use raycast::BentPath;

use crate::goal::{Goal, Objective, TakenFeature, TrackedPoints};
use crate::moves::Unknowns;
use crate::request::Feature;

/// Returns the unknowns of a placement with the feature under the cursor, and the tracked points in it. The placement
/// is not the nearest one. `None` if there is no closed form.
///
/// For a hotspot, the light is translated. For a highlight, it is also rotated about the point. For a shadow, the light
/// rotates about the pivot: the light path through the pivot has a point as far from the pivot as the cursor is, and
/// the rotation takes that point to the cursor.
pub(crate) fn rigid_start(goal: &Goal, near: &TrackedPoints) -> Option<(Vec<f64>, TrackedPoints)> {
    let (Unknowns::Rigid { unit }, Objective::Feature(taken)) = (&goal.unknowns, &goal.objective) else {
        return None;
    };
    let (from, to) = (taken.from.position, taken.to.position);
    let (pivot, turn) = match (taken.feature, taken.pivot) {
        (Feature::Shadow, Some(pivot)) => {
            let (point, t) = point_at_distance(goal, taken, pivot, near[0], pivot.distance(to))?;
            let turn = DQuat::from_rotation_arc((point - pivot).normalize(), (to - pivot).normalize());
            let mut near = near.clone();
            near[0][0] = t;
            return Some((rigid_unknowns(goal, *unit, (pivot, pivot), turn), near));
        }
        (Feature::Shadow | Feature::Hotspot, _) => (from, DQuat::IDENTITY),
        (Feature::Highlight | Feature::Diffuse, _) => {
            let [from_direction, to_direction] = taken.directions;
            (from, DQuat::from_rotation_arc(from_direction, to_direction))
        }
    };
    Some((rigid_unknowns(goal, *unit, (pivot, to), turn), near.clone()))
}

/// Returns the unknowns that move a point of the light from `from` to `to` and rotate the light about that point.
fn rigid_unknowns(goal: &Goal, unit: f64, (from, to): (DVec3, DVec3), turn: DQuat) -> Vec<f64> {
    let source = goal.scene_light.source();
    let translation = (to + turn * (source - from) - source) / unit;
    [translation.to_array(), turn.to_scaled_axis().to_array()].concat()
}

/// Finds the point on the light path through the pivot that lies a distance behind the pivot, and the point's `t`.
fn point_at_distance(
    goal: &Goal,
    taken: &TakenFeature,
    pivot: DVec3,
    [near_t, pivot_t]: [f64; 2],
    distance: f64,
) -> Option<(DVec3, f64)> {
    let LightRays::Bent(tube) = goal.scene_light.rays else {
        let point = pivot + (taken.from.position - pivot).normalize() * distance;
        return Some((point, pivot_t + distance));
    };
    let across = taken.start_coords.cross_coords;
    let path = BentPath::new(tube, across.x, across.y, goal.scene_light.origin_in_world);
    let at = |t: f64| {
        let (segment, u) = tube.segment_at(t);
        path.position_at(segment, u)
    };
    let end = tube.t_end();
    let excess = |t: f64| at(t).distance(pivot) - distance;
    // Growing steps find a point that is too far, and bisection the one between.
    let (mut low, mut high) = (pivot_t, near_t);
    let mut step = (near_t - pivot_t).max(1e-6);
    while excess(high) < 0.0 {
        if high >= end || step > 1e12 {
            return None;
        }
        low = high;
        high = (high + step).min(end);
        step *= 2.0;
    }
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    let t = f64::midpoint(low, high);
    Some((at(t), t))
}
