//! Fixed chain of steps from the start of a drag to the cursor.
//!
//! The least change of the picture is not a continuous function of the cursor: two local minima can lie a pixel apart.
//! So a drag takes a fixed number of sub-steps along the straight way of the feature, each a strictly convex problem,
//! and nothing is accepted or taken back. The result depends on the start and the cursor alone.

use crate::convex_step::{Slopes, StepValues, StepWeights, convex_step};
use crate::matrix::{Matrix, difference, independent_rows, length, scaled_sum};
use crate::problem::{Evaluated, Problem, Tracked};
use crate::request::DragLimit;

/// Largest violation of a bound during the chain, and at its end.
const TOLERANCE_ON_WAY: f64 = 3.0;
const TOLERANCE_AT_END: f64 = 1e-6;

/// Most Newton steps that fulfil the equations exactly, and the error at which they are. An equation of a pin that
/// depends on the others has at most the error of the second constant.
const NEWTON_STEPS: usize = 8;
const EXACT: f64 = 1e-10;
const HELD: f64 = 1e-6;

/// Largest change of the light by those steps.
const MAX_NEWTON_CHANGE: f64 = 0.05;

/// Numbers of a chain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChainRule {
    /// Sub-steps along the way, and further steps at its end.
    pub sub_steps: usize,
    pub end_steps: usize,
    pub weights: StepWeights,
    /// Largest change of the light in a sub-step, in units of the unknowns. A larger one ends the drag.
    pub max_change: f64,
    /// Largest length of the rows. Longer ones count as rows of this length, so that a far target pulls no more than a
    /// near one.
    pub max_rows: f64,
}

/// Light at the end of a chain.
#[derive(Clone, Debug)]
pub(crate) struct ChainEnd {
    /// Values of the unknowns.
    pub x: Vec<f64>,
    pub tracked: Tracked,
    /// Bound with the least room.
    pub limit: DragLimit,
    pub iterations: usize,
}

/// Follows the objective from a share of its way, at which the unknowns are `begin`, to another share. Returns the bound
/// that ends the drag before.
pub(crate) fn follow(
    problem: &Problem,
    begin: Vec<f64>,
    near: &Tracked,
    [from, to]: [f64; 2],
    rule: &ChainRule,
) -> Result<ChainEnd, DragLimit> {
    let lost = DragLimit::NoDescent;
    let mut x = begin;
    let mut tracked = near.clone();
    for step in 1..=rule.sub_steps + rule.end_steps {
        let share = from + (to - from) * (step as f64 / rule.sub_steps as f64).min(1.0);
        let at = problem.evaluate(&x, share, &tracked).ok_or(lost)?;
        let change = step_along(problem, &x, share, &at, rule);
        if length(&change) > rule.max_change {
            return Err(at.violated(0.0).unwrap_or(lost));
        }
        x = scaled_sum(&x, &change, 1.0);
        let after = problem.evaluate(&x, share, &at.tracked).ok_or(lost)?;
        if let Some(limit) = after.violated(TOLERANCE_ON_WAY) {
            return Err(limit);
        }
        tracked = after.tracked;
    }
    let (x, at) = fulfil(problem, &x, to, &tracked)?;
    let limit = at.violated(f64::NEG_INFINITY).unwrap_or(lost);
    Ok(ChainEnd { x, limit, tracked: at.tracked, iterations: rule.sub_steps + rule.end_steps })
}

/// Fulfils the equations and bounds exactly, with the least change of the light. Returns the bound that prevents it.
fn fulfil(problem: &Problem, from: &[f64], share: f64, near: &Tracked) -> Result<(Vec<f64>, Evaluated), DragLimit> {
    let lost = DragLimit::NoDescent;
    let mut x = from.to_vec();
    let mut at = problem.evaluate(&x, share, near).ok_or(lost)?;
    let began = at.clone();
    let mut active = vec![false; at.bounds.len()];
    for _ in 0..NEWTON_STEPS {
        for (is_active, bound) in active.iter_mut().zip(&at.bounds) {
            *is_active |= bound.compliance == 0.0 && bound.value < 0.0;
        }
        let of_bounds = at.bounds.iter().zip(&active).filter(|(_, active)| **active).map(|(bound, _)| &bound.value);
        let error = at.equations.iter().chain(of_bounds).fold(0.0, |most, error| f64::max(most, error.abs()));
        if error < EXACT {
            break;
        }
        let chosen: Vec<usize> = (0..active.len()).filter(|bound| active[*bound]).collect();
        x = scaled_sum(&x, &newton_step(problem, &x, share, &at, &chosen), 1.0);
        at = problem.evaluate(&x, share, &at.tracked).ok_or(lost)?;
    }
    let limit = || began.violated(0.0).or_else(|| at.violated(0.0)).unwrap_or(lost);
    let is_exact = at
        .equations
        .iter()
        .enumerate()
        .all(|(row, error)| error.abs() < if row < at.of_feature { EXACT } else { HELD });
    if !is_exact || length(&difference(&x, from)) > MAX_NEWTON_CHANGE || at.violated(TOLERANCE_AT_END).is_some() {
        return Err(limit());
    }
    Ok((x, at))
}

/// Computes the change of the unknowns `x` by one convex step.
fn step_along(problem: &Problem, x: &[f64], share: f64, at: &Evaluated, rule: &ChainRule) -> Vec<f64> {
    let slopes = problem.slopes(x, share, at);
    let chosen = independent_equations(problem, at, &slopes.equations);
    let equations: Vec<f64> = chosen.iter().map(|row| at.equations[*row]).collect();
    let slopes = Slopes { equations: slopes.equations.selected(&chosen), ..slopes };
    let factor = (rule.max_rows / length(&at.rows)).min(1.0);
    let rows: Vec<f64> = at.rows.iter().map(|row| row * factor).collect();
    let values = StepValues { equations: &equations, rows: &rows, bounds: &at.bounds };
    convex_step(x, &values, &slopes, rule.weights, problem.work())
}

/// Computes the least change of the unknowns that fulfils the equations and makes the `active` bounds 0.
fn newton_step(problem: &Problem, x: &[f64], share: f64, at: &Evaluated, active: &[usize]) -> Vec<f64> {
    let slopes = problem.slopes(x, share, at);
    let of_bounds = active.iter().map(|bound| at.bounds[*bound].value);
    let values: Vec<f64> = at.equations.iter().copied().chain(of_bounds).collect();
    let all = slopes.equations.stacked(&slopes.bounds.selected(active));
    let chosen = independent_equations(problem, at, &all);
    let equations: Vec<f64> = chosen.iter().map(|row| values[*row]).collect();
    let slopes = Slopes { equations: all.selected(&chosen), ..Slopes::none(x.len()) };
    let values = StepValues { equations: &equations, rows: &[], bounds: &[] };
    convex_step(&vec![0.0; x.len()], &values, &slopes, StepWeights::EVEN, problem.work())
}

/// Selects the equations of the feature, and as many of the others as are independent.
fn independent_equations(problem: &Problem, at: &Evaluated, slopes: &Matrix) -> Vec<usize> {
    let others: Vec<usize> = (at.of_feature..slopes.rows).collect();
    (0..at.of_feature).chain(independent_rows(slopes, &others, problem.work())).collect()
}
