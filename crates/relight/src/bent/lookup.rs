//! Position of a receiver on the faces of a bent map, like `bent_lookup.wgsl`. The faces of a cube are its front, +V,
//! -V, +W and -W, in that order. (V, W, R / slope) are on it like positions on a straight cone. A map without a cube
//! has one face, linear in v and w.

use light::Lanes;

use super::BentMapParams;
use crate::lanes::{F32s, Masks, U32s};
use crate::visibility::{fit_of, texel_at};

pub(super) type Pair = [F32s; 2];

#[derive(Clone, Copy, Debug)]
pub(super) struct MapTexel {
    pub face: U32s,
    pub texel: Pair,
    /// Change of (v, w) from texel to texel, to the right and downwards.
    pub right: Pair,
    pub down: Pair,
    /// Depth on the face per unit of t. On a straight cone it is the distance along the face's own axis. The next field
    /// is its change from one texel to the next one below.
    pub gain: F32s,
    pub gain_down: F32s,
    /// Depth that corresponds to a stored value of 1.
    pub far: F32s,
}

/// Computes the texel that contains (V, W) where the tube has this `radius`, on a map of `side` texels.
#[inline(always)]
pub(super) fn map_texel(map: &BentMapParams, side: f32, [v_len, w_len]: Pair, radius: F32s) -> MapTexel {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    // At the source the radius is 0, and so are V and W.
    let radius = F32s::select(radius.gt(zero), radius, one);
    let resolution = F32s::splat(side);
    let Some(slope) = map.slope else {
        let fit = fit_of(&map.fits[..1], U32s::splat(0));
        let step = [F32s::splat(2.0) / (fit[2] * resolution), F32s::splat(-2.0) / (fit[3] * resolution)];
        return MapTexel {
            face: U32s::splat(0),
            texel: texel_at(fit, [v_len / radius, w_len / radius], resolution),
            right: [step[0], zero],
            down: [zero, step[1]],
            gain: one,
            gain_down: zero,
            far: F32s::splat(map.t_span),
        };
    };
    let slope = F32s::splat(slope);
    let depth = radius / slope;
    let (aside_v, aside_w) = (v_len.abs(), w_len.abs());
    let front = depth.ge(aside_v.most(aside_w));
    let along_v = aside_v.ge(aside_w);
    let turned = [F32s::select(along_v, v_len, w_len), F32s::select(along_v, w_len, v_len)];
    let ahead = F32s::select(front, depth, turned[0].abs());
    let face = face_of(front, along_v, turned[0].gt(zero));
    let xy = [F32s::select(front, v_len, turned[1]) / ahead, F32s::select(front, w_len, depth) / ahead];
    let fit = fit_of(&map.fits, face);
    let step = [F32s::splat(2.0) / (fit[2] * resolution), F32s::splat(-2.0) / (fit[3] * resolution)];
    // On a side x = w / |v| and y = 1 / (slope |v|), or the same with v and w exchanged.
    let size = ahead / radius;
    let away = -slope * size * size * step[1];
    let sign = F32s::select(turned[0].gt(zero), one, F32s::select(turned[0].lt(zero), -one, zero));
    let (side_right, side_down) = ([zero, size * step[0]], [sign * away, xy[0] * away]);
    let (side_right, side_down) = (turned_back(along_v, side_right), turned_back(along_v, side_down));
    let span = F32s::splat(map.t_span);
    MapTexel {
        face,
        texel: texel_at(fit, xy, resolution),
        right: [F32s::select(front, step[0] / slope, side_right[0]), F32s::select(front, zero, side_right[1])],
        down: [F32s::select(front, zero, side_down[0]), F32s::select(front, step[1] / slope, side_down[1])],
        gain: F32s::select(front, one, slope * size),
        gain_down: F32s::select(front, zero, slope * away),
        far: F32s::select(front, span, span * slope),
    }
}

/// Returns a step on a side of +-V unchanged, and a step on a side of +-W with v and w exchanged.
#[inline(always)]
fn turned_back(along_v: Masks, [a, b]: Pair) -> Pair {
    [F32s::select(along_v, a, b), F32s::select(along_v, b, a)]
}

#[inline(always)]
fn face_of(front: Masks, along_v: Masks, positive: Masks) -> U32s {
    let on_v = U32s::select(positive, U32s::splat(1), U32s::splat(2));
    let on_w = U32s::select(positive, U32s::splat(3), U32s::splat(4));
    U32s::select(front, U32s::splat(0), U32s::select(along_v, on_v, on_w))
}
