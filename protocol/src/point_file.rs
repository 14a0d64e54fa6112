//! Point files: a JSON array of world positions `[x, y, z]`.

use glam::DVec3;
use serde_json::value::RawValue;

use crate::FileError;
use crate::error::from_json;

/// World position, with the precision of its text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrittenPoint {
    pub position: DVec3,
    /// Unit of the last digit of the coordinate with the most decimals: 0.001 for `[1, 2.5, 0.250]`. Trailing
    /// zeros count.
    pub last_digit: f64,
}

/// Parses the text of a point file.
pub fn parse(text: &str) -> Result<Vec<WrittenPoint>, FileError> {
    let points: Vec<[f64; 3]> = from_json(text)?;
    let written: Vec<[&RawValue; 3]> = serde_json::from_str(text).map_err(FileError::Syntax)?;
    let last_digit =
        |texts: [&RawValue; 3]| texts.map(|text| last_digit(text.get())).into_iter().fold(f64::INFINITY, f64::min);
    let points = points.into_iter().zip(written);
    Ok(points
        .map(|(point, written)| WrittenPoint { position: point.into(), last_digit: last_digit(written) })
        .collect())
}

/// Returns the unit of the last digit of a JSON number.
fn last_digit(number: &str) -> f64 {
    let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    // A number whose exponent does not fit i32 is zero, or rounds to zero.
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let exponent = exponent.saturating_sub(i32::try_from(decimals).unwrap_or(i32::MAX));
    format!("1e{exponent}").parse().expect("a power of ten")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_count_as_they_are_written() {
        let written = parse("[[1, 2.5, 0.250], [1e2, -3.25E-2, 4], [7, 0, 8], [0.1, 0e9, 1e+1]]").unwrap();
        let found: Vec<f64> = written.iter().map(|point| point.last_digit).collect();
        for (found, expected) in found.into_iter().zip([1e-3, 1e-4, 1.0, 0.1]) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} for {expected}");
        }
        assert_eq!(written[1].position, DVec3::new(100.0, -0.0325, 4.0));
    }
}
