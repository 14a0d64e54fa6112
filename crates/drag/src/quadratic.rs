//! The step that a solver takes: the smallest change that fulfils what is linear about the present place.

use std::rc::Rc;

use crate::matrix::{
    Matrix, cholesky, dot, independent_rows, solve_lower, solve_lower_transposed, solve_symmetric,
};
use crate::work::WorkBudget;

/// The least `mu` beside limits, as a share of the trace of `J J^T`. What it leaves of a residual goes in further steps.
const MIN_MU_BESIDE_LIMITS: f64 = 1e-7;

/// The least `mu`: what no change does anything to asks for nothing.
const MIN_MU: f64 = 1e-30;

/// Turns in which springs come in and go together, so that many do not take as many turns. Past these they do so one by one, which
/// ends for certain.
const MAX_BATCHED_TURNS: usize = 8;

/// To what share of their size limits are held.
const LIMIT_TOLERANCE: f64 = 1e-14;

/// What is linear about a place `x`: residuals `residual + jacobian dx`, and limits that are to stay 0 or more, `limits +
/// slopes dx`. The values are given beside it, since they may be of a place nearby.
pub(crate) struct Linearization<'a> {
    pub jacobian: Matrix,
    pub slopes: Matrix,
    /// How firmly each residual is held.
    pub rows: Rc<[Hold]>,
    /// How softly each limit gives way; 0 where it does not.
    pub compliances: Vec<f64>,
    /// Of the fixed rows those that the others follow from.
    fixed: Vec<usize>,
    /// `I + sum a a^T / give` over the soft rows: what the size of a change is measured by where these count. `None` of none.
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
            if let Hold::Soft(give) = hold
                && work.spend(square(jacobian.columns))
            {
                let metric = metric.get_or_insert_with(|| identity(jacobian.columns));
                add_square(metric, jacobian.row(row), *give);
            }
        }
        Self { jacobian, slopes, rows, compliances, fixed, metric, work }
    }
}

/// Steps of what goes over all of a square matrix.
fn square(columns: usize) -> u64 {
    (columns * columns) as u64
}

fn identity(count: usize) -> Matrix {
    let mut matrix = Matrix::zero(count, count);
    (0..count).for_each(|k| *matrix.at(k, k) = 1.0);
    matrix
}

/// Adds `a a^T / give`.
fn add_square(metric: &mut Matrix, a: &[f64], give: f64) {
    for (row, value) in a.iter().enumerate() {
        let scaled = value / give;
        a.iter().enumerate().for_each(|(column, value)| *metric.at(row, column) += scaled * value);
    }
}

/// Adds `a by`.
fn add_scaled(sum: &mut [f64], a: &[f64], by: f64) {
    sum.iter_mut().zip(a).for_each(|(sum, value)| *sum += value * by);
}

/// How firmly a residual is held at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hold {
    /// As far as limits and what is fixed let it.
    Objective,
    /// Whatever is asked.
    Fixed,
    /// `|residual|^2 / give` is weighed against the size of the change.
    Soft(f64),
}

/// Values of residuals and limits, and which count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Values<'a> {
    pub residual: &'a [f64],
    pub limits: &'a [f64],
    pub counting: RowSelection,
}

/// Which residuals count; limits do that are not soft, and with [`Self::All`] those that are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowSelection {
    All,
    /// Not those that are soft.
    Firm,
    /// Those alone that are fixed.
    Fixed,
}

