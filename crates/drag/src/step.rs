//! A place that the solver is at, and a step from it.

use crate::bound::Bound;
use crate::goal::{Evaluation, Goal, Near};
use crate::matrix::{dot, length};
use crate::quadratic::{Counting, Hold, Linear, Values, smallest};
use crate::request::Limit;

/// A residual this small is none, in radii or radians.
const NOTHING: f64 = 1e-10;

/// Steps from one place to the nearest at which all holds, with one Jacobian.
const STEPS_BACK: usize = 8;

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
    /// The light that the drag began with. `None` where even that cannot be evaluated.
    pub fn begin(goal: &Goal, near: &Near) -> Option<Self> {
        let unmoved = vec![0.0; goal.moves.count()];
        let at = At { evaluation: goal.evaluate(&unmoved, 0.0, near)?, x: unmoved };
        Some(Self { at, held_by: None, iterations: 0 })
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
