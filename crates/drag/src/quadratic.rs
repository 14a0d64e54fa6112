//! The step that a solver takes: the smallest change that fulfils what is linear about the present place.

/// A dense matrix, row by row.
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

    pub fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.values[row * self.columns + column]
    }

    /// Its product with a column.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..self.rows).map(|row| dot(self.row(row), x)).collect()
    }

    /// The product of its transpose with a column.
    pub fn transposed_times(&self, y: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.columns];
        for (row, y) in y.iter().enumerate() {
            for (sum, value) in sum.iter_mut().zip(self.row(row)) {
                *sum += value * y;
            }
        }
        sum
    }

    /// `A B^T`.
    fn times_transposed(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.rows, other.rows);
        for i in 0..self.rows {
            for j in 0..other.rows {
                *product.at(i, j) = dot(self.row(i), other.row(j));
            }
        }
        product
    }
}

/// The least `mu` beside limits, as a share of the trace of `J J^T`. What it leaves of a residual goes in further steps.
const SOFT_BESIDE_LIMITS: f64 = 1e-7;

/// The `mu` of a residual that does not count.
const UNHEARD: f64 = 1e200;

/// The least `mu`: what no change does anything to asks for nothing.
const LEAST: f64 = 1e-30;

/// To what share of their size limits are held.
const ROUNDED: f64 = 1e-14;

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn length(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// What is linear about a place `x`: residuals `residual + jacobian dx`, and limits that are to stay 0 or more, `limits +
/// slopes dx`. The values are given beside it, since they may be of a place nearby.
pub(crate) struct Linear {
    pub jacobian: Matrix,
    pub slopes: Matrix,
    /// How firmly each residual is held.
    pub rows: Vec<Hold>,
    /// How softly each limit gives way; 0 where it does not.
    pub give: Vec<f64>,
}

/// How firmly a residual is held at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Hold {
    /// As far as limits and what is fixed let it.
    Asked,
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
    pub counting: Counting,
}

/// Which residuals count; limits do that are not soft, and with [`Self::All`] those that are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Counting {
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
/// never let go. Soft rows have a `mu` of their own, in limits too, which then are springs on one side.
pub(crate) fn smallest(x: &[f64], linear: &Linear, values: Values, mu: f64) -> (Vec<f64>, Pulls) {
    let Linear { jacobian, slopes, give, .. } = linear;
    let Values { residual, limits, counting } = values;
    let wanted: Vec<f64> = jacobian.times(x).iter().zip(residual).map(|(a, b)| a - b).collect();
    let floor: Vec<f64> = slopes.times(x).iter().zip(limits).map(|(a, b)| a - b).collect();
    let mut active: Vec<usize> = Vec::new();
    let mut best: Option<(Vec<f64>, Pulls)> = None;
    for _ in 0..4 * limits.len() + 4 {
        let (y, weights) = with_active(linear, (&wanted, counting), &floor, &active, mu);
        let (of_rows, pulls) = weights.split_at(jacobian.rows);
        // A limit that holds the light back where it wants to go is let go of.
        let wrong = active.iter().enumerate().filter(|(k, _)| pulls[*k] < 0.0);
        if let Some((k, _)) = wrong.min_by(|a, b| pulls[a.0].total_cmp(&pulls[b.0])) {
            active.remove(k);
            continue;
        }
        let height = slopes.times(&y);
        let counts = |k: usize| give[k] == 0.0 || counting == Counting::All;
        let broken =
            (0..limits.len()).filter(|k| counts(*k) && !active.contains(k) && height[*k] < floor[*k] - 1e-12);
        let mut of_limits = vec![0.0; limits.len()];
        active
            .iter()
            .zip(pulls)
            .for_each(|(&k, pull)| of_limits[k] = if give[k] > 0.0 { 0.0 } else { *pull });
        best = Some((y, Pulls { rows: of_rows.to_vec(), limits: of_limits }));
        let Some(worst) = broken.min_by(|&a, &b| (height[a] - floor[a]).total_cmp(&(height[b] - floor[b])))
        else {
            break;
        };
        active.push(worst);
    }
    let still = || Pulls { rows: vec![0.0; jacobian.rows], limits: vec![0.0; limits.len()] };
    best.unwrap_or_else(|| (x.to_vec(), still()))
}

