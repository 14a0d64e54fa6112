//! Shadows of a board, with known outlines.

use glam::{Mat3, Mat4, Vec2, Vec3};
use light::parameters::CONE_ANGLE;
use light::{CheckedLight, Light};

use super::super::{
    AlphaTestedCasters, DirectionalMapParams, OmniMapParams, RelitDirectional, RelitOmni, RelitSpot,
    StraightFace, StraightMap, StraightMapBuilder,
};
use super::SPOT_MAP;
use crate::lanes::{F32s, LANES, Masks, U32s, Vec3s};
use crate::shape::RelitShape;
use crate::surfaces::SurfaceLanes;
use crate::{
    AlphaTests, CasterHierarchy, CasterHierarchyNode, CasterLinks, CasterScene, DepthMap, ShadowFilter,
    Workers,
};

/// Number of texels along each side of a map.
pub(super) const SIDE: usize = 256;

/// Board between a light and a floor that receives its shadow. The light is at the origin of light space or beyond.
/// Light space is scene space here, and light travels along -z.
pub(super) struct Board {
    /// Least and greatest corner, at z = -1.
    pub low: Vec2,
    pub high: Vec2,
}

pub(super) const BOARD: Board = Board { low: Vec2::new(-0.3, 0.1), high: Vec2::new(0.2, 0.45) };
/// Height of the floor.
const FLOOR: f32 = -2.0;

impl Board {
    pub(super) fn positions(&self) -> [[f32; 3]; 4] {
        let Self { low, high } = *self;
        [[low.x, low.y, -1.0], [high.x, low.y, -1.0], [high.x, high.y, -1.0], [low.x, high.y, -1.0]]
    }

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
const FAR_NODE: CasterHierarchyNode =
    CasterHierarchyNode { min: [1e6; 3], triangle_count: 0, max: [1e6 + 1.0; 3], next: u32::MAX };

pub(super) fn scene<'a>(
    positions: &'a [[f32; 3]; 4],
    attributes: &'a [[f32; 9]],
    opaque_triangles: u32,
) -> CasterScene<'a> {
    CasterScene {
        positions,
        indices: &INDICES,
        planes: &[[0.0, 0.0, 1.0, -1.0]; 2],
        hierarchy: CasterHierarchy { nodes: &[FAR_NODE], triangles: &[] },
        attributes,
        opaque_triangles,
        alpha_tests: AlphaTests::default(),
        links: CasterLinks::default(),
    }
}

/// Makes sixteen points of the floor, from `first` on along x.
pub(super) fn floor(first: Vec2, step: f32) -> (SurfaceLanes, [Vec2; LANES]) {
    let at: [Vec2; LANES] = std::array::from_fn(|k| first + Vec2::X * (step * k as f32));
    let (zero, up) = (F32s::splat(0.0), Vec3s::splat([0.0, 0.0, 1.0]));
    let surface = SurfaceLanes {
        exists: Masks([u32::MAX; LANES]),
        position: Vec3s { x: F32s(at.map(|p| p.x)), y: F32s(at.map(|p| p.y)), z: F32s::splat(FLOOR) },
        depth: F32s::splat(1.0),
        geometric_normal: up,
        normal: up,
        terminator_offset: zero,
        triangle: U32s::splat(10),
        to_eye: up,
        base_color: Vec3s::splat([1.0; 3]),
        metallic: zero,
        roughness: F32s::splat(1.0),
    };
    (surface, at)
}

/// Numbers of judged points of the floor, of those in shadow, and of wrong ones. Points within `margin` of the outline
/// are not judged.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Judged {
    all: usize,
    dark: usize,
    pub wrong: usize,
}

fn judged<S: RelitShape>(shape: &S, map: &DepthMap, scene: &CasterScene, far: (f32, f32)) -> Judged {
    judged_by((&BOARD, 1), shape, map, scene, far)
}

/// Judges by the shadow of another board, at `finer` times as many points in each direction.
pub(super) fn judged_by<S: RelitShape>(
    (board, finer): (&Board, usize),
    shape: &S,
    map: &DepthMap,
    scene: &CasterScene,
    (spread, margin): (f32, f32),
) -> Judged {
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

/// Draws a map with the board on its first face, and nothing on `others`. `shell` is the kind of the board's surface.
pub(super) fn drawn(
    (place_from_scene, near): (Mat4, Option<f32>),
    (clip_from_place, others): (Mat3, usize),
    shell: u32,
) -> DepthMap {
    let positions = BOARD.positions();
    let leaves = [[0, 2 | shell << 16]];
    let mut faces = vec![StraightFace { clip_from_map: clip_from_place, leaves: &leaves, has_casters: true }];
    faces.extend((0..others).map(|_| StraightFace {
        clip_from_map: clip_from_place,
        leaves: &[],
        has_casters: false,
    }));
    let map = StraightMap { map_from_scene: place_from_scene, near, faces: &faces };
    let scene = scene(&positions, &[], 2);
    let alpha_tested = AlphaTestedCasters { scene: &scene, runs: &[], tests: AlphaTests::default() };
    let mut into = DepthMap::new(SIDE, 1 + others);
    let casters = (&positions[..], &[0][..], &INDICES[..]);
    StraightMapBuilder::default()
        .draw(&Workers::with_threads(2), &map, casters, &alpha_tested, &mut into)
        .expect("not cancelled");
    into
}

/// The one face of a spotlight, with slopes up to 1: up is y, ahead is -z.
pub(super) const SPOT_FACE: Mat3 = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::NEG_Z);

