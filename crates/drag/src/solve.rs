//! From where a drag began to where the cursor is.

use crate::goal::{DIFFERENCE, Goal, Near};
use crate::quadratic::Counting;
use crate::sight::Sight;
use crate::step::{At, Solution, back};

/// Edges that may turn up, and for soft pins.
const MOST_CUTS: [usize; 2] = [12, 4];

/// Places on a straight way that are looked at where what was found cannot be had, and halvings between the last two.
const ON_A_STRAIGHT_WAY: usize = 32;

/// The smallest change that brings the feature under the cursor, or as near as the limits let it. `None` where even the
/// beginning cannot be evaluated.
///
/// What light meets has no slope. So the drag is solved without it, and where the light that was found breaks what has to hold
/// the edge that it crossed is a further limit. Where its work is over it is what was found until then, which may break anything.
pub(crate) fn solve(goal: &mut Goal, near: &Near, sight: &Sight) -> Option<Solution> {
    let mut found = solve_within(goal, near)?;
    while goal.cuts.len() < MOST_CUTS[0] {
        let are_soft = goal.cuts.len() < MOST_CUTS[1];
        let cuts = sight.broken(goal, &found.at.x, are_soft);
        if cuts.is_empty() {
            break;
        }
        goal.cuts.extend(cuts);
        let Some(next) = solve_within(goal, near) else {
            return goal.work().is_over().then_some(found);
        };
        found = Solution { iterations: found.iterations + next.iterations, ..next };
    }
    found.at = allowed(&goal.gliding(1.0), found.at);
    let unheld = sight.unheld(goal, &found.at.x);
    if goal.work().is_over() {
        return Some(found);
    }
    if unheld.is_some() || !found.at.is_allowed() {
        found.held_by = unheld.or(found.held_by);
        found.at = on_the_way(goal, near, sight, &found.at.x)?;
    }
    Some(found)
}

/// As far on the straight way to `x` as what has to hold does.
fn on_the_way(goal: &Goal, near: &Near, sight: &Sight, x: &[f64]) -> Option<At> {
    let goal = &goal.gliding(1.0);
    let begun = Solution::begin(goal, near)?.at;
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
    let about = goal.linear(&at.x, 1.0, &at.evaluation, DIFFERENCE);
    back(goal, 1.0, &about, &at, Counting::Fixed).unwrap_or(at)
}

/// The same within the limits that are known.
///
/// First evenly, so that where the light ends up is continuous. Where that does not land, a jump may; one that does not either is
/// for nothing, and the light glides from where it could not go on evenly.
pub(crate) fn solve_within(goal: &Goal, near: &Near) -> Option<Solution> {
    let mut found = Solution::begin(goal, near)?;
    let share = found.flow(goal);
    if share == 1.0 && found.settle(goal) {
        return Some(found);
    }
    let wall = found.clone();
    if !found.jump(goal, near, share) {
        found = Solution { iterations: found.iterations, ..wall };
        found.glide(goal, share);
    }
    Some(found)
}
