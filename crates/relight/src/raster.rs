//! Draws triangles as a light sees them onto a face of its shadow map: the depth of what is nearest, a texel.
//!
//! What Vulkan's rules ask of a driver with 8 bits of a texel: corners are rounded to 1/256 of a texel, a triangle
//! covers the texels whose centres are in it, and centres on an edge by the top-left rule. Both windings are drawn.
//!
//! In two steps, each on all threads. Set-up finds where triangles lie, 16 at once, and lists them by bands of rows.
//! Then each band is drawn by one thread. Which depth wins does not depend on the order, and so a map has the same bytes
//! however many threads draw it.

mod clip;
mod holed;
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
use holed::HoledPiece;
use project::Projection;
use rule::{Bent, Orthographic, Perspective, Rule};
use setup::{Piece, SetUp};
use wide::{COUNT, Ints};

/// Rows that one thread draws at once. Of a map 2048 texels wide they take half a megabyte, which stays next to the core.
const BAND: usize = 64;
/// Texels of bounding boxes after which a thread looks whether it has to give way: some tens of microseconds.
const LOOK_AFTER: usize = 1 << 16;
/// What small triangles count as between two looks.
const SMALL_A_LOOK: usize = 1 << 10;
/// Triangles that one thread sets up at once.
const PIECE: usize = 2048;
/// Most texels a side: corners in 1/256 of a texel are exact in f32 as far as the guard band, which is twice as wide.
pub const MOST_SIDE: usize = 8192;

/// Three corners: each a homogeneous place (X, Y, Z), and a value that perspective interpolates.
pub type Triangle = [[f32; 4]; 3];

/// A triangle with an alpha test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoledTriangle {
    /// As others have them.
    pub corners: Triangle,
    /// (u, v, alpha) of each corner.
    pub uv_alpha: [[f32; 3]; 3],
    /// Which of the tests it has.
    pub test: u32,
}

/// Triangles with alpha tests, to be drawn with others.
#[derive(Clone, Copy, Debug)]
pub struct Holed<'a, Chunk> {
    /// The triangles.
    pub chunks: &'a [Chunk],
    /// All tests.
    pub tests: AlphaTests<'a>,
}

