//! Warnings about lights that are usable.

use std::f64::consts::TAU;
use std::fmt;

use crate::Tube;

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

/// Number of points along a segment that are tested for overlaps.
const ALONG: usize = 16;
/// Number of points around the axis that are tested for overlaps.
const AROUND: usize = 12;

impl Tube<f64> {
    /// Returns warnings about the light. Overlaps are searched on a grid, at the rim of the tube and on its axis: one
    /// narrower than a sixteenth of a segment may be missed. At most one overlap is reported.
    pub fn warnings(&self) -> Vec<LightWarning> {
        let corners = self.segments.windows(2).enumerate().filter_map(|(i, pair)| {
            let cos = pair[0].curve.u_hat(1.0).dot(pair[1].curve.u_hat(0.0));
            (cos < 1.0 - 1e-9).then_some(LightWarning::Corner { t: (i + 1) as f64 })
        });
        corners.chain(self.overlap()).collect()
    }

    fn overlap(&self) -> Option<LightWarning> {
        (0..self.n * ALONG).find_map(|k| {
            let (i, u) = (k / ALONG, (k % ALONG) as f64 / ALONG as f64);
            let curve = &self.segments[i].curve;
            let (v_hat, w_hat) = self.cross_section(curve, curve.u_hat(u));
            (0..=AROUND).find_map(|around| {
                let (sin, cos) = libm::sincos(TAU * around as f64 / AROUND as f64);
                // The last point is on the axis. The others avoid the rounding at the rim.
                let rho = if around == AROUND { 0.0 } else { 0.999 * curve.radius(u) };
                let q = curve.position(u) + (v_hat * cos + w_hat * sin) * rho;
                let t = i as f64 + u;
                let mut other = None;
                self.for_each_root(q, |root| {
                    let other_t = root.segment as f64 + root.u;
                    if (other_t - t).abs() > 1e-6 {
                        other = Some(other_t);
                    }
                });
                other.map(|other_t| LightWarning::Overlap { t, other_t })
            })
        })
    }
}
