//! Tests that simplified meshes stay within the error.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::{MAX_TO_RMS_ERROR, Mesh, simplify};

/// Returns the corners and indices of a part of a unit sphere, from the pole at -y up to the angle `end`. Triangles share
/// no vertices.
fn sphere(end: f64, rows: u32, columns: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let point = |row: u32, column: u32| {
        let polar = end * f64::from(row) / f64::from(rows);
        let (sine, cosine) = libm::sincos(TAU * f64::from(column % columns) / f64::from(columns));
        let around = if row == 0 || (row == rows && end == PI) { 0.0 } else { libm::sin(polar) };
        DVec3::new(around * cosine, -libm::cos(polar), around * sine).as_vec3().to_array()
    };
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let corners = places.flat_map(|(row, column)| {
        [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)].map(|(i, j)| point(row + i, column + j))
    });
    let positions: Vec<_> = corners.collect();
    let indices = (0..positions.len() as u32).collect();
    (positions, indices)
}

/// Returns the largest distance of `mesh` from the unit sphere, over its corners and points between.
fn farthest(mesh: &Mesh) -> f64 {
    const STEPS: u32 = 10;
    let corners = |triangle: &[u32; 3]| triangle.map(|k| Vec3::from(mesh.positions[k as usize]).as_dvec3());
    let between = |[a, b, c]: [DVec3; 3]| {
        (0..=STEPS).flat_map(move |i| (0..=STEPS - i).map(move |j| (i, j))).map(move |(i, j)| {
            let (b_share, c_share) = (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
            a.lerp(b, b_share) + (c - a) * c_share
        })
    };
    let points = mesh.indices.as_chunks().0.iter().map(corners).flat_map(between);
    points.map(|point| (point.length() - 1.0).abs()).fold(0.0, f64::max)
}

/// Every point of the simplified mesh is within the permitted distance of the sphere. With the mean taken for the
/// maximum it is not.
#[test]
fn simplified_meshes_stay_within_the_error() {
    for (positions, indices) in [sphere(PI, 96, 192), sphere(PI / 4.0, 96, 192)] {
        let left = |error: f64| simplify(&positions, (&indices, &[]), error);
        for error in [0.003, 0.01, 0.03, 0.1] {
            let mesh = left(error);
            assert!(mesh.indices.len() * 4 < indices.len(), "{error}: {}", mesh.indices.len());
            assert!(farthest(&mesh) < error, "{error}: {}", farthest(&mesh));
            assert!(farthest(&left(MAX_TO_RMS_ERROR * error)) > error, "{error}: the planted fault went unseen");
        }
        // Below f32 precision: all triangles remain but those without area at the poles.
        let least = left(1e-4).indices.len();
        assert!(least > indices.len() * 9 / 10, "{least}");
    }
}

/// Alpha-tested triangles stay unchanged, and degenerate triangles are harmless.
#[test]
fn alpha_tested_and_degenerate_triangles_are_not_simplified() {
    let (positions, indices) = sphere(PI, 24, 48);
    let corners = |mesh: &Mesh| mesh.indices.iter().map(|&k| mesh.positions[k as usize]).collect::<Vec<_>>();
    let alpha_tested = simplify(&positions, (&[], &indices), 0.1);
    assert_eq!((alpha_tested.opaque_indices, corners(&alpha_tested)), (0, positions.clone()));
    let (opaque, rest) = indices.split_at(indices.len() / 2);
    let both = simplify(&positions, (opaque, rest), 0.1);
    assert!(both.opaque_indices > 0 && both.opaque_indices < opaque.len() / 2);
    assert_eq!(corners(&both)[both.opaque_indices..], positions[opaque.len()..]);

    assert_eq!(simplify(&[], (&[], &[]), 1.0).indices, [0_u32; 0]);
    assert_eq!(simplify(&[[1.0; 3]; 3], (&[0, 1, 2], &[]), 1.0).indices, [0_u32; 0], "one point");
    let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    for error in [f64::MIN_POSITIVE, 1.0, f64::MAX] {
        assert!(simplify(&line, (&[0, 1, 2], &[]), error).indices.len() <= 3);
        assert!(simplify(&positions, (&indices, &[]), error).indices.len() < indices.len());
    }
}
