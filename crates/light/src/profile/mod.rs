//! Falloff and shadow of light (light model, section 6). They depend on light coordinates alone, so one module serves
//! lights of every shape.

mod blackbody;
mod cross_falloff;
mod distance_ramps;
mod edge_outline;
mod section_outline;

use glam::DVec3;

use crate::emission::emission;
use crate::lanes::Lanes;
use crate::parameter::ValueType;
use crate::parameters::{
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, DECAY, DECAY_START, DIFFUSE, ENABLE_COLOR_TEMPERATURE, ENABLED, EXPOSURE,
    INTENSITY, SHADOW_COLOR, SHADOW_ENABLE, SPECULAR,
};
use crate::{Decay, Light, LightCoords, ParameterKey};

pub use blackbody::blackbody;
pub use cross_falloff::CrossFalloff;
pub use distance_ramps::DistanceRamps;
pub use edge_outline::EdgeOutline;
pub use section_outline::SectionOutline;

/// Brightness of a light as a whole, falloff across and along it, and look of its shadows.
#[derive(Clone, Debug, PartialEq)]
pub struct LightProfile {
    /// Factor of all emitted light, linear RGB: `color intensity 2^exposure` times the colour of its temperature, or 0
    /// if the light is off.
    pub tint: DVec3,
    /// Factor of diffuse reflection.
    pub diffuse: f64,
    /// Factor of specular reflection.
    pub specular: f64,
    /// True if the light casts shadows.
    pub shadow_enable: bool,
    /// Share of the light that arrives in its shadow, linear RGB.
    pub shadow_color: DVec3,
    /// Falloff across the light.
    pub profile: CrossFalloff,
    /// Outline of the cross-section.
    pub section: SectionOutline,
    /// Outline of the edge around the axis.
    pub radial: EdgeOutline,
    /// Falloff along the light.
    pub decay: Decay,
    /// Distances at which the light begins and ends.
    pub distance_ramps: DistanceRamps,
    /// Distance from the source, in world units, below which decay does not increase irradiance further: the source
    /// itself would be infinitely bright.
    pub min_distance: f64,
}

impl LightProfile {
    /// Makes a profile of a checked light. Its minimum distance is `least_distance`, in world units, or the light's
    /// decay start if that is larger.
    pub fn of(light: &Light, least_distance: f64) -> Self {
        Self {
            tint: tint(light),
            diffuse: light.get(DIFFUSE),
            specular: light.get(SPECULAR),
            shadow_enable: light.get(SHADOW_ENABLE),
            shadow_color: light.get(SHADOW_COLOR).max(DVec3::ZERO),
            profile: if light.value(&CONE_ANGLE).is_some() { CrossFalloff::of(light) } else { CrossFalloff::FLAT },
            section: SectionOutline::of(light),
            radial: EdgeOutline::of(light),
            decay: own_value(light, DECAY).unwrap_or_default(),
            distance_ramps: DistanceRamps::of(light),
            min_distance: 0.0,
        }
        .with_min_distance(light, least_distance)
    }

    /// Sets the minimum distance to `least_distance` or the light's decay start, the larger one.
    #[must_use]
    pub fn with_min_distance(mut self, light: &Light, least_distance: f64) -> Self {
        self.min_distance = own_value(light, DECAY_START).unwrap_or(0.0).max(least_distance);
        self
    }

    /// Returns the factors of all the light's radiance towards the eye, linear RGB, of the diffuse and the specular
    /// lobe.
    pub fn lobe_weights(&self) -> [DVec3; 2] {
        [self.tint * self.diffuse, self.tint * self.specular]
    }

    /// Returns true if no picture can show the light.
    pub fn is_dark(&self) -> bool {
        self.tint == DVec3::ZERO || (self.diffuse, self.specular) == (0.0, 0.0)
    }

    /// Returns true if irradiance depends on the path length.
    pub fn needs_distance(&self) -> bool {
        self.decay != Decay::None || self.distance_ramps != DistanceRamps::NONE
    }

    /// Returns the share of the light that arrives at a visibility from 0 to 1, linear RGB.
    pub fn arriving(&self, visibility: f64) -> DVec3 {
        self.shadow_color.lerp(DVec3::ONE, visibility)
    }
}

impl LightProfile {
    /// Computes the irradiance on a surface perpendicular to the light, linear RGB, without visibility:
    /// `emission tint profile(rho) cut(s) decay(s)`. `rho` follows from the position in the cross-section.
    pub fn irradiance(&self, emission: DVec3, coords: &LightCoords) -> DVec3 {
        emission * self.tint * self.attenuation_at(coords.v, coords.w, coords.s)
    }

    /// Returns the share of the light that remains at (v, w) after a path of length `s` in world units.
    #[inline(always)]
    pub fn attenuation_at<F: Lanes>(&self, v: F, w: F, s: F) -> F {
        let along = self.distance_ramps.at(s) * self.decay.at(s.most(F::of(self.min_distance)));
        self.across(v, w) * along
    }

    /// Returns the factor of the position across the light. Light outside an outline is cut if the light does not end
    /// there by itself.
    #[inline(always)]
    pub fn across<F: Lanes>(&self, v: F, w: F) -> F {
        let share = self.radial.share(v, w);
        let rho2 = self.section.rho2(v, w) / (share * share);
        let falloff = self.profile.at(rho2);
        let ends_at_edge = self.section == SectionOutline::Circle && self.radial.is_uniform();
        if ends_at_edge { falloff } else { F::select(rho2.gt(F::of(1.0)), F::of(0.0), falloff) }
    }
}

fn tint(light: &Light) -> DVec3 {
    if !light.get(ENABLED) {
        return DVec3::ZERO;
    }
    let temperature = light.get(ENABLE_COLOR_TEMPERATURE).then(|| blackbody(light.get(COLOR_TEMPERATURE)));
    let color = light.get(COLOR) * temperature.unwrap_or(DVec3::ONE);
    emission::<f64>(color, light.get(INTENSITY)) * libm::exp2(light.get(EXPOSURE))
}

/// Returns the value of a parameter; `None` if lights of that shape do not have it.
fn own_value<T: ValueType>(light: &Light, key: ParameterKey<T>) -> Option<T> {
    light.value(&key).and_then(T::from_value)
}
