//! Fixed chain of steps from the start of a drag to the cursor.
//!
//! The least change of the picture is not a continuous function of the cursor: two local minima can lie a pixel apart.
//! So a drag takes a fixed number of sub-steps along the straight way of the feature, each a strictly convex problem,
//! and nothing is accepted or taken back. The result depends on the start and the cursor alone.

use crate::matrix::{difference, length, scaled_sum};
use crate::penalized::{StepValues, convex_step};
use crate::problem::{Problem, Tracked};
use crate::request::DragLimit;

/// Sub-steps along the feature's way, and further steps at its end.
const SUB_STEPS: usize = 16;
const END_STEPS: usize = 4;

/// Largest violation of a bound during the chain, and at its end.
const TOLERANCE_ON_WAY: f64 = 3.0;
const TOLERANCE_AT_END: f64 = 0.02;

/// Largest change of the light in a sub-step, in units of the unknowns, per pixel that the feature moves.
const MAX_CHANGE_PER_PX: f64 = 0.15;

/// Most Newton steps that bring the feature exactly under the cursor, and the error at which it is.
const NEWTON_STEPS: usize = 8;
const EXACT: f64 = 1e-10;

/// Largest change of the light by those steps.
const MAX_NEWTON_CHANGE: f64 = 0.05;

/// Light at the end of a chain.
#[derive(Clone, Debug)]
pub(crate) struct ChainEnd {
    /// Values of the unknowns.
    pub x: Vec<f64>,
    pub tracked: Tracked,
    pub iterations: usize,
}

/// Follows the feature to the cursor, which is `distance_px` away. Returns the bound that ends the drag on its way.
pub(crate) fn follow(problem: &Problem, near: &Tracked, distance_px: f64) -> Result<ChainEnd, DragLimit> {
    let lost = DragLimit::NoDescent;
    let longest = MAX_CHANGE_PER_PX * (distance_px / SUB_STEPS as f64).max(1.0);
    let mut x = vec![0.0; problem.unknowns.count()];
    let mut tracked = near.clone();
    for step in 1..=SUB_STEPS + END_STEPS {
        let share = (step as f64 / SUB_STEPS as f64).min(1.0);
        let at = problem.evaluate(&x, share, &tracked).ok_or(lost)?;
        let slopes = problem.slopes(&x, share, &at);
        let change = convex_step(&x, &at.values(), &slopes, problem.work());
        if length(&change) > longest {
            return Err(at.violated(0.0).unwrap_or(lost));
        }
        x = scaled_sum(&x, &change, 1.0);
        let after = problem.evaluate(&x, share, &at.tracked).ok_or(lost)?;
        if let Some(limit) = after.violated(TOLERANCE_ON_WAY) {
            return Err(limit);
        }
        tracked = after.tracked;
    }
    let before = x.clone();
    let mut at = problem.evaluate(&x, 1.0, &tracked).ok_or(lost)?;
    for _ in 0..NEWTON_STEPS {
        if at.error() < EXACT {
            break;
        }
        let slopes = problem.slopes(&x, 1.0, &at);
        // Only the equations count, and the change by this step.
        let (unchanged, still) = (vec![0.0; x.len()], vec![0.0; at.rows.len()]);
        let values = StepValues { equations: &at.equations, rows: &still, bounds: &[] };
        x = scaled_sum(&x, &convex_step(&unchanged, &values, &slopes, problem.work()), 1.0);
        at = problem.evaluate(&x, 1.0, &at.tracked).ok_or(lost)?;
    }
    if at.error() >= EXACT || length(&difference(&x, &before)) > MAX_NEWTON_CHANGE {
        return Err(at.violated(0.0).unwrap_or(lost));
    }
    match at.violated(TOLERANCE_AT_END) {
        Some(limit) => Err(limit),
        None => Ok(ChainEnd { x, tracked: at.tracked, iterations: SUB_STEPS + END_STEPS }),
    }
}