/// The smallest `y` for which the residuals at `y` are 0, as far as the limits let them, and how each limit and each fixed
/// residual pulls.
///
/// `y` is least in `|y|^2 + |residual|^2 / mu` over what fulfils the limits. Without limits that is `J^T (J J^T + mu I)^-1
/// (J x - residual)` (light model, section 7). Limits are brought in by an active set: each as a further row that is held at
/// 0, and let go where it pulls the wrong way. They come before residuals, which only ask; a fixed residual is a row that is
/// never let go. What is soft has a `mu` of its own, limits too, which then are springs on one side. That changes what `|y|^2`
/// is measured by, and adds no rows: however much is pinned, there are as many unknowns.
pub(crate) fn smallest_step(
    x: &[f64],
    linear: &Linearization,
    values: Values,
    mu: f64,
) -> (Vec<f64>, Multipliers) {
    let Linearization { jacobian, slopes, rows, compliances: give, work, .. } = linear;
    let Values { residual, limits, counting } = values;
    let wanted: Vec<f64> = jacobian.times(x).iter().zip(residual).map(|(a, b)| a - b).collect();
    let floor: Vec<f64> = slopes.times(x).iter().zip(limits).map(|(a, b)| a - b).collect();
    let mut pull = vec![0.0; jacobian.columns];
    for (row, hold) in rows.iter().enumerate() {
        if let (Hold::Soft(give), RowSelection::All) = (hold, counting) {
            add_scaled(&mut pull, jacobian.row(row), wanted[row] / give);
        }
    }
    let step = QpStep { linear, wanted, floor, pull, counting, mu };
    let mut active: Vec<usize> = Vec::new();
    let mut best: Option<(Vec<f64>, Multipliers)> = None;
    let most = 4 * limits.len().min(4 * jacobian.columns) + 4;
    for turn in 0..most {
        let compared = (jacobian.columns + active.len()) * limits.len();
        if !work.spend(compared as u64) {
            break;
        }
        let (y, of_rows, pulls) = step.with_active(&active);
        // A limit that holds the light back where it wants to go is let go of.
        let wrong = active.iter().enumerate().filter(|(k, _)| pulls[*k] < 0.0);
        if let Some((k, &limit)) = wrong.min_by(|a, b| pulls[a.0].total_cmp(&pulls[b.0])) {
            if give[limit] > 0.0 && turn < MAX_BATCHED_TURNS {
                let mut pulls = pulls.iter();
                active.retain(|limit| pulls.next().is_some_and(|pull| *pull >= 0.0) || give[*limit] == 0.0);
            } else {
                active.remove(k);
            }
            continue;
        }
        let height = slopes.times(&y);
        let counts = |k: usize| give[k] == 0.0 || counting == RowSelection::All;
        let broken: Vec<usize> = (0..limits.len())
            .filter(|k| counts(*k) && height[*k] < step.floor[*k] - 1e-12 && !active.contains(k))
            .collect();
        let mut of_limits = vec![0.0; limits.len()];
        active.iter().zip(pulls).for_each(|(&k, pull)| of_limits[k] = if give[k] > 0.0 { 0.0 } else { pull });
        best = Some((y, Multipliers { rows: of_rows, limits: of_limits }));
        let below = |k: &usize| height[*k] - step.floor[*k];
        let Some(worst) = broken.iter().copied().min_by(|a, b| below(a).total_cmp(&below(b))) else { break };
        if give[worst] > 0.0 && turn < MAX_BATCHED_TURNS {
            active.extend(broken.into_iter().filter(|k| give[*k] > 0.0));
        } else {
            active.push(worst);
        }
    }
    let still = || Multipliers { rows: vec![0.0; jacobian.rows], limits: vec![0.0; limits.len()] };
    best.unwrap_or_else(|| (x.to_vec(), still()))
}

/// How residuals and limits pull at what changes: the multipliers of their rows, of limits 0 or more.
#[derive(Clone, Debug, Default)]
pub(crate) struct Multipliers {
    pub rows: Vec<f64>,
    pub limits: Vec<f64>,
}

/// What a step is made of.
struct QpStep<'a> {
    linear: &'a Linearization<'a>,
    /// What rows and limits are to be at `y`.
    wanted: Vec<f64>,
    floor: Vec<f64>,
    /// Where soft rows pull.
    pull: Vec<f64>,
    counting: RowSelection,
    mu: f64,
}

