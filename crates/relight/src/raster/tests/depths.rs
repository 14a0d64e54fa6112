//! Depths that maps store.

use super::oracle::{is_covered, shares};
use super::{DepthRule, PLAIN, Random, RasterTriangle, corner, drawn};

/// Half a unit in the last place of 1.
const U: f64 = 0.5 * f32::EPSILON as f64;

/// Makes a triangle, small or large, near or far, perhaps thin.
fn random_triangle(random: &mut Random, side: usize) -> ([[i32; 2]; 3], RasterTriangle) {
    let size = [400, 3000, 30_000, 90_000][random.whole(0, 4) as usize];
    let first = [random.whole(0, 256 * side as i32), random.whole(0, 256 * side as i32)];
    let corners = [0, 1, 2].map(|_| first.map(|x| x + random.whole(-size, size)));
    let triangle = corners.map(|at| {
        let (w, value) = (random.real(0.1, 1.0), random.real(0.05, 0.95));
        corner(at, w, value, side)
    });
    (corners, triangle)
}

/// Computes N or D at a center by [`shares`], and its greatest value at a corner.
fn linear(corners: [[i32; 2]; 3], n: [f64; 3], column: usize, row: usize) -> (f64, f64) {
    let shares = shares(corners, column, row);
    let here = (0..3).map(|k| shares[k] * n[k]).sum();
    (here, n.into_iter().fold(0.0, f64::max))
}

/// Computes the tolerance of a depth N / D.
///
/// N at corners is rounded twice, D once. A difference from the first corner, at most as large as the greatest, is
/// rounded, and so are the area, its inverse and the product: 4. Two sums at the first texel, and two at each: 4 more.
/// Then the product with the row's factor, itself rounded, and the quotient: 3.
fn tolerance(depth: f64, (n, most_n): (f64, f64), (d, most_d): (f64, f64)) -> f64 {
    depth * U * (10.0 * most_n / n + 9.0 * most_d / d + 3.0)
}

#[test]
fn values_are_interpolated_by_perspective() {
    let mut random = Random(21);
    let side = 300;
    let (mut covered, mut affine) = (0, 0);
    for _ in 0..120 {
        let (corners, triangle) = random_triangle(&mut random, side);
        let texels = drawn(&[triangle], PLAIN, side);
        let [values, ds] = [3, 2].map(|k| triangle.map(|corner| f64::from(corner[k])));
        let ds = ds.map(f64::recip);
        for (index, depth) in texels.iter().enumerate() {
            let (column, row) = (index % side, index / side);
            if !is_covered(corners, column, row) {
                continue;
            }
            let n = linear(corners, [0, 1, 2].map(|k| values[k] * ds[k]), column, row);
            let d = linear(corners, ds, column, row);
            let (expected, error) = (n.0 / d.0, (f64::from(*depth) - n.0 / d.0).abs());
            let tolerance = tolerance(expected, n, d);
            assert!(error <= tolerance, "{error:e} of {tolerance:e} at {column}, {row}: {triangle:?}");
            covered += 1;
            // Deliberate fault that the check must detect: values that are linear on the map.
            affine += usize::from((linear(corners, values, column, row).0 - expected).abs() > tolerance);
        }
    }
    assert!(covered > 100_000 && affine > covered * 9 / 10, "{affine} of {covered}");
}

#[test]
fn a_bent_depth_is_over_what_its_row_says() {
    let (side, row, depth_per_value) = (40, [2.0, -0.02], 0.7);
    let all = [[-1.0, 1.0], [3.0, 1.0], [-1.0, -3.0]].map(|[x, y]| [x, y, 1.0, 0.5]);
    let texels = drawn(&[all], DepthRule::Bent { row_divisor: row, depth_per_value }, side);
    for (index, depth) in texels.iter().enumerate() {
        let factor = 2.0 - 0.02 * ((index / side) as f64 + 0.5);
        let expected = 0.5 * f64::from(depth_per_value) / factor;
        // The corners' roundings, four of the row's factor, which sums two numbers of at most its double, and more.
        let tolerance = expected * U * 40.0;
        assert!((f64::from(*depth) - expected).abs() < tolerance, "{depth} for {expected}");
    }
}

#[test]
fn a_straight_lights_depth_is_near_over_w() {
    let mut random = Random(8);
    let side = 300;
    let near = 0.07_f32;
    let mut covered = 0;
    for _ in 0..60 {
        let (corners, triangle) = random_triangle(&mut random, side);
        let texels = drawn(&[triangle], DepthRule::Perspective { near }, side);
        let ds = triangle.map(|corner| f64::from(near) / f64::from(corner[2]));
        for (index, depth) in texels.iter().enumerate() {
            let (column, row) = (index % side, index / side);
            if is_covered(corners, column, row) {
                let (expected, most) = linear(corners, ds, column, row);
                assert!((f64::from(*depth) - expected).abs() <= 10.0 * U * most);
                covered += 1;
            } else {
                assert_eq!(*depth, 0.0);
            }
        }
    }
    assert!(covered > 50_000);
}

#[test]
fn an_orthographic_depth_is_the_value_where_it_is_within_0_and_1() {
    let side = 64;
    // From -0.5 at the left to 1.5 at the right.
    let all = [[-1.0, 1.0, -0.5], [3.0, 1.0, 3.5], [-1.0, -3.0, -0.5]].map(|[x, y, value]| [x, y, 1.0, value]);
    let texels = drawn(&[all], DepthRule::Orthographic, side);
    for (index, depth) in texels.iter().enumerate() {
        let value = 2.0 * ((index % side) as f64 + 0.5) / side as f64 - 0.5;
        let expected = if (0.0..=1.0).contains(&value) { value } else { 0.0 };
        assert!((f64::from(*depth) - expected).abs() <= 10.0 * U * 3.5, "{depth} for {expected}");
    }
}

#[test]
fn the_nearest_triangle_wins_whatever_the_order() {
    let side = 20;
    let all = |value: f32, w: f32| [[-1.0, 1.0], [3.0, 1.0], [-1.0, -3.0]].map(|[x, y]| [x * w, y * w, w, value]);
    let (near, far) = (all(0.25, 0.5), all(0.75, 0.8));
    let straight = DepthRule::Perspective { near: 0.25 };
    for pair in [[near, far], [far, near]] {
        assert!(drawn(&pair, PLAIN, side).iter().all(|depth| *depth == 0.25));
        assert!(drawn(&pair, straight, side).iter().all(|depth| *depth == 0.5));
        assert!(drawn(&pair, DepthRule::Orthographic, side).iter().all(|depth| *depth > 0.9));
    }
}
