//! What a light's cross-section looks like.

use super::own_value;
use crate::lanes::{Lanes, choose};
use crate::parameters::{CROSS_SECTION, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH};
use crate::{CrossSection, Light};

/// The outline across a light, in radii: how far out a place lies as a share of the way to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SectionOutline {
    /// The circle of radius 1.
    Circle,
    /// The superellipse `(|v| / a)^p + (|w| / b)^p = 1` (Barzel), which lies in that circle: what would reach past it is
    /// made smaller as a whole, so that a tube that does not fold stays one that does not.
    Superellipse {
        /// `1 / a` and `1 / b`.
        scale: [f64; 2],
        /// `p`, 2 or more; infinite for a rectangle.
        power: f64,
    },
}

impl SectionOutline {
    /// The outline of a checked light.
    pub fn of(light: &Light) -> Self {
        match own_value(light, CROSS_SECTION) {
            None | Some(CrossSection::Circle) => Self::Circle,
            Some(CrossSection::Superellipse) => {
                let half = [light.get(SECTION_WIDTH), light.get(SECTION_HEIGHT)];
                let power = 2.0 / light.get(SECTION_ROUNDNESS);
                let shrunk = max_extent(half, power).max(1.0);
                Self::Superellipse { scale: half.map(|half| shrunk / half), power }
            }
        }
    }

    /// The square of how far out a place lies, 1 on the outline.
    #[inline(always)]
    pub fn rho2<F: Lanes>(&self, v: F, w: F) -> F {
        let Self::Superellipse { scale, power } = *self else { return v * v + w * w };
        let (x, y) = (v.abs() * F::of(scale[0]), w.abs() * F::of(scale[1]));
        // The larger apart, so that no power leaves the range of numbers.
        let (most, least) = (x.most(y), x.least(y));
        let share = choose!(F, most.gt(F::of(0.0)), least / most, F::of(0.0));
        let rho = most * (F::of(1.0) + share.pow(power)).pow(power.recip());
        rho * rho
    }
}

/// How far from its middle the superellipse with those half extents reaches: the greatest of `|a^2 X + b^2 Y|` over
/// `X^(p/2) + Y^(p/2) = 1`, which Hölder's inequality has as the norm of `(a^2, b^2)` with the exponent `q = p / (p - 2)`.
fn max_extent([a, b]: [f64; 2], power: f64) -> f64 {
    let q = if power.is_infinite() { 1.0 } else { power / (power - 2.0) };
    let (most, least) = (a.max(b), a.min(b));
    if q.is_infinite() {
        return most;
    }
    most * libm::pow(1.0 + libm::pow(least / most, 2.0 * q), 0.5 / q)
}
