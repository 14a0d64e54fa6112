//! Maps of many triangles and of all sizes.

use glam::{Mat3, Vec3};

use super::{DepthRule, PLAIN, Random, RasterTriangle, drawn};
use crate::Workers;
use crate::raster::{MapFace, RasterMemory, draw_face};

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
            draw_face(
                &face,
                &[random_triangles(&mut Random(6), 50)],
                &workers,
                &mut scratch,
                &mut [0.0; 49],
                7,
            );
            let mut texels = vec![0.0; 300 * 300];
            draw_face(&face, &chunks, &workers, &mut scratch, &mut texels, 300);
            maps.push(bits(&texels));
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
        let above = drawn(&[[a, b, c]], PLAIN, side);
        let is_above = |index: usize| index % side + index / side + 1 < side;
        let is_right =
            |(index, depth): (usize, &f32)| (*depth < 1.0) == is_above(index) || is_on(index, side);
        assert!(above.iter().enumerate().all(is_right), "{side}");
    }
}

/// True on the diagonal from the top right to the bottom left.
fn is_on(index: usize, side: usize) -> bool {
    index % side + index / side + 1 == side
}

#[test]
fn a_face_shows_what_its_matrix_puts_there() {
    // Right is -y, up is z, ahead is x. The face shows only the upper right quarter.
    let axes = Mat3::from_cols(Vec3::Z, Vec3::NEG_X, Vec3::Y);
    let quarter = Mat3::from_cols(Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::new(-1.0, -1.0, 1.0));
    let face = MapFace { clip_from_map: quarter * axes, depths: PLAIN };
    let place = |right: f32, up: f32| [2.0, -2.0 * right, 2.0 * up, 0.5];
    let triangle = [place(0.0, 0.0), place(0.5, 0.0), place(0.0, 0.5)];
    let mut texels = vec![0.0; 64];
    draw_face(&face, &[[triangle]], &Workers::with_threads(1), &mut RasterMemory::default(), &mut texels, 8);
    let covered: Vec<usize> =
        texels.iter().enumerate().filter(|(_, x)| **x < 1.0).map(|(index, _)| index).collect();
    // The triangle is half of the lower left quarter of the face. Centers on the long edge, which is to their left, are
    // not covered.
    assert_eq!(covered, [40, 48, 49, 56, 57, 58]);
}
