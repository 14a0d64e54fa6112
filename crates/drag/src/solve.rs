//! From where a drag began to where the cursor is, in steps that are solved one after the other.

use crate::goal::{Evaluation, Goal, Near};
use crate::quadratic::{Linear, dot, length, smallest};
use crate::start::rigid_start;

/// A residual this small is none, in radii or radians.
const NOTHING: f64 = 1e-10;

/// A residual that is small enough on the way.
const ON_THE_WAY: f64 = 1e-3;

/// What a residual weighs beside the size of the change.
const PENALTY: f64 = 1e3;

/// A change this small is none.
const STILL: f64 = 1e-10;

/// The longest step at a time, in the units of what moves.
const LONGEST_STEP: f64 = 0.25;

/// Steps that one place on the way takes at most, and the last one.
const STEPS: [usize; 2] = [4, 40];

/// Steps that bring a light back to where the feature lies under the cursor.
const STEPS_BACK: usize = 8;

/// Halvings of a step that does not do.
const HALVINGS: usize = 10;

/// Places on the way at most.
const MOST_PLACES: f64 = 48.0;

/// How far apart they are, in radii or radians.
const BETWEEN_PLACES: f64 = 0.25;

/// A place that the solver is at.
#[derive(Clone, Debug)]
pub(crate) struct At {
    pub x: Vec<f64>,
    pub evaluation: Evaluation,
}

/// What was found.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub at: At,
    /// The limit that holds it back most, by its index.
    pub held_by: Option<usize>,
    pub iterations: usize,
}

/// The smallest change that brings the feature under the cursor, or as near as the limits let it. `None` where even the
/// beginning cannot be evaluated.
pub(crate) fn solve(goal: &Goal, near: Near) -> Option<Solution> {
    let unmoved = vec![0.0; goal.moves.count()];
    let begun = At { evaluation: goal.evaluate(&unmoved, 0.0, near)?, x: unmoved };
    // A light that moves as a whole is put where it has to be, and from there as near to where it was as may be.
    let whole = rigid_start(goal, near)
        .and_then(|(x, near)| Some(At { evaluation: goal.evaluate(&x, 1.0, near)?, x }))
        .filter(At::is_there);
    let mut found = Solution { at: begun, held_by: None, iterations: 0 };
    if let Some(at) = whole {
        found.at = at;
    } else {
        let places = goal.way().div_euclid(BETWEEN_PLACES).clamp(0.0, MOST_PLACES - 1.0) as usize + 1;
        for place in 1..places {
            let share = place as f64 / places as f64;
            found.go(goal, share, STEPS[0]);
        }
    }
    found.go(goal, 1.0, STEPS[1]);
    Some(found)
}

impl At {
    /// Whether the feature lies where it should, and no limit is broken.
    fn is_there(&self) -> bool {
        length(&self.evaluation.residual) < NOTHING
            && self.evaluation.limits.iter().all(|limit| *limit >= 0.0)
    }

    /// What is to become less: what is off, above all, and the size of the change.
    fn merit(&self) -> f64 {
        let broken: f64 = self.evaluation.limits.iter().map(|limit| (-limit).max(0.0)).sum();
        0.5 * dot(&self.x, &self.x) + PENALTY * (length(&self.evaluation.residual) + 10.0 * broken)
    }
}

impl Solution {
    /// Goes on to a share of the way.
    fn go(&mut self, goal: &Goal, share: f64, steps: usize) {
        let Some(evaluation) = goal.evaluate(&self.at.x, share, self.at.evaluation.near) else { return };
        self.at.evaluation = evaluation;
        for _ in 0..steps {
            if share < 1.0 && length(&self.at.evaluation.residual) < ON_THE_WAY {
                break;
            }
            self.iterations += 1;
            let Some(size) = self.step(goal, share) else { break };
            if size < STILL {
                break;
            }
        }
    }

    /// One step, and how large it was; `None` where none does.
    fn step(&mut self, goal: &Goal, share: f64) -> Option<f64> {
        let At { x, evaluation } = &self.at;
        let linear = goal.linear(x, share, evaluation);
        let (wanted, pulls) = smallest(x, &linear, softness(&linear));
        self.held_by =
            (0..pulls.len()).filter(|k| pulls[*k] > 0.0).max_by(|&a, &b| pulls[a].total_cmp(&pulls[b]));
        let way: Vec<f64> = wanted.iter().zip(x).map(|(wanted, x)| wanted - x).collect();
        let whole = length(&way);
        let mut factor = (LONGEST_STEP / whole).min(1.0);
        let (was_there, merit) = (self.at.is_there(), self.at.merit());
        for _ in 0..HALVINGS {
            let next: Vec<f64> = x.iter().zip(&way).map(|(x, way)| x + factor * way).collect();
            let next = goal
                .evaluate(&next, share, evaluation.near)
                .map(|evaluation| At { x: next, evaluation })
                .map(|next| back(goal, share, &linear, &next).unwrap_or(next));
            if let Some(next) = next
                && (next.is_there() || !was_there)
                && next.merit() < merit
            {
                self.at = next;
                return Some(factor * whole);
            }
            factor *= 0.5;
        }
        None
    }
}

/// How softly residuals ask: a fixed number stalls, and ten times this loses half of the hard cases (light model, section 7).
fn softness(linear: &Linear) -> f64 {
    let size = length(&linear.residual);
    (1e-6 * (size * size).min(1.0) + 1e-15) * trace_of(linear)
}

/// The nearest place at which the feature lies where it should, by what was linear about a place nearby; `None` where that
/// leads nowhere.
fn back(goal: &Goal, share: f64, about: &Linear, from: &At) -> Option<At> {
    let mut at = from.clone();
    let nowhere = vec![0.0; at.x.len()];
    for _ in 0..STEPS_BACK {
        if at.is_there() {
            return Some(at);
        }
        let linear = Linear {
            residual: at.evaluation.residual.to_vec(),
            limits: at.evaluation.limits.iter().map(|limit| limit - 1e-12).collect(),
            jacobian: about.jacobian.clone(),
            slopes: about.slopes.clone(),
        };
        let (by, _) = smallest(&nowhere, &linear, 1e-15 * trace_of(&linear));
        let x: Vec<f64> = at.x.iter().zip(&by).map(|(x, by)| x + by).collect();
        let off = length(&at.evaluation.residual);
        at = At { evaluation: goal.evaluate(&x, share, at.evaluation.near)?, x };
        if length(&at.evaluation.residual) > off && off > NOTHING {
            return None;
        }
    }
    at.is_there().then_some(at)
}

fn trace_of(linear: &Linear) -> f64 {
    (0..2).map(|row| dot(linear.jacobian.row(row), linear.jacobian.row(row))).sum()
}
