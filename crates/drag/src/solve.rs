//! From where a drag began to where the cursor is, in steps that are solved one after the other.

use crate::goal::{Bound, Evaluation, Goal, Near};
use crate::quadratic::{Counting, Hold, Linear, Values, dot, length, smallest};
use crate::request::Limit;
use crate::sight::Sight;
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

/// Edges that may turn up, and for soft pins.
const MOST_CUTS: [usize; 2] = [24, 4];

/// Places on a straight way that are looked at where what was found cannot be had, and halvings between the last two.
const ON_A_STRAIGHT_WAY: usize = 32;

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
    /// What holds it back most.
    pub held_by: Option<Limit>,
    pub iterations: usize,
}

/// The smallest change that brings the feature under the cursor, or as near as the limits let it. `None` where even the
/// beginning cannot be evaluated.
///
/// What light meets has no slope. So the drag is solved without it, and where the light that was found breaks what has to hold
/// the edge that it crossed is a further limit.
pub(crate) fn solve(goal: &mut Goal, near: &Near, sight: &Sight) -> Option<Solution> {
    let mut found = solve_within(goal, near)?;
    while goal.cuts.len() < MOST_CUTS[0] {
        let are_soft = goal.cuts.len() < MOST_CUTS[1];
        let Some(cut) = sight.broken(goal, &found.at.x, are_soft) else { break };
        goal.cuts.push(cut);
        let iterations = found.iterations;
        found = solve_within(goal, near)?;
        found.iterations += iterations;
    }
    found.at = allowed(goal, found.at);
    if !found.at.is_allowed() || !sight.all_hold(goal, &found.at.x) {
        found.at = on_the_way(goal, near, sight, &found.at.x)?;
    }
    Some(found)
}

/// The light that the drag began with.
fn begin(goal: &Goal, near: &Near) -> Option<At> {
    let unmoved = vec![0.0; goal.moves.count()];
    Some(At { evaluation: goal.evaluate(&unmoved, 0.0, near)?, x: unmoved })
}

/// As far on the straight way to `x` as what has to hold does.
fn on_the_way(goal: &Goal, near: &Near, sight: &Sight, x: &[f64]) -> Option<At> {
    let begun = begin(goal, near)?;
    let beginning =
        At { evaluation: goal.evaluate(&begun.x, 1.0, near).unwrap_or(begun.evaluation), x: begun.x };
    let at = |share: f64, near: &Near| {
        let x: Vec<f64> = x.iter().map(|x| x * share).collect();
        let at = At { evaluation: goal.evaluate(&x, 1.0, near)?, x };
        let at = allowed(goal, at);
        (at.is_allowed() && sight.all_hold(goal, &at.x)).then_some(at)
    };
    let (mut last, mut share) = (beginning, 0.0);
    let mut step = 1.0 / ON_A_STRAIGHT_WAY as f64;
    for _ in 0..2 * ON_A_STRAIGHT_WAY {
        match at(share + step, &last.evaluation.near) {
            Some(next) if share + step <= 1.0 => (last, share) = (next, share + step),
            _ => step *= 0.5,
        }
    }
    Some(last)
}

/// What has to hold brought back to holding, where that can be from there.
fn allowed(goal: &Goal, at: At) -> At {
    if at.is_allowed() {
        return at;
    }
    let about = goal.linear(&at.x, 1.0, &at.evaluation);
    back(goal, 1.0, &about, &at, Counting::Fixed).unwrap_or(at)
}

