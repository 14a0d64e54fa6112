//! Tests for edges that are straight in a bent map and for triangles that show in it, like `bent_map.wgsl`. Each works
//! on one edge and on sixteen.

use light::{Curve, Lanes, Mask};

use super::casters::{BentFace, BentMap};
use super::slab::TubePosition;

/// Kind of an open surface without an alpha test. On a closed surface light meets only the front.
pub(super) const OPEN: u32 = u32::MAX;
/// Kind of a closed surface whose triangles face inwards. `OPEN - 1` is the kind of one whose triangles face outwards.
pub(super) const INSIDE_OUT: u32 = u32::MAX - 2;
/// Largest shift of a corner by rasterization, in the finest texels: to a grid of 1/16 texel, the coarsest that Vulkan
/// allows, of texels that are up to four times as wide in the other direction. The grid of this crate is finer, but
/// both backends must drop the same triangles.
const SNAP_TEXELS: f64 = 0.25;
/// Bound of the rounding error of a position of size 1, the length of the light: four roundings.
const POSITION_ROUNDING: f64 = 1.0 / 4_194_304.0;

/// Edge of a triangle: its ends in tube space, and their tube coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge<F: Lanes> {
    pub qa: F::Vec3,
    pub a: TubePosition<F>,
    pub qb: F::Vec3,
    pub b: TubePosition<F>,
}

impl<F: Lanes> Edge<F> {
    /// True if the edge is certainly straight in the map, because it is short or nearly orthogonal to the light.
    /// `bounds` are the edge bounds of the slab.
    #[inline(always)]
    pub fn is_safe(&self, bounds: [F; 4]) -> F::Mask {
        let dt = (self.b.t - self.a.t).abs();
        let length = F::length(self.qb - self.qa);
        let error = (bounds[0] * dt + bounds[1] * length) * dt;
        error.le(self.a.r.least(self.b.r)) & (bounds[2] * dt + bounds[3] * length).le(F::of(1.0))
    }
}

/// Returns the number of texels per unit of v and w at a point. Texels of a cube have the same angular width, so there
/// are fewer per unit far from its axis.
#[inline(always)]
fn texels_at<F: Lanes>(map: &BentMap, v: F, w: F) -> F {
    let texels = F::of(f64::from(map.texels_per_vw));
    match map.cube_slope {
        None => texels,
        Some(slope) => texels / (F::of(f64::from(slope)) * v.abs().most(w.abs())).most(F::of(1.0)),
    }
}

/// True if light meets the back of a triangle of a closed surface. Another part of the surface then shadows it. False
/// where the rounding of corners might turn the triangle round. `turned` is 1 for an inside-out surface, else -1.
#[inline(always)]
pub(super) fn faces_away<F: Lanes>(map: &BentMap, [a, b, c]: [&TubePosition<F>; 3], turned: F) -> F::Mask {
    let has_width = a.r.least(b.r.least(c.r)).gt(F::of(0.0));
    let (v, w) = (a.v / a.r, a.w / a.r);
    let ab = [b.v / b.r - v, b.w / b.r - w];
    let ac = [c.v / c.r - v, c.w / c.r - w];
    // Seen along the light, the rotation from v to w is clockwise. A triangle that turns from v to w faces away from
    // the source.
    let area = turned * (ab[0] * ac[1] - ab[1] * ac[0]);
    let around = length2(ab) + length2(ac) + length2([ac[0] - ab[0], ac[1] - ab[1]]);
    has_width & area.lt(-(around * F::of(SNAP_TEXELS) / texels_at(map, v, w)))
}

#[inline(always)]
fn length2<F: Lanes>([x, y]: [F; 2]) -> F {
    (x * x + y * y).sqrt()
}

/// True if a triangle's image lies beyond one side of the drawn part of each face. `bow` is the largest deviation of
/// (V, W, R) from the straight edges, as a length in tube space. The inside of a quadratic triangle deviates by at most
/// 4/3 of the deviation at the middles of its edges; a factor of 2 leaves room for more.
#[inline(always)]
pub(super) fn off_map<F: Lanes>(map: &BentMap, corners: [&TubePosition<F>; 3], bow: F) -> F::Mask {
    let mut off = F::Mask::of(true);
    for face in map.faces {
        off = off & off_face(face, corners, F::of(2.0) * bow);
    }
    off
}

