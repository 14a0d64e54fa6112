//! Triangles that reach behind the light, to its source, or far aside.

use super::oracle::meet;
use super::{DepthRule, PLAIN, Random, RasterTriangle, counts, drawn};

/// Largest error of a position in texels: corners are rounded to half of 1/256 of a texel, and corners made by
/// clipping, as far aside as the guard band goes, are off by as much again in f32.
const MAX_POSITION_ERROR: f64 = 1.0 / 256.0;

/// Decides if a texel is in the part of a triangle with w of at least `least_w`; `None` if it is too close to tell.
/// Returns the least and the greatest w and value there too.
fn expected(triangle: &RasterTriangle, index: usize, side: usize, least_w: f64) -> (Option<bool>, [[f64; 2]; 2]) {
    let (column, row) = ((index % side) as f64 + 0.5, (index / side) as f64 + 0.5);
    let around = [
        [-MAX_POSITION_ERROR, -MAX_POSITION_ERROR],
        [MAX_POSITION_ERROR, -MAX_POSITION_ERROR],
        [-MAX_POSITION_ERROR, MAX_POSITION_ERROR],
        [MAX_POSITION_ERROR, MAX_POSITION_ERROR],
    ]
    .map(|[right, down]| meet(triangle, column + right, row + down, side));
    let is_in = around.iter().all(|(shares, w, _)| shares.iter().all(|share| *share > 0.0) && *w > least_w);
    let is_behind = |k: usize| around.iter().all(|(shares, _, _)| shares[k] < 0.0);
    let is_cut = around.iter().all(|(_, w, _)| *w < least_w);
    let is_out = (0..3).any(is_behind) || is_cut;
    let range = |of: fn(&([f64; 3], f64, f64)) -> f64| {
        let all = around.iter().map(of);
        [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
    };
    ((is_in != is_out).then_some(is_in), [range(|at| at.1), range(|at| at.2)])
}

/// Makes a triangle with corners in front of the light and behind it.
fn about_the_light(random: &mut Random) -> RasterTriangle {
    let far = [1.0, 30.0][random.whole(0, 2) as usize];
    [0, 1, 2].map(|_| {
        let [x, y] = [0, 1].map(|_| random.real(-far, far));
        [x, y, random.real(-0.6, 1.0), random.real(0.1, 0.9)]
    })
}

#[test]
fn the_part_of_a_triangle_ahead_of_the_light_is_drawn() {
    let mut random = Random(33);
    let side = 64;
    let (mut covered, mut unsure, mut behind) = (0, 0, 0);
    for _ in 0..400 {
        let triangle = about_the_light(&mut random);
        for (index, depth) in drawn(&[triangle], PLAIN, side).into_iter().enumerate() {
            let (is_in, [_, [least, most]]) = expected(&triangle, index, side, 0.0);
            match is_in {
                Some(is_in) => assert_eq!(depth < 1.0, is_in, "{triangle:?} at {index}"),
                None => unsure += 1,
            }
            if is_in == Some(true) {
                covered += 1;
                behind += usize::from(triangle.iter().any(|corner| corner[2] < 0.0));
                // The bound of `depths.rs`, where N and D at the cut are at most so many times as large as here.
                let tolerance = 1e-3 + (most - least);
                let depth = f64::from(depth);
                assert!(depth > least - tolerance && depth < most + tolerance, "{depth}: {least} to {most}");
            }
        }
    }
    assert!(covered > 50_000 && behind > 20_000 && unsure < covered / 20, "{covered}, {behind}, {unsure}");
}

#[test]
fn geometry_nearer_than_the_near_plane_is_clipped() {
    let mut random = Random(71);
    let (side, near) = (64, 0.3_f32);
    let (mut covered, mut cut) = (0, 0);
    for _ in 0..400 {
        let triangle = about_the_light(&mut random);
        let texels = drawn(&[triangle], DepthRule::Perspective { near }, side);
        for (index, depth) in texels.into_iter().enumerate() {
            let (is_in, [[least, most], _]) = expected(&triangle, index, side, f64::from(near));
            let Some(is_in) = is_in else { continue };
            assert_eq!(depth > 0.0, is_in, "{triangle:?} at {index}");
            if is_in {
                let [high, low] = [least, most].map(|w| f64::from(near) / w);
                assert!(f64::from(depth) > low - 1e-5 && f64::from(depth) < high + 1e-5);
                covered += 1;
            } else {
                // Texels that would be drawn without clipping.
                cut += usize::from(expected(&triangle, index, side, 0.0).0 == Some(true));
            }
        }
    }
    assert!(covered > 20_000 && cut > 10_000, "{covered}, {cut}");
}

#[test]
fn a_floor_that_reaches_behind_the_light_is_tiled_without_gaps() {
    let mut random = Random(15);
    let (side, cells) = (64, 12);
    let mut grid = Vec::new();
    for index in 0..(cells + 1) * (cells + 1) {
        let [across, ahead] = [index % (cells + 1), index / (cells + 1)];
        let coordinate =
            |step: usize, random: &mut Random| (step as f32 - 0.5 * cells as f32 + random.real(-0.3, 0.3)) * 3.0;
        // The floor is half a unit below the light, and tilted. Beyond its end there is nothing.
        let [x, w] = [coordinate(across, &mut random), coordinate(ahead, &mut random)];
        grid.push([x, -0.5 - 0.1 * w, w, 0.5]);
    }
    let mut floor: Vec<RasterTriangle> = Vec::new();
    for index in 0..cells * cells {
        let at = index % cells + index / cells * (cells + 1);
        let [a, b, c, d] = [grid[at], grid[at + 1], grid[at + cells + 1], grid[at + cells + 2]];
        floor.extend(if random.whole(0, 2) == 0 { [[a, b, c], [d, b, c]] } else { [[a, b, d], [d, a, c]] });
    }
    let counts = counts(&floor, PLAIN, side);
    assert!(counts.iter().all(|count| *count <= 1));
    // y / w = -0.1 - 0.5 / w is below -0.15 for w below 10, where the floor is as wide as the map.
    let first = (0.5 * 1.15 * side as f64).ceil() as usize;
    assert!(counts[first * side..].iter().all(|count| *count == 1), "there are gaps");
}

#[test]
fn triangles_at_the_source_draw_nothing() {
    let tip = [0.0, 0.0, 0.0, 0.1];
    let (a, b) = ([0.3, 0.2, 0.5, 0.3], [-0.4, 0.7, 1.0, 0.5]);
    let nowhere = [0.3, 0.2, 0.0, 0.3];
    let no_number = [f32::NAN, 0.0, 1.0, 0.5];
    let too_far = [f32::INFINITY, 0.0, 1.0, 0.5];
    let behind = a.map(|x| -x);
    for triangle in
        [[tip, a, b], [a, tip, b], [tip; 3], [tip, tip, a], [a, a, b], [no_number, a, b], [a, too_far, b], [behind; 3]]
    {
        assert!(drawn(&[triangle], PLAIN, 32).iter().all(|depth| *depth == 1.0), "{triangle:?}");
    }
    // A corner with w = 0 is clipped at the guard band, and all depths are finite.
    let texels = drawn(&[[nowhere, a, b]], PLAIN, 32);
    assert!(texels.iter().all(|depth| depth.is_finite()) && texels.iter().any(|depth| *depth < 1.0));
}

#[test]
fn corners_far_aside_do_not_move_the_visible_part() {
    let side = 64;
    // The triangle covers half of the map, however far its other corners are. Beyond 2^9 times the map it is clipped.
    for far in [3.0, 100.0, 1e3, 1e5, 1e7] {
        let triangle = [[0.0, far, 1.0, 0.5], [0.0, -far, 1.0, 0.5], [far, 0.0, 1.0, 0.5]];
        for (index, depth) in drawn(&[triangle], PLAIN, side).iter().enumerate() {
            assert_eq!(*depth < 1.0, index % side >= side / 2, "{far} at {index}");
        }
    }
}
