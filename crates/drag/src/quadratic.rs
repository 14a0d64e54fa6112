//! Quadratic program of a step: the smallest change that fulfils the linearization about the present point.
//!
//! Each residual is a row of the Jacobian, an equation to be fulfilled. `Hold` is its priority.

use std::rc::Rc;

use crate::matrix::{
    Matrix, add_scaled, cholesky, difference, dot, independent_rows, scaled_sum, solve_lower, solve_lower_transposed,
    solve_symmetric,
};
use crate::work::WorkBudget;

/// Least `mu` of the objective if there are also limits or hard pins, as a share of the trace of `J J^T`. Further steps
/// reduce the residual that this softness leaves.
const MIN_MU_BESIDE_LIMITS: f64 = 1e-7;

/// Least `mu`. With it, an equation with a zero row in the Jacobian, which no change can fulfil, is ignored instead of
/// dividing by zero.
const MIN_MU: f64 = 1e-30;

/// Number of first iterations of the active-set method in which all soft limits (springs) are added or removed
/// together. One at a time, many springs would take many iterations. Later iterations change one limit at a time, so
/// that the method surely terminates.
const MAX_BATCHED_TURNS: usize = 8;

/// Softness of hard pins and hard limits, as a share of the squared length of the row.
const LIMIT_TOLERANCE: f64 = 1e-14;

/// Linearization about unknowns `x`: residuals `residual + jacobian dx`, and limits `limits + slopes dx` that must stay
/// 0 or more. `residual` and `limits` are not part of it, because a step may use those of a nearby point (`Values`).
pub(crate) struct Linearization<'a> {
    pub jacobian: Matrix,
    pub slopes: Matrix,
    /// Priority of each residual, a row of `jacobian`.
    pub rows: Rc<[Hold]>,
    /// Softness of each limit, a row of `slopes`; 0 for a hard limit.
    pub compliances: Vec<f64>,
    /// Indices of independent rows of hard pins. The other rows of hard pins are linear combinations of these.
    fixed: Vec<usize>,
    /// Metric that measures a change together with the soft residuals it leaves: `I + sum a a^T / compliance` over the
    /// soft rows `a`. `None` without soft rows.
    metric: Option<Matrix>,
    work: &'a WorkBudget<'a>,
}

impl<'a> Linearization<'a> {
    pub fn new(
        (jacobian, slopes): (Matrix, Matrix),
        rows: Rc<[Hold]>,
        compliances: Vec<f64>,
        work: &'a WorkBudget<'a>,
    ) -> Self {
        let fixed: Vec<usize> = (0..rows.len()).filter(|row| rows[*row] == Hold::Fixed).collect();
        let is_few = fixed.len() <= jacobian.columns;
        let fixed = if is_few { fixed } else { independent_rows(&jacobian, &fixed, work) };
        let mut metric = None;
        for (row, hold) in rows.iter().enumerate() {
            if let Hold::Soft(compliance) = hold
                && work.spend(square(jacobian.columns))
            {
                let metric = metric.get_or_insert_with(|| Matrix::identity(jacobian.columns));
                add_square(metric, jacobian.row(row), *compliance);
            }
        }
        Self { jacobian, slopes, rows, compliances, fixed, metric, work }
    }
}

/// Returns the cost of an operation on all values of a square matrix, in steps of the work budget.
fn square(columns: usize) -> u64 {
    (columns * columns) as u64
}

/// Adds `a a^T / compliance` to `metric`.
fn add_square(metric: &mut Matrix, a: &[f64], compliance: f64) {
    for (row, value) in a.iter().enumerate() {
        let scaled = value / compliance;
        a.iter().enumerate().for_each(|(column, value)| *metric.at(row, column) += scaled * value);
    }
}

/// Priority of a residual, an equation of the linearization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hold {
    /// The equation is fulfilled as far as the limits and the `Fixed` equations allow.
    Objective,
    /// The equation is always fulfilled, before the objective: a hard pin or a joint.
    Fixed,
    /// The equation may be violated at a cost: `|residual|^2` divided by this compliance is weighed against the size of
    /// the change.
    Soft(f64),
}

/// Values of the residuals and limits in a step, and the residuals to fulfil.
#[derive(Clone, Debug)]
pub(crate) struct Values<'a> {
    pub residual: &'a [f64],
    pub limits: Vec<f64>,
    pub counting: RowSelection,
}