/// What a texel stores of what is nearest there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depths {
    /// The least `value * depth_per_value / (row[0] + row[1] * (i + 0.5))` in row `i`, at least 0; 1 where there is
    /// nothing. What has w >= 10^-30 is drawn.
    Bent {
        /// What depths are divided by: the first, plus the second for each row.
        row: [f32; 2],
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
pub struct Face {
    /// From places to clip coordinates (x, y, w): |x| <= w and |y| <= w are on the face, y is up.
    pub clip_from_place: Mat3,
    /// What is stored.
    pub depths: Depths,
}

/// Memory of [`draw_face_with_holes`], kept from one drawing to the next.
#[derive(Debug, Default)]
pub struct Scratch {
    pieces: Vec<Piece>,
    holed: Vec<HoledPiece>,
    /// For [`Rule::in_row`].
    rows: Vec<f32>,
}

/// As [`draw_face_with_holes`] without any that have some, onto rows without gaps.
#[cfg(test)]
fn draw_face<Chunk: AsRef<[Triangle]> + Sync>(
    face: &Face,
    chunks: &[Chunk],
    workers: &Workers,
    scratch: &mut Scratch,
    texels: &mut [f32],
    side: usize,
) {
    let none = Holed::<&[HoledTriangle]> { chunks: &[], tests: AlphaTests::default() };
    let mut with_gaps = vec![0.0; side * stride(side)];
    draw_face_with_holes(face, chunks, &none, workers, scratch, &mut with_gaps, side).expect("not cancelled");
    texels.copy_from_slice(&without_gaps(&with_gaps, side));
}

/// A face's rows without the room behind them.
#[cfg(test)]
fn without_gaps(texels: &[f32], side: usize) -> Vec<f32> {
    texels.chunks(stride(side)).flat_map(|row| &row[..side]).copied().collect()
}

/// Draws triangles, and those that have holes, onto a face of `side` texels a side: `texels`, as a [`DepthMap`] has them.
pub fn draw_face_with_holes<Chunk: AsRef<[Triangle]> + Sync, HoledChunk: AsRef<[HoledTriangle]> + Sync>(
    face: &Face,
    chunks: &[Chunk],
    holed: &Holed<HoledChunk>,
    workers: &Workers,
    scratch: &mut Scratch,
    texels: &mut [f32],
    side: usize,
) -> Result<(), Cancelled> {
    assert!(side <= MOST_SIDE && texels.len() == side * stride(side), "a face of {side} texels a side");
    let Scratch { pieces, holed: holed_pieces, rows } = scratch;
    let slices: Vec<&[Triangle]> = chunks.iter().flat_map(|chunk| chunk.as_ref().chunks(PIECE)).collect();
    pieces.resize_with(slices.len(), Piece::default);
    let holed_slices: Vec<&[HoledTriangle]> =
        holed.chunks.iter().flat_map(|chunk| chunk.as_ref().chunks(PIECE)).collect();
    holed_pieces.resize_with(holed_slices.len(), HoledPiece::default);
    let projection = Projection::new(face, side);
    let set_up = |(piece, triangles): (&mut Piece, &[Triangle])| {
        Arch::new().dispatch(SetUp { piece, triangles, projection: &projection });
    };
    let set_up_holed = |(piece, triangles): (&mut HoledPiece, &[HoledTriangle])| {
        piece.set_up(triangles, &projection);
    };
    workers.run(|| {
        pieces.par_iter_mut().zip(slices.into_par_iter()).for_each(set_up);
        holed_pieces.par_iter_mut().zip(holed_slices.into_par_iter()).for_each(set_up_holed);
    });
    let seen = Seen { pieces, holed: holed_pieces, tests: holed.tests };
    match face.depths {
        Depths::Bent { row: [first, each], depth_per_value } => {
            let in_row = |row: usize| (first + each * (row as f32 + 0.5)) / depth_per_value;
            rows.clear();
            rows.extend((0..side).map(in_row));
            draw_bands(workers, Bent { rows }, seen, texels, side)
        }
        Depths::Perspective { .. } => draw_bands(workers, Perspective, seen, texels, side),
        Depths::Orthographic => draw_bands(workers, Orthographic, seen, texels, side),
    }
}

/// Everything that is drawn, set up.
#[derive(Clone, Copy)]
struct Seen<'a> {
    pieces: &'a [Piece],
    holed: &'a [HoledPiece],
    tests: AlphaTests<'a>,
}

/// Draws all bands of a face. Some cost much more than others, and one may take long.
fn draw_bands<R: Rule>(
    workers: &Workers,
    rule: R,
    seen: Seen,
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
    /// [`COUNT`], which the compiler does not see through: what it makes of products with 0, 1, 2 and so on is slower.
    count: Ints,
}

/// Goes on with a band. False where it has to give way.
struct DrawBand<'a, 'b, R> {
    rule: R,
    seen: Seen<'a>,
    work: &'a mut BandWork<'b>,
    stride: usize,
    workers: &'a Workers,
}

impl<R: Rule> WithSimd for DrawBand<'_, '_, R> {
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
        let mut band = Band { first, end: first + height, stride, texels, count: black_box(COUNT) };
        let mut looked_at = 0;
        while piece < seen.pieces.len() + seen.holed.len() {
            if let Some(of_piece) = seen.pieces.get(piece) {
                let (large, small) = (&of_piece.large_in[index], &of_piece.small_in[index]);
                while triangle < large.len() {
                    let of_large = &of_piece.large[large[triangle] as usize];
                    large::draw(rule, of_large, &mut band);
                    triangle += 1;
                    looked_at += of_large.texels_in(&band);
                    if looked_at > LOOK_AFTER {
                        looked_at = 0;
                        if workers.is_due() {
                            *next = Some((piece, triangle));
                            return false;
                        }
                    }
                }
                while triangle < large.len() + small.len() {
                    let from = triangle - large.len();
                    let some = &small[from..small.len().min(from + SMALL_A_LOOK)];
                    for of_small in some {
                        small::draw(rule, of_small, &mut band);
                    }
                    triangle += some.len();
                    if workers.is_due() {
                        *next = Some((piece, triangle));
                        return false;
                    }
                }
            } else {
                let holed = &seen.holed[piece - seen.pieces.len()];
                while triangle < holed.count_in(index) {
                    looked_at += holed.draw(rule, seen.tests, (index, triangle), &mut band);
                    triangle += 1;
                    if looked_at > LOOK_AFTER {
                        looked_at = 0;
                        if workers.is_due() {
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
