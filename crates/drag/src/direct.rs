//! Straight to where the feature should be, from several lights: for drags whose way there is closed.

use crate::goal::{DIFFERENCE, Goal, Near};
use crate::matrix::length;
use crate::moves::Moves;
use crate::pins::Pinned;
use crate::quadratic::{Counting, Values, smallest};
use crate::request::Radii;
use crate::sight::Sight;
use crate::solve::solve;
use crate::start::rigid_start;
use crate::step::{At, Solution, trace_of};

/// Lights that are started from beside the one that the drag began with, and how far they are from it, in the units of what moves.
const AWAY: [f64; 6] = [0.03, 0.1, 0.2, 0.4, 0.1, 0.3];

/// Steps from each, the longest, and by which share what is off has to become less in how many.
const STEPS: usize = 32;
const LONGEST: f64 = 0.2;
const LESS: f64 = 0.5;
const WITHIN: usize = 6;

/// Halvings of a step that makes nothing better.
const HALVINGS: usize = 5;

/// Rounds in which edges turn up that what is pinned crosses.
const ROUNDS: usize = 4;

/// Lights with the feature where it should be and all that has to hold, as they are found, and the steps that it took.
///
/// First by the way that is found when soft pins do not count; then from the light that the drag began with, from those that
/// are `known` with the feature there or near to it, and from some beside.
pub(crate) fn others<'a>(
    goal: &'a Goal,
    near: &'a Near,
    sight: &'a Sight,
    known: [&'a [f64]; 2],
) -> impl Iterator<Item = Solution> + 'a {
    // Where nothing can be said of soft pins in that light they do not count.
    let firmly = move || {
        let has_soft = goal.pins.iter().any(|pin| !pin.is_hard);
        let found = if has_soft { solve_with(goal, near, sight, |pin| pin.is_hard) } else { None };
        let softly = found.as_ref().and_then(|found| from(goal, near, sight, found.at.x.clone()));
        softly.into_iter().chain(found)
    };
    let unmoved = vec![0.0; goal.moves.count()];
    let placed = rigid_start(goal, near).map(|(x, _)| x);
    let known = known.into_iter().map(<[f64]>::to_vec);
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let away = AWAY.iter().map(move |size| {
        (0..goal.moves.count()).map(|k| size * random.next() * goal.moves.share(k)).collect::<Vec<f64>>()
    });
    let starts = std::iter::once(unmoved).chain(placed).chain(known).chain(away);
    std::iter::once_with(firmly).flatten().chain(starts.filter_map(move |x| from(goal, near, sight, x)))
}

/// What is found with some of the pins alone.
pub(crate) fn solve_with(
    goal: &Goal,
    near: &Near,
    sight: &Sight,
    is_kept: fn(&Pinned) -> bool,
) -> Option<Solution> {
    let (mut goal, near) = goal.with_pins(near, is_kept);
    solve(&mut goal, &near, sight)
}

/// The light that is found from one.
fn from(goal: &Goal, near: &Near, sight: &Sight, x: Vec<f64>) -> Option<Solution> {
    let mut goal = goal.clone();
    goal.cuts.clear();
    let near = goal.near_at_end(&x, near);
    let evaluation = goal.evaluate(&x, 1.0, &near)?;
    let mut found = Solution { at: At { x, evaluation }, held_by: None, iterations: 0 };
    for _ in 0..ROUNDS {
        found.descend(&goal)?;
        found.shrink(&goal);
        let cuts = sight.broken(&goal, &found.at.x, false);
        if cuts.is_empty() {
            return sight.unheld(&goal, &found.at.x).is_none().then_some(found);
        }
        goal.cuts.extend(cuts);
        found.at.evaluation = goal.evaluate(&found.at.x, 1.0, &found.at.evaluation.near)?;
    }
    None
}

impl Solution {
    /// Newton's method with steps that make what is off less; `None` where that leads nowhere.
    fn descend(&mut self, goal: &Goal) -> Option<()> {
        let nowhere = vec![0.0; self.at.x.len()];
        let mut before = Vec::new();
        for _ in 0..STEPS {
            if self.at.is_there() {
                return Some(());
            }
            let off = self.at.all_off();
            if before.len() >= WITHIN && off > LESS * before[before.len() - WITHIN] {
                return None;
            }
            before.push(off);
            self.iterations += 1;
            let linear = goal.linear(&self.at.x, 1.0, &self.at.evaluation, DIFFERENCE);
            let limits: Vec<f64> =
                self.at.evaluation.bounds.iter().map(|bound| bound.value - 1e-12).collect();
            let residual = &self.at.evaluation.residual;
            let values = Values { residual, limits: &limits, counting: Counting::Firm };
            let (step, _) = smallest(&nowhere, &linear, values, 1e-15 * trace_of(&linear));
            let mut factor = (LONGEST / length(&step)).min(1.0);
            let better = (0..HALVINGS).find_map(|_| {
                let x: Vec<f64> = self.at.x.iter().zip(&step).map(|(x, step)| x + factor * step).collect();
                factor *= 0.5;
                let evaluation = goal.evaluate(&x, 1.0, &self.at.evaluation.near)?;
                let at = At { x, evaluation };
                (at.all_off() < off || at.is_there()).then_some(at)
            });
            self.at = better?;
        }
        self.at.is_there().then_some(())
    }
}

impl Moves {
    /// How far an unknown goes where a light is changed at random: turns farther than ways, radii less.
    fn share(&self, unknown: usize) -> f64 {
        match self {
            Self::Rigid { .. } if unknown >= 3 => 2.0,
            Self::Points { points, radii: Radii::Solve, .. } if unknown >= 3 * points.len() => 0.1,
            _ => 1.0,
        }
    }
}

/// A linear congruential generator (Knuth's MMIX), the same numbers for each drag.
struct Random(u64);

impl Random {
    /// Between -1 and 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
