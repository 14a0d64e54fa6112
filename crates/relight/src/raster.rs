//! Draws triangles as a light sees them onto a face of its shadow map: the depth of what is nearest, a texel.
//!
//! What Vulkan's rules ask of a driver with 8 bits of a texel: corners are rounded to 1/256 of a texel, a triangle
//! covers the texels whose centres are in it, and centres on an edge by the top-left rule. Both windings are drawn.
//!
//! In two steps, each on all threads. Set-up finds where triangles lie, 16 at once, and lists them by bands of rows.
//! Then each band is drawn by one thread. Which depth wins does not depend on the order, and so a map has the same bytes
//! however many threads draw it.

mod alpha_tested;
mod clip;
mod large;
mod project;
mod rule;
mod setup;
mod small;
#[cfg(test)]
mod tests;
mod wide;

use std::hint::black_box;

use glam::Mat3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use crate::alpha_test::AlphaTests;
use crate::depth_map::stride;
use crate::{Cancelled, Workers};
use alpha_tested::AlphaTestedPiece;
use project::Projection;
use rule::{BentDepthTest, DepthTest, OrthographicDepthTest, PerspectiveDepthTest};
use setup::{OpaquePiece, SetUp};
use wide::{Ints, LANE_INDICES};

/// Rows that one thread draws at once. Of a map 2048 texels wide they take half a megabyte, which stays next to the core.
const BAND: usize = 64;
/// Texels of bounding boxes after which a thread looks whether it has to give way: some tens of microseconds.
const YIELD_CHECK_TEXELS: usize = 1 << 16;
/// What small triangles count as between two looks.
const YIELD_CHECK_TRIANGLES: usize = 1 << 10;
/// Triangles that one thread sets up at once.
const TRIANGLES_PER_PIECE: usize = 2048;
/// Most texels a side: corners in 1/256 of a texel are exact in f32 as far as the guard band, which is twice as wide.
pub const MAX_SIDE: usize = 8192;

/// Three corners: each a homogeneous place (X, Y, Z), and a value that perspective interpolates.
pub type RasterTriangle = [[f32; 4]; 3];

/// A triangle with an alpha test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaTestedTriangle {
    /// As others have them.
    pub corners: RasterTriangle,
    /// (u, v, alpha) of each corner.
    pub uv_alpha: [[f32; 3]; 3],
    /// Which of the tests it has.
    pub test: u32,
}

/// Triangles with alpha tests, to be drawn with others.
#[derive(Clone, Copy, Debug)]
pub struct AlphaTestedTriangles<'a, Chunk> {
    /// The triangles.
    pub chunks: &'a [Chunk],
    /// All tests.
    pub tests: AlphaTests<'a>,
}

/// What a texel stores of what is nearest there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthRule {
    /// The least `value * depth_per_value / (row[0] + row[1] * (i + 0.5))` in row `i`, at least 0; 1 where there is
    /// nothing. What has w >= 10^-30 is drawn.
    Bent {
        /// What depths are divided by: the first, plus the second for each row.
        row_divisor: [f32; 2],
        /// Depth of a value of 1.
        depth_per_value: f32,
    },
    /// The greatest `near / w`; 0 where there is nothing. What has w < `near` is cut away.
    Perspective {
        /// Positive.
        near: f32,
    },
    /// The greatest value within 0 and 1; 0 where there is nothing. What has others is cut away. For places with w = 1.
    Orthographic,
}

/// How a face of a map is drawn.
#[derive(Clone, Copy, Debug)]
pub struct MapFace {
    /// From places to clip coordinates (x, y, w): |x| <= w and |y| <= w are on the face, y is up.
    pub clip_from_map: Mat3,
    /// What is stored.
    pub depths: DepthRule,
}

/// Memory of [`draw_face_with_alpha_tests`], kept from one drawing to the next.
#[derive(Debug, Default)]
pub struct RasterMemory {
    pieces: Vec<OpaquePiece>,
    alpha_tested: Vec<AlphaTestedPiece>,
    /// For [`DepthTest::row_factor`].
    rows: Vec<f32>,
}

/// As [`draw_face_with_alpha_tests`] without any that have some, onto rows without gaps.
#[cfg(test)]
fn draw_face<Chunk: AsRef<[RasterTriangle]> + Sync>(
    face: &MapFace,
    chunks: &[Chunk],
    workers: &Workers,
    scratch: &mut RasterMemory,
    texels: &mut [f32],
    side: usize,
) {
    let none = AlphaTestedTriangles::<&[AlphaTestedTriangle]> { chunks: &[], tests: AlphaTests::default() };
    let mut with_gaps = vec![0.0; side * stride(side)];
    draw_face_with_alpha_tests(face, chunks, &none, workers, scratch, &mut with_gaps, side)
        .expect("not cancelled");
    texels.copy_from_slice(&without_gaps(&with_gaps, side));
}

/// A face's rows without the room behind them.
#[cfg(test)]
fn without_gaps(texels: &[f32], side: usize) -> Vec<f32> {
    texels.chunks(stride(side)).flat_map(|row| &row[..side]).copied().collect()
}

