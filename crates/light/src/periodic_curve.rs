//! Numbers that vary around an axis.

/// Maximum number of knots of a periodic curve.
pub const MAX_KNOTS: usize = 16;

/// Number over an angle in degrees: linear from knot to knot, and from the last knot around to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicCurve {
    knots: Vec<[f64; 2]>,
}

/// Linear piece between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearPiece {
    /// Start in degrees. The piece ends where the next one starts.
    pub start_degrees: f64,
    /// Numbers at both ends.
    pub values: [f64; 2],
    /// 1 over its length in degrees.
    pub inverse_length: f64,
}

impl PeriodicCurve {
    /// Makes the curve through `knots`, each `[degrees, number]`; `None` if there are none. [`crate::Parameter::check`]
    /// checks their order and range.
    pub fn new(knots: Vec<[f64; 2]>) -> Option<Self> {
        (!knots.is_empty()).then_some(Self { knots })
    }

    /// Knots, each `[degrees, number]`.
    pub fn knots(&self) -> &[[f64; 2]] {
        &self.knots
    }

    /// Returns true if the degrees ascend from 0 to less than 360.
    pub(crate) fn is_ascending(&self) -> bool {
        let is_on_the_circle = self.knots.iter().all(|[degrees, _]| (0.0..360.0).contains(degrees));
        is_on_the_circle && self.knots.is_sorted_by(|[a, _], [b, _]| a < b)
    }

    /// Returns the pieces in order, one more than there are knots. The first begins at the last knot, one turn before,
    /// so that the pieces cover all angles from 0 to 360 degrees.
    pub fn pieces(&self) -> Vec<LinearPiece> {
        let (Some([first, first_value]), Some([last, last_value])) = (self.knots.first(), self.knots.last()) else {
            return Vec::new();
        };
        let around = [[last - 360.0, *last_value]].into_iter().chain(self.knots.iter().copied());
        let next = self.knots.iter().copied().chain([[first + 360.0, *first_value]]);
        let piece = |([from, value], [to, next_value]): ([f64; 2], [f64; 2])| LinearPiece {
            start_degrees: from,
            values: [value, next_value],
            inverse_length: 1.0 / (to - from),
        };
        around.zip(next).map(piece).collect()
    }
}
