//! From where a drag began to where the cursor is, in steps that are solved one after the other.

use crate::bound::Bound;
use crate::goal::{Evaluation, Goal, Near};
use crate::matrix::{dot, length};
use crate::quadratic::{Counting, Hold, Linear, Values, smallest};
use crate::request::Limit;
use crate::sight::Sight;
use crate::start::rigid_start;

/// A residual this small is none, in radii or radians.
const NOTHING: f64 = 1e-10;

/// The longest step at a time, in the units of what moves.
const LONGEST_STEP: f64 = 0.25;

/// How far places on a way are apart, in radii or radians, and how many there are at least and at most: where the light goes evenly,
/// and where it may jump. What it goes by joints and along limits is as rough as the places are far apart.
const EVENLY: Places = Places { apart: 0.025, least: 16.0, most: 96.0 };
pub(crate) const IN_JUMPS: Places = Places { apart: 0.1, least: 4.0, most: 48.0 };

/// How much faster than so far a light that goes evenly may go, and how far in any case, as a share of what it has gone from place to
/// place.
const FASTER: f64 = 4.0;
const SMALL_JUMP: f64 = 0.5;

/// Parts of a way to the next place that are tried, each a quarter of the one before: where the light goes evenly, and where it may
/// jump.
const PARTS: [usize; 2] = [2, 4];

/// Newton's steps to a place, and over how far each takes differences. Where two segments of a tube meet slopes jump: what
/// is linear on one side leads nowhere on the other, and what is on the mean over both does.
pub(crate) const DIFFERENCES: [f64; 6] = [1e-6, 1e-6, 1e-6, 1e-3, 1e-2, 5e-2];

/// How far from a joint, in segments, a place may go on along that.
const NEAR_JOINT: f64 = 0.1;

/// Steps from one place to the nearest at which all holds, with one Jacobian.
const STEPS_BACK: usize = 8;

/// Steps in which a change becomes smaller, and by which share each.
const SHRINKING: usize = 24;
const SHRINK: f64 = 0.3;

/// Edges that may turn up, and for soft pins.
const MOST_CUTS: [usize; 2] = [12, 4];

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
        let cuts = sight.broken(goal, &found.at.x, are_soft);
        if cuts.is_empty() {
            break;
        }
        goal.cuts.extend(cuts);
        let iterations = found.iterations;
        found = solve_within(goal, near)?;
        found.iterations += iterations;
    }
    found.at = allowed(&goal.gliding(1.0), found.at);
    let unheld = sight.unheld(goal, &found.at.x);
    if unheld.is_some() || !found.at.is_allowed() {
        found.held_by = unheld.or(found.held_by);
        found.at = on_the_way(goal, near, sight, &found.at.x)?;
    }
    Some(found)
}

/// The light that the drag began with.
pub(crate) fn begin(goal: &Goal, near: &Near) -> Option<At> {
    let unmoved = vec![0.0; goal.moves.count()];
    Some(At { evaluation: goal.evaluate(&unmoved, 0.0, near)?, x: unmoved })
}

/// As far on the straight way to `x` as what has to hold does.
fn on_the_way(goal: &Goal, near: &Near, sight: &Sight, x: &[f64]) -> Option<At> {
    let goal = &goal.gliding(1.0);
    let begun = begin(goal, near)?;
    let beginning =
        At { evaluation: goal.evaluate(&begun.x, 1.0, near).unwrap_or(begun.evaluation), x: begun.x };
    let at = |share: f64, near: &Near| {
        let x: Vec<f64> = x.iter().map(|x| x * share).collect();
        let at = At { evaluation: goal.evaluate(&x, 1.0, near)?, x };
        let at = allowed(goal, at);
        (at.is_allowed() && sight.unheld(goal, &at.x).is_none()).then_some(at)
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
    let about = goal.linear(&at.x, 1.0, &at.evaluation, DIFFERENCES[0]);
    back(goal, 1.0, &about, &at, Counting::Fixed).unwrap_or(at)
}

/// The same within the limits that are known.
///
/// First evenly, so that where the light ends up is continuous. Where that way ends, a jump may lead on; one that does not land is
/// for nothing, and the light glides from where it could not go on evenly.
pub(crate) fn solve_within(goal: &Goal, near: &Near) -> Option<Solution> {
    let mut found = Solution { at: begin(goal, near)?, held_by: None, iterations: 0 };
    let (mut share, mut gone) = (0.0, 0.0);
    let places = EVENLY.count(goal);
    while share < 1.0 {
        let pace = (share > 0.0).then(|| gone / (share * places));
        let before = found.at.x.clone();
        let Some(reached) = found.follow(goal, share, (share + 1.0 / places).min(1.0), pace) else { break };
        (share, gone) = (reached, gone + length_between(&found.at.x, &before));
    }
    if share < 1.0 {
        let wall = found.clone();
        if !found.jump(goal, near, share) {
            found = Solution { iterations: found.iterations, ..wall };
            found.glide(goal, share);
        }
    }
    Some(found)
}

/// Places on a way that are gone to one after the other.
pub(crate) struct Places {
    apart: f64,
    least: f64,
    most: f64,
}

impl Places {
    /// How many there are.
    pub fn count(&self, goal: &Goal) -> f64 {
        (goal.way() / self.apart).clamp(self.least, self.most)
    }
}

impl At {
    /// Whether the feature lies where it should, and nothing is broken.
    pub fn is_there(&self) -> bool {
        self.off() < NOTHING
            && self.pins_off() < NOTHING
            && self.hard_bounds().all(|bound| bound.value >= 0.0)
    }

    /// Whether the light can be had: hard pins and limits hold, where it glides but for those of the place under the cursor.
    pub fn is_allowed(&self) -> bool {
        self.pins_off() < NOTHING && self.hard_bounds().all(|bound| bound.value >= 0.0)
    }

    fn hard_bounds(&self) -> impl Iterator<Item = &Bound> {
        self.evaluation.bounds.iter().filter(|bound| bound.give == 0.0)
    }

    fn sum_of_squares(&self, which: impl Fn(Hold) -> bool) -> f64 {
        let Evaluation { residual, rows, .. } = &self.evaluation;
        residual.iter().zip(rows.iter()).filter(|(_, row)| which(**row)).map(|(off, _)| off * off).sum()
    }

    /// How far the feature is off.
    pub fn off(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Asked).sqrt()
    }

    /// How far the feature and hard pins are off and by how much limits are broken, squared.
    pub fn all_off(&self) -> f64 {
        let broken = self.hard_bounds().map(|bound| bound.value.min(0.0));
        self.sum_of_squares(|row| !matches!(row, Hold::Soft(_))) + broken.map(|off| off * off).sum::<f64>()
    }

    /// How far hard pins are off.
    fn pins_off(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Fixed).sqrt()
    }
}