impl QpStep<'_> {
    /// The smallest `y` with the active limits at 0, and the multipliers of all rows and of those limits.
    ///
    /// With `M = L L^T` for what is soft and `y0 = M^-1 pull`, `|y|^2` and the soft rows are `|L^T (y - y0)|^2`, and so only firm
    /// rows are left, as `L^-1 a` of what they were.
    fn with_active(&self, active: &[usize]) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let Linearization { jacobian, slopes, rows, compliances: give, fixed, metric, work } = self.linear;
        let is_spring = |limit: &&usize| give[**limit] > 0.0;
        let are_soft = self.counting == RowSelection::All && metric.is_some();
        // Where nothing is soft M is I.
        let soft = (are_soft || active.iter().any(|limit| is_spring(&limit))).then(|| {
            let unsoft = || identity(jacobian.columns);
            let mut metric = metric.clone().filter(|_| are_soft).unwrap_or_else(unsoft);
            let mut pull = self.pull.clone();
            for &limit in active.iter().filter(is_spring) {
                if !work.spend(square(jacobian.columns)) {
                    break;
                }
                add_square(&mut metric, slopes.row(limit), give[limit]);
                add_scaled(&mut pull, slopes.row(limit), self.floor[limit] / give[limit]);
            }
            let lower = cholesky(&metric, work);
            let rest = solve_lower_transposed(&lower, &solve_lower(&lower, &pull));
            (lower, rest)
        });
        let asked = || (0..rows.len()).filter(|row| rows[*row] == Hold::Objective);
        let asking = asked().filter(|_| self.counting != RowSelection::Fixed);
        let limits = active.iter().filter(|limit| give[**limit] == 0.0);
        let firm: Vec<FirmRow> = asking
            .map(FirmRow::Objective)
            .chain(fixed.iter().copied().map(FirmRow::Fixed))
            .chain(limits.copied().map(FirmRow::Limit))
            .collect();
        let trace: f64 = asked().map(|row| dot(jacobian.row(row), jacobian.row(row))).sum();
        // What is firm comes first: residuals ask more softly than it is rounded.
        let is_asked_alone = firm.iter().all(|row| matches!(row, FirmRow::Objective(_)));
        let asking = if is_asked_alone { self.mu } else { self.mu.max(MIN_MU_BESIDE_LIMITS * trace) };
        let mut all = Matrix::zero(firm.len(), jacobian.columns);
        let (mut right, mut softness) = (Vec::new(), Vec::new());
        for (k, row) in firm.iter().enumerate() {
            let (a, wanted) = match *row {
                FirmRow::Objective(row) | FirmRow::Fixed(row) => (jacobian.row(row), self.wanted[row]),
                FirmRow::Limit(limit) => (slopes.row(limit), self.floor[limit]),
            };
            if let Some((lower, rest)) = &soft
                && work.spend(square(jacobian.columns))
            {
                all.row_mut(k).copy_from_slice(&solve_lower(lower, a));
                right.push(wanted - dot(a, rest));
            } else {
                all.row_mut(k).copy_from_slice(a);
                right.push(wanted);
            }
            let is_asked = matches!(row, FirmRow::Objective(_));
            softness.push(if is_asked { asking } else { LIMIT_TOLERANCE * dot(a, a) + MIN_MU });
        }
        let mut normal = all.times_transposed(&all, work);
        softness.iter().enumerate().for_each(|(k, mu)| *normal.at(k, k) += mu);
        let weights = solve_symmetric(normal, right, work);
        let mut y = all.transposed_times(&weights);
        if let Some((lower, rest)) = &soft {
            y = solve_lower_transposed(lower, &y);
            y.iter_mut().zip(rest).for_each(|(y, rest)| *y += rest);
        }
        let mut of_rows = vec![0.0; rows.len()];
        let mut of_limits = vec![0.0; slopes.rows];
        for (row, weight) in firm.iter().zip(weights) {
            match *row {
                FirmRow::Objective(row) | FirmRow::Fixed(row) => of_rows[row] = weight,
                FirmRow::Limit(limit) => of_limits[limit] = weight,
            }
        }
        let pull_of = |&limit: &usize| {
            if give[limit] > 0.0 {
                (self.floor[limit] - dot(slopes.row(limit), &y)) / give[limit]
            } else {
                of_limits[limit]
            }
        };
        let pulls = active.iter().map(pull_of).collect();
        (y, of_rows, pulls)
    }
}

/// A row that is firm.
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

    /// The same with further rows, `y . row = 0`.
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
        let residual: Vec<f64> = (0..rows.len()).map(|row| if row == 0 { residual } else { 0.0 }).collect();
        let limits: Vec<f64> = limits.iter().map(|(value, _)| *value).collect();
        smallest_step(
            &[0.0, 0.0],
            &linear,
            Values { residual: &residual, limits: &limits, counting: RowSelection::All },
            1e-12,
        )
        .0
    }

    fn near(y: &[f64], expected: [f64; 2]) {
        assert!(y.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{y:?} is not {expected:?}");
    }

    /// Of all points on a line the one nearest to 0; with a wall the one at the wall; and where the wall stands before the
    /// line, as near as the wall lets it.
    #[test]
    fn the_smallest_step_keeps_within_limits() {
        near(&step(-2.0, &[]), [1.0, 1.0]);
        near(&step(-2.0, &[(0.25, [-1.0, 0.0])]), [0.25, 1.75]);
        // A limit that is far away changes nothing.
        near(&step(-2.0, &[(5.0, [-1.0, 0.0])]), [1.0, 1.0]);
        near(&step(-2.0, &[(0.25, [-1.0, 0.0]), (0.5, [0.0, -1.0])]), [0.25, 0.5]);
        // One that is broken is mended first.
        near(&step(-2.0, &[(-0.5, [-1.0, 0.0])]), [-0.5, 2.5]);
    }

    /// What is fixed stays, whatever is asked; what is soft gives way by what it costs: with `a = 2 - b`, the least of
    /// `a^2 + b^2 + b^2 / give` has `b = 2 give / (1 + 2 give)`.
    #[test]
    fn pins_hold() {
        near(&pinned(-2.0, &[], &[(Hold::Fixed, [0.0, 1.0])]), [2.0, 0.0]);
        near(&pinned(-2.0, &[], &[(Hold::Fixed, [1.0, 1.0])]), [0.0, 0.0]);
        near(&pinned(-2.0, &[(1.5, [-1.0, 0.0])], &[(Hold::Fixed, [0.0, 1.0])]), [1.5, 0.0]);
        near(&pinned(-2.0, &[], &[(Hold::Soft(0.25), [0.0, 1.0])]), [2.0 - 1.0 / 3.0, 1.0 / 3.0]);
    }
}
