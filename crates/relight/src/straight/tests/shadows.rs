//! Shadows of a board, with known outlines.

use glam::{Mat3, Mat4, Vec2, Vec3};
use hierarchy::HierarchyNode;
use light::parameters::CONE_ANGLE;
use light::{CheckedLight, Light};

use super::super::{
    AlphaTestedCasters, OpaqueCasters, RelitDirectional, RelitOmni, RelitSpot, StraightFace, StraightMap,
    StraightMapBuilder,
};
use super::{OMNI_MAP, SPOT_MAP, SUN_MAP};
use crate::lanes::{F32s, LANES, U32s, Vec3s};
use crate::shape::RelitShape;
use crate::surfaces::SurfaceLanes;
use crate::{AlphaTests, CasterHierarchy, CasterLinks, CasterScene, DepthMap, Workers};

/// Number of texels along each side of a map.
pub(super) const SIDE: usize = 256;

/// Board between a light and a floor that receives its shadow. The light is at the origin of light space or beyond.
/// Light space is scene space here, and light travels along -z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Board {
    /// Least and greatest corner, at z = -1.
    pub low: Vec2,
    pub high: Vec2,
}

pub(super) const BOARD: Board = Board { low: Vec2::new(-0.3, 0.1), high: Vec2::new(0.2, 0.45) };
pub(super) const POSITIONS: [[f32; 3]; 4] = {
    let Board { low, high } = BOARD;
    [[low.x, low.y, -1.0], [high.x, low.y, -1.0], [high.x, high.y, -1.0], [low.x, high.y, -1.0]]
};
/// Height of the floor.
const FLOOR: f32 = -2.0;

impl Board {
    /// Returns the outline of the board on a map: the nearest edges of texels, since centers beyond them lie outside.
    pub(super) fn on_map(&self) -> Self {
        let half = SIDE as f32 / 2.0;
        Self { low: (self.low * half).round() / half, high: (self.high * half).round() / half }
    }

    /// Returns the distance of a point of the floor from the outline of the shadow, positive inside, in world units.
    /// `spread` is the size of the shadow relative to the board.
    pub(super) fn depth_in_shadow(&self, at: Vec2, spread: f32) -> f32 {
        (at - self.low * spread).min(self.high * spread - at).min_element()
    }
}

const INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];
/// Node far from everything, so no ray test finds a triangle.
const FAR_NODE: HierarchyNode = HierarchyNode { min: [1e6; 3], count: 0, max: [1e6 + 1.0; 3], next: u32::MAX };

/// Makes the scene of the board.
pub(super) fn scene(attributes: &[[f32; 9]], opaque_triangles: u32) -> CasterScene<'_> {
    CasterScene {
        positions: &POSITIONS,
        indices: &INDICES,
        planes: &[[0.0, 0.0, 1.0, -1.0]; 2],
        hierarchy: CasterHierarchy { nodes: &[FAR_NODE], triangles: &[] },
        attributes,
        opaque_triangles,
        alpha_tests: AlphaTests::default(),
        links: CasterLinks::default(),
    }
}

pub(super) fn opaque_scene() -> CasterScene<'static> {
    scene(&[], 2)
}

/// Makes sixteen points of the floor, from `first` on along x.
fn floor(first: Vec2, step: f32) -> (SurfaceLanes, [Vec2; LANES]) {
    let at: [Vec2; LANES] = std::array::from_fn(|k| first + Vec2::X * (step * k as f32));
    let surface = SurfaceLanes {
        position: Vec3s { x: F32s(at.map(|p| p.x)), y: F32s(at.map(|p| p.y)), z: F32s::splat(FLOOR) },
        triangle: U32s::splat(10),
        ..SurfaceLanes::facing(Vec3s::splat([0.0, 0.0, 1.0]))
    };
    (surface, at)
}