/// Residuals that a step fulfils. Hard limits always count, soft limits with [`Self::All`] only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowSelection {
    All,
    /// All residuals except the soft ones.
    Firm,
    /// The residuals of hard pins alone.
    Fixed,
}

/// Computes the smallest `y` at which the residuals are 0, as far as the limits allow, and the multipliers of all rows
/// and limits.
///
/// `y` minimizes `|y|^2 + |residual|^2 / mu` under the limits. Without limits that is `J^T (J J^T + mu I)^-1 (J x -
/// residual)` (light model, section 7). The active-set method adds each limit that `y` violates as a further equation,
/// which keeps the limit at 0, and removes the equation if its multiplier has the wrong sign. Limits come before the
/// residuals of the objective. A fixed residual is an equation that is never removed. Each soft residual and each soft
/// limit has its own softness in place of `mu`. A soft limit acts as a spring that pushes to one side. Soft residuals
/// and soft limits change the metric of `|y|^2` and add no equations. So the size of the system does not grow with the
/// number of soft pins.
pub(crate) fn smallest_step(x: &[f64], linear: &Linearization, values: Values, mu: f64) -> (Vec<f64>, Multipliers) {
    let Linearization { jacobian, slopes, rows, compliances, work, .. } = linear;
    let Values { residual, limits, counting } = values;
    let targets = difference(&jacobian.times(x), residual);
    let limit_targets = difference(&slopes.times(x), &limits);
    let mut soft_right = vec![0.0; jacobian.columns];
    for (row, hold) in rows.iter().enumerate() {
        if let (Hold::Soft(compliance), RowSelection::All) = (hold, counting) {
            add_scaled(&mut soft_right, jacobian.row(row), targets[row] / compliance);
        }
    }
    let step = QpStep { linear, targets, limit_targets, soft_right, counting, mu };
    let mut active: Vec<usize> = Vec::new();
    let mut best: Option<(Vec<f64>, Multipliers)> = None;
    let max_turns = 4 * limits.len().min(4 * jacobian.columns) + 4;
    for turn in 0..max_turns {
        if !work.spend(((jacobian.columns + active.len()) * limits.len()) as u64) {
            break;
        }
        let (y, of_rows, of_active) = step.with_active(&active);
        let is_batched = |limit: usize| compliances[limit] > 0.0 && turn < MAX_BATCHED_TURNS;
        // A limit that pulls in the wrong direction leaves the active set.
        let wrong = active.iter().enumerate().filter(|(k, _)| of_active[*k] < 0.0);
        if let Some((k, &limit)) = wrong.min_by(|a, b| of_active[a.0].total_cmp(&of_active[b.0])) {
            if is_batched(limit) {
                let mut multipliers = of_active.iter();
                active.retain(|limit| multipliers.next().is_some_and(|m| *m >= 0.0) || compliances[*limit] == 0.0);
            } else {
                active.remove(k);
            }
            continue;
        }
        let products = slopes.times(&y);
        let excess = |k: &usize| products[*k] - step.limit_targets[*k];
        let counts = |k: usize| compliances[k] == 0.0 || counting == RowSelection::All;
        let violated: Vec<usize> = (0..limits.len())
            .filter(|k| counts(*k) && products[*k] < step.limit_targets[*k] - 1e-12 && !active.contains(k))
            .collect();
        let mut of_limits = vec![0.0; limits.len()];
        for (&limit, multiplier) in active.iter().zip(of_active).filter(|(limit, _)| compliances[**limit] <= 0.0) {
            of_limits[limit] = multiplier;
        }
        best = Some((y, Multipliers { rows: of_rows, limits: of_limits }));
        let Some(worst) = violated.iter().copied().min_by(|a, b| excess(a).total_cmp(&excess(b))) else { break };
        if is_batched(worst) {
            active.extend(violated.into_iter().filter(|limit| compliances[*limit] > 0.0));
        } else {
            active.push(worst);
        }
    }
    best.unwrap_or_else(|| {
        (x.to_vec(), Multipliers { rows: vec![0.0; jacobian.rows], limits: vec![0.0; limits.len()] })
    })
}

