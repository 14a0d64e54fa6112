//! A place that the solver is at, and a step from it.

use crate::bound::Bound;
use crate::goal::{Evaluation, Goal, TrackedPoints};
use crate::matrix::{dot, length};
use crate::quadratic::{Hold, Linearization, RowSelection, Values, smallest_step};
use crate::request::DragLimit;

/// A residual this small is none, in radii or radians.
const RESIDUAL_TOLERANCE: f64 = 1e-10;

/// Steps from one place to the nearest at which all holds, with one Jacobian.
const MAX_RESTORE_STEPS: usize = 8;

/// A place that the solver is at.
#[derive(Clone, Debug)]
pub(crate) struct Iterate {
    pub x: Vec<f64>,
    pub evaluation: Evaluation,
}

/// What was found.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub iterate: Iterate,
    /// What holds it back most.
    pub strongest_limit: Option<DragLimit>,
    pub iterations: usize,
}

impl Iterate {
    /// Whether the feature lies where it should, and nothing is broken.
    pub fn is_converged(&self) -> bool {
        self.objective_error() < RESIDUAL_TOLERANCE
            && self.pin_error() < RESIDUAL_TOLERANCE
            && self.hard_bounds().all(|bound| bound.value >= 0.0)
    }

    /// Whether the light can be had: hard pins and limits hold, where it glides but for those of the place under the cursor.
    pub fn is_feasible(&self) -> bool {
        self.pin_error() < RESIDUAL_TOLERANCE && self.hard_bounds().all(|bound| bound.value >= 0.0)
    }

    fn hard_bounds(&self) -> impl Iterator<Item = &Bound> {
        self.evaluation.bounds.iter().filter(|bound| bound.compliance == 0.0)
    }

    fn sum_of_squares(&self, which: impl Fn(Hold) -> bool) -> f64 {
        let Evaluation { residual, rows, .. } = &self.evaluation;
        residual.iter().zip(rows.iter()).filter(|(_, row)| which(**row)).map(|(off, _)| off * off).sum()
    }

    /// How far the feature is off.
    pub fn objective_error(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Objective).sqrt()
    }

    /// How far the feature and hard pins are off and by how much limits are broken, squared.
    pub fn merit(&self) -> f64 {
        let broken = self.hard_bounds().map(|bound| bound.value.min(0.0));
        self.sum_of_squares(|row| !matches!(row, Hold::Soft(_))) + broken.map(|off| off * off).sum::<f64>()
    }

    /// How far hard pins are off.
    fn pin_error(&self) -> f64 {
        self.sum_of_squares(|row| row == Hold::Fixed).sqrt()
    }
}

impl Solution {
    /// The light that the drag began with. `None` where even that cannot be evaluated.
    pub fn begin(goal: &Goal, near: &TrackedPoints) -> Option<Self> {
        let unmoved = vec![0.0; goal.unknowns.count()];
        let at = Iterate { evaluation: goal.evaluate(&unmoved, 0.0, near)?, x: unmoved };
        Some(Self { iterate: at, strongest_limit: None, iterations: 0 })
    }

    /// What is linear about a place nearby wants of `at`, with the smallest change since `from`.
    pub fn step_target(
        &mut self,
        goal: &Goal,
        from: &[f64],
        at: &Iterate,
        linear: &Linearization,
        (mu, counting): (f64, RowSelection),
    ) -> Vec<f64> {
        let moved: Vec<f64> = at.x.iter().zip(from).map(|(x, from)| x - from).collect();
        let limits: Vec<f64> = at.evaluation.bounds.iter().map(|bound| bound.value - 1e-12).collect();
        let values = Values { residual: &at.evaluation.residual, limits: &limits, counting };
        let (wanted, pulls) = smallest_step(&moved, linear, values, mu);
        self.strongest_limit = goal.strongest_limit(&at.evaluation, &pulls);
        wanted.iter().zip(from).map(|(wanted, from)| from + wanted).collect()
    }
}

pub(crate) fn length_between(a: &[f64], b: &[f64]) -> f64 {
    length(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>())
}

/// The nearest place at which all that counts is as it should be, by what was linear about a place nearby; `None` where that
/// leads nowhere.
pub(crate) fn restore_feasibility(
    goal: &Goal,
    share: f64,
    about: &Linearization,
    from: &Iterate,
    counting: RowSelection,
) -> Option<Iterate> {
    let mut at = from.clone();
    let nowhere = vec![0.0; at.x.len()];
    let mu = 1e-15 * objective_trace(about);
    let is_good =
        |at: &Iterate| if counting == RowSelection::Fixed { at.is_feasible() } else { at.is_converged() };
    let off_of = |at: &Iterate| {
        if counting == RowSelection::Fixed { at.pin_error() } else { at.objective_error() + at.pin_error() }
    };
    for _ in 0..MAX_RESTORE_STEPS {
        if is_good(&at) {
            return Some(at);
        }
        let limits: Vec<f64> = at.evaluation.bounds.iter().map(|bound| bound.value - 1e-12).collect();
        let residual = &at.evaluation.residual;
        let (by, _) = smallest_step(&nowhere, about, Values { residual, limits: &limits, counting }, mu);
        let x: Vec<f64> = at.x.iter().zip(&by).map(|(x, by)| x + by).collect();
        let off = off_of(&at);
        at = Iterate { evaluation: goal.evaluate(&x, share, &at.evaluation.tracked)?, x };
        if off_of(&at) > off && off > RESIDUAL_TOLERANCE {
            return None;
        }
    }
    is_good(&at).then_some(at)
}

/// The trace of `J J^T` of what is asked.
pub(crate) fn objective_trace(linear: &Linearization) -> f64 {
    let asked = (0..linear.rows.len()).filter(|row| linear.rows[*row] == Hold::Objective);
    asked.map(|row| dot(linear.jacobian.row(row), linear.jacobian.row(row))).sum()
}
