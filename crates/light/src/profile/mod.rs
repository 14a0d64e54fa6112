//! What becomes of light on its way (light model, section 6): functions of the place alone, for lights of every
//! shape.

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
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, DECAY, DECAY_START, DIFFUSE, ENABLE_COLOR_TEMPERATURE, ENABLED,
    EXPOSURE, INTENSITY, SHADOW_COLOR, SHADOW_ENABLE, SPECULAR,
};
use crate::{Decay, Light, LightCoords, ParameterKey};

pub use blackbody::blackbody;
pub use cross_falloff::CrossFalloff;
pub use distance_ramps::DistanceRamps;
pub use edge_outline::EdgeOutline;
pub use section_outline::SectionOutline;

/// How bright a light is as a whole, how it falls off across and along it, and what its shadows look like.
#[derive(Clone, Debug, PartialEq)]
pub struct LightProfile {
    /// Factor of all that it emits, linear RGB: `color intensity 2^exposure` times the colour of its temperature, or 0 where
    /// the light is off.
    pub tint: DVec3,
    /// Factor of what surfaces scatter of it.
    pub diffuse: f64,
    /// Factor of what surfaces mirror of it.
    pub specular: f64,
    /// Whether anything shadows it.
    pub shadow_enable: bool,
    /// Share of it that reaches what is in its shadow, linear RGB.
    pub shadow_color: DVec3,
    /// Across the light.
    pub profile: CrossFalloff,
    /// What its cross-section looks like.
    pub section: SectionOutline,
    /// How far out it reaches around its axis.
    pub radial: EdgeOutline,
    /// Along it.
    pub decay: Decay,
    /// Where along it light begins and ends.
    pub distance_ramps: DistanceRamps,
    /// Light falls off no further nearer to its source, in world units: the source itself would be infinitely
    /// bright.
    pub min_distance: f64,
}

impl LightProfile {
    /// What a checked light does to what it emits. It falls off no further than at `min_distance` from its source, in
    /// world units, wherever its decay starts.
    pub fn of(light: &Light, least_distance: f64) -> Self {
        Self {
            tint: tint(light),
            diffuse: light.get(DIFFUSE),
            specular: light.get(SPECULAR),
            shadow_enable: light.get(SHADOW_ENABLE),
            shadow_color: light.get(SHADOW_COLOR).max(DVec3::ZERO),
            profile: if light.value(&CONE_ANGLE).is_some() {
                CrossFalloff::of(light)
            } else {
                CrossFalloff::FLAT
            },
            section: SectionOutline::of(light),
            radial: EdgeOutline::of(light),
            decay: own_value(light, DECAY).unwrap_or_default(),
            distance_ramps: DistanceRamps::of(light),
            min_distance: 0.0,
        }
        .with_min_distance(light, least_distance)
    }

    /// The same where it falls off no further than at `min_distance`, or where the light's decay starts.
    #[must_use]
    pub fn with_min_distance(mut self, light: &Light, least_distance: f64) -> Self {
        self.min_distance = own_value(light, DECAY_START).unwrap_or(0.0).max(least_distance);
        self
    }

    /// Factors of all that reaches the eye by the light, linear RGB: of what surfaces scatter, and of what they mirror.
    pub fn lobe_weights(&self) -> [DVec3; 2] {
        [self.tint * self.diffuse, self.tint * self.specular]
    }

    /// Whether no picture can show the light.
    pub fn is_dark(&self) -> bool {
        self.tint == DVec3::ZERO || (self.diffuse, self.specular) == (0.0, 0.0)
    }

    /// Whether it matters how far light has come.
    pub fn needs_distance(&self) -> bool {
        self.decay != Decay::None || self.distance_ramps != DistanceRamps::NONE
    }

    /// The share of the light that arrives where `sight` of it is not in the way of anything, 0 to 1.
    pub fn arriving(&self, visibility: f64) -> DVec3 {
        self.shadow_color.lerp(DVec3::ONE, visibility)
    }
}

/// Irradiance on a surface square to the light, linear RGB, without visibility: `emission tint profile(rho) cut(s)
/// decay(s)`, `rho` being where the place lies in the cross-section.
pub fn irradiance(filter: &LightProfile, emission: DVec3, place: &LightCoords) -> DVec3 {
    emission * filter.tint * filter.attenuation_at(place.v, place.w, place.s)
}

impl LightProfile {
    /// What is left of light at (v, w) after a way of length `s` in world units.
    #[inline(always)]
    pub fn attenuation_at<F: Lanes>(&self, v: F, w: F, s: F) -> F {
        let along = self.distance_ramps.at(s) * self.decay.at(s.most(F::of(self.min_distance)));
        across(self, v, w) * along
    }
}

/// What becomes of light across: nothing is left outside of an outline that the light does not end at by itself.
#[inline(always)]
fn across<F: Lanes>(filter: &LightProfile, v: F, w: F) -> F {
    let share = filter.radial.share(v, w);
    let rho2 = filter.section.rho2(v, w) / (share * share);
    if filter.section == SectionOutline::Circle && filter.radial.is_uniform() {
        return filter.profile.at(rho2);
    }
    F::select(rho2.gt(F::of(1.0)), F::of(0.0), filter.profile.at(rho2))
}

fn tint(light: &Light) -> DVec3 {
    if !light.get(ENABLED) {
        return DVec3::ZERO;
    }
    let temperature = light.get(ENABLE_COLOR_TEMPERATURE).then(|| blackbody(light.get(COLOR_TEMPERATURE)));
    let color = light.get(COLOR) * temperature.unwrap_or(DVec3::ONE);
    emission::<f64>(color, light.get(INTENSITY)) * libm::exp2(light.get(EXPOSURE))
}

/// The value of a parameter; `None` where lights of that shape have none.
fn own_value<T: ValueType>(light: &Light, key: ParameterKey<T>) -> Option<T> {
    light.value(&key).and_then(T::from_value)
}
