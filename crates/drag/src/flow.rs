//! Path following from the start of a drag to the cursor, in steps of bounded length, so that the resulting light is a
//! continuous function of the cursor.
//!
//! Each step is the least change that keeps the feature on its path as far as limits allow, and a continuous function
//! of its start. The objective yields softly where no small change reaches it (a damped inverse). The solver takes back
//! a step only if it is too long for the linearization. So nearby cursors lead to nearby lights, also along limits and
//! off them.

use crate::goal::{DIFFERENCE, Goal};
use crate::matrix::{difference, length, scaled_sum};
use crate::quadratic::{Linearization, RowSelection};
use crate::step::{Iterate, Solution, length_between, objective_trace, restore_feasibility};

/// Distance between samples of the path, in radii or radians. The next constant is the range of their number.
const SAMPLE_SPACING: f64 = 0.025;
const SAMPLE_COUNT_RANGE: [f64; 2] = [16.0, 96.0];

/// Most steps along the path. A steep path takes more steps than it has samples. If a path needs more steps than this,
/// the solver gives up following it.
const MAX_PATH_STEPS: usize = 160;

/// Most steps at the end of the path, until the feature is under the cursor.
const MAX_CONVERGE_STEPS: usize = 6;

/// Longest step, in units of the unknowns.
const MAX_STEP: f64 = 0.02;

/// Softness of the objective, as a share of the trace of `J J^T`.
const OBJECTIVE_COMPLIANCE: f64 = 1e-4;

/// Largest error of the feature after a step. The next constant is the same as a multiple of the error before the step.
/// The solver quarters a step that exceeds both, at most as many times as the last constant says.
const MAX_STEP_ERROR: f64 = 3e-3;
const MAX_ERROR_GROWTH: f64 = 1.5;
const QUARTERINGS: usize = 3;

/// Largest change of the light from the end of the path to the light that has the feature exactly under the cursor.
const MAX_FINAL_JUMP: f64 = 0.02;

impl Solution {
    /// Follows the path in small, even steps as far as possible, and returns the share of the path that was covered.
    pub fn follow_path(&mut self, goal: &Goal) -> f64 {
        let samples = goal.sample_count(SAMPLE_SPACING, SAMPLE_COUNT_RANGE);
        let (mut share, mut steps) = (0.0, 0);
        while share < 1.0 && steps < MAX_PATH_STEPS {
            let Some(reached) = self.advance(goal, share, (share + 1.0 / samples).min(1.0)) else { break };
            (share, steps) = (reached, steps + 1);
        }
        share
    }

    /// Moves the feature under the cursor from the end of the path. Returns true if there is such a light nearby.
    pub fn converge(&mut self, goal: &Goal) -> bool {
        for _ in 0..MAX_CONVERGE_STEPS {
            if self.iterate.is_converged() || self.advance(goal, 1.0, 1.0).is_none() {
                break;
            }
        }
        if self.iterate.is_converged() {
            return true;
        }
        let exact = self.newton_to(goal, 1.0, RowSelection::Firm).or_else(|| self.newton_along_joint(goal, 1.0));
        let near_by = exact.filter(|at| length_between(&at.x, &self.iterate.x) < MAX_FINAL_JUMP);
        let Some(at) = near_by else { return false };
        self.iterate = at;
        true
    }

    /// Takes a step from the share `from` of the path towards `to`, and returns the share reached. `None` if the light
    /// cannot be evaluated there.
    fn advance(&mut self, goal: &Goal, from: f64, to: f64) -> Option<f64> {
        self.iterations += 1;
        let ahead = self.iterate.at_share(goal, to)?;
        let linear = goal.linearize(&ahead.x, to, &ahead.evaluation, DIFFERENCE);
        let target = self.damped_target(goal, &ahead, &linear);
        // A long path is taken in parts.
        let (mut parts, mut longest) = ((length_between(&target, &ahead.x) / MAX_STEP).max(1.0), MAX_STEP);
        let mut stepped = None;
        for _ in 0..=QUARTERINGS {
            let share = if parts > 1.0 { from + (to - from) / parts } else { to };
            let here = self.iterate.at_share(goal, share)?;
            let next = self.bounded_step(goal, share, &here, &linear, longest);
            let is_near = |next: &Iterate| {
                next.objective_error() < MAX_STEP_ERROR.max(MAX_ERROR_GROWTH * self.iterate.objective_error())
            };
            let is_taken = next.as_ref().is_some_and(is_near);
            stepped = next.map(|next| (next, share)).or(stepped);
            if is_taken {
                break;
            }
            (parts, longest) = (parts * 4.0, longest * 0.25);
        }
        let (next, share) = stepped?;
        self.iterate = next;
        Some(share)
    }

    /// Computes the unknowns after a damped step from `at`, with the slopes of a linearization about a nearby point.
    fn damped_target(&mut self, goal: &Goal, at: &Iterate, linear: &Linearization) -> Vec<f64> {
        self.step_target(goal, &at.x, at, linear, OBJECTIVE_COMPLIANCE * objective_trace(linear), RowSelection::All)
    }

    /// Takes a step towards `target` that is at most `longest`, and restores the limits and hard pins.
    fn bounded_step(
        &mut self,
        goal: &Goal,
        share: f64,
        at: &Iterate,
        linear: &Linearization,
        longest: f64,
    ) -> Option<Iterate> {
        let step = difference(&self.damped_target(goal, at, linear), &at.x);
        let factor = (longest / length(&step)).min(1.0);
        let next = at.moved_to(goal, scaled_sum(&at.x, &step, factor), share)?;
        Some(restore_feasibility(goal, share, linear, &next, RowSelection::Fixed).unwrap_or(next))
    }
}
