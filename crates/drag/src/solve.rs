//! From where a drag began to where the cursor is, in steps that are solved one after the other.

use crate::bound::Bound;
use crate::goal::{Asked, Evaluation, Goal, Near};
use crate::matrix::{dot, length};
use crate::quadratic::{Counting, Hold, Linear, Values, smallest};
use crate::request::Limit;
use crate::sight::Sight;
use crate::start::rigid_start;

/// A residual this small is none, in radii or radians.
const NOTHING: f64 = 1e-10;

/// The longest step at a time, in the units of what moves, where the feature stays where it should be, and where it does not.
const LONGEST_STEP: [f64; 2] = [0.25, 0.03];

/// How far places on the way are apart, in radii or radians, and how many there are.
const BETWEEN_PLACES: f64 = 0.1;
const PLACES: [f64; 2] = [4.0, 48.0];

/// Quarterings of a way to the next place that cannot be gone.
const QUARTERINGS: usize = 4;

/// Newton's steps to a place, and over how far each takes differences. Where two segments of a tube meet slopes jump: what
/// is linear on one side leads nowhere on the other, and what is on the mean over both does.
pub(crate) const DIFFERENCES: [f64; 6] = [1e-6, 1e-6, 1e-6, 1e-3, 1e-2, 5e-2];

/// How far from a joint, in segments, a place may go on along that.
const NEAR_JOINT: f64 = 0.1;

/// Halvings between the last place on a straight way that can be had and the wall.
const TO_THE_WALL: usize = 20;

/// Steps from one place to the nearest at which all holds, with one Jacobian.
const STEPS_BACK: usize = 8;

/// Steps where nothing lands: so many on the way, whatever is left of it, so that the light's end is continuous; and at its end
/// until they are [`STILL`], so many at most.
const GLIDING: usize = 24;
const SETTLING: usize = 40;

/// A step this small is none.
const STILL: f64 = 1e-7;

/// How softly the feature pulls there, as a share of the trace of `J J^T`: what helps little is not done.
const GIVE_WAY: f64 = 1e-2;

