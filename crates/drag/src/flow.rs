//! Evenly from where a drag began to where the cursor is, so that where the light ends up is continuous.
//!
//! The light goes by small steps of bounded length, each the least change that keeps the feature on its way as far as limits let
//! it. A step is a continuous function of where it begins: what asks gives way softly where no small change does it (a damped
//! inverse), and nothing is tried and taken back but for steps that are too long for what is linear. So cursors that are near to
//! each other lead to lights that are near to each other, also along limits and off them.

use crate::goal::{DIFFERENCE, Goal};
use crate::quadratic::{Counting, Linear};
use crate::step::{At, Solution, back, length_between, trace_of};

/// How far places of the way are apart, in radii or radians, and how many there are at least and at most.
const APART: f64 = 0.025;
const PLACES: [f64; 2] = [16.0, 96.0];

/// Steps on the way, where it is steep more than there are places; what takes more does not go evenly.
const STEPS: usize = 160;

/// Steps from the end of the way to where the feature is under the cursor.
const SETTLING: usize = 6;

/// The longest step, in the units of what moves.
const LONGEST: f64 = 0.02;

/// How softly the feature asks, as a share of the trace of `J J^T`.
const GIVE: f64 = 1e-4;

/// How far off the feature may be after a step, or by which share farther than before it; else it is quartered, so many times.
const OFF: f64 = 3e-3;
const FARTHER: f64 = 1.5;
const QUARTERINGS: usize = 3;

/// How far from the end of the way a light may lie that has the feature under the cursor to the last bit.
const TO_THE_LAST_BIT: f64 = 0.02;

impl Solution {
    /// Goes as far on the way as it goes evenly, and says which share of it that is.
    pub fn flow(&mut self, goal: &Goal) -> f64 {
        let places = goal.places(APART, PLACES);
        let (mut share, mut steps) = (0.0, 0);
        while share < 1.0 && steps < STEPS {
            let Some(reached) = self.advance(goal, share, (share + 1.0 / places).min(1.0)) else { break };
            (share, steps) = (reached, steps + 1);
        }
        share
    }

    /// From the end of the way to where the feature is under the cursor. Whether there is such a light near by.
    pub fn settle(&mut self, goal: &Goal) -> bool {
        for _ in 0..SETTLING {
            if self.at.is_there() || self.advance(goal, 1.0, 1.0).is_none() {
                break;
            }
        }
        if self.at.is_there() {
            return true;
        }
        let there = self.reach(goal, 1.0, Counting::Firm).or_else(|| self.reach_along_joint(goal, 1.0));
        let near_by = there.filter(|at| length_between(&at.x, &self.at.x) < TO_THE_LAST_BIT);
        let is_there = near_by.is_some();
        self.at = near_by.unwrap_or_else(|| self.at.clone());
        is_there
    }

    /// A step from one share of the way towards another, and which share it comes to; `None` where nothing can be evaluated there.
    fn advance(&mut self, goal: &Goal, from: f64, to: f64) -> Option<f64> {
        self.iterations += 1;
        let ahead = self.with_share(goal, to)?;
        let linear = goal.linear(&ahead.x, to, &ahead.evaluation, DIFFERENCE);
        let wanted = self.wanted_of(goal, &ahead, &linear);
        let long = length_between(&wanted, &ahead.x) / LONGEST;
        // Of a long way a part.
        let (mut parts, mut longest) = (long.max(1.0), LONGEST);
        let mut stepped = None;
        for _ in 0..=QUARTERINGS {
            let share = if parts > 1.0 { from + (to - from) / parts } else { to };
            let here = self.with_share(goal, share)?;
            let next = self.stepped(goal, share, &here, &linear, longest);
            let is_near = |next: &At| next.off() < OFF.max(FARTHER * self.at.off());
            let is_taken = next.as_ref().is_some_and(is_near);
            stepped = next.map(|next| (next, share)).or(stepped);
            if is_taken {
                break;
            }
            (parts, longest) = (parts * 4.0, longest * 0.25);
        }
        let (next, share) = stepped?;
        self.at = next;
        Some(share)
    }

    /// The present place, with the feature to be at another share of its way.
    fn with_share(&self, goal: &Goal, share: f64) -> Option<At> {
        let At { x, evaluation } = &self.at;
        Some(At { x: x.clone(), evaluation: goal.evaluate(x, share, &evaluation.near)? })
    }

    /// What is linear about a place nearby wants of `at`, softly.
    fn wanted_of(&mut self, goal: &Goal, at: &At, linear: &Linear) -> Vec<f64> {
        self.wanted(goal, &at.x, at, linear, (GIVE * trace_of(linear), Counting::All))
    }

    /// A step that is no longer than `longest`, and back within what has to hold.
    fn stepped(&mut self, goal: &Goal, share: f64, at: &At, linear: &Linear, longest: f64) -> Option<At> {
        let mut x = self.wanted_of(goal, at, linear);
        let factor = (longest / length_between(&x, &at.x)).min(1.0);
        x.iter_mut().zip(&at.x).for_each(|(x, was)| *x = was + factor * (*x - was));
        let next = At { evaluation: goal.evaluate(&x, share, &at.evaluation.near)?, x };
        Some(back(goal, share, linear, &next, Counting::Fixed).unwrap_or(next))
    }
}
