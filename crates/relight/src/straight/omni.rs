//! An omni light: the twin of `omni.wgsl`. Light space: source at the origin. Its map has the
//! faces of a cube: +x, -x, +y, -y, +z and -z.

mod receiver;

use glam::Mat4;
use light::{Lanes, LightFilter, Mask};

use super::{LightFrame, Located, nothing};
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::shape::{Sample, Shape};
use crate::surfaces::Surface;
use crate::{Scene, ShadowFilter};

/// An omni light as it is drawn.
#[derive(Debug)]
pub struct Omni {
    frame: LightFrame,
    light_filter: LightFilter,
    /// Infinite where the light has no end.
    range: f32,
    map: OmniMapPlace,
}

/// What an omni light's map shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OmniMapPlace {
    /// The near plane of its faces: depths are this over the way ahead.
    pub near: f32,
    /// How far what casts shadows may stray from the surface, in world units.
    pub mesh_error: f32,
    /// Middle and 1 / half size of what is drawn of each face, as slopes.
    pub fits: [[f32; 4]; 6],
    /// How texels are blended.
    pub filter: ShadowFilter,
}

impl Omni {
    /// `light_from_scene` takes scene space to light space, by a rotation and a shift. `range` is the distance at which
    /// the light ends, in world units.
    pub fn new(
        light_from_scene: Mat4,
        light_filter: LightFilter,
        range: Option<f32>,
        map: OmniMapPlace,
    ) -> Self {
        let range = range.unwrap_or(f32::INFINITY);
        Self { frame: LightFrame::new(light_from_scene), light_filter, range, map }
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
            toward: self.frame.scene_vector(position * (F32s::splat(-1.0) / s)),
        }
    }
}

/// How far to the left and how far up on the faces of a cube, seen from within, rays meet them.
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

impl Shape for Omni {
    fn light_filter(&self) -> &LightFilter {
        &self.light_filter
    }

    #[inline(always)]
    fn sample(&self, scene: &Scene, map: Option<&DepthMap>, surface: &Surface, asked: Masks) -> Sample {
        let mut located = self.locate(surface.position);
        located.inside = located.inside & asked;
        if !located.inside.any() {
            return nothing();
        }
        let visibility = match map {
            Some(map) => self.visibility(scene, map, surface, located.toward, located.inside),
            None => F32s::splat(1.0),
        };
        located.sample(&self.light_filter, visibility)
    }
}