/// Draws triangles, and those that have holes, onto a face of `side` texels a side: `texels`, as a [`DepthMap`] has them.
pub fn draw_face_with_alpha_tests<
    Chunk: AsRef<[RasterTriangle]> + Sync,
    HoledChunk: AsRef<[AlphaTestedTriangle]> + Sync,
>(
    face: &MapFace,
    chunks: &[Chunk],
    alpha_tested: &AlphaTestedTriangles<HoledChunk>,
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
    let set_up = |(piece, triangles): (&mut OpaquePiece, &[RasterTriangle])| {
        Arch::new().dispatch(SetUp { piece, triangles, projection: &projection });
    };
    let set_up_alpha_tested = |(piece, triangles): (&mut AlphaTestedPiece, &[AlphaTestedTriangle])| {
        piece.set_up(triangles, &projection);
    };
    workers.run(|| {
        pieces.par_iter_mut().zip(slices.into_par_iter()).for_each(set_up);
        alpha_tested_pieces.par_iter_mut().zip(alpha_tested_slices.into_par_iter()).for_each(set_up_alpha_tested);
    });
    let seen = SetUpTriangles { pieces, alpha_tested: alpha_tested_pieces, tests: alpha_tested.tests };
    match face.depths {
        DepthRule::Bent { row_divisor: [first, each], depth_per_value } => {
            let in_row = |row: usize| (first + each * (row as f32 + 0.5)) / depth_per_value;
            rows.clear();
            rows.extend((0..side).map(in_row));
            draw_bands(workers, BentDepthTest { rows }, seen, texels, side)
        }
        DepthRule::Perspective { .. } => draw_bands(workers, PerspectiveDepthTest, seen, texels, side),
        DepthRule::Orthographic => draw_bands(workers, OrthographicDepthTest, seen, texels, side),
    }
}

/// Everything that is drawn, set up.
#[derive(Clone, Copy)]
struct SetUpTriangles<'a> {
    pieces: &'a [OpaquePiece],
    alpha_tested: &'a [AlphaTestedPiece],
    tests: AlphaTests<'a>,
}

/// Draws all bands of a face. Some cost much more than others, and one may take long.
fn draw_bands<R: DepthTest>(
    workers: &Workers,
    rule: R,
    seen: SetUpTriangles,
    texels: &mut [f32],
    side: usize,
) -> Result<(), Cancelled> {
    let bands = texels.chunks_mut((BAND * stride(side)).max(1)).enumerate();
    let bands = bands.map(|(index, texels)| BandWork { index, texels, next: None });
    workers.each(bands, |work| {
        Arch::new().dispatch(DrawBand { rule, seen, work, stride: stride(side), workers })
    })
}

/// A band, and how far it is drawn.
struct BandWork<'a> {
    index: usize,
    texels: &'a mut [f32],
    /// The piece that is next, those with holes behind the others, and the triangle in it; `None` before it is cleared.
    next: Option<(usize, usize)>,
}

/// Rows of a face while they are drawn.
struct Band<'a> {
    /// The first row, and the one after the last.
    first: usize,
    end: usize,
    /// Texels from one row to the next.
    stride: usize,
    texels: &'a mut [f32],
    /// [`LANE_INDICES`], which the compiler does not see through: what it makes of products with 0, 1, 2 and so on is slower.
    lane_indices: Ints,
}

/// Goes on with a band. False where it has to give way.
struct DrawBand<'a, 'b, R> {
    rule: R,
    seen: SetUpTriangles<'a>,
    work: &'a mut BandWork<'b>,
    stride: usize,
    workers: &'a Workers,
}

impl<R: DepthTest> WithSimd for DrawBand<'_, '_, R> {
    type Output = bool;

    #[expect(clippy::inline_always, reason = "pulp compiles it for the vectors that it found")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let Self { rule, seen, work: BandWork { index, texels, next }, stride, workers } = self;
        let index = *index;
        let (mut piece, mut triangle) = next.unwrap_or_else(|| {
            texels.fill(R::CLEARED);
            (0, 0)
        });
        let (first, height) = (index * BAND, texels.len() / stride);
        let mut band =
            Band { first, end: first + height, stride, texels, lane_indices: black_box(LANE_INDICES) };
        let mut looked_at = 0;
        while piece < seen.pieces.len() + seen.alpha_tested.len() {
            if let Some(of_piece) = seen.pieces.get(piece) {
                let (large, small) = (&of_piece.large_by_band[index], &of_piece.small_by_band[index]);
                while triangle < large.len() {
                    let of_large = &of_piece.large[large[triangle] as usize];
                    large::draw(rule, of_large, &mut band);
                    triangle += 1;
                    looked_at += of_large.texels_in(&band);
                    if looked_at > YIELD_CHECK_TEXELS {
                        looked_at = 0;
                        if workers.should_yield() {
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
                    if workers.should_yield() {
                        *next = Some((piece, triangle));
                        return false;
                    }
                }
            } else {
                let alpha_tested = &seen.alpha_tested[piece - seen.pieces.len()];
                while triangle < alpha_tested.count_in(index) {
                    looked_at += alpha_tested.draw(rule, seen.tests, (index, triangle), &mut band);
                    triangle += 1;
                    if looked_at > YIELD_CHECK_TEXELS {
                        looked_at = 0;
                        if workers.should_yield() {
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
