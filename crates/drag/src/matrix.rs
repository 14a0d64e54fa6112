//! Dense linear algebra. A function that visits more than one row of a matrix counts its steps, and its result has no
//! meaning once the budget is spent.

use crate::work::WorkBudget;

/// Size of a row's remainder, as a share of the largest row, below which the row counts as a linear combination of the
/// others. The slopes come from finite differences with an error of 1e-10.
const DEPENDENT: f64 = 1e-8;

/// Dense matrix in row-major order.
#[derive(Clone, Debug)]
pub(crate) struct Matrix {
    pub rows: usize,
    pub columns: usize,
    values: Vec<f64>,
}

impl Matrix {
    pub fn zero(rows: usize, columns: usize) -> Self {
        Self { rows, columns, values: vec![0.0; rows * columns] }
    }

    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.columns..][..self.columns]
    }

    pub fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.values[row * self.columns..][..self.columns]
    }

    pub fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.values[row * self.columns + column]
    }

    /// Copies the rows of the selection.
    pub fn selected(&self, rows: &[usize]) -> Self {
        let values = rows.iter().flat_map(|row| self.row(*row)).copied().collect();
        Self { rows: rows.len(), columns: self.columns, values }
    }

    /// Copies the rows, followed by those of `other`.
    pub fn stacked(&self, other: &Self) -> Self {
        let values = self.values.iter().chain(&other.values).copied().collect();
        Self { rows: self.rows + other.rows, columns: self.columns, values }
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn length(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Adds `a` times `factor` to `sum`.
pub(crate) fn add_scaled(sum: &mut [f64], a: &[f64], factor: f64) {
    sum.iter_mut().zip(a).for_each(|(sum, value)| *sum += value * factor);
}

/// Computes `a - b`.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Computes `a` plus `factor` times `b`.
pub(crate) fn scaled_sum(a: &[f64], b: &[f64], factor: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// Selects a maximal set of independent rows among `among`. Each is the row with the largest remainder after
/// subtracting its components along those selected before.
pub(crate) fn independent_rows(matrix: &Matrix, among: &[usize], work: &WorkBudget) -> Vec<usize> {
    let mut left: Vec<Vec<f64>> = among.iter().map(|row| matrix.row(*row).to_vec()).collect();
    let mut chosen = Vec::new();
    let mut first = 0.0;
    while chosen.len() < matrix.columns.min(among.len()) {
        let sizes = left.iter().map(|row| dot(row, row)).enumerate();
        let Some((next, size)) = sizes.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        first = f64::max(first, size);
        if size <= DEPENDENT * DEPENDENT * first || !work.spend((3 * among.len() * matrix.columns) as u64) {
            break;
        }
        chosen.push(among[next]);
        let direction: Vec<f64> = left[next].iter().map(|value| value / size.sqrt()).collect();
        for row in &mut left {
            let along = dot(row, &direction);
            row.iter_mut().zip(&direction).for_each(|(value, direction)| *value -= along * direction);
        }
    }
    chosen.sort_unstable();
    chosen
}

/// Computes the lower triangle `L` of a symmetric positive matrix `L L^T`, by Cholesky's method.
pub(crate) fn cholesky(matrix: &Matrix, work: &WorkBudget) -> Matrix {
    let n = matrix.rows;
    let mut lower = Matrix::zero(n, n);
    for row in 0..n {
        if !work.spend((row * row / 2 + row) as u64) {
            break;
        }
        for column in 0..=row {
            let known = dot(&lower.row(row)[..column], &lower.row(column)[..column]);
            let left = matrix.row(row)[column] - known;
            *lower.at(row, column) =
                if row == column { left.max(0.0).sqrt() } else { left / lower.row(column)[column] };
        }
    }
    lower
}

/// Computes `L^-1 x`.
pub(crate) fn solve_lower(lower: &Matrix, x: &[f64]) -> Vec<f64> {
    let mut y = x.to_vec();
    for row in 0..y.len() {
        let known = dot(&lower.row(row)[..row], &y[..row]);
        y[row] = (y[row] - known) / lower.row(row)[row];
    }
    y
}

/// Computes `L^-T x`.
pub(crate) fn solve_lower_transposed(lower: &Matrix, x: &[f64]) -> Vec<f64> {
    let mut y = x.to_vec();
    for row in (0..y.len()).rev() {
        let known: f64 = (row + 1..y.len()).map(|below| lower.row(below)[row] * y[below]).sum();
        y[row] = (y[row] - known) / lower.row(row)[row];
    }
    y
}

/// Solves a symmetric positive system, by elimination with pivots from the diagonal.
pub(crate) fn solve_symmetric(mut matrix: Matrix, mut right: Vec<f64>, work: &WorkBudget) -> Vec<f64> {
    let n = right.len();
    let mut order: Vec<usize> = (0..n).collect();
    for step in 0..n {
        if !work.spend(2 * ((n - step) * (n - step)) as u64) {
            break;
        }
        let pivot = (step..n)
            .max_by(|&a, &b| {
                let (a, b) = (order[a], order[b]);
                matrix.row(a)[a].total_cmp(&matrix.row(b)[b])
            })
            .unwrap_or(step);
        order.swap(step, pivot);
        let p = order[step];
        let diagonal = matrix.row(p)[p];
        if diagonal <= 0.0 {
            continue;
        }
        for &row in &order[step + 1..] {
            let factor = matrix.row(row)[p] / diagonal;
            for &column in &order[step..] {
                let above = matrix.row(p)[column];
                *matrix.at(row, column) -= factor * above;
            }
            right[row] -= factor * right[p];
        }
    }
    let mut solution = vec![0.0; n];
    for step in (0..n).rev() {
        let row = order[step];
        let known: f64 = order[step + 1..].iter().map(|&column| matrix.row(row)[column] * solution[column]).sum();
        let diagonal = matrix.row(row)[row];
        solution[row] = if diagonal > 0.0 { (right[row] - known) / diagonal } else { 0.0 };
    }
    solution
}
