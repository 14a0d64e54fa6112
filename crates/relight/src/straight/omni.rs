//! Omni lights, like `omni.wgsl`. Light space has its origin at the source. The map has the faces of a cube: +x, -x,
//! +y, -y, +z and -z.

use glam::Mat4;
use light::{Lanes, LightProfile};

use super::receiver::{MapDepths, StraightReceiver, StraightShape};
use super::{DEPTH_ROUNDING, Located, REACH_TEXELS, depth_error, followed_share, rise_of_facets};
use crate::ShadowFilter;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::surfaces::SurfaceLanes;
use crate::transform::Affine3s;
use crate::visibility::{GRAZING_TEXELS, fit_of, texel_at};

/// Omni light as it is drawn.
#[derive(Debug)]
pub struct RelitOmni {
    /// Rotation and translation.
    light_from_scene: Affine3s,
    light_profile: LightProfile,
    /// Infinite for a light without end.
    range: f32,
    map: OmniMapParams,
}

/// Shadow map of an omni light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OmniMapParams {
    /// Distance of the near plane of each face from the source, in world units. A depth in the map is this distance
    /// divided by the distance ahead.
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
    pub fn new(light_from_scene: Mat4, light_profile: LightProfile, range: Option<f32>, map: OmniMapParams) -> Self {
        let range = range.unwrap_or(f32::INFINITY);
        Self { light_from_scene: Affine3s::splat(light_from_scene), light_profile, range, map }
    }
}

/// Depths of an omni light's map: the near plane's distance divided by the distance ahead, which is 1 on the near plane
/// and 0 at infinity. Across the map's image of a plane this nearness is linear. [`StraightReceiver::plane`] has it as
/// its value.
pub(super) struct OmniDepths {
    /// Least and greatest nearness of a receiver's plane that is compared.
    bounds: [F32s; 2],
}

impl MapDepths for OmniDepths {
    #[inline(always)]
    fn lit(&self, stored: F32s, plane: F32s, [tolerance, reach]: [F32s; 2]) -> [Masks; 2] {
        let excess = stored - plane.within(self.bounds[0], self.bounds[1]);
        [excess.le(tolerance), excess.le(reach)]
    }
}

impl StraightShape for RelitOmni {
    type Depths = OmniDepths;

    fn profile(&self) -> &LightProfile {
        &self.light_profile
    }

    #[inline(always)]
    fn locate(&self, scene_position: Vec3s) -> Located {
        let zero = F32s::splat(0.0);
        let position = self.light_from_scene.position(scene_position);
        let s = F32s::length(position);
        let [v, w] = on_cube(position);
        Located {
            inside: s.gt(zero) & s.le(F32s::splat(self.range)),
            t: s / F32s::splat(self.range),
            v,
            w,
            s,
            to_light: self.light_from_scene.transposed_vector(position * (F32s::splat(-1.0) / s)),
        }
    }

