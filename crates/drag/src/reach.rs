//! Straight to a light that has the feature under the cursor, wherever it is.

use crate::goal::{DIFFERENCE, Goal, Near};
use crate::matrix::dot;
use crate::quadratic::Counting;
use crate::start::rigid_start;
use crate::step::{At, Solution, back, length_between, trace_of};

/// The longest way to one place, in the units of what moves.
const LONGEST: f64 = 0.25;

/// Newton's steps to a place, and over how far each takes differences. Where two segments of a tube meet slopes jump: what
/// is linear on one side leads nowhere on the other, and what is on the mean over both does.
const DIFFERENCES: [f64; 6] = [DIFFERENCE, DIFFERENCE, DIFFERENCE, 1e-3, 1e-2, 5e-2];

/// How far from a joint, in segments, a place may go on along that.
const NEAR_JOINT: f64 = 0.1;

/// How far places of a way are apart, in radii or radians, and how many there are at least and at most.
pub(crate) const APART: f64 = 0.1;
pub(crate) const PLACES: [f64; 2] = [4.0, 48.0];

/// Parts of a way to the next place that are tried, each a quarter of the one before.
const PARTS: usize = 4;

/// Steps in which a change becomes smaller, and by which share each.
const SHRINKING: usize = 24;
const SHRINK: f64 = 0.3;

impl Solution {
    /// Goes on from a share of the way however it may, also from another light that has the feature under the cursor. Whether it
    /// lands.
    pub fn jump(&mut self, goal: &Goal, near: &Near, from: f64) -> bool {
        let places = goal.places(APART, PLACES);
        let mut share = from;
        while share < 1.0 {
            match self.follow(goal, share, (share + 1.0 / places).min(1.0)) {
                Some(reached) => share = reached,
                None => return self.put(goal, near),
            }
        }
        self.at.is_there() || self.put(goal, near)
    }

    /// Goes on from one share of the way to another, or to one between, by the smallest change that has the feature there; `None`
    /// where nothing does even for a small part of it.
    fn follow(&mut self, goal: &Goal, share: f64, end: f64) -> Option<f64> {
        let parts = || std::iter::successors(Some(1.0), |part| Some(part * 0.25)).take(PARTS);
        let next_of = |part: f64| if part < 1.0 { share + (end - share) * part } else { end };
        let mut reached = parts().map(next_of).find_map(|next| {
            let at = self.reach(goal, next, Counting::All).or_else(|| self.reach_along_joint(goal, next))?;
            Some((at, next))
        });
        // What is soft gives way where nothing else does.
        if reached.is_none() && goal.has_soft_pins() {
            reached =
                parts().map(next_of).find_map(|next| Some((self.reach(goal, next, Counting::Firm)?, next)));
        }
        let (at, next) = reached?;
        self.at = at;
        Some(next)
    }

    /// Puts a light that moves as a whole where the feature is under the cursor. Whether it may be there.
    fn put(&mut self, goal: &Goal, near: &Near) -> bool {
        let Some((x, near)) = rigid_start(goal, near) else { return false };
        let Some(evaluation) = goal.evaluate(&x, 1.0, &near) else { return false };
        let at = At { x, evaluation };
        let is_there = at.is_there();
        if is_there {
            self.at = at;
            self.shrink(goal);
        }
        is_there
    }

    /// The nearest place with the feature where it should be, by Newton's method.
    pub fn reach(&mut self, goal: &Goal, share: f64, counting: Counting) -> Option<At> {
        let evaluation = goal.evaluate(&self.at.x, share, &self.at.evaluation.near)?;
        let from = self.at.x.clone();
        let mut at = At { x: from.clone(), evaluation };
        for over in DIFFERENCES {
            if at.is_there() {
                return Some(at);
            }
            self.iterations += 1;
            let linear = goal.linear(&at.x, share, &at.evaluation, over);
            let mu = 1e-15 * trace_of(&linear);
            let x = self.wanted(goal, &from, &at, &linear, (mu, counting));
            if length_between(&x, &from) > LONGEST {
                return None;
            }
            let evaluation = goal.evaluate(&x, share, &at.evaluation.near)?;
            at = At { x, evaluation };
            // Beside limits what is asked is weighed against the change; the rest is a way of its own.
            if let Some(at) = back(goal, share, &linear, &at, Counting::Firm) {
                return Some(at);
            }
        }
        None
    }

    /// The same along a joint of the tube. Slopes jump where two segments meet, and where those of each side lead to the other
    /// the nearest place is on the joint itself: along that they are the same.
    pub fn reach_along_joint(&mut self, goal: &Goal, share: f64) -> Option<At> {
        let places = self.at.evaluation.near.first()?.iter().enumerate();
        let joints: Vec<_> = places
            .map(|(which, t)| (which, t.round()))
            .filter(|(which, joint)| {
                *joint > 0.0 && (self.at.evaluation.near[0][*which] - joint).abs() < NEAR_JOINT
            })
            .collect();
        joints.into_iter().find_map(|joint| {
            let found = self.reach(&goal.at_joint(joint), share, Counting::All)?;
            let evaluation = goal.evaluate(&found.x, share, &found.evaluation.near)?;
            Some(At { evaluation, ..found }).filter(At::is_there)
        })
    }

    /// Makes the change smaller as long as the feature stays where it should be.
    pub fn shrink(&mut self, goal: &Goal) {
        for _ in 0..SHRINKING {
            let smaller: Vec<f64> = self.at.x.iter().map(|x| x * (1.0 - SHRINK)).collect();
            let Some(evaluation) = goal.evaluate(&smaller, 1.0, &self.at.evaluation.near) else { return };
            let mut found = Self { at: At { x: smaller, evaluation }, ..self.clone() };
            match found.reach(goal, 1.0, Counting::All) {
                Some(at) if dot(&at.x, &at.x) < dot(&self.at.x, &self.at.x) => self.at = at,
                _ => return,
            }
            self.iterations = found.iterations;
        }
    }
}
