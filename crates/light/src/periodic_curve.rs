//! A number that varies around an axis.

/// Most knots that such a curve has.
pub const MAX_KNOTS: usize = 16;

/// A number over an angle in degrees: linear from knot to knot, and from the last one on around to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicCurve {
    knots: Vec<[f64; 2]>,
}

/// The way from one knot to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearPiece {
    /// Degrees at which it begins. It goes on to where the next one does.
    pub start_degrees: f64,
    /// The numbers at its two ends.
    pub values: [f64; 2],
    /// 1 over the degrees that it is long.
    pub inverse_length: f64,
}

impl PeriodicCurve {
    /// The curve through `knots`, each `[degrees, number]`; `None` where there are none. Whether they are in order and in
    /// range is for [`crate::Parameter::check`] to say.
    pub fn new(knots: Vec<[f64; 2]>) -> Option<Self> {
        (!knots.is_empty()).then_some(Self { knots })
    }

    /// The knots, each `[degrees, number]`.
    pub fn knots(&self) -> &[[f64; 2]] {
        &self.knots
    }

    /// Whether the degrees ascend from 0 to less than 360.
    pub(crate) fn is_ascending(&self) -> bool {
        let is_on_the_circle = self.knots.iter().all(|[degrees, _]| (0.0..360.0).contains(degrees));
        is_on_the_circle && self.knots.is_sorted_by(|[a, _], [b, _]| a < b)
    }

    /// One piece more than there are knots, in order: the first begins at the last knot, a turn before, so that they hold all
    /// angles from 0 to 360 degrees.
    pub fn pieces(&self) -> Vec<LinearPiece> {
        let (Some([first, first_value]), Some([last, last_value])) = (self.knots.first(), self.knots.last())
        else {
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
