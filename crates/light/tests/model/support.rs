//! What several tests need.

use light::parameters::{CONE_ANGLE, CONE_SOFTNESS};
use light::{CrossFalloff, Light};

/// The profile of a spotlight of so many degrees and that softness.
pub fn profile(cone_angle: f64, cone_softness: f64) -> CrossFalloff {
    CrossFalloff::of(&Light::spot().with(CONE_ANGLE, cone_angle).with(CONE_SOFTNESS, cone_softness))
}
