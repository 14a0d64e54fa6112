//! Spotlights, like `cone.wgsl` and `spot.wgsl`. Light space has its origin at the source, and the light shines along
//! -z.

mod receiver;

use glam::Mat4;
use light::{Lanes, LightProfile, Mask};

use super::{LightFrame, Located, no_light};
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::shape::{LightSampleLanes, RelitShape};
use crate::surfaces::SurfaceLanes;
use crate::{CasterScene, ShadowFilter};

/// Spotlight as it is drawn.
#[derive(Debug)]
pub struct RelitSpot {
    frame: LightFrame,
    light_profile: LightProfile,
    tan_outer: f32,
    /// Infinite for a light without end.
    range: f32,
    map: SpotMapParams,
}

/// Shadow map of a spotlight. It has one face, or those of a cube about the light's axis: front, +x, -x, +y and -y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotMapParams {
    /// Distance of the near plane of each face. A depth in the map is this distance divided by the distance ahead.
    pub near: f32,
    /// Largest deviation of the casters from the surface, in world units.
    pub mesh_error: f32,
    /// Center and 1 / half size of the drawn part of each face, as slopes.
    pub fits: [[f32; 4]; 5],
    pub filter: ShadowFilter,
}

impl RelitSpot {
    /// Makes a light that is ready to draw. `light_from_scene` takes scene space to light space, by a rotation and a
    /// translation. `tan_outer` is the tangent of the half angle, `range` the axial distance at which the light ends,
    /// in world units.
    pub fn new(
        light_from_scene: Mat4,
        light_profile: LightProfile,
        (tan_outer, range): (f32, Option<f32>),
        map: SpotMapParams,
    ) -> Self {
        let range = range.unwrap_or(f32::INFINITY);
        Self { frame: LightFrame::new(light_from_scene), light_profile, tan_outer, range, map }
    }

    #[inline(always)]
    pub(super) fn locate(&self, scene_position: Vec3s) -> Located {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let position = self.frame.position(scene_position);
        let depth = -position.z;
        let is_ahead = depth.gt(zero);
        let per_depth = one / F32s::select(is_ahead, depth, one);
        let (x, y) = (position.x * per_depth, position.y * per_depth);
        let tan = F32s::splat(self.tan_outer);
        let s = F32s::length(position);
        Located {
            inside: is_ahead & (x * x + y * y).le(tan * tan) & depth.le(F32s::splat(self.range)),
            // Axes of a BendyLight's cross-section: w_hat is up, v_hat = w_hat x u_hat points to the left of +x.
            v: -x / tan,
            w: y / tan,
            s,
            to_light: self.frame.scene_vector(position * (F32s::splat(-1.0) / s)),
        }
    }
}

impl RelitShape for RelitSpot {
    fn light_profile(&self) -> &LightProfile {
        &self.light_profile
    }

    #[inline(always)]
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        asked: Masks,
    ) -> LightSampleLanes {
        let mut located = self.locate(surface.position);
        located.inside = located.inside & asked;
        if !located.inside.any() {
            return no_light();
        }
        let visibility = match map {
            Some(map) => self.visibility(scene, map, surface, located.to_light, located.inside),
            None => F32s::splat(1.0),
        };
        located.sample(&self.light_profile, visibility)
    }
}
