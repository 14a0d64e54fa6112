//! Shadows of casters with holes.

use glam::{Mat4, Vec2};

use super::super::{AlphaTestedCasters, AlphaTestedRun, StraightFace, StraightMap, StraightMapBuilder};
use super::shadows::{BOARD, Board, MARGIN, SIDE, SPOT_FACE, drawn, floor, scene, spot};
use crate::lanes::LANES;
use crate::shape::RelitShape;
use crate::{AlphaTest, AlphaTests, DepthMap, Workers};

#[test]
fn light_comes_through_holes_and_nowhere_else() {
    let positions = BOARD.positions();
    // Alpha falls along x from 1 to 0, and makes holes below a half.
    let attributes: Vec<[f32; 9]> =
        positions.map(|[x, ..]| [0.0, 0.0, 1.0, 0.5, 0.5, 1.0, 1.0, 1.0, (0.2 - x) / 0.5]).into();
    let tests = AlphaTests { tests: &[AlphaTest::OF_ONE_TEXEL], texels: &[255] };
    let scene = scene(&positions, &attributes, 0);
    let run = |triangles| [AlphaTestedRun { triangles, test: 0 }];
    let map = |runs: &[AlphaTestedRun]| {
        let face = StraightFace { clip_from_map: SPOT_FACE, leaves: &[], has_casters: true };
        let map = StraightMap { map_from_scene: Mat4::IDENTITY, near: Some(0.1), faces: &[face] };
        let mut into = DepthMap::new(SIDE, 1);
        let alpha_tested = AlphaTestedCasters { scene: &scene, runs, tests };
        StraightMapBuilder::default()
            .draw(&Workers::with_threads(2), &map, (&[], &[], &[]), &alpha_tested, &mut into)
            .expect("not cancelled");
        into
    };
    // The board is solid left of the middle, for x up to -0.05, and its shadow reaches twice as far.
    let half = Board { high: Vec2::new(-0.05, BOARD.high.y), ..BOARD };
    let wrong = |map: &DepthMap| {
        let mut wrong = 0;
        for row in 0..40 {
            let (surface, at) = floor(Vec2::new(-0.7, 0.05 + 0.025 * row as f32), 0.08);
            let sample = spot().sample(&scene, Some(map), &surface, surface.exists);
            for lane in (0..LANES).filter(|lane| sample.inside.lane(*lane)) {
                let depth = half.depth_in_shadow(at[lane], 2.0);
                let expected = if depth > 0.0 { 0.0 } else { 1.0 };
                wrong += usize::from(depth.abs() > MARGIN && sample.visibility.0[lane] != expected);
            }
        }
        wrong
    };
    assert_eq!(wrong(&map(&run(0..2))), 0);
    assert!(wrong(&map(&run(0..1))) > 50, "half of the board is missing");
    assert!(wrong(&drawn((Mat4::IDENTITY, Some(0.1)), (SPOT_FACE, 0), 0)) > 50, "a board without holes");
}
