//! Helpers that several tests share.

use light::parameters::{CONE_ANGLE, CONE_SOFTNESS};
use light::{CrossFalloff, Light};

/// Returns the profile of a spotlight with a cone angle in degrees and a softness.
pub fn profile(cone_angle: f64, cone_softness: f64) -> CrossFalloff {
    CrossFalloff::of(&Light::spot().with(CONE_ANGLE, cone_angle).with(CONE_SOFTNESS, cone_softness))
}
