//! Spotlights, like `cone.wgsl` and `spot.wgsl`. Light space has its origin at the source, and the light shines along
//! -z.

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

/// Spotlight as it is drawn.
#[derive(Debug)]
pub struct RelitSpot {
    /// Rotation and translation.
    light_from_scene: Affine3s,
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
        tan_outer: f32,
        range: Option<f32>,
        map: SpotMapParams,
    ) -> Self {
        let range = range.unwrap_or(f32::INFINITY);
        Self { light_from_scene: Affine3s::splat(light_from_scene), light_profile, tan_outer, range, map }
    }
}

/// Depths of a spotlight's map, which are the near plane's distance divided by the distance ahead. The value of a plane
/// is 1 / depth.
pub(super) struct SpotDepths {
    /// Least and greatest 1 / depth of the receiver's plane that is compared.
    bounds: [F32s; 2],
    near: F32s,
}

impl MapDepths for SpotDepths {
    #[inline(always)]
    fn lit(&self, stored: F32s, plane: F32s, [tolerance, reach]: [F32s; 2]) -> [Masks; 2] {
        let expected = plane.within(self.bounds[0], self.bounds[1]) * self.near;
        [stored.le(expected + tolerance), stored.le(expected + reach)]
    }
}

impl StraightShape for RelitSpot {
    type Depths = SpotDepths;

    fn profile(&self) -> &LightProfile {
        &self.light_profile
    }

    #[inline(always)]
    fn locate(&self, scene_position: Vec3s) -> Located {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let position = self.light_from_scene.position(scene_position);
        let depth = -position.z;
        let is_ahead = depth.gt(zero);
        let per_depth = one / F32s::select(is_ahead, depth, one);
        let (x, y) = (position.x * per_depth, position.y * per_depth);
        let tan = F32s::splat(self.tan_outer);
        let s = F32s::length(position);
        Located {
            inside: is_ahead & (x * x + y * y).le(tan * tan) & depth.le(F32s::splat(self.range)),
            t: depth / F32s::splat(self.range),
            // Axes of a BendyLight's cross-section: w_hat is up, v_hat = w_hat x u_hat points to the left of +x.
            v: -x / tan,
            w: y / tan,
            s,
            to_light: self.light_from_scene.transposed_vector(position * (F32s::splat(-1.0) / s)),
        }
    }

    /// The plane through p has 1 / depth = `n.(x, y, 1) / n.p` on the ray (x, y, 1): linear in (x, y).
    #[inline(always)]
    fn receiver(&self, map: &DepthMap, surface: &SurfaceLanes, normal: Vec3s) -> StraightReceiver<SpotDepths> {
        let one = F32s::splat(1.0);
        let in_light = self.light_from_scene.position(surface.shadow_position());
        let face = if map.faces() > 1 { face_of(in_light) } else { U32s::splat(0) };
        let position = to_face_axes(face, in_light);
        let normal = to_face_axes(face, self.light_from_scene.vector(normal));
        let depth = position.z.most(F32s::splat(1e-30));
        let fit = fit_of(&self.map.fits, face);
        let side = F32s::splat(map.side() as f32);

        let slopes = [F32s::splat(2.0) / (fit[2] * side), F32s::splat(2.0) / (fit[3] * side)];
        let texel_slope = slopes[0].most(slopes[1]);
        let plane_distance = F32s::dot(normal, position).least(F32s::splat(-1e-30));
        let path_length = F32s::length(position);
        let inverse_depth = one / depth;
        let stored_depth = F32s::splat(self.map.near) * inverse_depth;
        let per_distance = one / plane_distance;
        let step = [normal.x * per_distance * slopes[0], -(normal.y * per_distance * slopes[1])];

        // The map's depth, linear across a triangle, is off by some ulps of its largest value, 1.
        let rise = rise_of_facets(texel_slope, plane_distance / path_length);
        let mesh_error = depth_error(-plane_distance, path_length, self.map.mesh_error);
        let tolerance = (rise + mesh_error) * stored_depth + F32s::splat(DEPTH_ROUNDING);

        let run = (step[0] * step[0] + step[1] * step[1]).sqrt() * depth;
        let share = followed_share(F32s::splat(REACH_TEXELS) * texel_slope, run);
        StraightReceiver {
            face,
            texel: texel_at(fit, [position.x * inverse_depth, position.y * inverse_depth], side),
            plane: inverse_depth,
            step,
            depths: SpotDepths {
                bounds: [(one - share) * inverse_depth, inverse_depth / (one - share)],
                near: F32s::splat(self.map.near),
            },
            tolerance,
            reach: tolerance.most(share / (one - share) * stored_depth),
            filter: self.map.filter,
            is_steep: run.gt(F32s::splat(GRAZING_TEXELS) * texel_slope),
            traced_length: path_length * (F32s::splat(3.0) * share).least(F32s::splat(0.9)),
        }
    }
}

/// Returns the faces that hold positions in light space.
#[inline(always)]
fn face_of(position: Vec3s) -> U32s {
    let zero = F32s::splat(0.0);
    let (aside_x, aside_y) = (position.x.abs(), position.y.abs());
    let on_x = U32s::select(position.x.gt(zero), U32s::splat(1), U32s::splat(2));
    let on_y = U32s::select(position.y.gt(zero), U32s::splat(3), U32s::splat(4));
    let aside = U32s::select(aside_x.ge(aside_y), on_x, on_y);
    U32s::select((-position.z).ge(aside_x.most(aside_y)), U32s::splat(0), aside)
}

/// Rotates vectors into the axes of faces: right, up and ahead. No angle changes, and half of the faces are mirrored.
#[inline(always)]
fn to_face_axes(face: U32s, v: Vec3s) -> Vec3s {
    let front = face.equals(U32s::splat(0));
    let along_x = face.equals(U32s::splat(1)) | face.equals(U32s::splat(2));
    let turned = face.equals(U32s::splat(2)) | face.equals(U32s::splat(4));
    let ahead = F32s::select(along_x, v.x, v.y);
    let ahead = F32s::select(turned, -ahead, ahead);
    Vec3s {
        x: F32s::select(front, v.x, F32s::select(along_x, v.y, v.x)),
        y: F32s::select(front, v.y, -v.z),
        z: F32s::select(front, -v.z, ahead),
    }
}
