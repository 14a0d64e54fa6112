//! Warnings about lights that are usable.

use std::fmt;

use crate::Tube;
use crate::overlap::TubeOverlap;

/// Property of a valid light that may surprise an artist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightWarning {
    /// Corner of the curve, where two control points coincide: no light reaches the wedge outside it.
    Corner {
        /// Global t of the joint.
        t: f64,
    },
    /// Overlap of distant parts of the tube: a point in both is lit by the one with the smaller `|r| / R`.
    Overlap {
        /// Global t of a point in one part.
        t: f64,
        /// Global t of the same point in the other part.
        other_t: f64,
    },
}

impl fmt::Display for LightWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Corner { t } => {
                write!(f, "the curve has a corner at t = {t}, and no light reaches the wedge outside it")
            }
            Self::Overlap { t, other_t } => write!(
                f,
                "the tube overlaps itself near t = {t:.2} and t = {other_t:.2}: points there are lit from one part only"
            ),
        }
    }
}

impl Tube<f64> {
    /// Returns warnings about the light. At most one overlap is reported, as [`Self::overlap()`] finds it.
    pub fn warnings(&self) -> Vec<LightWarning> {
        let corners = self.segments.windows(2).enumerate().filter_map(|(i, pair)| {
            let cos = pair[0].curve.u_hat(1.0).dot(pair[1].curve.u_hat(0.0));
            (cos < 1.0 - 1e-9).then_some(LightWarning::Corner { t: (i + 1) as f64 })
        });
        let overlap = self.overlap(0.0).map(|TubeOverlap { t, other_t, .. }| LightWarning::Overlap { t, other_t });
        corners.chain(overlap).collect()
    }
}
