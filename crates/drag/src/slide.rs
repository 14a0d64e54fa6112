//! Slides along limits: brings a feature that cannot lie under the cursor, or a dragged control point, as near to it as
//! the limits allow.

use glam::DVec3;
use light::CheckedLight;

use crate::goal::{DIFFERENCE, Goal, Objective, TrackedPoints};
use crate::matrix::{difference, length, scaled_sum};
use crate::moves::Unknowns;
use crate::point_in_light::SceneLight;
use crate::quadratic::{Hold, RowSelection};
use crate::reach::{SAMPLE_COUNT_RANGE, SAMPLE_SPACING};
use crate::request::{DragLimit, RadiusMode};
use crate::step::{Iterate, Solution, length_between, objective_trace, restore_feasibility};
use crate::work::WorkBudget;

/// Number of times that an interval is halved to find the last feasible point of a straight line before a limit.
const LIMIT_HALVINGS: usize = 20;

/// Number of steps along the path of a drag that does not converge. The next constant is the most steps at its end,
/// until a step is shorter than [`MIN_STEP`].
const SLIDE_STEPS: usize = 24;
const MAX_SETTLE_STEPS: usize = 40;

/// Step length below which the light counts as at rest, in units of the unknowns.
const MIN_STEP: f64 = 1e-7;

/// Longest step, in units of the unknowns.
const MAX_STEP: f64 = 0.03;

/// Softness of the objective in a slide, as a share of the trace of `J J^T`. With it, the light does not change much
/// for a small gain.
const OBJECTIVE_COMPLIANCE: f64 = 1e-2;

/// Most times that a step is quartered because it does not reduce the cost.
const QUARTERINGS: usize = 4;

/// Result of a dragged control point.
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    /// A light that can be evaluated.
    pub light: CheckedLight,
    /// Limit that keeps the control point from its target; `None` if the point has reached its target.
    pub limit: Option<DragLimit>,
    /// Distance of the control point from its target, in light-local units.
    pub distance_left: f64,
}

/// Moves a control point of `light` to `to` in light-local space, or as near as the fold limit allows.
///
/// With [`RadiusMode::Follow`] radii that would make the tube fold shrink, and nothing keeps the point from its target.
/// The result depends on the light and on `to` alone.
///
/// `None` if the light has no such control point or it is the source, if `to` is not finite, and for
/// [`RadiusMode::Solve`], since radii have no effect on a position.
pub fn slide_point(light: &CheckedLight, point: usize, to: DVec3, radii: RadiusMode) -> Option<Slide> {
    let points = light.light().points();
    if !(1..points.len()).contains(&point) || radii == RadiusMode::Solve || !to.is_finite() {
        return None;
    }
    light.tube()?;
    let unit = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    let unknowns = Unknowns::Points { points: vec![point], radii, unit };
    let objective = Objective::Position { point, to };
    let work = WorkBudget::new(&|_| true);
    let scene_light = SceneLight::new(light.rays(), DVec3::ZERO, DVec3::ZERO, &work);
    let goal = Goal::new(objective, light, unknowns, scene_light, Vec::new());
    let near = vec![[0.0; 2]];
    // Without a limit the point reaches its target to the last bit.
    let whole_change = ((to - points[point].position) / unit).to_array();
    let reaches =
        goal.evaluate(&whole_change, 1.0, &near).is_some_and(|at| at.bounds.iter().all(|bound| bound.value >= 0.0));
    if reaches {
        let mut moved = points.to_vec();
        moved[point].position = to;
        goal.unknowns.shrink_radii(light.light(), &mut moved);
        let moved = light.light().clone().map_points(|index, point| *point = moved[index]);
        if let Ok(light) = CheckedLight::new(moved) {
            return Some(Slide { light, limit: None, distance_left: 0.0 });
        }
    }
    let found = solve_position(&goal, &near, &whole_change)?;
    let moved = CheckedLight::new(goal.unknowns.light(light.light(), &found.iterate.x));
    // A light that the solver accepts does not fold, and so can be evaluated. The light of the start can be in any
    // case.
    let light = moved.unwrap_or_else(|_| light.clone());
    let distance_left = light.light().points()[point].position.distance(to);
    Some(Slide { light, limit: found.strongest_limit.or(Some(DragLimit::NoDescent)), distance_left })
}

