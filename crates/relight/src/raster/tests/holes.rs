//! Triangles with alpha tests.

use glam::Mat3;

use super::oracle::meet;
use super::{DepthRule, PLAIN, Random, RasterTriangle, drawn_face};
use crate::Workers;
use crate::alpha_test::{AlphaTest, AlphaTests};
use crate::raster::{AlphaTestedTriangle, AlphaTestedTriangles, MapFace, RasterMemory};

const TEST: AlphaTest = AlphaTest { nearest: true, ..AlphaTest::OF_ONE_TEXEL };

fn drawn(
    plain: &[RasterTriangle],
    triangles: &[AlphaTestedTriangle],
    tests: AlphaTests,
    depths: DepthRule,
    side: usize,
) -> Vec<f32> {
    let face = MapFace { clip_from_map: Mat3::IDENTITY, depths };
    let alpha_tested = AlphaTestedTriangles { chunks: &[triangles], tests };
    drawn_face(&face, &[plain], &alpha_tested, &Workers::with_threads(2), &mut RasterMemory::default(), side)
}

/// Makes a floor below the light that continues behind it, with one cell of a texture along x, and one along the depth.
fn floor() -> [RasterTriangle; 2] {
    let [a, b, c, d] = [[-3.0, -0.3], [3.0, -0.3], [-3.0, 4.0], [3.0, 4.0]].map(|[x, w]| [x, -0.4, w, 0.5]);
    [[a, b, c], [c, b, d]]
}

fn with_uv(triangle: RasterTriangle, test: u32) -> AlphaTestedTriangle {
    AlphaTestedTriangle { corners: triangle, uv_alpha: triangle.map(|[x, _, w, _]| [x, w, 1.0]), test }
}

#[test]
fn holes_are_where_perspective_puts_them() {
    // The texture is a chessboard of two by two texels, each 1/4 of the floor's units wide.
    let (side, cell) = (160, 0.25);
    let test = AlphaTest { width: 2, height: 2, ..TEST };
    let tests = AlphaTests { tests: &[test], texels: &[255, 0, 0, 255] };
    let scaled = |triangle: RasterTriangle| {
        let uv_alpha = triangle.map(|[x, _, w, _]| [x, w, 1.0].map(|x| if x == 1.0 { 1.0 } else { x / (2.0 * cell) }));
        AlphaTestedTriangle { uv_alpha, ..with_uv(triangle, 0) }
    };
    let triangles = floor().map(scaled);
    let texels = drawn(&[], &triangles, tests, PLAIN, side);
    let (mut seen, mut flat) = (0, 0);
    for (index, depth) in texels.into_iter().enumerate() {
        let (column, row) = ((index % side) as f64 + 0.5, (index / side) as f64 + 0.5);
        let (_, w, _) = meet(&floor()[0], column, row, side);
        let x = w * (2.0 * column / side as f64 - 1.0);
        // Only texels that are clear of the edges of cells, and near enough that 1/256 of a texel of the map does not
        // matter.
        let is_clear = |x: f64| (x / f64::from(cell)).fract().abs() > 0.1 && (x / f64::from(cell)).fract().abs() < 0.9;
        if w > 0.0 && w < 2.0 && x.abs() < 3.0 && is_clear(x) && is_clear(w) {
            let is_solid =
                |x: f64, w: f64| ((x / f64::from(cell)).floor() + (w / f64::from(cell)).floor()) % 2.0 == 0.0;
            assert_eq!(depth < 1.0, is_solid(x, w), "at {column}, {row}: {x}, {w}");
            seen += 1;
            // Deliberate fault that the check must detect: the holes of a floor parallel to the map.
            flat += usize::from(is_solid(column / side as f64, row / side as f64) != is_solid(x, w));
        }
    }
    assert!(seen > 2000 && flat > 500, "{flat} of {seen}");
}

#[test]
fn a_solid_picture_makes_no_difference_and_an_empty_one_all() {
    let mut random = Random(77);
    let side = 200;
    let triangles: Vec<RasterTriangle> = (0..400)
        .map(|_| {
            [0, 1, 2].map(|_| {
                let [x, y] = [0, 1].map(|_| random.real(-1.5, 1.5));
                [x, y, random.real(-0.2, 1.0), random.real(0.0, 1.0)]
            })
        })
        .collect();
    let solid = AlphaTest { cutoff: 0.8, factor: 0.9, ..TEST };
    let tests = [solid, AlphaTest { offset: 1, ..solid }, AlphaTest { factor: 0.7, ..solid }];
    let tests = AlphaTests { tests: &tests, texels: &[255, 100] };
    let of =
        |test: u32| triangles.iter().map(|triangle| with_uv(*triangle, test)).collect::<Vec<AlphaTestedTriangle>>();
    for depths in [PLAIN, DepthRule::Perspective { near: 0.1 }, DepthRule::Orthographic] {
        let nothing = drawn(&[], &[], tests, depths, side);
        assert_eq!(drawn(&[], &of(1), tests, depths, side), nothing, "the texel's alpha is too little");
        assert_eq!(drawn(&[], &of(2), tests, depths, side), nothing, "the material's is");
        let faint = of(0).into_iter().map(|triangle| {
            let uv_alpha = triangle.uv_alpha.map(|[u, v, _]| [u, v, 0.5]);
            AlphaTestedTriangle { uv_alpha, ..triangle }
        });
        assert_eq!(drawn(&[], &faint.collect::<Vec<_>>(), tests, depths, side), nothing, "the corners' is");
        // Half of the triangles of each kind, so that both are in a map. Small and large triangles round N and D
        // differently, by 19 times 2^-24 of their values at corners, which are here up to 80 times those at a texel.
        let whole = super::drawn(&triangles, depths, side);
        let both = drawn(&triangles[..200], &of(0)[200..], tests, depths, side);
        for (whole, both) in whole.iter().zip(&both) {
            assert!((whole - both).abs() <= 1e-4 * whole, "{whole} {both}");
        }
        assert_ne!(whole, nothing);
    }
}
