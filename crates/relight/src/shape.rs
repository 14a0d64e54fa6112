//! What every shape of light brings.

use light::LightProfile;

use crate::CasterScene;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::surfaces::SurfaceLanes;

/// What sixteen pixels get of a light, without the shadow of where nothing is `inside`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSampleLanes {
    /// Whether the light's volume holds the surface, in shadow or not.
    pub inside: Masks,
    /// Unit vector to where light comes from.
    pub direction: Vec3s,
    /// On a surface square to the light, without shadow and tint.
    pub irradiance: Vec3s,
    /// 1 lit, 0 in shadow.
    pub visibility: F32s,
}

/// A shape of light.
pub(crate) trait RelitShape: Sync {
    /// What becomes of its light on its way.
    fn light_profile(&self) -> &LightProfile;
    /// What surfaces get of it, where they are `asked` for. `map` is there where anything shadows it.
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        asked: Masks,
    ) -> LightSampleLanes;
}