/// Moves the control point straight towards its target up to the first limit, and then slides along that limit.
///
/// For each share of the straight line there is one light, and the search checks if it is feasible.
fn solve_position(goal: &Goal, near: &TrackedPoints, whole_change: &[f64]) -> Option<Solution> {
    let mut found = Solution::begin(goal, near)?;
    let at = |share: f64| {
        let x = whole_change.iter().map(|change| change * share).collect();
        Iterate::new(goal, x, share, near).filter(Iterate::is_converged)
    };
    let samples = goal.sample_count(SAMPLE_SPACING, SAMPLE_COUNT_RANGE);
    let mut share = 0.0;
    let mut step = 1.0 / samples;
    for _ in 0..samples as usize + LIMIT_HALVINGS {
        match at(share + step).filter(|_| share + step <= 1.0) {
            Some(next) => (found.iterate, share) = (next, share + step),
            None => step *= 0.5,
        }
    }
    found.slide(goal, share);
    Some(found)
}

/// Cost that a slide minimizes.
struct Cost<'a> {
    /// Unknowns of the last light that had the feature at its target.
    limit_x: &'a [f64],
    /// Weight of the change of the light since `limit_x`, relative to the squared error of the feature.
    compliance: f64,
}

impl Cost<'_> {
    /// Computes the cost: the squared error of the feature, plus the weighted change of the light and the errors of
    /// soft pins.
    fn of(&self, at: &Iterate) -> f64 {
        let rows = at.evaluation.residual.iter().zip(at.evaluation.rows.iter());
        let of_rows =
            rows.map(|(error, row)| if let Hold::Soft(compliance) = row { error * error / compliance } else { 0.0 });
        let soft_bounds = at.evaluation.bounds.iter().filter(|bound| bound.compliance > 0.0);
        let of_bounds = soft_bounds.map(|bound| {
            let violation = bound.value.min(0.0);
            violation * violation / bound.compliance
        });
        let soft: f64 = of_rows.chain(of_bounds).sum();
        let (error, change) = (at.objective_error(), length_between(&at.x, self.limit_x));
        error * error + self.compliance * (change * change + soft)
    }
}

impl Solution {
    /// Goes on from a share of the path after which no light has the feature at its target, to the light with the least
    /// cost.
    ///
    /// The cost weighs the error of the feature against the change of the light. So the light neither jumps nor changes
    /// much for a small gain. The target of the feature may lie outside the light.
    pub fn slide(&mut self, hard_goal: &Goal, from: f64) {
        let Some(start) = self.iterate.at_share(hard_goal, from) else { return };
        let trace = objective_trace(&hard_goal.linearize(&start.x, from, &start.evaluation, DIFFERENCE));
        let cost = Cost { limit_x: &start.x, compliance: OBJECTIVE_COMPLIANCE * trace };
        let goal = hard_goal.with_edge_compliance(cost.compliance);
        for step in 1..=SLIDE_STEPS {
            let share = from + (1.0 - from) * step as f64 / SLIDE_STEPS as f64;
            self.cheaper_step(&goal, share, &cost, MAX_STEP);
        }
        let mut longest = MAX_STEP;
        for _ in 0..MAX_SETTLE_STEPS {
            match self.cheaper_step(&goal, 1.0, &cost, longest) {
                Some(moved) if moved > MIN_STEP => longest = (2.0 * moved).min(MAX_STEP),
                _ => break,
            }
        }
        if let (Objective::Feature(_), Some(at)) =
            (&hard_goal.objective, self.newton_to(hard_goal, 1.0, RowSelection::Firm))
        {
            self.iterate = at;
        }
    }

    /// Takes a step that reduces the cost or restores the limits, and returns its length. `None` if no such step is
    /// found.
    fn cheaper_step(&mut self, goal: &Goal, share: f64, cost: &Cost, longest: f64) -> Option<f64> {
        self.iterations += 1;
        let at = self.iterate.at_share(goal, share)?;
        self.iterate = at.clone();
        let linear = goal.linearize(&at.x, share, &at.evaluation, DIFFERENCE);
        let target = self.step_target(goal, cost.limit_x, &at, &linear, cost.compliance, RowSelection::All);
        let step = difference(&target, &at.x);
        let (before, was_allowed) = (cost.of(&at), at.is_feasible());
        let mut factor = (longest / length(&step)).min(1.0);
        for _ in 0..QUARTERINGS {
            if let Some(next) = at.moved_to(goal, scaled_sum(&at.x, &step, factor), share) {
                let next = restore_feasibility(goal, share, &linear, &next, RowSelection::Fixed).unwrap_or(next);
                if next.is_feasible() && (cost.of(&next) < before || !was_allowed) {
                    let moved = length_between(&next.x, &at.x);
                    self.iterate = next;
                    return Some(moved);
                }
            }
            factor *= 0.25;
        }
        None
    }
}
