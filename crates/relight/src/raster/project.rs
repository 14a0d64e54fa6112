//! Projection of positions to texels of a face: of 16 corners at once, and of one alone, to the same bits.
#![expect(clippy::cast_possible_wrap, reason = "positions on a map are far below 2^31")]

use std::ops::RangeInclusive;

use glam::Mat3;
use light::Lanes;

use super::clip::ClipCorner;
use super::large::Corner;
use super::wide::{F32s, Ints, LANES};
use super::{DepthRule, MapFace, RasterTriangle};

/// Texels from the middle of a face to the end of the guard band, at which triangles are clipped.
const GUARD_TEXELS: f32 = 8192.0;
/// Number of rows of a map that one thread draws at once. Those of a map 2048 texels wide take half a megabyte, which
/// stays in a near cache.
const ROWS_PER_BAND_OF_MAP: usize = 64;
/// Least w of a drawn position. A position with a smaller w is as good as at the source. Quotients by a w that is not
/// smaller stay within f32.
const MIN_W: f32 = 1e-30;
/// Offset for rounding a float of at most 2^22: the sum has the nearest integer in its last bits.
const ROUND: f32 = 12_582_912.0;

/// Transform from positions to the texels of a face or a picture, and to the interpolated numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection {
    clip_from_map: Mat3,
    /// Width and height of the part that is drawn, in texels.
    pub size: [usize; 2],
    /// Number of rows that one thread draws at once.
    pub rows_per_band: usize,
    /// Least w. Smaller ones are clipped.
    pub least_w: f32,
    /// End of the guard band, as values of |x| / w and |y| / w.
    pub guard: [f32; 2],
    /// Scale and shift from x / w and -y / w to 1/256 of a texel from the center of the first one of the whole.
    scale: [f32; 2],
    shift: [f32; 2],
    /// Place of the drawn part's first texel in the whole, in 1/256 of a texel.
    offset: [i32; 2],
    /// Near plane if N is `near / w`; `None` if N is value / w.
    near: Option<f32>,
}

impl Projection {
    pub fn new(face: &MapFace, side: usize) -> Self {
        let near = match face.depths {
            DepthRule::Perspective { near } => Some(near),
            DepthRule::Bent { .. } | DepthRule::Orthographic => None,
        };
        Self {
            clip_from_map: face.clip_from_map,
            least_w: near.unwrap_or(MIN_W),
            near,
            ..Self::part_of([side; 2], [0, 0], [side; 2], ROWS_PER_BAND_OF_MAP)
        }
    }

    /// Makes the projection of clip coordinates (x, y, w) to a part of a picture of `whole` texels: that of `size` texels
    /// from `first` on. N is value / w. The part has the bits of the whole.
    pub fn part_of(whole: [usize; 2], first: [usize; 2], size: [usize; 2], rows_per_band: usize) -> Self {
        let half = whole.map(|side| 0.5 * side as f32);
        Self {
            clip_from_map: Mat3::IDENTITY,
            size,
            rows_per_band,
            least_w: MIN_W,
            guard: half.map(|half| GUARD_TEXELS / half),
            scale: half.map(|half| 256.0 * half),
            shift: half.map(|half| 256.0 * half - 128.0),
            offset: first.map(|texels| 256 * texels as i32),
            near: None,
        }
    }

    /// Returns the number of bands.
    pub fn band_count(&self) -> usize {
        self.size[1].div_ceil(self.rows_per_band)
    }

    /// Returns the first and the last band that hold these rows.
    pub fn bands_of(&self, rows: [i32; 2]) -> RangeInclusive<usize> {
        let [first, last] = rows.map(|row| row as usize / self.rows_per_band);
        first..=last
    }

    /// Transforms a corner to clip coordinates.
    pub fn clip(&self, [x, y, z, value]: [f32; 4]) -> ClipCorner<4> {
        let matrix = self.clip_from_map;
        let axis = |k: usize| {
            let yz = y.mul_add(matrix.y_axis[k], z * matrix.z_axis[k]);
            x.mul_add(matrix.x_axis[k], yz)
        };
        [axis(0), axis(1), axis(2), value]
    }

    /// Projects a corner with w > 0 in the guard band.
    pub fn corner(&self, [x, y, w, value]: ClipCorner<4>) -> Corner {
        let d = w.recip();
        let rounded = |ratio: f32, axis: usize| {
            let most = GUARD_TEXELS * 256.0 + self.scale[axis];
            let coordinate = ratio.mul_add(self.scale[axis], self.shift[axis]).clamp(-most, most);
            (coordinate + ROUND).to_bits().cast_signed() - ROUND.to_bits().cast_signed() - self.offset[axis]
        };
        Corner { at: [rounded(x * d, 0), rounded(-(y * d), 1)], n: self.near.unwrap_or(value) * d, d }
    }
}

/// Corners of sixteen triangles, projected onto a face.
#[derive(Clone, Copy)]
pub(super) struct Corners {
    pub clip: [F32s; 4],
    pub at: [Ints; 2],
    pub n: F32s,
    pub d: F32s,
}

/// Transposes triangles into X, Y, Z and the value of each corner. It is not inlined, because compilers make slower
/// code of it among other code.
#[inline(never)]
pub(super) fn transpose_corners(group: &[RasterTriangle; LANES]) -> [[F32s; 4]; 3] {
    let mut transposed = [[F32s::ZERO; 4]; 3];
    for (lane, triangle) in group.iter().enumerate() {
        for corner in 0..3 {
            for axis in 0..4 {
                transposed[corner][axis].0[lane] = triangle[corner][axis];
            }
        }
    }
    transposed
}

/// Projects one corner of sixteen triangles.
#[inline(always)]
pub(super) fn project(position: &[F32s; 4], projection: &Projection) -> Corners {
    let matrix = projection.clip_from_map;
    let clip = [
        clip_axis(position, matrix.x_axis.x, matrix.y_axis.x, matrix.z_axis.x),
        clip_axis(position, matrix.x_axis.y, matrix.y_axis.y, matrix.z_axis.y),
        clip_axis(position, matrix.x_axis.z, matrix.y_axis.z, matrix.z_axis.z),
        position[3],
    ];
    let d = F32s::splat(1.0) / clip[2];
    let Projection { scale, shift, offset, .. } = projection;
    let right = (clip[0] * d).times_plus(F32s::splat(scale[0]), F32s::splat(shift[0]));
    let down = (clip[1] * d).times_plus(F32s::splat(-scale[1]), F32s::splat(shift[1]));
    let at = [rounded(right) - Ints::splat(offset[0]), rounded(down) - Ints::splat(offset[1])];
    let n = match projection.near {
        Some(near) => F32s::splat(near) * d,
        None => position[3] * d,
    };
    Corners { clip, at, n, d }
}

#[inline(always)]
fn clip_axis(position: &[F32s; 4], x: f32, y: f32, z: f32) -> F32s {
    let yz = position[1].times_plus(F32s::splat(y), position[2] * F32s::splat(z));
    position[0].times_plus(F32s::splat(x), yz)
}

#[inline(always)]
fn rounded(x: F32s) -> Ints {
    (x + F32s::splat(ROUND)).bits() - Ints::splat(ROUND.to_bits().cast_signed())
}

/// Returns a condition that holds in lanes whose corners need no clipping.
#[inline(always)]
pub(super) fn is_inside(corners: &Corners, projection: &Projection) -> Ints {
    let [x, y, w, _] = corners.clip;
    let [right, down] = projection.guard.map(|guard| w * F32s::splat(guard));
    F32s::splat(projection.least_w).at_most(w) | x.abs().at_most(right) | y.abs().at_most(down)
}