/// Multipliers of the residuals and of the limits. A limit's multiplier is 0 or more.
#[derive(Clone, Debug)]
pub(crate) struct Multipliers {
    pub rows: Vec<f64>,
    pub limits: Vec<f64>,
}

/// Data of one step that stay the same while the set of active limits changes.
struct QpStep<'a> {
    linear: &'a Linearization<'a>,
    /// Value that the product of each row of the Jacobian with `y` should have. The next field is the least product of
    /// each row of limits.
    targets: Vec<f64>,
    limit_targets: Vec<f64>,
    /// Right side of the equations that the soft residuals add to the metric.
    soft_right: Vec<f64>,
    counting: RowSelection,
    mu: f64,
}

impl QpStep<'_> {
    /// Computes the smallest `y` that keeps the `active` limits at 0, the multipliers of all residuals, and the
    /// multipliers of the active limits.
    ///
    /// With `M = L L^T` for the soft rows and `y0 = M^-1 right`, `|y|^2` and the soft rows together are `|L^T (y -
    /// y0)|^2`. Only firm rows remain, each as `L^-1 a`.
    fn with_active(&self, active: &[usize]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let Linearization { jacobian, slopes, rows, compliances, fixed, metric, work } = self.linear;
        let (soft_limits, hard_limits): (Vec<usize>, Vec<usize>) =
            active.iter().partition(|limit| compliances[**limit] > 0.0);
        let are_soft = self.counting == RowSelection::All && metric.is_some();
        // Without soft rows and active soft limits M is I.
        let soft = (are_soft || !soft_limits.is_empty()).then(|| {
            let identity = || Matrix::identity(jacobian.columns);
            let mut metric = metric.clone().filter(|_| are_soft).unwrap_or_else(identity);
            let mut right = self.soft_right.clone();
            for limit in soft_limits {
                if !work.spend(square(jacobian.columns)) {
                    break;
                }
                add_square(&mut metric, slopes.row(limit), compliances[limit]);
                add_scaled(&mut right, slopes.row(limit), self.limit_targets[limit] / compliances[limit]);
            }
            let lower = cholesky(&metric, work);
            let y0 = solve_lower_transposed(&lower, &solve_lower(&lower, &right));
            (lower, y0)
        });
        let objective = || (0..rows.len()).filter(|row| rows[*row] == Hold::Objective);
        let firm: Vec<FirmRow> = objective()
            .filter(|_| self.counting != RowSelection::Fixed)
            .map(FirmRow::Objective)
            .chain(fixed.iter().copied().map(FirmRow::Fixed))
            .chain(hard_limits.into_iter().map(FirmRow::Limit))
            .collect();
        let trace: f64 = objective().map(|row| dot(jacobian.row(row), jacobian.row(row))).sum();
        // Firm rows come first, so the softness of the objective exceeds their rounding errors.
        let is_objective = |row: &FirmRow| matches!(row, FirmRow::Objective(_));
        let objective_mu =
            if firm.iter().all(is_objective) { self.mu } else { self.mu.max(MIN_MU_BESIDE_LIMITS * trace) };
        let mut all = Matrix::zero(firm.len(), jacobian.columns);
        let (mut right, mut softness) = (Vec::new(), Vec::new());
        for (k, row) in firm.iter().enumerate() {
            let (a, target) = match *row {
                FirmRow::Objective(row) | FirmRow::Fixed(row) => (jacobian.row(row), self.targets[row]),
                FirmRow::Limit(limit) => (slopes.row(limit), self.limit_targets[limit]),
            };
            if let Some((lower, y0)) = &soft
                && work.spend(square(jacobian.columns))
            {
                all.row_mut(k).copy_from_slice(&solve_lower(lower, a));
                right.push(target - dot(a, y0));
            } else {
                all.row_mut(k).copy_from_slice(a);
                right.push(target);
            }
            softness.push(if is_objective(row) { objective_mu } else { LIMIT_TOLERANCE * dot(a, a) + MIN_MU });
        }
        let mut normal = all.times_transposed(&all, work);
        softness.iter().enumerate().for_each(|(k, mu)| *normal.at(k, k) += mu);
        let weights = solve_symmetric(normal, right, work);
        let mut y = all.transposed_times(&weights);
        if let Some((lower, y0)) = &soft {
            y = scaled_sum(&solve_lower_transposed(lower, &y), y0, 1.0);
        }
        let mut of_rows = vec![0.0; rows.len()];
        let mut of_limits = vec![0.0; slopes.rows];
        for (row, weight) in firm.iter().zip(weights) {
            match *row {
                FirmRow::Objective(row) | FirmRow::Fixed(row) => of_rows[row] = weight,
                FirmRow::Limit(limit) => of_limits[limit] = weight,
            }
        }
        let multiplier = |&limit: &usize| match compliances[limit] {
            compliance if compliance > 0.0 => (self.limit_targets[limit] - dot(slopes.row(limit), &y)) / compliance,
            _ => of_limits[limit],
        };
        let of_active = active.iter().map(multiplier).collect();
        (y, of_rows, of_active)
    }
}

