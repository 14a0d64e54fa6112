//! Rasterizer of triangles onto a face of a shadow map, seen by the light. Each texel gets the depth of the nearest.
//!
//! It follows Vulkan's rules for a driver with 8 subtexel bits. Corners are rounded to 1/256 of a texel. A triangle
//! covers the texels whose centers are in it, and centers on an edge by the top-left rule. Both windings are drawn.
//!
//! It works in two steps, each on all threads. Set-up finds the positions of triangles, 16 at once, and lists them by
//! bands of rows. Then one thread draws each band. The depth that wins does not depend on the order, so any number of
//! threads makes the same bytes.

mod alpha_tested;
mod clip;
mod ids;
mod large;
mod project;
mod rule;
mod setup;
mod small;
#[cfg(test)]
mod tests;
mod visibility_buffer;
mod wide;

use std::hint::black_box;

use glam::Mat3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::alpha_test::AlphaTests;
use crate::depth_map::stride;
use crate::{Cancelled, Workers};
use alpha_tested::AlphaTestedPiece;
use ids::TriangleIds;
use project::Projection;
use rule::{BentDepthTest, DepthTest, OrthographicDepthTest, PerspectiveDepthTest};
use setup::{OpaquePiece, SetUp, Triangles};
use wide::{Ints, LANE_INDICES};

pub use visibility_buffer::{PicturePart, VisibilityBuffer, VisibilityBuilder, VisibleTriangles};

/// Number of texels in bounding boxes after which a thread checks if it must yield: some tens of microseconds.
const YIELD_CHECK_TEXELS: usize = 1 << 16;
/// Number of small triangles after which a thread checks if it must yield.
const YIELD_CHECK_TRIANGLES: usize = 1 << 10;
/// Triangles that one thread sets up at once.
const TRIANGLES_PER_PIECE: usize = 2048;
/// Largest side of a face in texels. Corners in 1/256 of a texel are exact in f32 up to the guard band, which is twice
/// as wide.
pub const MAX_SIDE: usize = 8192;

/// Three corners: each a homogeneous position (X, Y, Z), and a value for perspective interpolation.
pub type RasterTriangle = [[f32; 4]; 3];

/// Triangle with an alpha test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaTestedTriangle {
    pub corners: RasterTriangle,
    /// (u, v, alpha) of each corner.
    pub uv_alpha: [[f32; 3]; 3],
    /// Index of the triangle's alpha test.
    pub test: u32,
}

/// Alpha-tested triangles that are drawn together with opaque ones.
#[derive(Clone, Copy, Debug)]
pub struct AlphaTestedTriangles<'a, Chunk> {
    pub chunks: &'a [Chunk],
    pub tests: AlphaTests<'a>,
}

/// Rule for the depth that a texel stores if several triangles cover it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthRule {
    /// Least `value * depth_per_value / (row[0] + row[1] * (i + 0.5))` in row `i`, at least 0; 1 without a triangle.
    /// Draws the part with w >= 10^-30.
    Bent {
        /// Divisor of depths in a row of texels: the first number, plus the second number times the row.
        row_divisor: [f32; 2],
        /// Depth of a value of 1.
        depth_per_value: f32,
    },
    /// Greatest `near / w`; 0 without a triangle. Clips the part with w < `near`.
    Perspective {
        /// Distance of the near plane, more than 0.
        near: f32,
    },
    /// Greatest value from 0 to 1; 0 without a triangle. Discards other values. For positions with w = 1.
    Orthographic,
}

/// Face of a map to draw.
#[derive(Clone, Copy, Debug)]
pub struct MapFace {
    /// Transform from positions to clip coordinates (x, y, w). |x| <= w and |y| <= w are on the face, and y is up.
    pub clip_from_map: Mat3,
    pub depths: DepthRule,
}

/// Work memory of [`draw_face`], reused from one face to the next.
#[derive(Debug, Default)]
pub struct RasterMemory {
    pieces: Vec<OpaquePiece>,
    alpha_tested: Vec<AlphaTestedPiece>,
    /// Factor [`DepthTest::row_factor`] of each row.
    rows: Vec<f32>,
}

/// Draws triangles, opaque and alpha-tested, onto a face of `side` texels a side. `texels` has the layout of a
/// [`DepthMap`].
pub fn draw_face<Chunk: AsRef<[RasterTriangle]> + Sync, AlphaTestedChunk: AsRef<[AlphaTestedTriangle]> + Sync>(
    face: &MapFace,
    chunks: &[Chunk],
    alpha_tested: &AlphaTestedTriangles<AlphaTestedChunk>,
    workers: &Workers,
    scratch: &mut RasterMemory,
    texels: &mut [f32],
    side: usize,
) -> Result<(), Cancelled> {
    assert!(side <= MAX_SIDE && texels.len() == side * stride(side), "a face of {side} texels a side");
    let RasterMemory { pieces, alpha_tested: alpha_tested_pieces, rows } = scratch;
    let slices: Vec<&[RasterTriangle]> =
        chunks.iter().flat_map(|chunk| chunk.as_ref().chunks(TRIANGLES_PER_PIECE)).collect();
    pieces.resize_with(slices.len(), OpaquePiece::default);
    let alpha_tested_slices: Vec<&[AlphaTestedTriangle]> =
        alpha_tested.chunks.iter().flat_map(|chunk| chunk.as_ref().chunks(TRIANGLES_PER_PIECE)).collect();
    alpha_tested_pieces.resize_with(alpha_tested_slices.len(), AlphaTestedPiece::default);
    let projection = Projection::new(face, side);
    workers.run(|| {
        pieces.par_iter_mut().zip(slices).for_each(|(piece, triangles)| {
            Arch::new().dispatch(SetUp { piece, triangles: Triangles::Listed(triangles), projection: &projection });
        });
        let alpha_tested = alpha_tested_pieces.par_iter_mut().zip(alpha_tested_slices);
        alpha_tested.for_each(|(piece, triangles)| piece.set_up(triangles, &projection));
    });
    let seen = SetUpTriangles { pieces, alpha_tested: alpha_tested_pieces, tests: alpha_tested.tests };
    match face.depths {
        DepthRule::Bent { row_divisor: [first, each], depth_per_value } => {
            rows.clear();
            rows.extend((0..side).map(|row| (first + each * (row as f32 + 0.5)) / depth_per_value));
            draw_bands(workers, BentDepthTest { rows }, seen, &projection, texels)
        }
        DepthRule::Perspective { .. } => draw_bands(workers, PerspectiveDepthTest, seen, &projection, texels),
        DepthRule::Orthographic => draw_bands(workers, OrthographicDepthTest, seen, &projection, texels),
    }
}

