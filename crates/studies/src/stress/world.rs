//! A light and its points keep their coordinates if they are moved, rotated and scaled together.

use glam::DVec3;
use light::parameters::DIRECTION;
use light::{DirectionMode, Light, Transform, Tube};
use proptest::prelude::*;
use serde::Serialize;

use super::light::{LightLimits, as_file, lights, placement};
use super::place::{PointSpec, bounds, in_tube};
use super::runner::{Check, CheckTally};

/// A light at the origin, test points, and a transform of both.
#[derive(Clone, Debug, Serialize)]
pub struct WorldCase {
    #[serde(serialize_with = "as_file")]
    pub light: Light,
    /// Positions before the transform.
    pub points: Vec<[f64; 3]>,
    pub translation: [f64; 3],
    /// Quaternion, xyzw.
    pub rotation: [f64; 4],
    pub scale: f64,
    /// Power of two by which control points and radii are scaled up, and the transform's scale down.
    pub units: i32,
}

/// Generates lights of every kind except those with the direction "path", which has its own conditioning.
pub fn cases() -> impl Strategy<Value = WorldCase> {
    let lights = lights(LightLimits { segments: 12, fold: 1.0, pinched: true, flipping: true });
    let units = prop_oneof![Just(0), -300..300];
    (lights, placement(), units, prop::collection::vec(in_tube(0.99), 1..16)).prop_map(|(light, to, units, places)| {
        let light = light.with(DIRECTION, DirectionMode::Tube);
        let tube = Tube::new(&light).expect("valid");
        let in_world = |place: PointSpec| tube.placement.world_from_tube(place.in_tube_space(&tube)).to_array();
        WorldCase {
            points: places.into_iter().map(in_world).collect(),
            light,
            translation: to.translation.to_array(),
            rotation: to.rotation.to_array(),
            scale: to.scale,
            units,
        }
    })
}

/// Checks each point.
pub fn check(case: &WorldCase, tally: &mut CheckTally) -> Check {
    let before = Tube::new(&case.light).expect("cases are valid");
    let move_by = Transform {
        translation: case.translation.into(),
        rotation: glam::DQuat::from_array(case.rotation),
        scale: case.scale,
    };
    let units = 2_f64.powi(case.units);
    let moved = case
        .light
        .clone()
        .with_transform(Transform { scale: case.scale / units, ..move_by })
        .map_points(|_, point| (point.position, point.radius) = (point.position * units, point.radius * units));
    let after = Tube::new(&moved).map_err(|error| format!("the moved light is refused: {error}"))?;
    case.points.iter().try_for_each(|&point| check_invariance(&before, &after, &move_by, point.into(), tally))
}

fn check_invariance(
    before: &Tube<f64>,
    after: &Tube<f64>,
    by: &Transform,
    point: DVec3,
    tally: &mut CheckTally,
) -> Check {
    let q = before.placement.tube_from_world(point);
    let Some(expected) = before.nearest_root(q) else { return Ok(()) };
    let mut moved = by.world_from_local(point);
    if tally.is_planted {
        moved += after.placement.rotation.x_axis * (1e-3 * expected.radius * after.placement.world_per_tube);
    }
    let moved_q = after.placement.tube_from_world(moved);
    // The world position is rounded relative to its size.
    let size = before.placement.world_per_tube * by.scale;
    let dq = 8.0 * f64::EPSILON * (by.translation.length() / size + q.length() + expected.r.length());
    let Some(bound) = bounds(before, &expected, q, f64::EPSILON, dq) else { return Ok(()) };
    let gap = expected.radius - expected.r.length();
    let t = expected.segment as f64 + expected.u;
    if gap < 8.0 * (bound.across + bound.radius) || t < bound.t || before.n as f64 - t < bound.t {
        return Ok(());
    }
    let mut found = None;
    after.for_each_root(moved_q, |root| {
        let off = (root.segment as f64 + root.u - t).abs();
        if found.is_none_or(|(best, _)| off < best) {
            found = Some((off, root));
        }
    });
    let place = format!("at t = {t:?} of {point}");
    let Some((off, root)) = found else {
        return tally.holds(false, || format!("the point {place} is lost in the move"));
    };
    tally.within(format_args!("t {place}"), off, bound.t)?;
    tally.within(format_args!("V {place}"), (root.v_len - expected.v_len).abs(), bound.across)?;
    tally.within(format_args!("W {place}"), (root.w_len - expected.w_len).abs(), bound.across)?;
    tally.within(format_args!("R {place}"), (root.radius - expected.radius).abs(), bound.radius)?;
    let turned = by.rotation.normalize() * before.tube_point(&expected).direction;
    let turn = (after.tube_point(&root).direction - turned).length();
    tally.within(format_args!("the direction {place}"), turn, bound.direction + 16.0 * f64::EPSILON)
}
