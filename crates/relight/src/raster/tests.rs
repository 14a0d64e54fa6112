//! Maps against triangles drawn slowly and exactly.
#![expect(clippy::cast_possible_wrap, reason = "positions on a map are far below 2^31")]

mod coverage;
mod cut;
mod depths;
mod holes;
mod oracle;
mod visibility;
mod whole_maps;

use std::sync::OnceLock;

use glam::Mat3;

use super::{AlphaTestedTriangle, AlphaTestedTriangles, DepthRule, MapFace, RasterMemory, RasterTriangle, draw_face};
use crate::depth_map::stride;
use crate::{AlphaTests, Workers};

/// Depth rule of a bent light, on a face whose depths are the values themselves.
const PLAIN: DepthRule = DepthRule::Bent { row_divisor: [1.0, 0.0], depth_per_value: 1.0 };

/// Xorshift generator, the same numbers each time.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Returns an integer from `low` to below `high`.
    fn whole(&mut self, low: i32, high: i32) -> i32 {
        low + ((self.bits() >> 11) % (high - low) as u64) as i32
    }

    fn real(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.bits() >> 40) as f32 / (1 << 24) as f32)
    }
}

/// Makes a corner at multiples of 1/256 of a texel from the center of the first one. In f32 it is off by less than half
/// of one, and so rounds to the same, up to 2^19 of them: the coordinate has four roundings of 2^-24 each.
fn corner(at: [i32; 2], w: f32, value: f32, side: usize) -> [f32; 4] {
    let [right, down] = at.map(|x| (f64::from(x) + 128.0) / (128.0 * side as f64) - 1.0);
    [(right * f64::from(w)) as f32, (-down * f64::from(w)) as f32, w, value]
}

/// Makes a triangle with w = 1 and the value 1/2.
fn flat(corners: [[i32; 2]; 3], side: usize) -> RasterTriangle {
    corners.map(|at| corner(at, 1.0, 0.5, side))
}

const NO_ALPHA_TESTED: AlphaTestedTriangles<&[AlphaTestedTriangle]> =
    AlphaTestedTriangles { chunks: &[], tests: AlphaTests { tests: &[], texels: &[] } };

/// Draws a face, and returns its rows without the unused room behind each.
fn drawn_face<Chunk: AsRef<[RasterTriangle]> + Sync>(
    face: &MapFace,
    chunks: &[Chunk],
    alpha_tested: &AlphaTestedTriangles<&[AlphaTestedTriangle]>,
    workers: &Workers,
    scratch: &mut RasterMemory,
    side: usize,
) -> Vec<f32> {
    let mut texels = vec![f32::NAN; side * stride(side)];
    draw_face(face, chunks, alpha_tested, workers, scratch, &mut texels, side).expect("not cancelled");
    texels.chunks(stride(side)).flat_map(|row| &row[..side]).copied().collect()
}

/// Draws a map of triangles whose positions are clip coordinates.
fn drawn(triangles: &[RasterTriangle], depths: DepthRule, side: usize) -> Vec<f32> {
    static WORKERS: OnceLock<Workers> = OnceLock::new();
    let face = MapFace { clip_from_map: Mat3::IDENTITY, depths };
    let workers = WORKERS.get_or_init(|| Workers::with_threads(2));
    drawn_face(&face, &[triangles], &NO_ALPHA_TESTED, workers, &mut RasterMemory::default(), side)
}

/// Counts for each texel the triangles that cover it, each drawn alone.
fn counts(triangles: &[RasterTriangle], depths: DepthRule, side: usize) -> Vec<usize> {
    let cleared = drawn(&[], depths, side);
    let mut counts = vec![0; side * side];
    for triangle in triangles {
        for (count, (depth, cleared)) in counts.iter_mut().zip(drawn(&[*triangle], depths, side).iter().zip(&cleared)) {
            *count += usize::from(depth != cleared);
        }
    }
    counts
}
