//! What becomes of light on its way (light model, section 6): functions of the place alone, for lights of every
//! shape.

use glam::DVec3;

use crate::parameters::{CONE_ANGLE, CONE_SOFTNESS, DECAY, EXPOSURE};
use crate::{Decay, Light, Place};

/// How bright a light is as a whole, and how it falls off across and along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFilter {
    /// Stops by which all of it is brightened.
    pub exposure: f64,
    /// Across the light.
    pub profile: Profile,
    /// Along it.
    pub decay: Decay,
    /// Light falls off no further nearer to its source, in world units: the source itself would be infinitely
    /// bright.
    pub least_distance: f64,
}

impl LightFilter {
    /// What a checked light does to what it emits.
    pub fn of(light: &Light, least_distance: f64) -> Self {
        Self {
            exposure: light.get(EXPOSURE),
            profile: Profile::new(light.get(CONE_ANGLE), light.get(CONE_SOFTNESS)),
            decay: light.get(DECAY),
            least_distance,
        }
    }
}

/// Irradiance on a surface square to the light, linear RGB, without visibility:
/// `emission 2^exposure profile(rho^2) decay(s)`.
pub fn irradiance(filter: &LightFilter, emission: DVec3, place: &Place) -> DVec3 {
    let rho2 = place.v * place.v + place.w * place.w;
    let falloff = filter.profile.at(rho2) * filter.decay.at(place.s.max(filter.least_distance));
    emission * (libm::exp2(filter.exposure) * falloff)
}

/// The smooth profile over `rho = |(v, w)|`: 1 inside, then an S-curve to 0 at the light's edge.
///
/// `rho` stands for the angle `theta = atan(rho tan coneAngle)` of a spotlight; the curve is `s^2 (3 - 2 s)`,
/// `s = (cos theta - cos outer) / (cos inner - cos outer)`, `inner = outer (1 - coneSoftness)`. Cosines, as
/// Real-Time Rendering's eq. 7.18 has them, need no inverse trigonometry, which GPUs do badly.
///
/// Computed from `1 - cos`, which does not cancel in a narrow cone, as shares of its value at the edge, which no
/// cone is too narrow for: with `x = tan^2 theta` and `h = sqrt(1 + x)`, `1 - cos theta = x / (h (1 + h))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// `tan^2 coneAngle`.
    pub tan2_outer: f64,
    /// `h (1 + h)` at the edge.
    pub edge: f64,
    /// 1 over the share of `1 - cos` at the edge by which it is less at the inner angle; 0 where they are equal, which
    /// makes the profile a step.
    pub inverse_span: f64,
}

impl Profile {
    /// The profile of a nominal half angle in degrees and its softness.
    pub fn new(cone_angle: f64, cone_softness: f64) -> Self {
        let outer = cone_angle.to_radians();
        let tan = libm::tan(outer);
        let tan2_outer = tan * tan;
        let half = |angle: f64| libm::sin(angle / 2.0);
        let inner_share = half(outer * (1.0 - cone_softness)) / half(outer);
        let span = 1.0 - inner_share * inner_share;
        let inverse_span = if span > 0.0 { 1.0 / span } else { 0.0 };
        Self { tan2_outer, edge: secants(tan2_outer), inverse_span }
    }

    /// Value at `rho^2`, up to 1.
    pub fn at(&self, rho2: f64) -> f64 {
        if self.inverse_span == 0.0 {
            return 1.0;
        }
        let share = rho2 * self.edge / secants(rho2 * self.tan2_outer);
        let s = ((1.0 - share) * self.inverse_span).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s)
    }
}

/// `h (1 + h)`, `h = sqrt(1 + tan^2)` the secant.
fn secants(tan2: f64) -> f64 {
    let h = (1.0 + tan2).sqrt();
    h * (1.0 + h)
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