/// The same within the limits that are known.
pub(crate) fn solve_within(goal: &Goal, near: &Near) -> Option<Solution> {
    let mut found = Solution { at: begin(goal, near)?, held_by: None, iterations: 0 };
    // A light that moves as a whole is put where it has to be, and from there as near to where it was as may be.
    let whole = rigid_start(goal, near)
        .and_then(|(x, near)| Some(At { evaluation: goal.evaluate(&x, 1.0, &near)?, x }))
        .filter(At::is_there);
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
    /// Whether the feature lies where it should, and nothing is broken.
    fn is_there(&self) -> bool {
        self.off() < NOTHING
            && self.pins_off() < NOTHING
            && self.hard_bounds().all(|bound| bound.value >= 0.0)
    }

    /// Whether the light can be had: hard pins hold, and so do limits but for the feature's own.
    fn is_allowed(&self) -> bool {
        let holds = |bound: &Bound| bound.value >= 0.0 || bound.limit == Limit::TubeEdge;
        self.pins_off() < NOTHING && self.hard_bounds().all(holds)
    }

    fn hard_bounds(&self) -> impl Iterator<Item = &Bound> {
        self.evaluation.bounds.iter().filter(|bound| bound.give == 0.0)
    }

    fn sum_of_squares(&self, which: impl Fn(Hold) -> bool) -> f64 {
        let Evaluation { residual, rows, .. } = &self.evaluation;
        residual.iter().zip(rows).filter(|(_, row)| which(**row)).map(|(off, _)| off * off).sum()
    }

    /// How far the feature is off.
    fn off(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Asked).sqrt()
    }

    /// How far hard pins are off.
    fn pins_off(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Fixed).sqrt()
    }

    /// What is to become less: what is off, above all, and the size of the change with what soft pins weigh beside it.
    fn merit(&self) -> f64 {
        let Evaluation { residual, rows, bounds, .. } = &self.evaluation;
        let broken: f64 = self.hard_bounds().map(|bound| (-bound.value).max(0.0)).sum();
        let of_row = |(off, row): (&f64, &Hold)| match row {
            Hold::Soft(give) => off * off / give,
            Hold::Asked | Hold::Fixed => 0.0,
        };
        let of_bound = |bound: &Bound| {
            let broken = bound.value.min(0.0);
            if bound.give > 0.0 { broken * broken / bound.give } else { 0.0 }
        };
        let soft =
            residual.iter().zip(rows).map(of_row).sum::<f64>() + bounds.iter().map(of_bound).sum::<f64>();
        0.5 * (dot(&self.x, &self.x) + soft) + PENALTY * (self.off() + 10.0 * (broken + self.pins_off()))
    }
}

impl Solution {
    /// Goes on to a share of the way.
    fn go(&mut self, goal: &Goal, share: f64, steps: usize) {
        let Some(evaluation) = goal.evaluate(&self.at.x, share, &self.at.evaluation.near) else { return };
        self.at.evaluation = evaluation;
        for _ in 0..steps {
            if share < 1.0 && self.at.off() + self.at.pins_off() < ON_THE_WAY {
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
        let limits: Vec<f64> = evaluation.bounds.iter().map(|bound| bound.value).collect();
        let values = Values { residual: &evaluation.residual, limits: &limits, counting: Counting::All };
        let (wanted, pulls) = smallest(x, &linear, values, softness(&linear, self.at.off()));
        self.held_by = goal.held_by(evaluation, &pulls);
        let way: Vec<f64> = wanted.iter().zip(x).map(|(wanted, x)| wanted - x).collect();
        let whole = length(&way);
        let mut factor = (LONGEST_STEP / whole).min(1.0);
        let (was_there, merit) = (self.at.is_there(), self.at.merit());
        for _ in 0..HALVINGS {
            let next: Vec<f64> = x.iter().zip(&way).map(|(x, way)| x + factor * way).collect();
            let next = goal
                .evaluate(&next, share, &evaluation.near)
                .map(|evaluation| At { x: next, evaluation })
                .map(|next| back(goal, share, &linear, &next, Counting::Firm).unwrap_or(next));
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

/// How softly residuals ask where they are `off`: a fixed number stalls, and ten times this loses half of the hard cases (light
/// model, section 7).
fn softness(linear: &Linear, off: f64) -> f64 {
    (1e-6 * (off * off).min(1.0) + 1e-15) * trace_of(linear)
}

/// The nearest place at which all that counts is as it should be, by what was linear about a place nearby; `None` where that
/// leads nowhere.
fn back(goal: &Goal, share: f64, about: &Linear, from: &At, counting: Counting) -> Option<At> {
    let mut at = from.clone();
    let nowhere = vec![0.0; at.x.len()];
    let mu = 1e-15 * trace_of(about);
    let is_good = |at: &At| if counting == Counting::Fixed { at.is_allowed() } else { at.is_there() };
    let off_of = |at: &At| if counting == Counting::Fixed { at.pins_off() } else { at.off() + at.pins_off() };
    for _ in 0..STEPS_BACK {
        if is_good(&at) {
            return Some(at);
        }
        let limits: Vec<f64> = at.evaluation.bounds.iter().map(|bound| bound.value - 1e-12).collect();
        let residual = &at.evaluation.residual;
        let (by, _) = smallest(&nowhere, about, Values { residual, limits: &limits, counting }, mu);
        let x: Vec<f64> = at.x.iter().zip(&by).map(|(x, by)| x + by).collect();
        let off = off_of(&at);
        at = At { evaluation: goal.evaluate(&x, share, &at.evaluation.near)?, x };
        if off_of(&at) > off && off > NOTHING {
            return None;
        }
    }
    is_good(&at).then_some(at)
}

/// The trace of `J J^T` of what is asked.
fn trace_of(linear: &Linear) -> f64 {
    let asked = (0..linear.rows.len()).filter(|row| linear.rows[*row] == Hold::Asked);
    asked.map(|row| dot(linear.jacobian.row(row), linear.jacobian.row(row))).sum()
}