#[inline(always)]
fn off_face<F: Lanes>(face: &BentFace, corners: [&TubePosition<F>; 3], bow: F) -> F::Mask {
    let m = &face.clip_from_mapped;
    let rows = [m.row(0), m.row(1), m.row(2)];
    let margin = across(rows[2], bow);
    let [depth_a, depth_b, depth_c] = clip_coordinates(rows[2], corners);
    let outer = [depth_a + margin, depth_b + margin, depth_c + margin];
    let zero = F::of(0.0);
    outer[0].lt(zero) & outer[1].lt(zero) & outer[2].lt(zero)
        | beyond(clip_coordinates(rows[0], corners), outer, across(rows[0], bow))
        | beyond(clip_coordinates(rows[1], corners), outer, across(rows[1], bow))
}

/// Computes a clip coordinate of each corner.
#[inline(always)]
fn clip_coordinates<F: Lanes>(row: glam::Vec3, [a, b, c]: [&TubePosition<F>; 3]) -> [F; 3] {
    [clip_coordinate(row, a), clip_coordinate(row, b), clip_coordinate(row, c)]
}

#[inline(always)]
fn clip_coordinate<F: Lanes>(row: glam::Vec3, at: &TubePosition<F>) -> F {
    F::of(f64::from(row.x)) * at.v + F::of(f64::from(row.y)) * at.w + F::of(f64::from(row.z)) * at.r
}

/// Returns the largest deviation of a clip coordinate, from the deviation `bow` of (V, W, R).
#[inline(always)]
fn across<F: Lanes>(row: glam::Vec3, bow: F) -> F {
    bow * F::of(f64::from(row.abs().element_sum()))
}

/// True if all three points lie beyond one of the two sides.
#[inline(always)]
fn beyond<F: Lanes>(x: [F; 3], outer: [F; 3], margin: F) -> F::Mask {
    let (a, b, c) = (outer[0] + margin, outer[1] + margin, outer[2] + margin);
    (x[0].gt(a) & x[1].gt(b) & x[2].gt(c)) | (x[0].lt(-a) & x[1].lt(-b) & x[2].lt(-c))
}

/// Returns the deviation of (V, W, R) from a straight edge, as a length in tube space.
#[inline(always)]
pub(super) fn edge_error<F: Lanes>(mapped: &TubePosition<F>, straight: &TubePosition<F>) -> F {
    length2([mapped.v - straight.v, mapped.w - straight.w]) + (mapped.r - straight.r).abs()
}

/// Returns the speed of the light path at (v, w) as a multiple of the center's speed, on a cube. It is 1 on a map with
/// one face.
#[inline(always)]
fn stretch_at<F: Lanes>(map: &BentMap, curve: &Curve<F>, v: F, w: F) -> F {
    if map.cube_slope.is_none() {
        return F::of(1.0);
    }
    let half = F::of(0.5);
    let speed = (F::of(2.0) * F::length(curve.d(half))).most(F::of(1e-20));
    let spread = curve.radius_derivative(half) * length2([v, w]).least(F::of(1.5)) / speed;
    length2([F::of(1.0), spread])
}

/// True if a point's image deviates too far from the straight edge, in texels: across the map, and along the light as
/// its length in the scene. `t_span` is the slab's.
#[inline(always)]
pub(super) fn exceeds_tolerance<F: Lanes>(
    map: &BentMap,
    curve: &Curve<F>,
    t_span: F,
    q: F::Vec3,
    mapped: &TubePosition<F>,
    straight: &TubePosition<F>,
) -> F::Mask {
    let zero = F::of(0.0);
    let has_width = mapped.r.least(straight.r).gt(zero);
    let (v, w) = (straight.v / straight.r, straight.w / straight.r);
    let scale = texels_at(map, v, w);
    let stretch = stretch_at(map, curve, v, w);
    let across = length2([(mapped.v / mapped.r - v) * scale, (mapped.w / mapped.r - w) * scale]);
    let speed = F::of(2.0) * F::length(curve.d(F::of(0.5))) * stretch * scale / straight.r;
    let along = (mapped.t - straight.t) / t_span * speed;
    // In a very thin tube a texel is smaller than the rounding error of a position. Bends below that error are noise,
    // and splitting for them would not end.
    let rounding = F::of(POSITION_ROUNDING) * (F::of(1.0) + F::length(q)) * stretch * scale / straight.r;
    let most = F::of(f64::from(map.tolerance_texels)).most(rounding);
    has_width & across.most(along.abs()).gt(most)
}
