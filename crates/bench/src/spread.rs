//! Many times in two.

use serde::Serialize;

/// Milliseconds of the fastest and of the middle of many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Nothing but other work makes one slower than this.
    pub min: f64,
    /// Half are faster.
    pub median: f64,
}

impl Spread {
    /// Of values in any order; 0 of none.
    pub(crate) fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let middle = values.len().saturating_sub(1) / 2;
        Self {
            min: values.first().copied().unwrap_or(0.0),
            median: values.get(middle).copied().unwrap_or(0.0),
        }
    }
}
