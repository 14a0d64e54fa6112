//! Emission of a light.

use crate::lanes::Lanes;

/// Returns colour times intensity, linear RGB. Negative components and a negative intensity count as 0.
#[inline(always)]
pub fn emission<F: Lanes>(color: F::Vec3, intensity: F) -> F::Vec3 {
    let zero = F::of(0.0);
    let [r, g, b] = F::coordinates(color);
    F::vec3([r.most(zero), g.most(zero), b.most(zero)]) * intensity.most(zero)
}