    #[inline(always)]
    fn receiver(&self, map: &DepthMap, surface: &SurfaceLanes, normal: Vec3s) -> StraightReceiver<OmniDepths> {
        let one = F32s::splat(1.0);
        let in_light = self.light_from_scene.position(surface.shadow_position());
        let face = face_of(in_light);
        let fit = fit_of(&self.map.fits, face);
        let side = F32s::splat(map.side() as f32);
        let at = to_face_axes(face, in_light);
        let normal = to_face_axes(face, self.light_from_scene.vector(normal));
        let ahead = at.z.most(F32s::splat(1e-30));
        let path_length = F32s::length(at);
        let near = F32s::splat(self.map.near);

        // Slopes from one texel to the next, and width of a texel at the receiver.
        let slopes = [F32s::splat(2.0) / (fit[2] * side), F32s::splat(2.0) / (fit[3] * side)];
        let width = slopes[0].most(slopes[1]) * ahead;
        // Height of the source over the plane. On the ray along e the plane is at e times height / -(normal . e), which
        // makes its nearness linear in e.
        let height = (-F32s::dot(normal, at)).most(F32s::splat(1e-30));
        let per_height = near / height;
        let nearness = near / ahead;
        let step = [-(normal.x * slopes[0] * per_height), normal.y * slopes[1] * per_height];

        let run = (step[0] * step[0] + step[1] * step[1]).sqrt() / nearness;
        let share = followed_share(F32s::splat(REACH_TEXELS) * width / ahead, run);
        let most = nearness / (one - share);

        // The stored depth, linear across a triangle, is off by some ulps of its largest value, 1.
        let rise = rise_of_facets(width, height / path_length);
        let mesh_error = depth_error(height, path_length, self.map.mesh_error);
        let tolerance = nearness * (rise / ahead + mesh_error) + F32s::splat(DEPTH_ROUNDING);
        StraightReceiver {
            face,
            texel: texel_at(fit, [at.x / ahead, at.y / ahead], side),
            plane: nearness,
            step,
            depths: OmniDepths { bounds: [nearness * (one - share), most] },
            tolerance,
            reach: tolerance.most(most - nearness),
            filter: self.map.filter,
            is_steep: (run * ahead).gt(F32s::splat(GRAZING_TEXELS) * width),
            traced_length: path_length * (F32s::splat(3.0) * share).least(F32s::splat(0.9)),
        }
    }
}

/// Intersects rays with the faces of a cube. Returns the coordinates to the left and up on the face, seen from within.
#[inline(always)]
fn on_cube(ray: Vec3s) -> [F32s; 2] {
    let zero = F32s::splat(0.0);
    let (x, y, z) = (ray.x.abs(), ray.y.abs(), ray.z.abs());
    let is_y = y.gt(x.most(z));
    let is_x = !is_y & x.gt(z);
    let size = F32s::select(is_y, y, F32s::select(is_x, x, z));
    let left_on_x = F32s::select(ray.x.gt(zero), -ray.z, ray.z);
    let left_on_z = F32s::select(ray.z.lt(zero), -ray.x, ray.x);
    let up_on_y = F32s::select(ray.y.gt(zero), ray.z, -ray.z);
    let left = F32s::select(is_y, -ray.x, F32s::select(is_x, left_on_x, left_on_z));
    [left / size, F32s::select(is_y, up_on_y, ray.y) / size]
}

/// Returns the faces that hold positions in light space.
#[inline(always)]
fn face_of(position: Vec3s) -> U32s {
    let zero = F32s::splat(0.0);
    let (x, y, z) = (position.x.abs(), position.y.abs(), position.z.abs());
    let of_x = U32s::select(position.x.lt(zero), U32s::splat(1), U32s::splat(0));
    let of_y = U32s::select(position.y.lt(zero), U32s::splat(3), U32s::splat(2));
    let of_z = U32s::select(position.z.lt(zero), U32s::splat(5), U32s::splat(4));
    U32s::select(x.ge(y.most(z)), of_x, U32s::select(y.ge(z), of_y, of_z))
}

/// Converts vectors to the axes of faces: right, up and ahead. Ahead points from the source to the face. Right and up
/// are y and z on the faces +x and -x, z and x on +y and -y, and x and y on +z and -z. The negative faces are mirrored,
/// which keeps lengths and angles.
#[inline(always)]
fn to_face_axes(face: U32s, v: Vec3s) -> Vec3s {
    let on_x = face.equals(U32s::splat(0)) | face.equals(U32s::splat(1));
    let on_y = face.equals(U32s::splat(2)) | face.equals(U32s::splat(3));
    let behind = (face & U32s::splat(1)).equals(U32s::splat(1));
    let ahead = F32s::select(on_x, v.x, F32s::select(on_y, v.y, v.z));
    Vec3s {
        x: F32s::select(on_x, v.y, F32s::select(on_y, v.z, v.x)),
        y: F32s::select(on_x, v.z, F32s::select(on_y, v.x, v.y)),
        z: F32s::select(behind, -ahead, ahead),
    }
}