/// Triangles of a face after set-up.
#[derive(Clone, Copy)]
struct SetUpTriangles<'a> {
    pieces: &'a [OpaquePiece],
    alpha_tested: &'a [AlphaTestedPiece],
    tests: AlphaTests<'a>,
}

/// Draws all bands of a face. A thread takes the next band when it has finished one, because some bands take much
/// longer than others.
fn draw_bands<R: DepthTest>(
    workers: &Workers,
    rule: R,
    seen: SetUpTriangles,
    projection: &Projection,
    texels: &mut [f32],
) -> Result<(), Cancelled> {
    let length = (projection.rows_per_band * stride(projection.size[0])).max(1);
    let bands = texels.chunks_mut(length).enumerate();
    let bands = bands.map(|(index, texels)| BandWork { index, texels, ids: (), next: None });
    workers.each(bands, |work| Arch::new().dispatch(DrawBand { rule, seen, projection, work, workers }))
}

/// Band of a face, and the progress of drawing it.
struct BandWork<'a, Ids> {
    index: usize,
    texels: &'a mut [f32],
    ids: Ids,
    /// Next piece of triangles, and next triangle in it. Pieces with alpha-tested triangles come last. `None` before
    /// the band is cleared.
    next: Option<(usize, usize)>,
}

/// Rows of a face while they are drawn.
struct Band<'a, Ids> {
    /// Index of the first row, and of the row after the last.
    first: usize,
    end: usize,
    /// Number of texels from one row to the next.
    stride: usize,
    texels: &'a mut [f32],
    ids: &'a mut Ids,
    /// [`LANE_INDICES`], hidden from the compiler, which otherwise turns products with the constants 0, 1, 2 and so on
    /// into slower code.
    lane_indices: Ints,
}

/// Task that goes on with drawing a band. It returns false if the thread must yield before the band is finished.
struct DrawBand<'a, 'b, R, Ids> {
    rule: R,
    seen: SetUpTriangles<'a>,
    projection: &'a Projection,
    work: &'a mut BandWork<'b, Ids>,
    workers: &'a Workers,
}

impl<R: DepthTest, Ids: TriangleIds> WithSimd for DrawBand<'_, '_, R, Ids> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let Self { rule, seen, projection, work: BandWork { index, texels, ids, next }, workers } = self;
        let (index, stride) = (*index, stride(projection.size[0]));
        let (mut piece, mut triangle) = next.unwrap_or_else(|| {
            texels.fill(R::CLEARED);
            ids.clear();
            (0, 0)
        });
        let (first, height) = (index * projection.rows_per_band, texels.len() / stride);
        let mut band = Band { first, end: first + height, stride, texels, ids, lane_indices: black_box(LANE_INDICES) };
        let mut examined = 0;
        while piece < seen.pieces.len() + seen.alpha_tested.len() {
            if let Some(of_piece) = seen.pieces.get(piece) {
                let (large, small) = (&of_piece.large_by_band[index], &of_piece.small_by_band[index]);
                while triangle < large.len() {
                    let of_large = &of_piece.large[large[triangle] as usize];
                    large::draw(rule, of_large, &mut band);
                    triangle += 1;
                    examined += of_large.texels_in(&band);
                    if examined > YIELD_CHECK_TEXELS {
                        examined = 0;
                        if workers.yielding.should_yield() {
                            *next = Some((piece, triangle));
                            return false;
                        }
                    }
                }
                while triangle < large.len() + small.len() {
                    let from = triangle - large.len();
                    let some = &small[from..small.len().min(from + YIELD_CHECK_TRIANGLES)];
                    for of_small in some {
                        small::draw(rule, of_small, &mut band);
                    }
                    triangle += some.len();
                    if workers.yielding.should_yield() {
                        *next = Some((piece, triangle));
                        return false;
                    }
                }
            } else {
                let alpha_tested = &seen.alpha_tested[piece - seen.pieces.len()];
                while triangle < alpha_tested.count_in(index) {
                    examined += alpha_tested.draw(rule, seen.tests, index, triangle, &mut band);
                    triangle += 1;
                    if examined > YIELD_CHECK_TEXELS {
                        examined = 0;
                        if workers.yielding.should_yield() {
                            *next = Some((piece, triangle));
                            return false;
                        }
                    }
                }
            }
            (piece, triangle) = (piece + 1, 0);
        }
        true
    }
}