/// Shadow of a board on the floor.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoardShadow {
    pub board: Board,
    /// Size of the shadow relative to the board.
    pub spread: f32,
    /// Distance from the outline within which points are not judged.
    pub margin: f32,
    /// Factor of the number of judged points in each direction.
    pub finer: usize,
}

/// Two texels, as slopes, at the floor. The filter reaches less than that.
const MARGIN: f32 = 2.0 * 2.0 / SIDE as f32 * 2.0;

pub(super) const SPOT_SHADOW: BoardShadow = BoardShadow { board: BOARD, spread: 2.0, margin: MARGIN, finer: 1 };
pub(super) const SUN_SHADOW: BoardShadow = BoardShadow { spread: 1.0, margin: MARGIN / 2.0, ..SPOT_SHADOW };

/// Numbers of judged points of the floor, of those in shadow, and of wrong ones.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Judged {
    all: usize,
    dark: usize,
    pub wrong: usize,
}

/// Compares the visibility of a light on the floor with the shadow that it should have.
pub(super) fn judge<S: RelitShape>(shape: &S, map: &DepthMap, scene: &CasterScene, shadow: &BoardShadow) -> Judged {
    let BoardShadow { board, spread, margin, finer } = *shadow;
    let mut judged = Judged::default();
    for row in 0..60 * finer {
        for group in 0..4 * finer {
            let first = Vec2::new(0.45 * group as f32, 0.03 * row as f32) / finer as f32 - 0.9;
            let (surface, at) = floor(first, 0.028 / finer as f32);
            let sample = shape.sample(scene, Some(map), &surface, surface.exists);
            for lane in (0..LANES).filter(|lane| sample.inside.lane(*lane)) {
                let depth = board.depth_in_shadow(at[lane], spread);
                if depth.abs() < margin {
                    continue;
                }
                let expected = if depth > 0.0 { 0.0 } else { 1.0 };
                judged.all += 1;
                judged.dark += usize::from(depth > 0.0);
                judged.wrong += usize::from(sample.visibility.0[lane] != expected);
            }
        }
    }
    judged
}

/// Map with the board on its first face.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoardMap {
    map_from_scene: Mat4,
    near: Option<f32>,
    clip_from_map: Mat3,
    /// Number of empty faces after the first.
    others: usize,
    /// Kind of the board's surface: 0 open, 1 closed, 2 closed and inside out.
    kind: u32,
}

/// The one face of a spotlight, with slopes up to 1: up is y, ahead is -z.
const SPOT_FACE: Mat3 = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::NEG_Z);
pub(super) const SPOT_BOARD: BoardMap =
    BoardMap { map_from_scene: Mat4::IDENTITY, near: Some(0.1), clip_from_map: SPOT_FACE, others: 0, kind: 0 };
/// The positions are (x, y, 1) and the depth of `SUN_MAP`.
pub(super) const SUN_BOARD: BoardMap = BoardMap {
    map_from_scene: Mat4::from_cols_array_2d(&[
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.25],
        [0.0, 0.0, 1.0, 0.75],
    ]),
    near: None,
    clip_from_map: Mat3::IDENTITY,
    ..SPOT_BOARD
};

impl BoardMap {
    pub fn drawn(&self) -> DepthMap {
        let alpha_tested = AlphaTestedCasters { scene: &opaque_scene(), runs: &[], tests: AlphaTests::default() };
        self.drawn_with(&[[0, 2 | self.kind << 16]], &alpha_tested)
    }

    pub fn drawn_with(&self, leaves: &[[u32; 2]], alpha_tested: &AlphaTestedCasters) -> DepthMap {
        let Self { map_from_scene, near, clip_from_map, others, .. } = *self;
        let mut faces = vec![StraightFace { clip_from_map, leaves: &[], has_casters: false }; 1 + others];
        faces[0] = StraightFace { clip_from_map, leaves, has_casters: true };
        let map = StraightMap { map_from_scene, near, faces: &faces };
        let mut into = DepthMap::new(SIDE, 1 + others);
        let casters = OpaqueCasters { positions: &POSITIONS, blocks: &[0], indices: &INDICES };
        StraightMapBuilder::default()
            .draw(&Workers::with_threads(2), &map, &casters, alpha_tested, &mut into)
            .expect("not cancelled");
        into
    }
}