pub(super) fn spot() -> RelitSpot {
    let cone = CheckedLight::new(Light::spot().with(CONE_ANGLE, 44.0)).expect("a light");
    RelitSpot::new(Mat4::IDENTITY, cone.light_profile().clone(), (1.0, None), SPOT_MAP)
}

/// Two texels, as slopes, at the floor. The filter reaches less than that.
pub(super) const MARGIN: f32 = 2.0 * 2.0 / SIDE as f32 * 2.0;

#[test]
fn a_spotlights_shadow_of_a_board_has_the_boards_outline_from_the_source() {
    let positions = BOARD.positions();
    let scene = scene(&positions, &[], 2);
    let judge = |map: &DepthMap| judged(&spot(), map, &scene, (2.0, MARGIN));
    let right = judge(&drawn((Mat4::IDENTITY, Some(0.1)), (SPOT_FACE, 0), 0));
    assert!(right.all > 2000 && right.dark > 300 && right.wrong == 0, "{right:?}");
    // Deliberate faults that the check must detect: a map upside down, one whose near plane is ten times farther away,
    // and one that is clipped where the board is.
    let upside_down = Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0)) * SPOT_FACE;
    assert!(judge(&drawn((Mat4::IDENTITY, Some(0.1)), (upside_down, 0), 0)).wrong > 300);
    assert!(judge(&drawn((Mat4::IDENTITY, Some(0.01)), (SPOT_FACE, 0), 0)).wrong > 300);
    assert!(judge(&drawn((Mat4::IDENTITY, Some(1.1)), (SPOT_FACE, 0), 0)).wrong > 300);
}

#[test]
fn an_omni_lights_shadow_of_a_board_has_the_boards_outline_from_the_source() {
    // The face of -z, with right x and up y, is the last. The first face drawn here takes its place.
    let omni = CheckedLight::new(Light::omni()).expect("a light");
    let fits = [[0.0, 0.0, 1.0, 1.0]; 6];
    let place = OmniMapParams { near: 0.1, mesh_error: 0.0, fits, filter: ShadowFilter::Bilinear };
    let omni = RelitOmni::new(Mat4::IDENTITY, omni.light_profile().clone(), None, place);
    let drawn = |face: Mat3| {
        let first = drawn((Mat4::IDENTITY, Some(0.1)), (face, 5), 0);
        let mut map = DepthMap::new(SIDE, 6);
        map.face_mut(5).copy_from_slice(first.clone().face_mut(0));
        assert!((1..6).all(|face| first.rows(face).flatten().all(|depth| *depth == 0.0)), "nothing is there");
        map
    };
    let positions = BOARD.positions();
    let scene = scene(&positions, &[], 2);
    let right = judged(&omni, &drawn(SPOT_FACE), &scene, (2.0, MARGIN));
    assert!(right.all > 2000 && right.dark > 300 && right.wrong == 0, "{right:?}");
    let upside_down = Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0)) * SPOT_FACE;
    assert!(judged(&omni, &drawn(upside_down), &scene, (2.0, MARGIN)).wrong > 300);
}

/// Returns the map positions of a directional light: (x, y, 1), and a depth from 0 at z = -3 to 1 at z = 1.
pub(super) fn sun_places() -> Mat4 {
    Mat4::from_cols_array_2d(&[
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.25],
        [0.0, 0.0, 1.0, 0.75],
    ])
}

pub(super) fn sun() -> RelitDirectional {
    let sun = CheckedLight::new(Light::directional()).expect("a light");
    let place = DirectionalMapParams {
        fit: [0.0, 0.0, 1.0, 1.0],
        bottom: -3.0,
        depth_scale: 0.25,
        mesh_error: 0.0,
        filter: ShadowFilter::Bilinear,
    };
    RelitDirectional::new(Mat4::IDENTITY, sun.light_profile().clone(), [0.0; 4], place)
}

#[test]
fn a_directional_lights_shadow_of_a_board_has_the_boards_outline() {
    let sun = sun();
    let positions = BOARD.positions();
    let scene = scene(&positions, &[], 2);
    let judge =
        |face: Mat3| judged(&sun, &drawn((sun_places(), None), (face, 0), 0), &scene, (1.0, MARGIN / 2.0));
    let right = judge(Mat3::IDENTITY);
    assert!(right.all > 2000 && right.dark > 100 && right.wrong == 0, "{right:?}");
    assert!(judge(Mat3::from_diagonal(Vec3::new(1.0, -1.0, 1.0))).wrong > 100, "upside down");
}

#[test]
fn of_closed_surfaces_only_what_faces_the_light_is_drawn() {
    // The board's front is up, towards the light. A board that faces outwards (1) is drawn, an inside-out one (2) is
    // not.
    for (places, near, face) in [(Mat4::IDENTITY, Some(0.1), SPOT_FACE), (sun_places(), None, Mat3::IDENTITY)]
    {
        let covered = |shell: u32| {
            drawn((places, near), (face, 0), shell).rows(0).flatten().filter(|depth| **depth > 0.0).count()
        };
        assert_eq!([covered(1), covered(2)], [covered(0), 0]);
        // Half a texel more or less all around, for 0.5 by 0.35 on 2 by 2.
        let area = 0.5 * 0.35 / 4.0 * (SIDE * SIDE) as f32;
        assert!((covered(0) as f32 - area).abs() < 0.5 * (0.5 + 0.35) * SIDE as f32, "{}", covered(0));
    }
}
