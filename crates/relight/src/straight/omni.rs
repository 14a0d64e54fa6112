//! Omni lights, like `omni.wgsl`. Light space has its origin at the source. The map has the faces of a cube: +x, -x,
//! +y, -y, +z and -z.

mod receiver;

use glam::Mat4;
use light::{Lanes, LightProfile, Mask};

use super::{LightFrame, Located, no_light};
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::shape::{LightSampleLanes, RelitShape};
use crate::surfaces::SurfaceLanes;
use crate::{CasterScene, ShadowFilter};

/// Omni light as it is drawn.
#[derive(Debug)]
pub struct RelitOmni {
    frame: LightFrame,
    light_profile: LightProfile,
    /// Infinite for a light without end.
    range: f32,
    map: OmniMapParams,
}

/// Shadow map of an omni light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OmniMapParams {
    /// Distance of the near plane of each face. A depth in the map is this distance divided by the distance ahead.
    pub near: f32,
    /// Largest deviation of the casters from the surface, in world units.
    pub mesh_error: f32,
    /// Center and 1 / half size of the drawn part of each face, as slopes.
    pub fits: [[f32; 4]; 6],
    pub filter: ShadowFilter,
}

impl RelitOmni {
    /// Makes a light that is ready to draw. `light_from_scene` takes scene space to light space, by a rotation and a
    /// translation. `range` is the distance at which the light ends, in world units.
    pub fn new(
        light_from_scene: Mat4,
        light_profile: LightProfile,
        range: Option<f32>,
        map: OmniMapParams,
    ) -> Self {
        let range = range.unwrap_or(f32::INFINITY);
        Self { frame: LightFrame::new(light_from_scene), light_profile, range, map }
    }

    #[inline(always)]
    pub(super) fn locate(&self, scene_position: Vec3s) -> Located {
        let zero = F32s::splat(0.0);
        let position = self.frame.position(scene_position);
        let s = F32s::length(position);
        let [v, w] = on_cube(position);
        Located {
            inside: s.gt(zero) & s.le(F32s::splat(self.range)),
            v,
            w,
            s,
            to_light: self.frame.scene_vector(position * (F32s::splat(-1.0) / s)),
        }
    }
}

/// Intersects rays with the faces of a cube. Returns the coordinates to the left and up on the face, seen from within.
#[inline(always)]
fn on_cube(way: Vec3s) -> [F32s; 2] {
    let zero = F32s::splat(0.0);
    let (x, y, z) = (way.x.abs(), way.y.abs(), way.z.abs());
    let is_y = y.gt(x.most(z));
    let is_x = !is_y & x.gt(z);
    let size = F32s::select(is_y, y, F32s::select(is_x, x, z));
    let left_on_x = F32s::select(way.x.gt(zero), -way.z, way.z);
    let left_on_z = F32s::select(way.z.lt(zero), -way.x, way.x);
    let up_on_y = F32s::select(way.y.gt(zero), way.z, -way.z);
    let left = F32s::select(is_y, -way.x, F32s::select(is_x, left_on_x, left_on_z));
    [left / size, F32s::select(is_y, up_on_y, way.y) / size]
}

impl RelitShape for RelitOmni {
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