pub(super) fn spot() -> RelitSpot {
    let cone = CheckedLight::new(Light::spot().with(CONE_ANGLE, 44.0)).expect("a light");
    RelitSpot::new(Mat4::IDENTITY, cone.light_profile().clone(), 1.0, None, SPOT_MAP)
}

pub(super) fn sun() -> RelitDirectional {
    let sun = CheckedLight::new(Light::directional()).expect("a light");
    RelitDirectional::new(Mat4::IDENTITY, sun.light_profile().clone(), [0.0; 4], SUN_MAP)
}

/// Asserts that the shadow on a `map` has the board's outline, with more than `dark` points in it. A map upside down is
/// a deliberate fault that the check must detect.
fn assert_outline(map: BoardMap, judge: impl Fn(BoardMap) -> Judged, dark: usize) {
    let right = judge(map);
    assert!(right.all > 2000 && right.dark > dark && right.wrong == 0, "{right:?}");
    let upside_down = Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0)) * map.clip_from_map;
    assert!(judge(BoardMap { clip_from_map: upside_down, ..map }).wrong > dark, "upside down");
}

#[test]
fn a_spotlights_shadow_of_a_board_has_the_boards_outline_from_the_source() {
    let judge = |map: BoardMap| judge(&spot(), &map.drawn(), &opaque_scene(), &SPOT_SHADOW);
    assert_outline(SPOT_BOARD, judge, 300);
    // Deliberate faults that the check must detect: a near plane ten times nearer, and one that clips the board.
    for near in [0.01, 1.1] {
        assert!(judge(BoardMap { near: Some(near), ..SPOT_BOARD }).wrong > 300, "{near}");
    }
}

#[test]
fn an_omni_lights_shadow_of_a_board_has_the_boards_outline_from_the_source() {
    let omni = CheckedLight::new(Light::omni()).expect("a light");
    let omni = RelitOmni::new(Mat4::IDENTITY, omni.light_profile().clone(), None, OMNI_MAP);
    let judge = |map: BoardMap| {
        // The face of -z, with right x and up y, is the last. The first face drawn here takes its place.
        let mut first = map.drawn();
        let mut map = DepthMap::new(SIDE, 6);
        map.face_mut(5).copy_from_slice(first.face_mut(0));
        assert!((1..6).all(|face| first.rows(face).flatten().all(|depth| *depth == 0.0)), "nothing is there");
        judge(&omni, &map, &opaque_scene(), &SPOT_SHADOW)
    };
    assert_outline(BoardMap { others: 5, ..SPOT_BOARD }, judge, 300);
}

#[test]
fn a_directional_lights_shadow_of_a_board_has_the_boards_outline() {
    assert_outline(SUN_BOARD, |map| judge(&sun(), &map.drawn(), &opaque_scene(), &SUN_SHADOW), 100);
}

#[test]
fn only_closed_surfaces_that_face_the_light_are_drawn() {
    // The board's front is up, towards the light. A board that faces outwards (1) is drawn, an inside-out one (2) is
    // not.
    for map in [SPOT_BOARD, SUN_BOARD] {
        let covered = [0, 1, 2]
            .map(|kind| BoardMap { kind, ..map }.drawn().rows(0).flatten().filter(|depth| **depth > 0.0).count());
        assert_eq!(covered, [covered[0], covered[0], 0]);
        // Half a texel more or less all around, for 0.5 by 0.35 on 2 by 2.
        let area = 0.5 * 0.35 / 4.0 * (SIDE * SIDE) as f32;
        assert!((covered[0] as f32 - area).abs() < 0.5 * (0.5 + 0.35) * SIDE as f32, "{covered:?}");
    }
}
