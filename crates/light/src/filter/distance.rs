//! What becomes of light along its way.

use super::own;
use crate::parameters::{CUT_OFF, CUT_ON, FAR_EDGE, NEAR_EDGE};
use crate::{Decay, Light};

/// Where along its way light begins and ends (Barzel's cut-on and cut-off), as two ramps of the path length `s` in world
/// units: `smooth((s - on_start) / on_width) (1 - smooth((s - off_start) / off_width))`, `smooth(x) = x^2 (3 - 2 x)` over
/// 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Where light begins to come up.
    pub on_start: f64,
    /// 1 over the length in which it does; infinite for a step.
    pub on_inverse_width: f64,
    /// Where light begins to go.
    pub off_start: f64,
    /// 1 over the length in which it does; infinite for a step, 0 where it never goes.
    pub off_inverse_width: f64,
}

impl Cut {
    /// No cut at all: every path length lies past the first ramp and before the second.
    pub const NONE: Self =
        Self { on_start: -1.0, on_inverse_width: 1.0, off_start: 0.0, off_inverse_width: 0.0 };

    /// The cuts of a checked light.
    pub fn of(light: &Light) -> Self {
        let mut cut = Self::NONE;
        if let Some(on) = own(light, CUT_ON).flatten() {
            let width = light.get(NEAR_EDGE);
            (cut.on_start, cut.on_inverse_width) = (on - width, width.recip());
        }
        if let Some(off) = own(light, CUT_OFF).flatten() {
            (cut.off_start, cut.off_inverse_width) = (off, light.get(FAR_EDGE).recip());
        }
        cut
    }

    /// The share of light that is there at the path length `s`.
    pub fn at(&self, s: f64) -> f64 {
        ramp(s - self.on_start, self.on_inverse_width)
            * (1.0 - ramp(s - self.off_start, self.off_inverse_width))
    }
}

/// From 0 to 1 over the first `1 / inverse_width`; nothing at 0 itself, however steep.
fn ramp(past: f64, inverse_width: f64) -> f64 {
    let x = if past > 0.0 { (past * inverse_width).min(1.0) } else { 0.0 };
    x * x * (3.0 - 2.0 * x)
}

impl Decay {
    /// The factor `1 / (x + y s + z s^2)` of the path length `s` as `[x, y, z]`.
    pub fn weights(self) -> [f64; 3] {
        match self {
            Self::None => [1.0, 0.0, 0.0],
            Self::Linear => [0.0, 1.0, 0.0],
            Self::InverseSquare => [0.0, 0.0, 1.0],
        }
    }

    /// That factor.
    pub fn at(self, s: f64) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Linear => 1.0 / s,
            Self::InverseSquare => 1.0 / (s * s),
        }
    }
}