/// Halvings of such a step that breaks something.
const HALVINGS: usize = 4;

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
    found.at = allowed(goal, found.at);
    let unheld = sight.unheld(goal, &found.at.x);
    if unheld.is_some() || !found.at.is_allowed() {
        found.held_by = unheld.or(found.held_by);
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

/// Of a control point that is dragged itself: straight to where it first meets a limit, which of each share of the way is one place
/// to look at, and on along that.
pub(crate) fn solve_position(goal: &Goal, near: &Near, way: &[f64]) -> Option<Solution> {
    let mut found = Solution { at: begin(goal, near)?, held_by: None, iterations: 0 };
    let at = |share: f64| {
        let x: Vec<f64> = way.iter().map(|way| way * share).collect();
        let at = At { evaluation: goal.evaluate(&x, share, near)?, x };
        at.is_there().then_some(at)
    };
    let places = (goal.way() / BETWEEN_PLACES).clamp(PLACES[0], PLACES[1]);
    let mut share = 0.0;
    let mut step = 1.0 / places;
    for _ in 0..places as usize + TO_THE_WALL {
        match at(share + step).filter(|_| share + step <= 1.0) {
            Some(next) => (found.at, share) = (next, share + step),
            None => step *= 0.5,
        }
    }
    found.glide(goal, share);
    Some(found)
}

/// The same within the limits that are known.
pub(crate) fn solve_within(goal: &Goal, near: &Near) -> Option<Solution> {
    let mut found = Solution { at: begin(goal, near)?, held_by: None, iterations: 0 };
    let places = (goal.way() / BETWEEN_PLACES).clamp(PLACES[0], PLACES[1]);
    let mut share = 0.0;
    while share < 1.0 {
        let next = (share + 1.0 / places).min(1.0);
        let Some(reached) = found.follow(goal, share, next) else {
            if let Some((x, near)) = rigid_start(goal, near)
                && let Some(evaluation) = goal.evaluate(&x, 1.0, &near)
                && let at = (At { x, evaluation })
                && at.is_there()
            {
                found.at = at;
                found.shrink(goal);
            } else {
                found.glide(goal, share);
            }
            break;
        };
        share = reached;
    }
    Some(found)
}

impl At {
    /// Whether the feature lies where it should, and nothing is broken.
    pub fn is_there(&self) -> bool {
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
        residual.iter().zip(rows.iter()).filter(|(_, row)| which(**row)).map(|(off, _)| off * off).sum()
    }

    /// How far the feature is off.
    fn off(&self) -> f64 {
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
    /// where nothing does even for a small part of it.
    fn follow(&mut self, goal: &Goal, share: f64, end: f64) -> Option<f64> {
        let parts = || std::iter::successors(Some(end - share), |part| Some(part * 0.25)).take(QUARTERINGS);
        let mut reached = parts().find_map(|part| {
            let next = (share + part).min(end);
            let at = self.reach(goal, next, Counting::All).or_else(|| self.reach_along_joint(goal, next))?;
            Some((at, next))
        });
        // What is soft gives way where nothing else does.
        if reached.is_none() && goal.has_soft_pins() {
            reached = parts().find_map(|part| {
                let next = (share + part).min(end);
                Some((self.reach(goal, next, Counting::Firm)?, next))
            });
        }
        let (at, next) = reached?;
        self.at = at;
        Some(next)
    }

    /// The nearest place with the feature where it should be, by Newton's method.
    fn reach(&mut self, goal: &Goal, share: f64, counting: Counting) -> Option<At> {
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
            if length_between(&x, &from) > LONGEST_STEP[0] {
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
    fn wanted(
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

    /// Goes on where nothing more has the feature where it should be: in small steps that are weighed against how far the feature
    /// stays off, so that the light neither jumps nor runs away for little.
    fn glide(&mut self, goal: &Goal, from: f64) {
        for step in 1..=GLIDING {
            let part = step as f64 / GLIDING as f64;
            self.nearer(goal, from + (1.0 - from) * part);
        }
        for _ in 0..SETTLING {
            let before = self.at.x.clone();
            self.nearer(goal, 1.0);
            if length_between(&self.at.x, &before) < STILL {
                break;
            }
        }
        if let (Asked::Feature(_), Some(at)) = (&goal.asked, self.reach(goal, 1.0, Counting::Firm)) {
            self.at = at;
        }
    }

    /// A small step towards where the feature should be.
    fn nearer(&mut self, goal: &Goal, share: f64) {
        self.iterations += 1;
        let Some(evaluation) = goal.evaluate(&self.at.x, share, &self.at.evaluation.near) else { return };
        self.at.evaluation = evaluation;
        let at = self.at.clone();
        let linear = goal.linear(&at.x, share, &at.evaluation, DIFFERENCES[0]);
        let pull = GIVE_WAY * trace_of(&linear);
        let x = self.wanted(goal, &at.x, &at, &linear, (pull, Counting::All));
        let way: Vec<f64> = x.iter().zip(&at.x).map(|(wanted, x)| wanted - x).collect();
        let mut factor = (LONGEST_STEP[1] / length(&way)).min(1.0);
        for _ in 0..HALVINGS {
            let x: Vec<f64> = at.x.iter().zip(&way).map(|(x, way)| x + factor * way).collect();
            let next = goal.evaluate(&x, share, &at.evaluation.near).map(|evaluation| At { x, evaluation });
            if let Some(next) = next {
                let next = back(goal, share, &linear, &next, Counting::Fixed).unwrap_or(next);
                if next.is_allowed() {
                    self.at = next;
                    return;
                }
            }
            factor *= 0.5;
        }
    }
}

fn length_between(a: &[f64], b: &[f64]) -> f64 {
    length(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
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
pub(crate) fn trace_of(linear: &Linear) -> f64 {
    let asked = (0..linear.rows.len()).filter(|row| linear.rows[*row] == Hold::Asked);
    asked.map(|row| dot(linear.jacobian.row(row), linear.jacobian.row(row))).sum()
}
