//! Coordinates are continuous at joints, and no point there is lost or counted twice.

use light::parameters::DIRECTION;
use light::{DirectionMode, Light, LightWarning, Real, Tube};
use proptest::prelude::*;
use serde::Serialize;

use super::light::{LightLimits, as_file, lights};
use super::place::{bounds, eps, point_at, root_at};
use super::runner::{Check, CheckTally};

/// A light and points near its joints.
#[derive(Clone, Debug, Serialize)]
pub struct JointCase {
    #[serde(serialize_with = "as_file")]
    pub light: Light,
    pub crossings: Vec<JointCrossing>,
}

/// A step across a joint.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct JointCrossing {
    /// Index of the joint, taken modulo the number of joints.
    pub joint: usize,
    pub v: f64,
    pub w: f64,
    /// Length along the tangent, in tube units.
    pub step: f64,
}

/// Generates lights with the direction "tube", which is continuous by definition.
pub fn cases() -> impl Strategy<Value = JointCase> {
    let lights = lights(LightLimits { segments: 12, fold: 1.0, pinched: true, flipping: true });
    let step = prop_oneof![Just(0.0).boxed(), super::light::decades(-16.0, -6.0).boxed()];
    let crossing = (0..64_usize, 0.0..0.999, 0.0..std::f64::consts::TAU, step, any::<bool>()).prop_map(
        |(joint, rho, angle, step, back)| JointCrossing {
            joint,
            v: rho * angle.cos(),
            w: rho * angle.sin(),
            step: if back { -step } else { step },
        },
    );
    (lights, prop::collection::vec(crossing, 1..16))
        .prop_map(|(light, crossings)| JointCase { light: light.with(DIRECTION, DirectionMode::Tube), crossings })
}

/// Checks each crossing, in f64 and f32.
pub fn check(case: &JointCase, tally: &mut CheckTally) -> Check {
    let tube = Tube::new(&case.light).expect("cases are valid");
    let corners: Vec<f64> = tube.warnings().into_iter().filter_map(corner).collect();
    if tube.segments.len() == 1 {
        return Ok(());
    }
    let single = Tube::<f32>::from(&tube);
    for crossing in &case.crossings {
        let joint = 1 + crossing.joint % (tube.segments.len() - 1);
        if corners.contains(&(joint as f64)) {
            continue;
        }
        both_sides_agree(&tube, joint, crossing, tally)?;
        check_no_gap(&tube, &tube, joint, crossing, tally)?;
        check_no_gap(&tube, &single, joint, crossing, tally)?;
    }
    Ok(())
}

fn corner(warning: LightWarning) -> Option<f64> {
    match warning {
        LightWarning::Corner { t } => Some(t),
        LightWarning::Overlap { .. } => None,
    }
}

/// Compares `V`, `W`, `R` and direction from the segment before the joint and from the one after it.
fn both_sides_agree(tube: &Tube<f64>, joint: usize, at: &JointCrossing, tally: &mut CheckTally) -> Check {
    let q = point_at(tube, joint as f64, at.v, at.w);
    let (before, mut after) = (root_at(tube, joint - 1, 1.0, q), root_at(tube, joint, 0.0, q));
    if tally.is_planted {
        after.r *= 1.1;
    }
    let Some(bound) = bounds(tube, &before, q, f64::EPSILON, 0.0) else { return Ok(()) };
    let place = format!("over joint {joint} at (v, w) = ({:?}, {:?})", at.v, at.w);
    tally.within(format_args!("V {place}"), (before.v_len - after.v_len).abs(), bound.across)?;
    tally.within(format_args!("W {place}"), (before.w_len - after.w_len).abs(), bound.across)?;
    let size = before.radius + tube.segments[joint - 1].curve.r0;
    tally.within(format_args!("R {place}"), (before.radius - after.radius).abs(), 16.0 * f64::EPSILON * size)?;
    let turn = (tube.direction_at(&before) - tube.direction_at(&after)).length();
    tally.within(format_args!("the direction {place}"), turn, 2.0 * bound.direction)
}

/// Checks that a point on the joint's plane, or a little to one side of it, is found once and at the expected
/// parameter.
fn check_no_gap<F: Real>(
    exact: &Tube<f64>,
    tube: &Tube<F>,
    joint: usize,
    at: &JointCrossing,
    tally: &mut CheckTally,
) -> Check {
    let from = point_at(exact, joint as f64, at.v, at.w);
    let here = root_at(exact, joint - 1, 1.0, from);
    let q = from + here.u_hat * at.step;
    // The curvature jumps here, so the same step is a different one in t on either side.
    let there = root_at(exact, joint, 0.0, from);
    let [Some(before), Some(after)] = [here, there].map(|root| bounds(exact, &root, q, eps::<F>(), at.step.abs()))
    else {
        return Ok(());
    };
    let gap = (1.0 - at.v.hypot(at.w)) * here.radius;
    if gap < 8.0 * (before.across + before.radius.max(after.radius)) {
        return Ok(());
    }
    let expected = at.step * if at.step < 0.0 { before.rate } else { after.rate };
    let bound = before.t.max(after.t) - at.step.abs() * before.rate.min(after.rate);
    let mut near = 0;
    let mut error = f64::INFINITY;
    tube.for_each_root(F::vec(q), |root| {
        let t = (root.segment as f64 - joint as f64) + root.u.f64();
        near += usize::from((t - expected).abs() <= bound + 2.0 * F::JOINT_MERGE.f64());
        error = error.min((t - expected).abs());
    });
    let place =
        format!("{:e} past joint {joint} at (v, w) = ({:?}, {:?}) in f{}", at.step, at.v, at.w, 8 * size_of::<F>());
    tally.within(format_args!("t {place}"), error, bound)?;
    tally.holds(near == 1, || format!("the root {place} counts {near} times"))
}
