//! Maps of many triangles and of all sizes.

use glam::{Mat3, Vec3};

use super::{DepthRule, NO_ALPHA_TESTED, PLAIN, Random, RasterTriangle, drawn, drawn_face};
use crate::Workers;
use crate::raster::{MapFace, RasterMemory};

/// Makes triangles, some of them large, some behind the light.
fn random_triangles(random: &mut Random, count: usize) -> Vec<RasterTriangle> {
    let one = |_| {
        let size = if random.whole(0, 50) == 0 { 3.0 } else { 0.02 };
        let middle = [0, 1].map(|_| random.real(-1.2, 1.2));
        [0, 1, 2].map(|_| {
            let w = random.real(if size > 1.0 { -0.1 } else { 0.5 }, 1.0);
            let [x, y] = middle.map(|x| (x + random.real(-size, size)) * w);
            [x, y, w, random.real(0.0, 1.0)]
        })
    };
    (0..count).map(one).collect()
}

#[test]
fn a_map_has_the_same_bytes_however_many_threads_draw_it() {
    let triangles = random_triangles(&mut Random(4), 12_000);
    let bits = |texels: &[f32]| texels.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
    for depths in [PLAIN, DepthRule::Perspective { near: 0.05 }, DepthRule::Orthographic] {
        let face = MapFace { clip_from_map: Mat3::IDENTITY, depths };
        let mut scratch = RasterMemory::default();
        let mut maps = Vec::new();
        for (threads, chunk) in [(1, 12_000), (2, 5000), (4, 77), (3, 12_000)] {
            let workers = Workers::with_threads(threads);
            let chunks: Vec<&[RasterTriangle]> = triangles.chunks(chunk).collect();
            // Another map in between leaves nothing behind.
            drawn_face(&face, &[random_triangles(&mut Random(6), 50)], &NO_ALPHA_TESTED, &workers, &mut scratch, 7);
            maps.push(bits(&drawn_face(&face, &chunks, &NO_ALPHA_TESTED, &workers, &mut scratch, 300)));
        }
        let backwards: Vec<RasterTriangle> = triangles.iter().rev().copied().collect();
        maps.push(bits(&drawn(&backwards, depths, 300)));
        assert!(maps.iter().all(|map| *map == maps[0]));
        assert_ne!(bits(&drawn(&triangles[1000..], depths, 300)), maps[0], "each of them counts");
    }
}

#[test]
fn maps_of_all_sizes_are_drawn_to_their_edges() {
    let corners = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[x, y]| [x, y, 1.0, 0.5]);
    let [a, b, c, d] = corners;
    for side in [1, 2, 15, 16, 17, 37, 63, 64, 65, 1000, 4096] {
        for depths in [PLAIN, DepthRule::Orthographic] {
            assert!(drawn(&[[a, b, c], [b, c, d]], depths, side).iter().all(|depth| *depth == 0.5), "{side}");
        }
        // Above the diagonal from the top right to the bottom left, or on it.
        for (index, depth) in drawn(&[[a, b, c]], PLAIN, side).iter().enumerate() {
            let diagonal = index % side + index / side + 1;
            assert!((*depth < 1.0) == (diagonal < side) || diagonal == side, "{index} of {side}");
        }
    }
}

#[test]
fn a_face_shows_what_its_matrix_puts_there() {
    // Right is -y, up is z, ahead is x. The face shows only the upper right quarter.
    let axes = Mat3::from_cols(Vec3::Z, Vec3::NEG_X, Vec3::Y);
    let quarter = Mat3::from_cols(Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::new(-1.0, -1.0, 1.0));
    let face = MapFace { clip_from_map: quarter * axes, depths: PLAIN };
    let corner = |right: f32, up: f32| [2.0, -2.0 * right, 2.0 * up, 0.5];
    let triangle = [corner(0.0, 0.0), corner(0.5, 0.0), corner(0.0, 0.5)];
    let (workers, mut scratch) = (Workers::with_threads(1), RasterMemory::default());
    let texels = drawn_face(&face, &[[triangle]], &NO_ALPHA_TESTED, &workers, &mut scratch, 8);
    let covered: Vec<usize> = texels.iter().enumerate().filter(|(_, x)| **x < 1.0).map(|(index, _)| index).collect();
    // The triangle is half of the lower left quarter of the face. Centers on the long edge, which is to their left, are
    // not covered.
    assert_eq!(covered, [40, 48, 49, 56, 57, 58]);
}
