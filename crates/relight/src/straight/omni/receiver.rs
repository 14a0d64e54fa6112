//! Receivers on an omni light's map, like `omni_lookup.wgsl`.

use light::{Lanes, Mask};

use super::super::{
    DEPTH_ROUNDING, GRAZING_TEXELS, REACH_TEXELS, depth_error, followed_share, rise_of_facets,
};
use super::RelitOmni;
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
    let (x, y, z) = (position.x.abs(), position.y.abs(), position.z.abs());
    let of_x = U32s::select(position.x.lt(zero), U32s::splat(1), U32s::splat(0));
    let of_y = U32s::select(position.y.lt(zero), U32s::splat(3), U32s::splat(2));
    let of_z = U32s::select(position.z.lt(zero), U32s::splat(5), U32s::splat(4));
    U32s::select(x.ge(y.most(z)), of_x, U32s::select(y.ge(z), of_y, of_z))
}

/// Rotates vectors into the axes of faces: right, up and ahead. Right and up are the axes that follow the face's own in
/// turn, on both faces of an axis. One of the two faces is mirrored, and no angle changes.
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

/// Position of receivers on a face of the map, and the planes that they lie in, by their nearness.
///
/// The map stores the quotient of the near plane's distance and the distance ahead. This nearness is a linear function
/// on the picture of a plane: 1 on the near plane, 0 at infinity.
struct OmniReceiver {
    face: U32s,
    texel: [F32s; 2],
    nearness: F32s,
    /// Change of the nearness of a receiver's plane from one texel to the next, to the right and downwards.
    step: [F32s; 2],
    /// Least nearness of a receiver's plane that is compared. The next field is the greatest.
    min_nearness: F32s,
    most: F32s,
    /// Difference in nearness between a caster and a receiver's plane up to which the caster does not shadow the
    /// receiver. `tolerance` is the difference if the map alone decides. `reach` is the greater difference if ray tests
    /// against the scene decide about the casters in between.
    tolerance: F32s,
    reach: F32s,
}

impl Receiver for OmniReceiver {
    #[inline(always)]
    fn texel(&self) -> [F32s; 2] {
        self.texel
    }

    #[inline(always)]
    fn lit_texels(&self, map: &DepthMap, first: [F32s; 2]) -> LitTexels {
        let [right, down] = self.step;
        let corner = self.nearness + (right * (first[0] - self.texel[0]) + down * (first[1] - self.texel[1]));
        let planes = [corner, corner + right, corner + down, corner + (right + down)];
        let stored = gathered(map, self.face, first);
        let beyond = beyond_map(first, map.side());
        let mut lit = LitTexels { resolved: beyond, deferred: beyond };
        for k in 0..4 {
            let excess = stored[k] - planes[k].within(self.min_nearness, self.most);
            lit.resolved[k] = lit.resolved[k] | excess.le(self.tolerance);
            lit.deferred[k] = lit.deferred[k] | excess.le(self.reach);
        }
        lit
    }
}

impl RelitOmni {
    /// Computes the share of the light that no caster blocks, for the `asked` lanes. The receiver's own plane has a
    /// nearness at each texel's center, and that nearness is compared with the texel, so that a plane cannot shadow
    /// itself.
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
        let face = face_of(in_light);
        let fit = fit_of(&self.map.fits, face);
        let side = F32s::splat(map.side() as f32);
        let at = to_face_axes(face, in_light);
        let normal = to_face_axes(face, self.frame.vector(normal));
        let ahead = at.z.most(F32s::splat(1e-30));
        let way_length = F32s::length(at);
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
        let rise = rise_of_facets(width, height / way_length);
        let strayed = depth_error(height, way_length, self.map.mesh_error);
        let tolerance = nearness * (rise / ahead + strayed) + F32s::splat(DEPTH_ROUNDING);
        let receiver = OmniReceiver {
            face,
            texel: texel_at(fit, [at.x / ahead, at.y / ahead], side),
            nearness,
            step,
            min_nearness: nearness * (one - share),
            most,
            tolerance,
            reach: tolerance.most(most - nearness),
        };
        let shares = filter_visibility(&receiver, map, self.map.filter);

        // A steep caster beside the receiver may be nearer than at it, so the ray test covers twice the reach, and as
        // far as the plane runs in the texels around.
        let grazes = asked & (!faces_light | (run * ahead).gt(F32s::splat(GRAZING_TEXELS) * width));
        let way = to_light * (way_length * (F32s::splat(3.0) * share).least(F32s::splat(0.9)));
        F32s::select(asked, resolve_along_segment(scene, surface, shares, grazes, way), zero)
    }
}
