//! Straight to a light that has the feature under the cursor, wherever it is.

use crate::goal::{DIFFERENCE, Goal, TrackedPoints};
use crate::matrix::dot;
use crate::quadratic::RowSelection;
use crate::start::rigid_start;
use crate::step::{Iterate, Solution, length_between, objective_trace, restore_feasibility};

/// The longest way to one place, in the units of what moves.
const MAX_STEP: f64 = 0.25;

/// Newton's steps to a place, and over how far each takes differences. Where two segments of a tube meet slopes jump: what
/// is linear on one side leads nowhere on the other, and what is on the mean over both does.
const DIFFERENCE_STEPS: [f64; 6] = [DIFFERENCE, DIFFERENCE, DIFFERENCE, 1e-3, 1e-2, 5e-2];

/// How far from a joint, in segments, a place may go on along that.
const MAX_JOINT_DISTANCE: f64 = 0.1;

/// How far places of a way are apart, in radii or radians, and how many there are at least and at most.
pub(crate) const SAMPLE_SPACING: f64 = 0.1;
pub(crate) const SAMPLE_COUNT_RANGE: [f64; 2] = [4.0, 48.0];

/// Parts of a way to the next place that are tried, each a quarter of the one before.
const PARTS: usize = 4;

/// Steps in which a change becomes smaller, and by which share each.
const MAX_SHRINK_STEPS: usize = 24;
const SHRINK: f64 = 0.3;

impl Solution {
    /// Goes on from a share of the way however it may, also from another light that has the feature under the cursor. Whether it
    /// lands.
    pub fn jump(&mut self, goal: &Goal, near: &TrackedPoints, from: f64) -> bool {
        let places = goal.sample_count(SAMPLE_SPACING, SAMPLE_COUNT_RANGE);
        let mut share = from;
        while share < 1.0 {
            match self.continue_to(goal, share, (share + 1.0 / places).min(1.0)) {
                Some(reached) => share = reached,
                None => return self.place_rigidly(goal, near),
            }
        }
        self.iterate.is_converged() || self.place_rigidly(goal, near)
    }

    /// Goes on from one share of the way to another, or to one between, by the smallest change that has the feature there; `None`
    /// where nothing does even for a small part of it.
    fn continue_to(&mut self, goal: &Goal, share: f64, end: f64) -> Option<f64> {
        let parts = || std::iter::successors(Some(1.0), |part| Some(part * 0.25)).take(PARTS);
        let next_of = |part: f64| if part < 1.0 { share + (end - share) * part } else { end };
        let mut reached = parts().map(next_of).find_map(|next| {
            let at = self
                .newton_to(goal, next, RowSelection::All)
                .or_else(|| self.newton_along_joint(goal, next))?;
            Some((at, next))
        });
        // What is soft gives way where nothing else does.
        if reached.is_none() && goal.has_soft_pins() {
            reached = parts()
                .map(next_of)
                .find_map(|next| Some((self.newton_to(goal, next, RowSelection::Firm)?, next)));
        }
        let (at, next) = reached?;
        self.iterate = at;
        Some(next)
    }

    /// Puts a light that moves as a whole where the feature is under the cursor. Whether it may be there.
    fn place_rigidly(&mut self, goal: &Goal, near: &TrackedPoints) -> bool {
        let Some((x, near)) = rigid_start(goal, near) else { return false };
        let Some(evaluation) = goal.evaluate(&x, 1.0, &near) else { return false };
        let at = Iterate { x, evaluation };
        let is_there = at.is_converged();
        if is_there {
            self.iterate = at;
            self.shrink(goal);
        }
        is_there
    }

    /// The nearest place with the feature where it should be, by Newton's method.
    pub fn newton_to(&mut self, goal: &Goal, share: f64, counting: RowSelection) -> Option<Iterate> {
        let evaluation = goal.evaluate(&self.iterate.x, share, &self.iterate.evaluation.tracked)?;
        let from = self.iterate.x.clone();
        let mut at = Iterate { x: from.clone(), evaluation };
        for over in DIFFERENCE_STEPS {
            if at.is_converged() {
                return Some(at);
            }
            self.iterations += 1;
            let linear = goal.linearize(&at.x, share, &at.evaluation, over);
            let mu = 1e-15 * objective_trace(&linear);
            let x = self.step_target(goal, &from, &at, &linear, (mu, counting));
            if length_between(&x, &from) > MAX_STEP {
                return None;
            }
            let evaluation = goal.evaluate(&x, share, &at.evaluation.tracked)?;
            at = Iterate { x, evaluation };
            // Beside limits what is asked is weighed against the change; the rest is a way of its own.
            if let Some(at) = restore_feasibility(goal, share, &linear, &at, RowSelection::Firm) {
                return Some(at);
            }
        }
        None
    }

    /// The same along a joint of the tube. Slopes jump where two segments meet, and where those of each side lead to the other
    /// the nearest place is on the joint itself: along that they are the same.
    pub fn newton_along_joint(&mut self, goal: &Goal, share: f64) -> Option<Iterate> {
        let places = self.iterate.evaluation.tracked.first()?.iter().enumerate();
        let joints: Vec<_> = places
            .map(|(which, t)| (which, t.round()))
            .filter(|(which, joint)| {
                *joint > 0.0
                    && (self.iterate.evaluation.tracked[0][*which] - joint).abs() < MAX_JOINT_DISTANCE
            })
            .collect();
        joints.into_iter().find_map(|joint| {
            let found = self.newton_to(&goal.at_joint(joint), share, RowSelection::All)?;
            let evaluation = goal.evaluate(&found.x, share, &found.evaluation.tracked)?;
            Some(Iterate { evaluation, ..found }).filter(Iterate::is_converged)
        })
    }

    /// Makes the change smaller as long as the feature stays where it should be.
    pub fn shrink(&mut self, goal: &Goal) {
        for _ in 0..MAX_SHRINK_STEPS {
            let smaller: Vec<f64> = self.iterate.x.iter().map(|x| x * (1.0 - SHRINK)).collect();
            let Some(evaluation) = goal.evaluate(&smaller, 1.0, &self.iterate.evaluation.tracked) else {
                return;
            };
            let mut found = Self { iterate: Iterate { x: smaller, evaluation }, ..self.clone() };
            match found.newton_to(goal, 1.0, RowSelection::All) {
                Some(at) if dot(&at.x, &at.x) < dot(&self.iterate.x, &self.iterate.x) => self.iterate = at,
                _ => return,
            }
            self.iterations = found.iterations;
        }
    }
}
