//! Falloff along a light path.

use super::own_value;
use crate::lanes::Lanes;
use crate::parameters::{CUT_OFF, CUT_ON, FAR_EDGE, NEAR_EDGE};
use crate::{Decay, Light};

/// Distances at which light begins and ends (Barzel's cut-on and cut-off), as two ramps of the path length `s` in world
/// units: `smooth((s - on_start) / on_width) (1 - smooth((s - off_start) / off_width))`, `smooth(x) = x^2 (3 - 2 x)`
/// over 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceRamps {
    /// Distance at which light begins to increase.
    pub on_start: f64,
    /// 1 over the length of the increase; infinite for a step.
    pub on_inverse_width: f64,
    /// Distance at which light begins to decrease.
    pub off_start: f64,
    /// 1 over the length of the decrease; infinite for a step, 0 if light never decreases.
    pub off_inverse_width: f64,
}

impl DistanceRamps {
    /// No cut: every path length lies past the first ramp and before the second.
    pub const NONE: Self = Self { on_start: -1.0, on_inverse_width: 1.0, off_start: 0.0, off_inverse_width: 0.0 };

    /// Cuts of a checked light.
    pub fn of(light: &Light) -> Self {
        let mut cut = Self::NONE;
        if let Some(on) = own_value(light, CUT_ON).flatten() {
            let width = light.get(NEAR_EDGE);
            (cut.on_start, cut.on_inverse_width) = (on - width, width.recip());
        }
        if let Some(off) = own_value(light, CUT_OFF).flatten() {
            (cut.off_start, cut.off_inverse_width) = (off, light.get(FAR_EDGE).recip());
        }
        cut
    }

    /// Returns the share of the light that remains at the path length `s`.
    #[inline(always)]
    pub fn at<F: Lanes>(&self, s: F) -> F {
        ramp(s - F::of(self.on_start), F::of(self.on_inverse_width))
            * (F::of(1.0) - ramp(s - F::of(self.off_start), F::of(self.off_inverse_width)))
    }
}

/// Returns the ramp from 0 to 1 over the first `1 / inverse_width`. It is 0 at 0 itself, however steep.
#[inline(always)]
fn ramp<F: Lanes>(beyond: F, inverse_width: F) -> F {
    let (zero, one) = (F::of(0.0), F::of(1.0));
    let x = F::select(beyond.gt(zero), (beyond * inverse_width).least(one), zero);
    x * x * (F::of(3.0) - F::of(2.0) * x)
}

impl Decay {
    /// Coefficients `[x, y, z]` of the factor `1 / (x + y s + z s^2)` of the path length `s`.
    pub fn denominator_coefficients(self) -> [f64; 3] {
        match self {
            Self::None => [1.0, 0.0, 0.0],
            Self::Linear => [0.0, 1.0, 0.0],
            Self::InverseSquare => [0.0, 0.0, 1.0],
        }
    }

    /// Returns the factor at the path length `s`.
    #[inline(always)]
    pub fn at<F: Lanes>(self, s: F) -> F {
        match self {
            Self::None => F::of(1.0),
            Self::Linear => F::of(1.0) / s,
            Self::InverseSquare => F::of(1.0) / (s * s),
        }
    }
}
