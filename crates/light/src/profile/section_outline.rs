//! Outline of a light's cross-section.

use super::own_value;
use crate::lanes::{Lanes, choose};
use crate::parameters::{CROSS_SECTION, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH};
use crate::{CrossSection, Light};

/// Outline across a light, in radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SectionOutline {
    /// Circle of radius 1.
    Circle,
    /// Superellipse `(|v| / a)^p + (|w| / b)^p = 1` (Barzel) inside that circle. A larger one is scaled down as a
    /// whole, so that a tube that does not fold still does not fold.
    Superellipse {
        scale: [f64; 2],
        /// Exponent `p`, 2 or more; infinite for a rectangle.
        power: f64,
    },
}

impl SectionOutline {
    /// Makes an outline of a checked light.
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

    /// Returns the square of the distance from the axis, as a share of the distance to the outline: 1 on the outline.
    #[inline(always)]
    pub fn rho2<F: Lanes>(&self, v: F, w: F) -> F {
        let Self::Superellipse { scale, power } = *self else { return v * v + w * w };
        let (x, y) = (v.abs() * F::of(scale[0]), w.abs() * F::of(scale[1]));
        // The larger one is factored out, so that no power overflows.
        let (most, least) = (x.most(y), x.least(y));
        let share = choose!(F::select, most.gt(F::of(0.0)), least / most, F::of(0.0));
        let rho = most * (F::of(1.0) + share.pow(power)).pow(power.recip());
        rho * rho
    }
}

/// Returns the maximum distance of the superellipse with those half extents from its centre: the greatest of `|a^2 X +
/// b^2 Y|` over `X^(p/2) + Y^(p/2) = 1`, which by Hölder's inequality is the norm of `(a^2, b^2)` with the exponent `q
/// = p / (p - 2)`.
fn max_extent([a, b]: [f64; 2], power: f64) -> f64 {
    let q = if power.is_infinite() { 1.0 } else { power / (power - 2.0) };
    let (most, least) = (a.max(b), a.min(b));
    if q.is_infinite() {
        return most;
    }
    most * libm::pow(1.0 + libm::pow(least / most, 2.0 * q), 0.5 / q)
}
