//! Jumps to a light that has the feature under the cursor, however far it is from the present one.

use crate::goal::{DIFFERENCE, Goal, TrackedPoints};
use crate::matrix::dot;
use crate::quadratic::RowSelection;
use crate::start::rigid_start;
use crate::step::{Iterate, Solution, length_between, objective_trace, restore_feasibility};

/// Longest change of the light between two samples of the path, in units of the unknowns.
const MAX_STEP: f64 = 0.25;

/// Steps of the finite differences in successive Newton steps. Slopes jump where two segments of a tube meet. The
/// linearization of one side then leads nowhere on the other, and the mean over both sides works.
const DIFFERENCE_STEPS: [f64; 6] = [DIFFERENCE, DIFFERENCE, DIFFERENCE, 1e-3, 1e-2, 5e-2];

/// Distance from a joint of the tube, in segments, within which the solver may go on with the point at the joint.
const MAX_JOINT_DISTANCE: f64 = 0.1;

/// Distance between samples of the path, in radii or radians. The next constant is the range of their number.
pub(crate) const SAMPLE_SPACING: f64 = 0.1;
pub(crate) const SAMPLE_COUNT_RANGE: [f64; 2] = [4.0, 48.0];

/// Number of times that the solver tries a shorter part of the path to the next sample, each a quarter of the one
/// before.
const PARTS: usize = 4;

/// Most steps that shrink the change of the light. The next constant is the share by which each step shrinks it.
const MAX_SHRINK_STEPS: usize = 24;
const SHRINK: f64 = 0.3;

impl Solution {
    /// Goes on from the share `from` of the path, and if necessary jumps to a different light that has the feature
    /// under the cursor. Returns true if it converges.
    pub fn jump(&mut self, goal: &Goal, near: &TrackedPoints, from: f64) -> bool {
        let samples = goal.sample_count(SAMPLE_SPACING, SAMPLE_COUNT_RANGE);
        let mut share = from;
        while share < 1.0 {
            let Some(reached) = self.continue_to(goal, share, (share + 1.0 / samples).min(1.0)) else {
                return self.place_rigidly(goal, near);
            };
            share = reached;
        }
        self.iterate.is_converged() || self.place_rigidly(goal, near)
    }

    /// Moves from the share `share` of the path to `end`, or only to a share between them, by the smallest change of
    /// the light that has the feature at its target there. Returns the share reached. `None` if not even a small part
    /// of the path has a solution.
    fn continue_to(&mut self, goal: &Goal, share: f64, end: f64) -> Option<f64> {
        let parts = || std::iter::successors(Some(1.0), |part| Some(part * 0.25)).take(PARTS);
        let next_of = |part: f64| if part < 1.0 { share + (end - share) * part } else { end };
        let mut reached = parts().map(next_of).find_map(|next| {
            let at = self.newton_to(goal, next, RowSelection::All).or_else(|| self.newton_along_joint(goal, next))?;
            Some((at, next))
        });
        // Soft pins yield if nothing else has a solution.
        if reached.is_none() && goal.has_soft_pins() {
            reached =
                parts().map(next_of).find_map(|next| Some((self.newton_to(goal, next, RowSelection::Firm)?, next)));
        }
        let (at, next) = reached?;
        self.iterate = at;
        Some(next)
    }

    /// Moves the light rigidly so that the feature is under the cursor. Returns true if the limits allow it.
    fn place_rigidly(&mut self, goal: &Goal, near: &TrackedPoints) -> bool {
        let rigid = rigid_start(goal, near).and_then(|(x, near)| Iterate::new(goal, x, 1.0, &near));
        let Some(at) = rigid.filter(Iterate::is_converged) else { return false };
        self.iterate = at;
        self.shrink(goal);
        true
    }

    /// Finds the nearest light that has the feature at its target at a share of the path, by Newton's method.
    /// `counting` selects the pins that have to be kept.
    pub fn newton_to(&mut self, goal: &Goal, share: f64, counting: RowSelection) -> Option<Iterate> {
        let mut at = self.iterate.at_share(goal, share)?;
        let from = at.x.clone();
        for difference in DIFFERENCE_STEPS {
            if at.is_converged() {
                return Some(at);
            }
            self.iterations += 1;
            let linear = goal.linearize(&at.x, share, &at.evaluation, difference);
            let mu = 1e-15 * objective_trace(&linear);
            let x = self.step_target(goal, &from, &at, &linear, mu, counting);
            if length_between(&x, &from) > MAX_STEP {
                return None;
            }
            at = at.moved_to(goal, x, share)?;
            // Beside limits the objective is weighed against the change. A separate restoration removes the remaining
            // error.
            if let Some(at) = restore_feasibility(goal, share, &linear, &at, RowSelection::Firm) {
                return Some(at);
            }
        }
        None
    }

    /// Finds the nearest light with a tracked point at a joint of the tube.
    ///
    /// Slopes jump where two segments meet. If the slopes of each side lead to the other, the nearest light has the
    /// point on the joint itself, and along the joint both sides have the same slopes.
    pub fn newton_along_joint(&mut self, goal: &Goal, share: f64) -> Option<Iterate> {
        let tracked = *self.iterate.evaluation.tracked.first()?;
        tracked.into_iter().enumerate().find_map(|(which, t)| {
            let joint = t.round();
            if !(joint > 0.0 && (t - joint).abs() < MAX_JOINT_DISTANCE) {
                return None;
            }
            let found = self.newton_to(&goal.at_joint(which, joint), share, RowSelection::All)?;
            found.at_share(goal, share).filter(Iterate::is_converged)
        })
    }

    /// Makes the change of the light since the start of the drag smaller, step by step, as long as the feature stays at
    /// its target.
    pub fn shrink(&mut self, goal: &Goal) {
        for _ in 0..MAX_SHRINK_STEPS {
            let smaller: Vec<f64> = self.iterate.x.iter().map(|x| x * (1.0 - SHRINK)).collect();
            let Some(iterate) = self.iterate.moved_to(goal, smaller, 1.0) else { return };
            let mut found = Self { iterate, ..self.clone() };
            match found.newton_to(goal, 1.0, RowSelection::All) {
                Some(at) if dot(&at.x, &at.x) < dot(&self.iterate.x, &self.iterate.x) => self.iterate = at,
                _ => return,
            }
            self.iterations = found.iterations;
        }
    }
}
