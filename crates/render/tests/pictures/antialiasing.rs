//! Tests of several samples per pixel.

use glam::DVec3;
use render::{Aov, View};
use scene::Material;

use crate::support::{BACKENDS, filled, floor, instances, on_plane, picture, renderer_of, scene_of, spot, view};

/// Returns a white floor from straight above, whose edges cross pixels.
fn edges(samples: u32) -> View {
    View { samples, ..view(DVec3::new(0.02, 3.0, 0.03), DVec3::new(0.02, 0.0, 0.03), [16, 16], Aov::Beauty) }
}

#[test]
fn coverage_is_the_area() {
    for backend in BACKENDS {
        let view = edges(64);
        let mut renderer = renderer_of(backend, &filled(DVec3::ONE));
        let beauty = renderer.render(&view, &[]).unwrap();
        let half_pixel = 3.0 * 0.4_f64.tan() / 16.0;
        let mut partly = 0;
        for (center, color) in on_plane(&beauty, &view, DVec3::Y, 0.0) {
            let covered = |c: f64| {
                (((c + half_pixel).min(1.0) - (c - half_pixel).max(-1.0)) / (2.0 * half_pixel)).clamp(0.0, 1.0)
            };
            let area = covered(center.x) * covered(center.z);
            // A lattice of N points misses an axis-parallel rectangle by less than (2 log2 N) / N of the pixel.
            assert!((color[3] - area).abs() < 2.0 * 6.0 / 64.0, "{center}: {} for {area}", color[3]);
            assert!((color[0] - color[3]).abs() < 1e-5);
            partly += usize::from(color[3] > 0.01 && color[3] < 0.99);
        }
        assert!(partly > 20);
        // Deliberate fault that the check must detect: a single sample per pixel has no partial coverage.
        assert!(renderer.render(&edges(1), &[]).unwrap().pixels.iter().all(|p| p[3] == 0.0 || p[3] == 1.0));
    }
}

#[test]
fn one_sample_is_repeatable_after_many() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &filled(DVec3::ONE));
        let first = renderer.render(&edges(1), &[]).unwrap();
        let many = renderer.render(&edges(8), &[]).unwrap();
        assert_eq!(renderer.render(&edges(1), &[]).unwrap(), first);
        assert_ne!(first, many);
    }
}

#[test]
fn only_aovs_that_can_be_averaged_are() {
    let scene = scene_of([floor(1.0, 0.0), floor(0.3, 0.5)], vec![Material::default()]);
    let lights = [spot(DVec3::new(0.4, 3.0, 0.0), DVec3::ZERO)];
    for aov in [Aov::Depth, Aov::Normal, Aov::T, Aov::Vw, Aov::Direction] {
        let of = |samples| picture(&scene, &View { aov, ..edges(samples) }, &lights);
        assert_eq!(of(1), of(8), "{aov:?}");
    }
}

/// Visibility is the average of its samples on both backends. Corners that round to the other of two steps move an edge:
/// a pixel in a hundred, as the tests of native pictures derive.
#[test]
fn visibility_is_averaged() {
    let scene = scene_of([floor(1.0, 0.0), floor(0.3, 0.5)], vec![Material::default()]);
    let lights = instances(&[spot(DVec3::new(0.4, 3.0, 0.0), DVec3::ZERO)]);
    let of = |backend, samples| {
        let view = View { aov: Aov::Visibility, ..edges(samples) };
        renderer_of(backend, &scene).render(&view, &lights).unwrap().pixels
    };
    let [wgpu, native] = BACKENDS.map(|backend| of(backend, 8));
    let apart = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        let others = a.iter().zip(b).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-6));
        others.count()
    };
    let at_edges = wgpu.iter().filter(|p| p.iter().any(|x| *x > 0.01 && *x < 0.99)).count();
    assert!(at_edges > 50 && apart(&wgpu, &native) <= 1 + at_edges / 100, "{} of {at_edges}", apart(&wgpu, &native));
    // Deliberate fault that the check must detect: the first of the samples alone.
    for backend in BACKENDS {
        let one = apart(&wgpu, &of(backend, 1));
        assert!(one > at_edges / 2, "{one} of {at_edges}");
    }
}
