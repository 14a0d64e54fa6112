//! What an artist should know of a light that is usable all the same.

use std::f64::consts::TAU;
use std::fmt;

use crate::Tube;

/// Something about a valid light that may surprise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightWarning {
    /// The curve has a corner, where two control points coincide: no point in the wedge outside it is lit.
    Corner {
        /// Global t of the joint.
        t: f64,
    },
    /// Distant parts of the tube overlap: a point in both is lit by the one with the smaller `|r| / R`.
    Overlap {
        /// Global t of a place in one part.
        t: f64,
        /// Global t of the same place in the other.
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

/// Places tried along a segment, and around it.
const ALONG: usize = 16;
/// See [`ALONG`].
const AROUND: usize = 12;

impl Tube<f64> {
    /// What should be known of this light. Overlaps are looked for at the rim of the tube and on its axis, on
    /// a grid: one narrower than a sixteenth of a segment may go unseen. At most one overlap is reported.
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
                // The last one is the axis; the others stay clear of the rim's own rounding.
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