#[derive(Clone, Copy, Debug)]
enum FirmRow {
    Objective(usize),
    Fixed(usize),
    Limit(usize),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]], columns: usize) -> Matrix {
        let mut made = Matrix::zero(rows.len(), columns);
        for (i, row) in rows.iter().enumerate() {
            (0..columns).for_each(|j| *made.at(i, j) = row[j]);
        }
        made
    }

    fn step(residual: f64, limits: &[(f64, [f64; 2])]) -> Vec<f64> {
        pinned(residual, limits, &[])
    }

    /// Computes the step of a residual with further fixed equations `y . row = 0`.
    fn pinned(residual: f64, limits: &[(f64, [f64; 2])], pins: &[(Hold, [f64; 2])]) -> Vec<f64> {
        let mut rows: Vec<&[f64]> = vec![&[1.0, 1.0]];
        rows.extend(pins.iter().map(|(_, row)| &row[..]));
        let slopes = matrix(&limits.iter().map(|(_, slope)| &slope[..]).collect::<Vec<_>>(), 2);
        let work = WorkBudget::new(&|_| true);
        let linear = Linearization::new(
            (matrix(&rows, 2), slopes),
            std::iter::once(Hold::Objective).chain(pins.iter().map(|(hold, _)| *hold)).collect(),
            vec![0.0; limits.len()],
            &work,
        );
        let residual = &[vec![residual], vec![0.0; pins.len()]].concat();
        let limits = limits.iter().map(|(value, _)| *value).collect();
        smallest_step(&[0.0; 2], &linear, Values { residual, limits, counting: RowSelection::All }, 1e-12).0
    }

    fn near(y: &[f64], expected: [f64; 2]) {
        assert!(y.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{y:?} is not {expected:?}");
    }

    /// The smallest step on a line is its point nearest to 0. With a limit across the line, it is the point of the line
    /// at the limit. If the limit keeps it from the line, it is the point nearest to the line.
    #[test]
    fn the_smallest_step_keeps_within_limits() {
        near(&step(-2.0, &[]), [1.0, 1.0]);
        near(&step(-2.0, &[(0.25, [-1.0, 0.0])]), [0.25, 1.75]);
        // A limit that does not bind has no effect.
        near(&step(-2.0, &[(5.0, [-1.0, 0.0])]), [1.0, 1.0]);
        near(&step(-2.0, &[(0.25, [-1.0, 0.0]), (0.5, [0.0, -1.0])]), [0.25, 0.5]);
        // A broken limit is restored first.
        near(&step(-2.0, &[(-0.5, [-1.0, 0.0])]), [-0.5, 2.5]);
    }

    /// A hard pin is kept at the expense of the objective. A soft pin yields by its cost: with `a = 2 - b`, the least
    /// value of `a^2 + b^2 + b^2 / c` at compliance `c` has `b = 2 c / (1 + 2 c)`.
    #[test]
    fn pins_hold() {
        near(&pinned(-2.0, &[], &[(Hold::Fixed, [0.0, 1.0])]), [2.0, 0.0]);
        near(&pinned(-2.0, &[], &[(Hold::Fixed, [1.0, 1.0])]), [0.0, 0.0]);
        near(&pinned(-2.0, &[(1.5, [-1.0, 0.0])], &[(Hold::Fixed, [0.0, 1.0])]), [1.5, 0.0]);
        near(&pinned(-2.0, &[], &[(Hold::Soft(0.25), [0.0, 1.0])]), [2.0 - 1.0 / 3.0, 1.0 / 3.0]);
    }
}
