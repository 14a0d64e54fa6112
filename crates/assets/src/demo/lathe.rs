//! Surfaces of revolution about +Y, from a smooth profile.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use scene::Primitive;

/// Maximum number of vertex rows along the profile.
const ROWS: usize = 64;
/// Number of candidate points per span between two control points. The rows are chosen among them.
const TRIED_PER_SPAN: usize = 24;
/// Vertices around the axis.
const AROUND: usize = 60;

/// Returns the surface of revolution about +Y of the uniform cubic B-spline with control points `(radius,
/// height)`, with its lowest point at y = 0.
///
/// The profile starts and ends on the axis, at its first and last control point, and keeps the outside on its
/// right: from under the foot up the outer wall, over the lip, and down inside. Its first and last step are
/// level, so that the surface is smooth on the axis. Normals are those of the spline.
pub fn lathe(profile: &[(f64, f64)]) -> Primitive {
    let rows = sample(&profile.iter().copied().map(DVec2::from).collect::<Vec<_>>());
    let ground = rows.iter().fold(f64::INFINITY, |least, (point, _)| least.min(point.y));
    let mut made = Primitive::default();
    for (point, tangent) in &rows {
        let outwards = DVec2::new(tangent.y, -tangent.x).normalize();
        for column in 0..AROUND {
            let (sin, cos) = libm::sincos(TAU * column as f64 / AROUND as f64);
            let turned = |v: DVec2| DVec3::new(v.x * cos, v.y, v.x * sin);
            made.positions.push(turned(*point - DVec2::new(0.0, ground)).as_vec3());
            made.normals.push(turned(outwards).as_vec3());
        }
    }
    let vertex = |row: usize, column: usize| (row * AROUND + column % AROUND) as u32;
    for row in 0..rows.len() - 1 {
        for column in 0..AROUND {
            let (a, b) = (vertex(row, column), vertex(row + 1, column));
            let (c, d) = (vertex(row, column + 1), vertex(row + 1, column + 1));
            // On the axis a row is a single point, and one of the two triangles has zero area.
            if row > 0 {
                made.indices.extend([a, b, c]);
            }
            if row + 2 < rows.len() {
                made.indices.extend([b, d, c]);
            }
        }
    }
    made
}

/// Samples at most `ROWS` points and tangents of the uniform cubic B-spline. A mirrored point beyond each end
/// makes it start and end at its control points.
///
/// Rows are evenly spaced by the sum of relative length and relative turn, so that both long walls and tight
/// lips look round.
fn sample(control: &[DVec2]) -> Vec<(DVec2, DVec2)> {
    let last = control.len() - 1;
    let (before, after) = (2.0 * control[0] - control[1], 2.0 * control[last] - control[last - 1]);
    let p = [&[before], control, &[after]].concat();
    let at = |row: usize| {
        let span = (row / TRIED_PER_SPAN).min(last - 1);
        let u = (row - span * TRIED_PER_SPAN) as f64 / TRIED_PER_SPAN as f64;
        let (b, db) = basis(u);
        let blend = |weights: [f64; 4]| weights.iter().zip(&p[span..]).map(|(w, p)| *w * *p).sum();
        (blend(b), blend(db))
    };
    let tried: Vec<(DVec2, DVec2)> = (0..=last * TRIED_PER_SPAN).map(at).collect();
    let so_far = |step: fn(&[(DVec2, DVec2)]) -> f64| {
        let sums = tried.windows(2).scan(0.0, |sum, pair| {
            *sum += step(pair);
            Some(*sum)
        });
        std::iter::once(0.0).chain(sums).collect::<Vec<f64>>()
    };
    let length = so_far(|pair| pair[1].0.distance(pair[0].0));
    let turn = so_far(|pair| {
        let (a, b) = (pair[0].1.normalize(), pair[1].1.normalize());
        libm::atan2(a.perp_dot(b).abs(), a.dot(b))
    });
    let (whole_length, whole_turn) = (length[tried.len() - 1], turn[tried.len() - 1]);
    let effort = |k: usize| length[k] / whole_length + turn[k] / whole_turn;
    let mut chosen: Vec<usize> = (0..ROWS)
        .map(|row| {
            let target = 2.0 * row as f64 / (ROWS - 1) as f64;
            (0..tried.len()).find(|&k| effort(k) >= target - 1e-9).unwrap_or(tried.len() - 1)
        })
        .collect();
    chosen.dedup();
    chosen.into_iter().map(|k| tried[k]).collect()
}

/// Returns the four uniform cubic B-spline weights at `u` in 0 to 1, and their derivatives.
fn basis(u: f64) -> ([f64; 4], [f64; 4]) {
    let s = 1.0 - u;
    let weights = [
        s * s * s / 6.0,
        (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0,
        (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
        u * u * u / 6.0,
    ];
    let derivatives = [-s * s / 2.0, (3.0 * u * u - 4.0 * u) / 2.0, (4.0 * s - 3.0 * s * s) / 2.0, u * u / 2.0];
    (weights, derivatives)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_derivatives_are_theirs() {
        for i in 1..20 {
            let (u, h) = (f64::from(i) / 20.0, 1e-6);
            let (weights, derivatives) = basis(u);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
            let (before, after) = (basis(u - h).0, basis(u + h).0);
            for (derivative, (before, after)) in derivatives.iter().zip(before.iter().zip(after)) {
                // A central difference of a cubic has an error of h^2 from truncation, and of eps / h from
                // rounding.
                assert!((derivative - (after - before) / (2.0 * h)).abs() < 1e-9, "at {u}");
            }
        }
    }

    #[test]
    fn triangles_wind_with_their_normals_and_close_the_surface() {
        let cup = [(0.0, 0.3), (0.2, 0.3), (0.3, 0.2), (0.4, 0.5), (0.3, 1.0), (0.2, 0.9), (0.1, 0.4), (0.0, 0.4)];
        let made = lathe(&cup);
        let (triangles, _) = made.indices.as_chunks::<3>();
        // By the divergence theorem a closed surface with outward winding has a positive volume. This one is a
        // thick cup.
        let mut six_volumes = 0.0;
        for t in triangles {
            let [a, b, c] = t.map(|i| made.positions[i as usize].as_dvec3());
            let mean: DVec3 = t.iter().map(|&i| made.normals[i as usize].as_dvec3()).sum();
            assert!((b - a).cross(c - a).dot(mean) > 0.0, "a triangle faces against its normals");
            six_volumes += a.dot(b.cross(c));
        }
        assert!(six_volumes / 6.0 > 0.05);
        assert!(made.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
        let lowest = made.positions.iter().fold(f32::INFINITY, |least, p| least.min(p.y));
        assert!(lowest.abs() < 1e-7, "it stands on the table");
    }
}
