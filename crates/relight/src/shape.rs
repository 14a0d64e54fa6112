//! Interface of the light shapes.

use light::LightProfile;

use crate::CasterScene;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::surfaces::SurfaceLanes;

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

/// Light of one shape.
pub(crate) trait RelitShape: Sync {
    fn light_profile(&self) -> &LightProfile;
    /// Samples the light at surfaces, in the `asked` lanes. `map` is the light's shadow map, `None` for a light without
    /// shadows.
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        asked: Masks,
    ) -> LightSampleLanes;
}
