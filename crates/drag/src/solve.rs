//! Solver of a drag, from its start to the cursor.

use crate::goal::{DIFFERENCE, Goal, TrackedPoints};
use crate::quadratic::RowSelection;
use crate::scene_visibility::SceneVisibility;
use crate::step::{Iterate, Solution, restore_feasibility};

/// Most tangents that are added in a drag. The second number is the most tangents at which soft pins may still add
/// some.
const MAX_TANGENTS: [usize; 2] = [12, 4];

/// Number of points on a straight line that are checked if the found light is not feasible, and number of times that
/// the interval after the last feasible point is halved.
const LINE_SEARCH_STEPS: usize = 32;

/// Finds the smallest change of the light that brings the feature under the cursor, or as near as the limits allow.
/// `None` if not even the start can be evaluated.
///
/// Visibility has no slope. So the drag is solved without it, and if the resulting light breaks a visibility
/// constraint, the edge that it crossed becomes a further limit. If the budget is spent, the result is the latest
/// light, which may break any constraint.
pub(crate) fn solve(goal: &mut Goal, near: &TrackedPoints, visibility: &SceneVisibility) -> Option<Solution> {
    let mut found = solve_with_tangents(goal, near)?;
    while goal.tangents.len() < MAX_TANGENTS[0] {
        let are_soft = goal.tangents.len() < MAX_TANGENTS[1];
        let tangents = visibility.violated_tangents(goal, &found.iterate.x, are_soft);
        if tangents.is_empty() {
            break;
        }
        goal.tangents.extend(tangents);
        let Some(next) = solve_with_tangents(goal, near) else {
            return goal.work().is_exhausted().then_some(found);
        };
        found = Solution { iterations: found.iterations + next.iterations, ..next };
    }
    found.iterate = made_feasible(&goal.with_edge_compliance(1.0), found.iterate);
    let violated = visibility.violated_limit(goal, &found.iterate.x);
    if goal.work().is_exhausted() {
        return Some(found);
    }
    if violated.is_some() || !found.iterate.is_feasible() {
        found.strongest_limit = violated.or(found.strongest_limit);
        found.iterate = feasible_on_line(goal, near, visibility, &found.iterate.x)?;
    }
    Some(found)
}

/// Changes the unknowns from the start of the drag along the straight line towards `x`, as long as all limits and hard
/// pins are kept. Returns the last feasible state.
fn feasible_on_line(goal: &Goal, near: &TrackedPoints, visibility: &SceneVisibility, x: &[f64]) -> Option<Iterate> {
    let goal = &goal.with_edge_compliance(1.0);
    let start = Solution::begin(goal, near)?.iterate;
    let at = |share: f64, near: &TrackedPoints| {
        let at = made_feasible(goal, Iterate::new(goal, x.iter().map(|x| x * share).collect(), 1.0, near)?);
        (at.is_feasible() && visibility.violated_limit(goal, &at.x).is_none()).then_some(at)
    };
    let (mut last, mut share) = (Iterate::new(goal, start.x.clone(), 1.0, near).unwrap_or(start), 0.0);
    let mut step = 1.0 / LINE_SEARCH_STEPS as f64;
    for _ in 0..2 * LINE_SEARCH_STEPS {
        match at(share + step, &last.evaluation.tracked) {
            Some(next) if share + step <= 1.0 => (last, share) = (next, share + step),
            _ => step *= 0.5,
        }
    }
    Some(last)
}

/// Restores the limits and hard pins of `at`. Returns `at` unchanged if that fails.
fn made_feasible(goal: &Goal, at: Iterate) -> Iterate {
    if at.is_feasible() {
        return at;
    }
    let about = goal.linearize(&at.x, 1.0, &at.evaluation, DIFFERENCE);
    restore_feasibility(goal, 1.0, &about, &at, RowSelection::Fixed).unwrap_or(at)
}

/// Solves the drag under the tangents found so far.
///
/// First it follows the path in even steps, so that the light is a continuous function of the cursor. If that does not
/// converge, it tries to jump. If the jump does not converge either, the light slides on from the end of the part that
/// was followed in even steps.
pub(crate) fn solve_with_tangents(goal: &Goal, near: &TrackedPoints) -> Option<Solution> {
    let mut found = Solution::begin(goal, near)?;
    let share = found.follow_path(goal);
    if share == 1.0 && found.converge(goal) {
        return Some(found);
    }
    let followed = found.clone();
    if !found.jump(goal, near, share) {
        found = Solution { iterations: found.iterations, ..followed };
        found.slide(goal, share);
    }
    Some(found)
}
