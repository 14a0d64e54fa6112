//! Quadratic program of one sub-step of a drag.

use crate::bound::Bound;
use crate::matrix::{Matrix, add_scaled, cholesky, dot, solve_lower, solve_lower_transposed, solve_symmetric};
use crate::work::WorkBudget;

/// Weights of the squared change of the light, in units of the unknowns: lengths of the light, and radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepWeights {
    /// Weight of the change since the start of the drag.
    pub change: f64,
    /// Weight of the change by this step; above 0.
    pub step: f64,
}

impl StepWeights {
    /// Weights of a step without rows, all alike.
    pub const EVEN: Self = Self { change: 0.0, step: 1.0 };
}

/// Weight of the squared violation of a hard bound.
const BOUND_WEIGHT: f64 = 1e3;

/// Most changes of the set of violated bounds. The set is mostly right after two.
const MAX_SET_CHANGES: usize = 12;

/// Softness of the equations, as a share of the largest. With it, an equation that no change can fulfil is left.
const EQUATION_SOFTNESS: f64 = 1e-9;

/// Linearization of a drag about a light: slopes of the equations, of the rows of the metric, and of the bounds.
pub(crate) struct Slopes {
    pub equations: Matrix,
    pub rows: Matrix,
    pub bounds: Matrix,
}

impl Slopes {
    /// Makes slopes of nothing in `n` unknowns.
    pub fn none(n: usize) -> Self {
        let none = Matrix::zero(0, n);
        Self { equations: none.clone(), rows: none.clone(), bounds: none }
    }
}

/// Values at the light about which a drag is linearized.
pub(crate) struct StepValues<'a> {
    pub equations: &'a [f64],
    pub rows: &'a [f64],
    pub bounds: &'a [Bound],
}

/// Computes the change `d` of the unknowns `x` that minimizes
/// `|rows|^2 + change |x + d|^2 + step |d|^2 + sum weight min(0, bound)^2` with all equations fulfilled.
///
/// The problem is strictly convex, so `d` is a continuous function of all inputs while the equations are independent.
pub(crate) fn convex_step(
    x: &[f64],
    at: &StepValues,
    slopes: &Slopes,
    weights: StepWeights,
    work: &WorkBudget,
) -> Vec<f64> {
    let n = x.len();
    let mut metric = Matrix::zero(n, n);
    let mut right: Vec<f64> = x.iter().map(|x| -weights.change * x).collect();
    (0..n).for_each(|k| *metric.at(k, k) = weights.change + weights.step);
    for (row, value) in at.rows.iter().enumerate() {
        if !work.spend((n * n) as u64) {
            return vec![0.0; n];
        }
        add_outer(&mut metric, slopes.rows.row(row), 1.0);
        add_scaled(&mut right, slopes.rows.row(row), -value);
    }
    let mut violated: Vec<bool> = at.bounds.iter().map(|bound| bound.value < 0.0).collect();
    let mut change = vec![0.0; n];
    for _ in 0..MAX_SET_CHANGES {
        if !work.spend(((n + at.bounds.len()) * n * n) as u64) {
            break;
        }
        let (mut metric, mut right) = (metric.clone(), right.clone());
        for (k, bound) in at.bounds.iter().enumerate().filter(|(k, _)| violated[*k]) {
            let weight = weight_of(bound);
            add_outer(&mut metric, slopes.bounds.row(k), weight);
            add_scaled(&mut right, slopes.bounds.row(k), -weight * bound.value);
        }
        change = with_equations(&metric, &right, at.equations, &slopes.equations, work);
        let now: Vec<bool> = at
            .bounds
            .iter()
            .enumerate()
            .map(|(k, bound)| bound.value + dot(slopes.bounds.row(k), &change) < 0.0)
            .collect();
        if now == violated {
            break;
        }
        violated = now;
    }
    change
}

fn weight_of(bound: &Bound) -> f64 {
    if bound.compliance > 0.0 { 1.0 / bound.compliance } else { BOUND_WEIGHT }
}

/// Minimizes `d M d / 2 - right d` with the equations fulfilled.
fn with_equations(metric: &Matrix, right: &[f64], values: &[f64], slopes: &Matrix, work: &WorkBudget) -> Vec<f64> {
    let lower = cholesky(metric, work);
    let inverse = |v: &[f64]| solve_lower_transposed(&lower, &solve_lower(&lower, v));
    let mut change = inverse(right);
    let along: Vec<Vec<f64>> = (0..values.len()).map(|row| inverse(slopes.row(row))).collect();
    let mut normal = Matrix::zero(values.len(), values.len());
    for (i, a) in along.iter().enumerate() {
        for j in 0..values.len() {
            *normal.at(i, j) = dot(a, slopes.row(j));
        }
    }
    let largest = (0..values.len()).map(|k| normal.row(k)[k]).fold(0.0, f64::max);
    (0..values.len()).for_each(|k| *normal.at(k, k) += EQUATION_SOFTNESS * largest);
    let excess = values.iter().enumerate().map(|(row, value)| value + dot(slopes.row(row), &change)).collect();
    for (multiplier, along) in solve_symmetric(normal, excess, work).iter().zip(&along) {
        add_scaled(&mut change, along, -multiplier);
    }
    change
}

/// Adds `weight a a^T` to `metric`.
fn add_outer(metric: &mut Matrix, a: &[f64], weight: f64) {
    for (row, value) in a.iter().enumerate() {
        if *value != 0.0 {
            add_scaled(metric.row_mut(row), a, weight * value);
        }
    }
}
