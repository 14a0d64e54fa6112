//! Where a light that moves as a whole may be put so that the feature lies under the cursor, in closed form.

use glam::{DQuat, DVec3};
use light::LightRays;
use raycast::BentPath;

use crate::goal::{Goal, Objective, TakenFeature, TrackedPoints};
use crate::moves::Unknowns;
use crate::request::Feature;

/// A placement with the feature under the cursor, and where it then lies in the light; not the nearest one. `None` where there is
/// no such closed form.
///
/// A hotspot goes with the light, a highlight by a turn about the place too. For a shadow, of the ways of the light the one
/// through the pivot is turned about that until it meets the cursor, by the place on it that is as far from the pivot as the
/// cursor is.
pub(crate) fn rigid_start(goal: &Goal, near: &TrackedPoints) -> Option<(Vec<f64>, TrackedPoints)> {
    let (Unknowns::Rigid { unit }, Objective::Feature(taken)) = (&goal.unknowns, &goal.objective) else {
        return None;
    };
    let (from, to) = (taken.from.position, taken.to.position);
    let (pivot, turn) = match (taken.feature, taken.pivot) {
        (Feature::Shadow, Some(pivot)) => {
            let (there, t) = point_at_distance(goal, taken, pivot, near[0], pivot.distance(to))?;
            let turn = DQuat::from_rotation_arc((there - pivot).normalize(), (to - pivot).normalize());
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

/// The numbers of the placement that takes a point of the light elsewhere and turns it about that.
fn rigid_unknowns(goal: &Goal, unit: f64, (from, to): (DVec3, DVec3), turn: DQuat) -> Vec<f64> {
    let source = goal.scene_light.source();
    let way = (to + turn * (source - from) - source) / unit;
    [way.to_array(), turn.to_scaled_axis().to_array()].concat()
}

/// The place on the way through the pivot, past it, that is so far from it, and where it lies on its way.
fn point_at_distance(
    goal: &Goal,
    taken: &TakenFeature,
    pivot: DVec3,
    [near_t, pivot_t]: [f64; 2],
    distance: f64,
) -> Option<(DVec3, f64)> {
    let LightRays::Bent(tube) = goal.scene_light.rays else {
        let there = pivot + (taken.from.position - pivot).normalize() * distance;
        return Some((there, pivot_t + distance));
    };
    let across = taken.start_coords.cross_coords;
    let path = BentPath::new(tube, across.x, across.y, goal.scene_light.origin_in_world);
    let at = |t: f64| {
        let segment = (t as usize).min(tube.segments.len() - 1);
        path.position_at(segment, t - segment as f64)
    };
    let end = if tube.segments.len() > tube.n { f64::INFINITY } else { tube.n as f64 };
    let far = |t: f64| at(t).distance(pivot) - distance;
    // Past the place where it is too near, by steps that grow, then between the two.
    let (mut low, mut high) = (pivot_t, near_t);
    let mut step = (near_t - pivot_t).max(1e-6);
    while far(high) < 0.0 {
        if high >= end || step > 1e12 {
            return None;
        }
        low = high;
        high = (high + step).min(end);
        step *= 2.0;
    }
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        if far(middle) < 0.0 { low = middle } else { high = middle }
    }
    let t = f64::midpoint(low, high);
    Some((at(t), t))
}
