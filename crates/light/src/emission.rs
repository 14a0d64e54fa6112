//! What leaves a light.

use crate::lanes::Lanes;

/// Colour times intensity, neither below zero, linear RGB.
#[inline(always)]
pub fn emission<F: Lanes>(color: F::Vec3, intensity: F) -> F::Vec3 {
    let zero = F::of(0.0);
    let [r, g, b] = F::coordinates(color);
    F::vec3([r.most(zero), g.most(zero), b.most(zero)]) * intensity.most(zero)
}
