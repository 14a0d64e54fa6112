//! Coverage of texels by triangles.

use super::oracle::{is_covered, is_covered_with_edges};
use super::{PLAIN, Random, RasterTriangle, corner, counts, drawn, flat};

/// Makes corners of triangles of all kinds: small, thin, without area, huge, and with corners and edges on centers.
fn random_corners(random: &mut Random, side: usize) -> [[i32; 2]; 3] {
    let end = 256 * side as i32;
    let kind = random.whole(0, 7);
    let mut anywhere = |low: i32, high: i32| [random.whole(low, high), random.whole(low, high)];
    let first = anywhere(-512, end + 512);
    let near = |[x, y]: [i32; 2], first: [i32; 2]| [x + first[0], y + first[1]];
    match kind {
        0 => [first, near(anywhere(-900, 900), first), near(anywhere(-900, 900), first)],
        1 => [first, anywhere(-512, end + 512), anywhere(-512, end + 512)],
        2 => {
            // Thin triangle: the third corner is next to the middle of the others.
            let second = anywhere(-512, end + 512);
            let middle = [0, 1].map(|axis| i32::midpoint(first[axis], second[axis]));
            [first, second, near(anywhere(-3, 4), middle)]
        }
        3 => {
            let step = anywhere(-300, 300);
            [first, near(step, first), near([3 * step[0], 3 * step[1]], first)]
        }
        4 => [0, 1, 2].map(|_| anywhere(-(1 << 19), 1 << 19)),
        5 => [0, 1, 2].map(|_| anywhere(-2, side as i32 + 2).map(|x| 256 * x)),
        _ => [first, near(anywhere(-40, 40), first), near(anywhere(-40, 40), first)],
    }
}

#[test]
fn a_triangle_covers_the_centres_that_exact_arithmetic_says() {
    let mut random = Random(11);
    let mut caught = 0;
    for side in [1, 2, 37, 64, 131] {
        for _ in 0..3000 / side + 60 {
            let corners = random_corners(&mut random, side);
            let w = random.real(0.5, 4.0);
            let texels = drawn(&[corners.map(|at| corner(at, w, 0.5, side))], PLAIN, side);
            for (index, depth) in texels.iter().enumerate() {
                let (column, row) = (index % side, index / side);
                let expected = is_covered(corners, column, row);
                assert_eq!(*depth < 1.0, expected, "{corners:?} at {column}, {row} of {side}");
                caught += usize::from(is_covered_with_edges(corners, column, row) != expected);
            }
        }
    }
    // Deliberate fault that the check must detect: coverage without a rule for edges.
    assert!(caught > 300, "centres on edges are what is difficult, and there are {caught} of them");
}

/// Makes triangles that cover more than the map. Two triangles share each edge.
fn mesh(random: &mut Random, side: usize, cell: i32) -> Vec<[[i32; 2]; 3]> {
    let cells = 256 * side as i32 / cell + 4;
    let mut grid = Vec::new();
    for index in 0..(cells + 1) * (cells + 1) {
        let on_centres = random.whole(0, 3) == 0;
        let corner = [index % (cells + 1), index / (cells + 1)].map(|step| {
            let coordinate = (step - 2) * cell + random.whole(-cell / 3, cell / 3 + 1);
            if on_centres { coordinate / 256 * 256 } else { coordinate }
        });
        grid.push(corner);
    }
    let mut triangles = Vec::new();
    for index in 0..cells * cells {
        let at = (index % cells + index / cells * (cells + 1)) as usize;
        let below = at + cells as usize + 1;
        let [a, b, c, d] = [grid[at], grid[at + 1], grid[below], grid[below + 1]];
        let (mut one, two) = if random.whole(0, 2) == 0 { ([a, b, c], [b, c, d]) } else { ([a, b, d], [a, d, c]) };
        one.rotate_left(random.whole(0, 3) as usize);
        triangles.extend([one, two]);
    }
    triangles
}

#[test]
fn each_texel_is_in_exactly_one_of_triangles_that_tile_the_map() {
    let mut random = Random(5);
    // Cells of at least 3 texels, so that no triangle turns over where corners move onto centers.
    for (side, cell) in [(64, 900), (64, 2100), (37, 1300), (300, 40_000)] {
        let triangles = mesh(&mut random, side, cell);
        let shapes: Vec<RasterTriangle> = triangles.iter().map(|corners| flat(*corners, side)).collect();
        assert_eq!(counts(&shapes, PLAIN, side), vec![1; side * side]);
        // Deliberate fault that the check must detect: edges that belong to both sides.
        let count = |index: usize| {
            let is_in = |corners: &&[[i32; 2]; 3]| is_covered_with_edges(**corners, index % side, index / side);
            triangles.iter().filter(is_in).count()
        };
        assert!((0..side * side).any(|index| count(index) > 1));
    }
}

#[test]
fn one_triangle_of_a_fan_covers_its_centre() {
    let mut random = Random(3);
    let (side, middle) = (16, [7 * 256, 9 * 256]);
    for blades in 3..12 {
        let rim = |k: usize| {
            let angle = std::f64::consts::TAU * (k % blades) as f64 / blades as f64;
            [middle[0] + (700.0 * libm::cos(angle)) as i32, middle[1] + (700.0 * libm::sin(angle)) as i32]
        };
        let blade = |k: usize| {
            let mut corners = [middle, rim(k), rim(k + 1)];
            corners.rotate_left(random.whole(0, 3) as usize);
            flat(corners, side)
        };
        let fan: Vec<RasterTriangle> = (0..blades).map(blade).collect();
        assert_eq!(counts(&fan, PLAIN, side)[9 * side + 7], 1, "{blades} blades");
    }
}

#[test]
fn neither_winding_nor_where_corners_begin_changes_a_map() {
    let mut random = Random(9);
    let side = 37;
    for _ in 0..200 {
        let [a, b, c] = random_corners(&mut random, side);
        let one = drawn(&[flat([a, b, c], side)], PLAIN, side);
        for turned in [[b, c, a], [c, a, b], [a, c, b], [b, a, c]] {
            assert_eq!(drawn(&[flat(turned, side)], PLAIN, side), one);
        }
    }
}