/// How residuals and limits pull at what changes: the multipliers of their rows, of limits 0 or more.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pulls {
    pub rows: Vec<f64>,
    pub limits: Vec<f64>,
}

/// The smallest `y` with the active limits at 0, and the multipliers of all rows and of those limits.
fn with_active(
    linear: &Linear,
    (wanted, counting): (&[f64], Counting),
    floor: &[f64],
    active: &[usize],
    mu: f64,
) -> (Vec<f64>, Vec<f64>) {
    let Linear { jacobian, slopes, rows, give } = linear;
    let count = jacobian.rows + active.len();
    let mut all = Matrix::zero(count, jacobian.columns);
    let mut right = Vec::with_capacity(count);
    for (row, wanted) in wanted.iter().enumerate() {
        (0..jacobian.columns).for_each(|column| *all.at(row, column) = jacobian.row(row)[column]);
        right.push(*wanted);
    }
    for (k, &limit) in active.iter().enumerate() {
        (0..jacobian.columns)
            .for_each(|column| *all.at(jacobian.rows + k, column) = slopes.row(limit)[column]);
        right.push(floor[limit]);
    }
    let mut normal = all.times_transposed(&all);
    let asked = || (0..jacobian.rows).filter(|row| rows[*row] == Hold::Asked);
    let trace: f64 = asked().map(|row| normal.row(row)[row]).sum();
    // What is firm comes first: residuals ask more softly than it is rounded.
    let is_firm = rows.contains(&Hold::Fixed) || active.iter().any(|limit| give[*limit] == 0.0);
    let asking = if is_firm { mu.max(SOFT_BESIDE_LIMITS * trace) } else { mu };
    for row in 0..count {
        let firm = ROUNDED * *normal.at(row, row) + LEAST;
        *normal.at(row, row) += match rows.get(row) {
            Some(Hold::Asked) if counting == Counting::Fixed => UNHEARD,
            Some(Hold::Asked) => asking,
            Some(Hold::Soft(_)) if counting != Counting::All => UNHEARD,
            Some(Hold::Soft(give)) => *give,
            Some(Hold::Fixed) => firm,
            None => firm.max(give[active[row - jacobian.rows]]),
        };
    }
    let weights = solved(normal, right);
    (all.transposed_times(&weights), weights)
}

/// The solution of a symmetric positive system, by elimination with pivots from the diagonal.
fn solved(mut matrix: Matrix, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    let mut order: Vec<usize> = (0..n).collect();
    for step in 0..n {
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
        let known: f64 =
            order[step + 1..].iter().map(|&column| matrix.row(row)[column] * solution[column]).sum();
        let diagonal = matrix.row(row)[row];
        solution[row] = if diagonal > 0.0 { (right[row] - known) / diagonal } else { 0.0 };
    }
    solution
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
        let linear = Linear {
            jacobian: matrix(&rows, 2),
            slopes: matrix(&limits.iter().map(|(_, slope)| &slope[..]).collect::<Vec<_>>(), 2),
            rows: std::iter::once(Hold::Asked).chain(pins.iter().map(|(hold, _)| *hold)).collect(),
            give: vec![0.0; limits.len()],
        };
        let residual: Vec<f64> = (0..rows.len()).map(|row| if row == 0 { residual } else { 0.0 }).collect();
        let limits: Vec<f64> = limits.iter().map(|(value, _)| *value).collect();
        smallest(
            &[0.0, 0.0],
            &linear,
            Values { residual: &residual, limits: &limits, counting: Counting::All },
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
