//! Evenly from where a drag began to where the cursor is, so that where the light ends up is continuous.
//!
//! The light goes by small steps of bounded length, each the least change that keeps the feature on its way as far as limits let
//! it. A step is a continuous function of where it begins: what asks gives way softly where no small change does it (a damped
//! inverse), and nothing is tried and taken back but for steps that are too long for what is linear. So cursors that are near to
//! each other lead to lights that are near to each other, also along limits and off them.

use crate::goal::{DIFFERENCE, Goal};
use crate::quadratic::{Linearization, RowSelection};
use crate::step::{Iterate, Solution, length_between, objective_trace, restore_feasibility};

/// How far places of the way are apart, in radii or radians, and how many there are at least and at most.
const SAMPLE_SPACING: f64 = 0.025;
const SAMPLE_COUNT_RANGE: [f64; 2] = [16.0, 96.0];

/// Steps on the way, where it is steep more than there are places; what takes more does not go evenly.
const MAX_PATH_STEPS: usize = 160;

/// Steps from the end of the way to where the feature is under the cursor.
const MAX_CONVERGE_STEPS: usize = 6;

/// The longest step, in the units of what moves.
const MAX_STEP: f64 = 0.02;

/// How softly the feature asks, as a share of the trace of `J J^T`.
const OBJECTIVE_COMPLIANCE: f64 = 1e-4;

/// How far off the feature may be after a step, or by which share farther than before it; else it is quartered, so many times.
const MAX_STEP_ERROR: f64 = 3e-3;
const MAX_ERROR_GROWTH: f64 = 1.5;
const QUARTERINGS: usize = 3;

/// How far from the end of the way a light may lie that has the feature under the cursor to the last bit.
const MAX_FINAL_JUMP: f64 = 0.02;

impl Solution {
    /// Goes as far on the way as it goes evenly, and says which share of it that is.
    pub fn follow_path(&mut self, goal: &Goal) -> f64 {
        let places = goal.sample_count(SAMPLE_SPACING, SAMPLE_COUNT_RANGE);
        let (mut share, mut steps) = (0.0, 0);
        while share < 1.0 && steps < MAX_PATH_STEPS {
            let Some(reached) = self.advance(goal, share, (share + 1.0 / places).min(1.0)) else { break };
            (share, steps) = (reached, steps + 1);
        }
        share
    }

    /// From the end of the way to where the feature is under the cursor. Whether there is such a light near by.
    pub fn converge(&mut self, goal: &Goal) -> bool {
        for _ in 0..MAX_CONVERGE_STEPS {
            if self.iterate.is_converged() || self.advance(goal, 1.0, 1.0).is_none() {
                break;
            }
        }
        if self.iterate.is_converged() {
            return true;
        }
        let there =
            self.newton_to(goal, 1.0, RowSelection::Firm).or_else(|| self.newton_along_joint(goal, 1.0));
        let near_by = there.filter(|at| length_between(&at.x, &self.iterate.x) < MAX_FINAL_JUMP);
        let is_there = near_by.is_some();
        self.iterate = near_by.unwrap_or_else(|| self.iterate.clone());
        is_there
    }

    /// A step from one share of the way towards another, and which share it comes to; `None` where nothing can be evaluated there.
    fn advance(&mut self, goal: &Goal, from: f64, to: f64) -> Option<f64> {
        self.iterations += 1;
        let ahead = self.with_share(goal, to)?;
        let linear = goal.linearize(&ahead.x, to, &ahead.evaluation, DIFFERENCE);
        let wanted = self.damped_target(goal, &ahead, &linear);
        let long = length_between(&wanted, &ahead.x) / MAX_STEP;
        // Of a long way a part.
        let (mut parts, mut longest) = (long.max(1.0), MAX_STEP);
        let mut stepped = None;
        for _ in 0..=QUARTERINGS {
            let share = if parts > 1.0 { from + (to - from) / parts } else { to };
            let here = self.with_share(goal, share)?;
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

    /// The present place, with the feature to be at another share of its way.
    fn with_share(&self, goal: &Goal, share: f64) -> Option<Iterate> {
        let Iterate { x, evaluation } = &self.iterate;
        Some(Iterate { x: x.clone(), evaluation: goal.evaluate(x, share, &evaluation.tracked)? })
    }

    /// What is linear about a place nearby wants of `at`, softly.
    fn damped_target(&mut self, goal: &Goal, at: &Iterate, linear: &Linearization) -> Vec<f64> {
        self.step_target(
            goal,
            &at.x,
            at,
            linear,
            (OBJECTIVE_COMPLIANCE * objective_trace(linear), RowSelection::All),
        )
    }

    /// A step that is no longer than `longest`, and back within what has to hold.
    fn bounded_step(
        &mut self,
        goal: &Goal,
        share: f64,
        at: &Iterate,
        linear: &Linearization,
        longest: f64,
    ) -> Option<Iterate> {
        let mut x = self.damped_target(goal, at, linear);
        let factor = (longest / length_between(&x, &at.x)).min(1.0);
        x.iter_mut().zip(&at.x).for_each(|(x, was)| *x = was + factor * (*x - was));
        let next = Iterate { evaluation: goal.evaluate(&x, share, &at.evaluation.tracked)?, x };
        Some(restore_feasibility(goal, share, linear, &next, RowSelection::Fixed).unwrap_or(next))
    }
}
