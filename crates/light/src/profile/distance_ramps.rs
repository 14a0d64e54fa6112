//! What becomes of light along its way.

use super::own_value;
use crate::lanes::Lanes;
use crate::parameters::{CUT_OFF, CUT_ON, FAR_EDGE, NEAR_EDGE};
use crate::{Decay, Light};

/// Where along its way light begins and ends (Barzel's cut-on and cut-off), as two ramps of the path length `s` in world
/// units: `smooth((s - on_start) / on_width) (1 - smooth((s - off_start) / off_width))`, `smooth(x) = x^2 (3 - 2 x)` over
/// 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceRamps {
    /// Where light begins to come up.
    pub on_start: f64,
    /// 1 over the length in which it does; infinite for a step.
    pub on_inverse_width: f64,
    /// Where light begins to go.
    pub off_start: f64,
    /// 1 over the length in which it does; infinite for a step, 0 where it never goes.
    pub off_inverse_width: f64,
}

impl DistanceRamps {
    /// No cut at all: every path length lies past the first ramp and before the second.
    pub const NONE: Self =
        Self { on_start: -1.0, on_inverse_width: 1.0, off_start: 0.0, off_inverse_width: 0.0 };

    /// The cuts of a checked light.
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

    /// The share of light that is there at the path length `s`.
    #[inline(always)]
    pub fn at<F: Lanes>(&self, s: F) -> F {
        ramp(s - F::of(self.on_start), F::of(self.on_inverse_width))
            * (F::of(1.0) - ramp(s - F::of(self.off_start), F::of(self.off_inverse_width)))
    }
}

/// From 0 to 1 over the first `1 / inverse_width`; nothing at 0 itself, however steep.
#[inline(always)]
fn ramp<F: Lanes>(past: F, inverse_width: F) -> F {
    let (zero, one) = (F::of(0.0), F::of(1.0));
    let x = F::select(past.gt(zero), (past * inverse_width).least(one), zero);
    x * x * (F::of(3.0) - F::of(2.0) * x)
}

impl Decay {
    /// The factor `1 / (x + y s + z s^2)` of the path length `s` as `[x, y, z]`.
    pub fn denominator_coefficients(self) -> [f64; 3] {
        match self {
            Self::None => [1.0, 0.0, 0.0],
            Self::Linear => [0.0, 1.0, 0.0],
            Self::InverseSquare => [0.0, 0.0, 1.0],
        }
    }

    /// That factor.
    #[inline(always)]
    pub fn at<F: Lanes>(self, s: F) -> F {
        match self {
            Self::None => F::of(1.0),
            Self::Linear => F::of(1.0) / s,
            Self::InverseSquare => F::of(1.0) / (s * s),
        }
    }
}
