//! Slow and exact triangles: coverage in integers of 128 bits, depths in f64.

use super::RasterTriangle;

/// Computes the side of the line from `from` to `to` on which a center lies, in 1/256 of a texel: 0 on the line.
fn side_of(from: [i32; 2], to: [i32; 2], at: [i32; 2]) -> i128 {
    let [ax, ay, bx, by, x, y] = [from[0], from[1], to[0], to[1], at[0], at[1]].map(i128::from);
    (bx - ax) * (y - ay) - (by - ay) * (x - ax)
}

/// True if the center of a texel is in a triangle. The top-left rule moves a center on an edge right by next to
/// nothing, and down by next to nothing of that. It is then inside left edges, and level ones at the top.
pub fn is_covered(corners: [[i32; 2]; 3], column: usize, row: usize) -> bool {
    let at = [256 * column as i32, 256 * row as i32];
    // Larger than any change of a line's function from one position to the next.
    let large = 1 << 26;
    let signs = [0, 1, 2].map(|k| {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let here = side_of(from, to, at);
        let rightwards = side_of(from, to, [at[0] + 1, at[1]]) - here;
        let downwards = side_of(from, to, [at[0], at[1] + 1]) - here;
        (here * large * large + rightwards * large + downwards).signum()
    });
    signs == [1; 3] || signs == [-1; 3]
}

/// True if the center of a texel is in a triangle or on its edges, without a rule for edges.
pub fn is_covered_with_edges(corners: [[i32; 2]; 3], column: usize, row: usize) -> bool {
    let at = [256 * column as i32, 256 * row as i32];
    let sides = [0, 1, 2].map(|k| side_of(corners[k], corners[(k + 1) % 3], at));
    sides.iter().all(|side| *side >= 0) || sides.iter().all(|side| *side <= 0)
}

/// Computes the barycentrics of a center, by areas. They have no meaning for a triangle without area.
pub fn shares(corners: [[i32; 2]; 3], column: usize, row: usize) -> [f64; 3] {
    let at = [256 * column as i32, 256 * row as i32];
    let area = side_of(corners[0], corners[1], corners[2]) as f64;
    [0, 1, 2].map(|k| side_of(corners[(k + 1) % 3], corners[(k + 2) % 3], at) as f64 / area)
}

/// Intersects the ray through a point of the map with a triangle in clip coordinates (x, y, w). Returns the shares of
/// the corners, whose signs tell on which side it passes, w and the value. Solves `shares . corners = w (x, y, 1)`.
pub fn meet(triangle: &RasterTriangle, column: f64, row: f64, side: usize) -> ([f64; 3], f64, f64) {
    let half = 0.5 * side as f64;
    let ray = glam::DVec3::new(column / half - 1.0, 1.0 - row / half, 1.0);
    let [a, b, c] = triangle.map(|[x, y, w, _]| glam::DVec3::new(x.into(), y.into(), w.into()));
    let volume = a.dot(b.cross(c));
    let per_w = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| ray.dot(normal) / volume);
    let w = per_w.iter().sum::<f64>().recip();
    let value = (0..3).map(|k| per_w[k] * f64::from(triangle[k][3])).sum::<f64>() * w;
    (per_w, w, value)
}
