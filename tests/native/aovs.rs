//! AOVs of surfaces and of lights.

use glam::{DQuat, DVec3};
use light::{Light, Transform};
use scene::{Aov, View};

use super::both::{ViewedScene, demo};
use super::straight::{in_room, shapes};

/// Largest difference of a value, as a share of the larger of it and 1. Positions have errors of some 2^-22 of the
/// room, and coordinates in a light as much over its width, which is a tenth of the room or more. Unit vectors of a
/// G-buffer have steps of 2^-15.
const MARGIN: f32 = 1e-4;

/// Number of pixels with values that differ, of those that have some. The native picture is moved `aside` by pixels.
fn differing(viewed: &ViewedScene, aov: Aov, [wgpu, native]: [&Light; 2], aside: usize) -> [usize; 2] {
    let view = View { aov, ..viewed.view.clone() };
    let [a, mut b] = viewed.raw(&view, [wgpu, native]);
    b.rotate_left(aside);
    let differ = |a: f32, b: f32| (a - b).abs() > MARGIN * a.abs().max(b.abs()).max(1.0);
    let differing = a.iter().zip(&b).filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| differ(*a, *b))).count();
    [differing, a.iter().filter(|pixel| pixel[3] > 0.0).count()]
}

/// At edges of surfaces and of the light a pixel in a hundred may lie on the other side. Planted faults: a light moved by
/// a hundredth of the room and turned by a degree, and a picture a pixel aside.
fn assert_aovs_agree(name: &str, viewed: &ViewedScene, light: &Light) {
    for aov in [Aov::Depth, Aov::Normal, Aov::Position, Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility] {
        let [differing, shown] = differing(viewed, aov, [light, light], 0);
        println!("{name}, {aov:?}: {differing} of {shown}");
        assert!(shown > 1000 && differing <= shown / 100, "{name}, {aov:?}: {differing} of {shown} differ");
    }
    let Transform { translation, rotation, scale } = light.transform();
    let turned = DQuat::from_rotation_y(0.02) * rotation;
    let moved = Transform { translation: translation + DVec3::new(0.1, 0.05, 0.0), rotation: turned, scale };
    let moved = light.clone().with_transform(moved);
    // Without a window, v and w of parallel rays are 0 everywhere.
    let seen = [Aov::Vw, Aov::Direction].map(|aov| differing(viewed, aov, [light, &moved], 0));
    assert!(
        seen.iter().any(|[by_light, shown]| by_light > &(shown / 2)),
        "{name}: a moved light goes unseen: {seen:?}"
    );
    let [by_pixel, shown] = differing(viewed, Aov::Position, [light, light], 1);
    assert!(by_pixel > shown / 2, "{name}: a picture a pixel aside goes unseen");
}

#[test]
fn aovs_of_straight_lights_agree_on_both_backends() {
    for (name, light) in shapes() {
        assert_aovs_agree(name, &in_room(), &light);
    }
}

#[test]
fn aovs_of_a_bendy_light_agree_on_both_backends() {
    let vases = demo("vases");
    let light = vases.contents.lights[0].light().clone();
    assert_aovs_agree("bendy", &ViewedScene::at(&vases), &light);
}

/// Lines of triangles fade over a pixel, by differences of neighbouring pixels on one side and by derivatives on the
/// other: they are compared where neither shows one.
#[test]
fn a_wireframe_shows_the_same_triangles() {
    let vases = demo("vases");
    let light = vases.contents.lights[0].light().clone();
    let viewed = ViewedScene::at(&vases);
    let view = View { aov: Aov::Wireframe, ..viewed.view.clone() };
    let [a, b] = viewed.raw(&view, [&light, &light]);
    let shown = a.iter().filter(|pixel| pixel[3] == 1.0).count();
    let lines = |picture: &[[f32; 4]]| picture.iter().filter(|pixel| pixel[1] > 0.5).count();
    let differing = a.iter().zip(&b).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-3 || a[3] != b[3]).count();
    println!("{differing} of {shown} differ; lines {} and {}", lines(&a), lines(&b));
    assert!(shown > 5000 && differing <= shown / 100, "{differing} of {shown} differ");
    assert!(lines(&a).abs_diff(lines(&b)) <= lines(&a) / 20, "{} and {} pixels of lines", lines(&a), lines(&b));
}
