//! Quantiles of measured values.

use serde::Serialize;

/// Quantiles of measured values, in the unit of the values. Each is one of the values, or 0 if there are none. JSON has
/// null for infinite ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    pub count: u64,
    /// Minimum. For run times it is the value that other work has disturbed least.
    pub min: f64,
    /// Median.
    pub p50: f64,
    pub p95: f64,
    pub p99: f64,
    pub p999: f64,
    pub max: f64,
}

impl Quantiles {
    /// Computes the quantiles of values in any order.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let index = (share * values.len() as f64).ceil() as usize;
            values.get(index.saturating_sub(1)).copied().unwrap_or(0.0)
        };
        Self::from_shares(values.len() as u64, at)
    }

    /// Makes quantiles of `count` values; `at(share)` returns the value that this share of all values does not exceed.
    pub fn from_shares(count: u64, at: impl Fn(f64) -> f64) -> Self {
        Self { count, min: at(0.0), p50: at(0.5), p95: at(0.95), p99: at(0.99), p999: at(0.999), max: at(1.0) }
    }

    /// Returns the ratio of each quantile to that of `other`.
    pub(crate) fn over(&self, other: &Self) -> Self {
        Self {
            count: self.count,
            min: self.min / other.min,
            p50: self.p50 / other.p50,
            p95: self.p95 / other.p95,
            p99: self.p99 / other.p99,
            p999: self.p999 / other.p999,
            max: self.max / other.max,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_were_measured() {
        let hundred = Quantiles::of((1..=100).rev().map(f64::from));
        let Quantiles { count, min, p50, p95, p99, p999, max } = hundred;
        assert_eq!((count, [min, p50, p95, p99, p999, max]), (100, [1.0, 50.0, 95.0, 99.0, 100.0, 100.0]));
        assert_eq!(Quantiles::of([7.0]), Quantiles::from_shares(1, |_| 7.0));
        assert_eq!(Quantiles::of([]), Quantiles::default());
        assert_eq!(hundred.over(&hundred).p95, 1.0);
    }
}
