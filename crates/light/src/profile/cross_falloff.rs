//! Falloff from a light's axis to its edge.

use crate::lanes::Lanes;
use crate::parameters::{CONE_ANGLE, CONE_SOFTNESS, PROFILE, PROFILE_POWER};
use crate::{Light, ProfileCurve};

/// Profile over `rho = |(v, w)|`: 1 inside, then along a curve to 0 at the light's edge.
///
/// `rho` stands for the angle `theta = atan(rho tan coneAngle)` of a spotlight. With `inner = outer (1 - coneSoftness)`
/// and `s = (cos theta - cos outer) / (cos inner - cos outer)`, clamped to 0 and 1, the profile is
/// - [`ProfileCurve::Smooth`]: the S-curve `s^2 (3 - 2 s)`;
/// - [`ProfileCurve::Power`]: `s^profilePower` (Real-Time Rendering, eq. 7.18);
/// - [`ProfileCurve::Linear`]: linear in `rho` from the inner angle's to 1;
/// - [`ProfileCurve::Cosine`]: `cos(theta)^profilePower`, cut at the edge (eq. 7.17), whatever the softness.
///
/// It is computed from `1 - cos` as a share of its value at the edge. `1 - cos` does not cancel in a narrow cone, and
/// the share works for the narrowest. With `x = tan^2 theta` and `h = sqrt(1 + x)`, `1 - cos theta = x / (h (1 + h))`.
/// No inverse trigonometry is needed, which is inaccurate on GPUs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossFalloff {
    pub curve: ProfileCurve,
    /// Exponent of the curves that have one.
    pub power: f64,
    pub tan2_outer: f64,
    /// `h (1 + h)` at the edge.
    pub edge: f64,
    /// 1 over the increase of `1 - s` from the inner angle to the edge, as a share of its value at the edge: of
    /// `1 - cos` for most curves, of `rho` for the linear one. 0 if the angles are equal, which makes the profile a
    /// step.
    pub inverse_span: f64,
}

impl CrossFalloff {
    /// Constant profile of lights without an edge.
    pub const FLAT: Self =
        Self { curve: ProfileCurve::Smooth, power: 1.0, tan2_outer: 0.0, edge: 2.0, inverse_span: 0.0 };

    /// Makes a profile of a checked light with a cone.
    pub fn of(light: &Light) -> Self {
        let curve = light.get(PROFILE);
        let outer = light.get(CONE_ANGLE).to_radians();
        let inner = outer * (1.0 - light.get(CONE_SOFTNESS));
        let tan = libm::tan(outer);
        let half = |angle: f64| libm::sin(angle / 2.0);
        let half_share = half(inner) / half(outer);
        let is_linear = curve == ProfileCurve::Linear;
        let inner_share = if is_linear { libm::tan(inner) / tan } else { half_share * half_share };
        let span = 1.0 - inner_share;
        let inverse_span = if span > 0.0 { 1.0 / span } else { 0.0 };
        let tan2_outer = tan * tan;
        Self { curve, power: light.get(PROFILE_POWER), tan2_outer, edge: secants(tan2_outer), inverse_span }
    }

    /// Returns the value at `rho^2`, up to 1.
    #[inline(always)]
    pub fn at<F: Lanes>(&self, rho2: F) -> F {
        let (zero, one) = (F::of(0.0), F::of(1.0));
        let tan2 = rho2 * F::of(self.tan2_outer);
        if self.curve == ProfileCurve::Cosine {
            return (one + tan2).pow(-0.5 * self.power);
        }
        if self.inverse_span == 0.0 {
            return one;
        }
        let share = match self.curve {
            ProfileCurve::Linear => rho2.sqrt(),
            _ => rho2 * F::of(self.edge) / secants(tan2),
        };
        let s = ((one - share) * F::of(self.inverse_span)).within(zero, one);
        match self.curve {
            ProfileCurve::Linear => s,
            ProfileCurve::Power => s.pow(self.power),
            _ => s * s * (F::of(3.0) - F::of(2.0) * s),
        }
    }
}

/// Computes `h (1 + h)` with the secant `h = sqrt(1 + tan^2)`.
#[inline(always)]
fn secants<F: Lanes>(tan2: F) -> F {
    let h = (F::of(1.0) + tan2).sqrt();
    h * (F::of(1.0) + h)
}
