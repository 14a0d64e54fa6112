//! A spotlight's map: the twin of `spot_faces.wgsl` and of what `spot.wgsl` has of it.

use light::{Lanes, Mask};

use super::super::{DEPTH_ROUNDING, GRAZING, REACH};
use super::Spot;
use crate::Scene;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::surfaces::Surface;
use crate::visibility::{LitTexels, Receiver, decided, filtered, gathered, in_their_own_way};

/// The faces that hold positions in light space.
#[inline(always)]
fn face_of(position: Vec3s) -> U32s {
    let zero = F32s::splat(0.0);
    let (aside_x, aside_y) = (position.x.abs(), position.y.abs());
    let on_x = U32s::select(position.x.gt(zero), U32s::splat(1), U32s::splat(2));
    let on_y = U32s::select(position.y.gt(zero), U32s::splat(3), U32s::splat(4));
    let aside = U32s::select(aside_x.ge(aside_y), on_x, on_y);
    U32s::select((-position.z).ge(aside_x.most(aside_y)), U32s::splat(0), aside)
}

/// Vectors in the axes of faces: right, up, and the way that they look. No angle changes; half of the faces are
/// mirrored.
#[inline(always)]
fn on_face(face: U32s, v: Vec3s) -> Vec3s {
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

/// A receiver's place on the map, and what its own plane looks like there.
struct SpotReceiver {
    face: U32s,
    texel: [F32s; 2],
    /// 1 / depth, and how it changes along the receiver's plane from texel to texel.
    inverse_depth: F32s,
    step: [F32s; 2],
    /// How much nearer to the source the map may have something, as a depth of the map, for the receiver to be lit: by
    /// all that the map can tell, and if what is near is left to the scene.
    tolerance: F32s,
    reach: F32s,
    /// Least and greatest 1 / depth that the receiver's plane is taken to have in the texels around.
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
        let (zero, one, side) = (F32s::splat(0.0), F32s::splat(1.0), F32s::splat(map.side() as f32));
        let [dx, dy] = self.step;
        let start = self.inverse_depth + (dx * (first[0] - self.texel[0]) + dy * (first[1] - self.texel[1]));
        let planes = [start, start + dx, start + dy, start + (dx + dy)];
        let stored = gathered(map, self.face, first);
        // Nothing throws shadows beyond the map, but floors that it is not fitted to are drawn up to its border.
        let (right, bottom) = (first[0] + one, first[1] + one);
        let left_beyond = first[0].lt(zero) | first[0].ge(side);
        let right_beyond = right.lt(zero) | right.ge(side);
        let top_beyond = first[1].lt(zero) | first[1].ge(side);
        let bottom_beyond = bottom.lt(zero) | bottom.ge(side);
        let beyond = [
            left_beyond | top_beyond,
            right_beyond | top_beyond,
            left_beyond | bottom_beyond,
            right_beyond | bottom_beyond,
        ];
        let mut lit = LitTexels { told: beyond, left: beyond };
        for k in 0..4 {
            let expected = planes[k].within(self.bounds[0], self.bounds[1]) * self.near;
            lit.told[k] = lit.told[k] | stored[k].le(expected + self.tolerance);
            lit.left[k] = lit.left[k] | stored[k].le(expected + self.reach);
        }
        lit
    }
}

