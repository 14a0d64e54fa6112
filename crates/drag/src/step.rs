//! State of the solver, and a step from it.

use crate::bound::Bound;
use crate::goal::{Evaluation, Goal, TrackedPoints};
use crate::matrix::{difference, dot, length, scaled_sum};
use crate::quadratic::{Hold, Linearization, RowSelection, smallest_step};
use crate::request::DragLimit;

/// Size below which a residual counts as 0, in radii or radians.
const RESIDUAL_TOLERANCE: f64 = 1e-10;

/// Most steps with one Jacobian that restore the constraints.
const MAX_RESTORE_STEPS: usize = 8;

/// State of the solver: values of the unknowns, and the evaluation of the light that they give.
#[derive(Clone, Debug)]
pub(crate) struct Iterate {
    pub x: Vec<f64>,
    pub evaluation: Evaluation,
}

/// Best light that the solver has found so far, with its iteration count.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub iterate: Iterate,
    /// Limit or hard pin with the largest multiplier in the latest step.
    pub strongest_limit: Option<DragLimit>,
    pub iterations: usize,
}

impl Iterate {
    /// Evaluates the unknowns `x` at a share of the path. `None` if the light cannot be evaluated.
    pub fn new(goal: &Goal, x: Vec<f64>, share: f64, near: &TrackedPoints) -> Option<Self> {
        Some(Self { evaluation: goal.evaluate(&x, share, near)?, x })
    }

    /// Evaluates other unknowns at a share of the path, with the points that this state tracks.
    pub fn moved_to(&self, goal: &Goal, x: Vec<f64>, share: f64) -> Option<Self> {
        Self::new(goal, x, share, &self.evaluation.tracked)
    }

    /// Evaluates the same unknowns at another share of the path.
    pub fn at_share(&self, goal: &Goal, share: f64) -> Option<Self> {
        self.moved_to(goal, self.x.clone(), share)
    }

    /// True if the feature is at its target and all limits and hard pins are kept.
    pub fn is_converged(&self) -> bool {
        self.objective_error() < RESIDUAL_TOLERANCE && self.is_feasible()
    }

    /// True if all hard limits and hard pins are kept. In a slide the limits of the point under the cursor are soft and
    /// do not count.
    pub fn is_feasible(&self) -> bool {
        self.pin_error() < RESIDUAL_TOLERANCE && self.hard_bounds().all(|bound| bound.value >= 0.0)
    }

    fn hard_bounds(&self) -> impl Iterator<Item = &Bound> {
        self.evaluation.bounds.iter().filter(|bound| bound.compliance == 0.0)
    }

    fn sum_of_squares(&self, which: impl Fn(Hold) -> bool) -> f64 {
        let Evaluation { residual, rows, .. } = &self.evaluation;
        residual.iter().zip(rows.iter()).filter(|(_, row)| which(**row)).map(|(error, _)| error * error).sum()
    }

    /// Returns the error of the feature, in radii or radians.
    pub fn objective_error(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Objective).sqrt()
    }

    /// Returns the sum of the squared errors of the feature and of the hard pins, and of the squared violations of hard
    /// limits.
    pub fn merit(&self) -> f64 {
        let violations = self.hard_bounds().map(|bound| bound.value.min(0.0));
        self.sum_of_squares(|row| !matches!(row, Hold::Soft(_))) + violations.map(|value| value * value).sum::<f64>()
    }

    /// Returns the error of the hard pins, in radii or radians.
    fn pin_error(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Fixed).sqrt()
    }
}

impl Solution {
    /// Makes the solution that leaves the light as it is at the start of the drag. `None` if that light cannot be
    /// evaluated.
    pub fn begin(goal: &Goal, near: &TrackedPoints) -> Option<Self> {
        let iterate = Iterate::new(goal, vec![0.0; goal.unknowns.count()], 0.0, near)?;
        Some(Self { iterate, strongest_limit: None, iterations: 0 })
    }

    /// Computes the unknowns with the smallest change from `from` that solve the linearized equations and limits, whose
    /// values are those of `at`. `linear` may be the linearization about a point near `at`.
    pub fn step_target(
        &mut self,
        goal: &Goal,
        from: &[f64],
        at: &Iterate,
        linear: &Linearization,
        mu: f64,
        counting: RowSelection,
    ) -> Vec<f64> {
        let moved = difference(&at.x, from);
        let (change, multipliers) = smallest_step(&moved, linear, at.evaluation.values(counting), mu);
        self.strongest_limit = goal.strongest_limit(&at.evaluation, &multipliers);
        scaled_sum(from, &change, 1.0)
    }
}

pub(crate) fn length_between(a: &[f64], b: &[f64]) -> f64 {
    length(&difference(a, b))
}

/// Finds the nearest state to `from` at which all equations that `counting` selects are fulfilled. Every step uses the
/// slopes of `about`, the linearization about a nearby point. `None` if the steps do not converge.
pub(crate) fn restore_feasibility(
    goal: &Goal,
    share: f64,
    about: &Linearization,
    from: &Iterate,
    counting: RowSelection,
) -> Option<Iterate> {
    let mut at = from.clone();
    let unmoved = vec![0.0; at.x.len()];
    let mu = 1e-15 * objective_trace(about);
    let are_pins_alone = counting == RowSelection::Fixed;
    let is_good = |at: &Iterate| if are_pins_alone { at.is_feasible() } else { at.is_converged() };
    let error_of = |at: &Iterate| if are_pins_alone { at.pin_error() } else { at.objective_error() + at.pin_error() };
    for _ in 0..MAX_RESTORE_STEPS {
        if is_good(&at) {
            return Some(at);
        }
        let (change, _) = smallest_step(&unmoved, about, at.evaluation.values(counting), mu);
        let error = error_of(&at);
        at = at.moved_to(goal, scaled_sum(&at.x, &change, 1.0), share)?;
        if error_of(&at) > error && error > RESIDUAL_TOLERANCE {
            return None;
        }
    }
    is_good(&at).then_some(at)
}

/// Computes the trace of `J J^T` over the rows of the objective in the Jacobian `J`.
pub(crate) fn objective_trace(linear: &Linearization) -> f64 {
    let rows = (0..linear.rows.len()).filter(|row| linear.rows[*row] == Hold::Objective);
    rows.map(|row| dot(linear.jacobian.row(row), linear.jacobian.row(row))).sum()
}
