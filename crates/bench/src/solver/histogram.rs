//! Quantiles of any number of values in constant memory.

use serde::{Serialize, Serializer};

use crate::Quantiles;

/// Values per doubling: bins are 4 % wide.
const BINS_AN_OCTAVE: f64 = 16.0;
/// The smallest value that is distinct from zero is `2^-LOWEST`.
const LOWEST: f64 = 120.0;
const BINS: usize = 160 * BINS_AN_OCTAVE as usize;

/// Histogram of values from 2^-120 to 2^40; smaller ones count as zero.
#[derive(Clone, Debug)]
pub struct Histogram {
    bins: Vec<u64>,
    count: u64,
    max: f64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { bins: vec![0; BINS], count: 0, max: 0.0 }
    }
}

impl Histogram {
    /// Counts a value, zero or more.
    pub fn record(&mut self, value: f64) {
        let bin = ((value.log2() + LOWEST) * BINS_AN_OCTAVE).ceil();
        self.bins[(bin.max(0.0) as usize).min(BINS - 1)] += 1;
        self.count += 1;
        self.max = self.max.max(value);
    }

    /// Adds the counts of another histogram.
    pub fn add(&mut self, other: &Self) {
        self.bins.iter_mut().zip(&other.bins).for_each(|(bin, other)| *bin += other);
        self.count += other.count;
        self.max = self.max.max(other.max);
    }

    /// Returns the value that a `share` of all values does not exceed, at most 4 % too large; 0 if there are none.
    pub fn quantile(&self, share: f64) -> f64 {
        let wanted = (share * self.count as f64).ceil() as u64;
        let mut seen = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                let upper = (bin as f64 / BINS_AN_OCTAVE - LOWEST).exp2();
                return if bin == 0 { 0.0 } else { upper.min(self.max) };
            }
        }
        self.max
    }

    /// Returns the quantiles of all values, at most 4 % too large.
    pub fn quantiles(&self) -> Quantiles {
        Quantiles::from_shares(self.count, |share| self.quantile(share))
    }
}

impl Serialize for Histogram {
    /// Serializes the quantiles.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.quantiles().serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::Histogram;

    #[test]
    fn quantiles_are_within_a_bin() {
        let (mut low, mut high) = (Histogram::default(), Histogram::default());
        (1..=600).for_each(|k| low.record(f64::from(k)));
        (601..=1000).for_each(|k| high.record(f64::from(k)));
        low.add(&high);
        for (share, exact) in [(0.5, 500.0), (0.999, 999.0)] {
            let quantile = low.quantile(share);
            assert!((exact..=1.045 * exact).contains(&quantile), "{share}: {quantile}");
        }
        assert_eq!(low.quantiles().max, 1000.0);
        assert_eq!(Histogram::default().quantile(0.5), 0.0);
        low.record(0.0);
        assert_eq!(low.quantile(0.0), 0.0);
    }
}