impl Spot {
    /// How much of the arriving light nothing is in the way of, where it is `asked`.
    ///
    /// Each texel is compared with the depth that the receiver's own plane has on the ray through that texel's centre,
    /// so that a plane cannot shadow itself. On the ray (x, y, 1) the plane through p has 1 / depth = n.(x, y, 1) /
    /// n.p: linear in (x, y).
    #[inline(always)]
    pub(super) fn visibility(
        &self,
        scene: &Scene,
        map: &DepthMap,
        surface: &Surface,
        to_light: Vec3s,
        asked: Masks,
    ) -> F32s {
        let (zero, one, half) = (F32s::splat(0.0), F32s::splat(1.0), F32s::splat(0.5));
        // Light that arrives from behind meets the surface's other side.
        let mut asked = asked & F32s::dot(surface.normal, to_light).gt(zero);
        asked = asked & !in_their_own_way(scene, surface, to_light, asked);
        if !asked.any() {
            return zero;
        }
        // A facet that faces away lies behind the plane of the smooth surface.
        let faces_light = F32s::dot(surface.geometric_normal, to_light).gt(zero);
        let normal = F32s::select_vec(faces_light, surface.geometric_normal, surface.normal);
        let in_light = self.frame.position(surface.shadow_position());
        let face = if map.faces() > 1 { face_of(in_light) } else { U32s::splat(0) };
        let position = on_face(face, in_light);
        let normal = on_face(face, self.frame.vector(normal));
        let depth = position.z.most(F32s::splat(1e-30));
        let fit = self.fit_of(face);
        let side = F32s::splat(map.side() as f32);

        let slopes = [F32s::splat(2.0) / (fit[2] * side), F32s::splat(2.0) / (fit[3] * side)];
        let texel_slope = slopes[0].most(slopes[1]);
        let plane_distance = F32s::dot(normal, position).least(F32s::splat(-1e-30));
        let way_length = F32s::length(position);
        let inverse_depth = one / depth;
        let stored_depth = F32s::splat(self.map.near) * inverse_depth;
        let per_distance = one / plane_distance;
        let step = [normal.x * per_distance * slopes[0], -(normal.y * per_distance * slopes[1])];

        // A neighbouring facet that rises out of this plane by 0.25 rad is not an occluder: that many texels of depth,
        // more where light grazes. And the map's depth, linear across a triangle, is off by some ulps of its largest
        // value, 1.
        let cosine = plane_distance / way_length;
        let rise = F32s::splat(0.25) * texel_slope / (cosine * cosine).most(F32s::splat(0.06));
        // The receiver's own caster may stray by e towards the light: with n.p = D < 0 the plane, moved so far along
        // its normal, has 1 / depth larger by the share e / (|D| - e), at most by its own size; light grazes at a
        // cosine of 0.1.
        let error = F32s::splat(self.map.mesh_error);
        let plane_height = (-plane_distance).most(F32s::splat(0.1) * way_length);
        let room = (plane_height - error).most(error);
        let strayed = F32s::select(room.gt(zero), error / room, zero);
        let tolerance = (rise + strayed) * stored_depth + F32s::splat(DEPTH_ROUNDING);

        // Seen edge on, the plane runs off to the source or to infinity within a texel: it is followed to the texels
        // around, but for the first tenth of light's way.
        let run = (step[0] * step[0] + step[1] * step[1]).sqrt() * depth;
        let around = F32s::splat(1.5) * run;
        let tenth = F32s::splat(0.9);
        let most =
            (F32s::splat(REACH) * texel_slope).least(half).most((around / (one + around)).least(tenth));
        let receiver = SpotReceiver {
            face,
            texel: [
                ((position.x * inverse_depth - fit[0]) * fit[2] * half + half) * side - half,
                (half - (position.y * inverse_depth - fit[1]) * fit[3] * half) * side - half,
            ],
            inverse_depth,
            step,
            tolerance,
            reach: tolerance.most(most / (one - most) * stored_depth),
            bounds: [(one - most) * inverse_depth, inverse_depth / (one - most)],
            near: F32s::splat(self.map.near),
        };
        let shares = filtered(&receiver, map, self.map.filter);

        // Beside the receiver a steep caster may be nearer than it is here: so the scene is asked for twice the reach,
        // and as far as the plane runs in the texels around.
        let grazes = asked & (!faces_light | run.gt(F32s::splat(GRAZING) * texel_slope));
        let way = to_light * (way_length * (F32s::splat(3.0) * most).least(tenth));
        F32s::select(asked, decided(scene, surface, shares, grazes, way), zero)
    }

    /// Middle and 1 / half size of what is drawn of faces, as slopes.
    #[inline(always)]
    fn fit_of(&self, face: U32s) -> [F32s; 4] {
        let [x, y, per_x, per_y] = self.map.fits[0];
        let mut fit = [F32s::splat(x), F32s::splat(y), F32s::splat(per_x), F32s::splat(per_y)];
        // Sixteen pixels that lie together mostly lie on one face.
        for (other, [x, y, per_x, per_y]) in (1..).zip(&self.map.fits[1..]) {
            let here = face.equals(U32s::splat(other));
            if here.any() {
                fit[0] = F32s::select(here, F32s::splat(*x), fit[0]);
                fit[1] = F32s::select(here, F32s::splat(*y), fit[1]);
                fit[2] = F32s::select(here, F32s::splat(*per_x), fit[2]);
                fit[3] = F32s::select(here, F32s::splat(*per_y), fit[3]);
            }
        }
        fit
    }
}