impl Solution {
    /// Goes on from one share of the way to another, or to one between, by the smallest change that has the feature there; `None`
    /// where nothing does even for a small part of it. With a `pace`, how far the light has gone from place to place so far, it goes
    /// on evenly, and does not jump.
    fn follow(&mut self, goal: &Goal, share: f64, end: f64, pace: Option<f64>) -> Option<f64> {
        let parts = || {
            std::iter::successors(Some(1.0), |part| Some(part * 0.25))
                .take(PARTS[usize::from(pace.is_none())])
        };
        let next_of = |part: f64| if part < 1.0 { share + (end - share) * part } else { end };
        let here = self.at.x.clone();
        let is_even = |at: &At, part: f64| {
            pace.is_none_or(|pace| length_between(&at.x, &here) <= pace * (FASTER * part).max(SMALL_JUMP))
        };
        let mut reached = parts().find_map(|part| {
            let next = next_of(part);
            let at = self.reach(goal, next, Counting::All).or_else(|| self.reach_along_joint(goal, next))?;
            is_even(&at, part).then_some((at, next))
        });
        // What is soft gives way where nothing else does.
        if reached.is_none() && goal.has_soft_pins() {
            reached = parts().find_map(|part| {
                let at = self.reach(goal, next_of(part), Counting::Firm)?;
                is_even(&at, part).then_some((at, next_of(part)))
            });
        }
        let (at, next) = reached?;
        self.at = at;
        Some(next)
    }

    /// Goes on from a share of the way however it may, also from another light that has the feature under the cursor. Whether it
    /// lands.
    fn jump(&mut self, goal: &Goal, near: &Near, from: f64) -> bool {
        let places = IN_JUMPS.count(goal);
        let mut share = from;
        while share < 1.0 {
            match self.follow(goal, share, (share + 1.0 / places).min(1.0), None) {
                Some(reached) => share = reached,
                None => return self.put(goal, near),
            }
        }
        true
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
            if length_between(&x, &from) > LONGEST_STEP {
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
    fn reach_along_joint(&mut self, goal: &Goal, share: f64) -> Option<At> {
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

    /// What is linear about a place nearby wants of `at`, with the smallest change since `from`.
    pub fn wanted(
        &mut self,
        goal: &Goal,
        from: &[f64],
        at: &At,
        linear: &Linear,
        (mu, counting): (f64, Counting),
    ) -> Vec<f64> {
        let moved: Vec<f64> = at.x.iter().zip(from).map(|(x, from)| x - from).collect();
        let limits: Vec<f64> = at.evaluation.bounds.iter().map(|bound| bound.value - 1e-12).collect();
        let values = Values { residual: &at.evaluation.residual, limits: &limits, counting };
        let (wanted, pulls) = smallest(&moved, linear, values, mu);
        self.held_by = goal.held_by(&at.evaluation, &pulls);
        wanted.iter().zip(from).map(|(wanted, from)| from + wanted).collect()
    }
}

pub(crate) fn length_between(a: &[f64], b: &[f64]) -> f64 {
    length(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
}

/// The nearest place at which all that counts is as it should be, by what was linear about a place nearby; `None` where that
/// leads nowhere.
pub(crate) fn back(goal: &Goal, share: f64, about: &Linear, from: &At, counting: Counting) -> Option<At> {
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
pub(crate) fn trace_of(linear: &Linear) -> f64 {
    let asked = (0..linear.rows.len()).filter(|row| linear.rows[*row] == Hold::Asked);
    asked.map(|row| dot(linear.jacobian.row(row), linear.jacobian.row(row))).sum()
}
