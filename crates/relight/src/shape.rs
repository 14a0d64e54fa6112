//! Interface of the light shapes.

use light::{Lanes, LightProfile};

use crate::CasterScene;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::surfaces::SurfaceLanes;

/// Largest attenuation that stays finite through the BRDF.
const MAX_ATTENUATION: f32 = 1e15;

/// Computes the attenuation of light by its profile. At the source itself it would be infinite.
#[inline(always)]
pub(crate) fn finite_attenuation(profile: &LightProfile, v: F32s, w: F32s, s: F32s) -> F32s {
    let most = F32s::splat(MAX_ATTENUATION);
    let share = profile.attenuation_at(v, w, s);
    F32s::select(share.le(most), share, most)
}

/// Light at sixteen pixels. In lanes that are not `inside` the values have no meaning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSampleLanes {
    /// Lanes whose surface is in the light's volume, in shadow or not.
    pub inside: Masks,
    /// Unit vector towards the direction from which light comes.
    pub direction: Vec3s,
    /// Irradiance of a surface orthogonal to the light, without shadow and tint.
    pub irradiance: Vec3s,
    /// Share of the light that no caster blocks: 1 if lit, 0 in shadow.
    pub visibility: F32s,
}

impl LightSampleLanes {
    /// Returns samples of surfaces that are all outside the light.
    #[inline(always)]
    pub fn none() -> Self {
        let zero = Vec3s::splat([0.0; 3]);
        Self { inside: Masks::ZERO, direction: zero, irradiance: zero, visibility: F32s::ZERO }
    }
}

/// Coordinates of sixteen surfaces in a light. In lanes that are not `inside` the values have no meaning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightCoordsLanes {
    /// Lanes whose surface is in the light's volume.
    pub inside: Masks,
    pub t: F32s,
    pub v: F32s,
    pub w: F32s,
    /// Unit vector towards the direction from which light comes.
    pub direction: Vec3s,
}

/// Light of one shape.
pub(crate) trait RelitShape: Sync {
    fn light_profile(&self) -> &LightProfile;
    /// Samples the light at surfaces, in the `active` lanes. `map` is the light's shadow map, `None` for a light
    /// without shadows.
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        active: Masks,
    ) -> LightSampleLanes;
    /// Computes the coordinates of surfaces in the light, in the `active` lanes.
    fn coords(&self, surface: &SurfaceLanes, active: Masks) -> LightCoordsLanes;
}
