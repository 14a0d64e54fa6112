//! Receivers on a spotlight's map, like `spot_faces.wgsl` and the map's part of `spot.wgsl`.

use light::{Lanes, Mask};

use super::super::{
    DEPTH_ROUNDING, GRAZING_TEXELS, REACH_TEXELS, depth_error, followed_share, rise_of_facets,
};
use super::RelitSpot;
use crate::CasterScene;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::surfaces::SurfaceLanes;
use crate::visibility::{
    Facing, LitTexels, Receiver, beyond_map, facing, filter_visibility, fit_of, gathered,
    resolve_along_segment, texel_at,
};

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

/// Position of receivers on the map, and the planes that they lie in.
struct SpotReceiver {
    face: U32s,
    texel: [F32s; 2],
    /// 1 / depth of the receiver, and its change along the receiver's plane from one texel to the next.
    inverse_depth: F32s,
    step: [F32s; 2],
    /// Difference in depth between a caster and a receiver's plane up to which the caster does not shadow the receiver.
    /// `tolerance` is the difference if the map alone decides. `reach` is the greater difference if ray tests against
    /// the scene decide about the casters in between.
    tolerance: F32s,
    reach: F32s,
    /// Least and greatest 1 / depth of the receiver's plane that is compared.
    bounds: [F32s; 2],
    near: F32s,
}

impl Receiver for SpotReceiver {
    #[inline(always)]
    fn texel(&self) -> [F32s; 2] {
        self.texel
    }

    #[inline(always)]
    fn lit_texels(&self, map: &DepthMap, first: [F32s; 2]) -> LitTexels {
        let [dx, dy] = self.step;
        let start = self.inverse_depth + (dx * (first[0] - self.texel[0]) + dy * (first[1] - self.texel[1]));
        let planes = [start, start + dx, start + dy, start + (dx + dy)];
        let stored = gathered(map, self.face, first);
        let beyond = beyond_map(first, map.side());
        let mut lit = LitTexels { resolved: beyond, deferred: beyond };
        for k in 0..4 {
            let expected = planes[k].within(self.bounds[0], self.bounds[1]) * self.near;
            lit.resolved[k] = lit.resolved[k] | stored[k].le(expected + self.tolerance);
            lit.deferred[k] = lit.deferred[k] | stored[k].le(expected + self.reach);
        }
        lit
    }
}

impl RelitSpot {
    /// Computes the share of the light that no caster blocks, for the `asked` lanes.
    ///
    /// The receiver's own plane has a depth on the ray through each texel's center, and that depth is compared with the
    /// texel, so that a plane cannot shadow itself. The plane through p has 1 / depth = `n.(x, y, 1) / n.p` on the ray
    /// (x, y, 1): linear in (x, y).
    #[inline(always)]
    pub(super) fn visibility(
        &self,
        scene: &CasterScene,
        map: &DepthMap,
        surface: &SurfaceLanes,
        to_light: Vec3s,
        asked: Masks,
    ) -> F32s {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let Facing { active: asked, faces_light, normal } = facing(scene, surface, to_light, asked);
        if !asked.any() {
            return zero;
        }
        let in_light = self.frame.position(surface.shadow_position());
        let face = if map.faces() > 1 { face_of(in_light) } else { U32s::splat(0) };
        let position = to_face_axes(face, in_light);
        let normal = to_face_axes(face, self.frame.vector(normal));
        let depth = position.z.most(F32s::splat(1e-30));
        let fit = fit_of(&self.map.fits, face);
        let side = F32s::splat(map.side() as f32);

        let slopes = [F32s::splat(2.0) / (fit[2] * side), F32s::splat(2.0) / (fit[3] * side)];
        let texel_slope = slopes[0].most(slopes[1]);
        let plane_distance = F32s::dot(normal, position).least(F32s::splat(-1e-30));
        let way_length = F32s::length(position);
        let inverse_depth = one / depth;
        let stored_depth = F32s::splat(self.map.near) * inverse_depth;
        let per_distance = one / plane_distance;
        let step = [normal.x * per_distance * slopes[0], -(normal.y * per_distance * slopes[1])];

        // The map's depth, linear across a triangle, is off by some ulps of its largest value, 1.
        let rise = rise_of_facets(texel_slope, plane_distance / way_length);
        let strayed = depth_error(-plane_distance, way_length, self.map.mesh_error);
        let tolerance = (rise + strayed) * stored_depth + F32s::splat(DEPTH_ROUNDING);

        let run = (step[0] * step[0] + step[1] * step[1]).sqrt() * depth;
        let most = followed_share(F32s::splat(REACH_TEXELS) * texel_slope, run);
        let receiver = SpotReceiver {
            face,
            texel: texel_at(fit, [position.x * inverse_depth, position.y * inverse_depth], side),
            inverse_depth,
            step,
            tolerance,
            reach: tolerance.most(most / (one - most) * stored_depth),
            bounds: [(one - most) * inverse_depth, inverse_depth / (one - most)],
            near: F32s::splat(self.map.near),
        };
        let shares = filter_visibility(&receiver, map, self.map.filter);

        // A steep caster beside the receiver may be nearer than at it, so the ray test covers twice the reach, and as
        // far as the plane runs in the texels around.
        let grazes = asked & (!faces_light | run.gt(F32s::splat(GRAZING_TEXELS) * texel_slope));
        let way = to_light * (way_length * (F32s::splat(3.0) * most).least(F32s::splat(0.9)));
        F32s::select(asked, resolve_along_segment(scene, surface, shares, grazes, way), zero)
    }
}
