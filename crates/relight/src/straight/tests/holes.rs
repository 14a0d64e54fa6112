//! Shadows of casters with holes.

use glam::Vec2;

use super::super::{AlphaTestedCasters, AlphaTestedRun};
use super::shadows::{BOARD, Board, BoardShadow, POSITIONS, SPOT_BOARD, SPOT_SHADOW, judge, scene, spot};
use crate::{AlphaTest, AlphaTests, DepthMap};

#[test]
fn light_comes_through_holes_and_nowhere_else() {
    // Alpha falls along x from 1 to 0, and makes holes below a half.
    let attributes: Vec<[f32; 9]> =
        POSITIONS.map(|[x, ..]| [0.0, 0.0, 1.0, 0.5, 0.5, 1.0, 1.0, 1.0, (0.2 - x) / 0.5]).into();
    let tests = AlphaTests { tests: &[AlphaTest::OF_ONE_TEXEL], texels: &[255] };
    let scene = scene(&attributes, 0);
    let drawn = |triangles| {
        let runs = [AlphaTestedRun { triangles, test: 0 }];
        SPOT_BOARD.drawn_with(&[], &AlphaTestedCasters { scene: &scene, runs: &runs, tests })
    };
    // The board is solid left of the middle, for x up to -0.05.
    let solid = Board { high: Vec2::new(-0.05, BOARD.high.y), ..BOARD };
    let wrong = |map: &DepthMap| judge(&spot(), map, &scene, &BoardShadow { board: solid, ..SPOT_SHADOW }).wrong;
    assert_eq!(wrong(&drawn(0..2)), 0);
    assert!(wrong(&drawn(0..1)) > 50, "half of the board is missing");
    assert!(wrong(&SPOT_BOARD.drawn()) > 50, "a board without holes");
}
