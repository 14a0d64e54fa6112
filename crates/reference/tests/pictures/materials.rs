//! Tests of materials in the reference: textures, holes and sides.

use glam::{DAffine3, DVec2, DVec3, Vec2};
use reference::Reference;
use scene::{Aov, Image, Material, Projection, Sampler, Scene, TextureRef, Wrap};

use crate::support::{floor, render, scene_of, spot, square, view};

/// Builds a square of half extent `half`, with a picture that covers it once.
fn pictured(half: f64, image: Image, sampler: Sampler) -> Scene {
    let (mut primitive, parent_from_local) = floor(half);
    primitive.uvs = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(Vec2::from).into();
    let mut scene = scene_of([(primitive, parent_from_local)]);
    scene.images = vec![image];
    scene.materials[0].base_color_texture = Some(TextureRef { image: 0, sampler });
    scene
}

fn gray(width: u32, height: u32, shades: &[u8]) -> Image {
    Image { width, height, rgba8: shades.iter().flat_map(|&shade| [shade, shade, shade, 255]).collect() }
}

fn linear(shade: u8) -> f64 {
    ((f64::from(shade) / 255.0 + 0.055) / 1.055).powf(2.4)
}

/// Returns the base color of `scene` at `x`, `z`, in the middle of a picture from one unit above.
fn base_color_at(scene: &Scene, x: f64, z: f64) -> f64 {
    let mut view = view(DVec3::new(x, 1.0, z), DVec3::new(x, 0.0, z), Aov::Beauty);
    view.camera.projection = Projection::Perspective { yfov: 1e-4, aspect_ratio: None, znear: 0.01, zfar: None };
    let middle = DVec2::new(f64::from(view.width), f64::from(view.height)) / 2.0;
    Reference::new(scene::pose(scene.clone(), 0.0)).surface(&view, middle).expect("the square is there").base_color.x
}

#[test]
fn texels_are_blended_between_their_centres() {
    let smooth = Sampler { wrap_u: Wrap::ClampToEdge, ..Sampler::default() };
    let scene = pictured(1.0, gray(2, 1, &[60, 200]), smooth);
    let [dark, bright] = [60, 200].map(linear);
    // Texel centres lie at uv 1/4 and 3/4, that is at x -1/2 and 1/2. The view covers 1e-4 of a texel, so mip
    // levels have no effect.
    for (x, share) in [(-0.5, 0.0), (-0.25, 0.25), (0.0, 0.5), (0.5, 1.0), (0.9, 1.0), (-0.9, 0.0)] {
        let expected = dark + (bright - dark) * share;
        assert!((base_color_at(&scene, x, 0.3) - expected).abs() < 1e-12, "{x}");
    }
    let repeating = pictured(1.0, gray(2, 1, &[60, 200]), Sampler::default());
    assert!(
        (base_color_at(&repeating, 1.0 - 1e-9, 0.3) - f64::midpoint(dark, bright)).abs() < 1e-8,
        "blends with the other end"
    );
    let nearest = pictured(1.0, gray(2, 1, &[60, 200]), Sampler { nearest: true, ..smooth });
    assert_eq!(base_color_at(&nearest, -0.01, 0.3), base_color_at(&nearest, -0.9, 0.3));
}

#[test]
fn far_pictures_are_their_mean_in_linear_light() {
    let size = 64_u32;
    let shades: Vec<u8> = (0..size * size).map(|k| if (k + k / size).is_multiple_of(2) { 30 } else { 220 }).collect();
    let scene = pictured(1.0, gray(size, size, &shades), Sampler::default());
    // From 2,000 units above, a pixel covers far more than the square.
    let mut view = view(DVec3::Y * 2000.0, DVec3::ZERO, Aov::Beauty);
    view.width = 1;
    view.height = 1;
    let surface = Reference::new(scene::pose(scene.clone(), 0.0)).surface(&view, DVec2::splat(0.5)).unwrap();
    let mean = f64::midpoint(linear(30), linear(220));
    assert!((surface.base_color.x - mean).abs() < 1e-12, "{} {mean}", surface.base_color.x);
    // Deliberate fault that the check must detect: the mean of the bytes.
    assert!((linear(125) - mean).abs() > 0.1);
}

/// Builds a screen over a floor. The left half of the screen is transparent.
fn cut_out(alpha_cutoff: Option<f32>) -> Scene {
    let image = Image { width: 2, height: 1, rgba8: vec![255, 255, 255, 0, 255, 255, 255, 255] };
    let sampler = Sampler { nearest: true, wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge };
    let (screen, below) = (pictured(0.5, image, sampler), floor(3.0));
    let raised = DAffine3::from_translation(DVec3::Y) * screen.nodes[0].parent_from_local;
    let mut scene = scene_of([(screen.meshes[0].primitives[0].clone(), raised), below]);
    scene.images = screen.images;
    scene.materials.push(Material { alpha_cutoff, ..screen.materials[0].clone() });
    scene.meshes[0].primitives[0].material = 1;
    scene
}

#[test]
fn light_passes_through_holes() {
    let spot = spot(DVec3::Y * 4.0, DVec3::ZERO);
    let bent = light::bend(&spot, 2).unwrap();
    let below = view(DVec3::new(0.0, 0.8, 2.5), DVec3::ZERO, Aov::Visibility);
    for light in [spot, bent] {
        let shadowed = |cutoff| {
            let frame = render(&cut_out(cutoff), &below, std::slice::from_ref(&light));
            frame.pixels.iter().filter(|pixel| pixel[3] == 1.0 && pixel[0] == 0.0).count()
        };
        let (whole, half) = (shadowed(None), shadowed(Some(0.5)));
        // The hole is half of the screen, give or take a row of pixels at its edges.
        assert!(whole > 60 && half.abs_diff(whole / 2) < whole / 8, "{whole} {half}");
    }
}

#[test]
fn back_faces_are_seen_where_the_material_says_so() {
    let mut scene = scene_of([(square(), DAffine3::IDENTITY)]);
    let from_below = view(DVec3::new(0.0, -2.0, 0.1), DVec3::ZERO, Aov::Normal);
    let seen = |scene: &Scene| render(scene, &from_below, &[]).pixels[48 * 16 + 24];
    assert_eq!(seen(&scene), [0.0; 4]);
    scene.materials[0].double_sided = true;
    // The normal faces the viewer, who is below.
    assert_eq!(seen(&scene), [0.0, -1.0, 0.0, 1.0]);
}

#[test]
fn orthographic_cameras_see_parallel() {
    let mut scene = scene_of([floor(1.0)]);
    let mut above = view(DVec3::Y * 3.0, DVec3::ZERO, Aov::Depth);
    above.camera.projection = Projection::Orthographic { ymag: 2.0, aspect_ratio: None, znear: 0.0, zfar: 10.0 };
    let frame = render(&scene, &above, &[]);
    // The square covers two of four units in each direction: half of the 32 rows, and as many of the 48
    // columns.
    let seen: Vec<_> = frame.pixels.iter().filter(|pixel| pixel[3] == 1.0).collect();
    assert_eq!(seen.len(), 16 * 16);
    assert!(seen.iter().all(|pixel| (pixel[0] - 3.0).abs() < 1e-12), "one distance everywhere");
    scene.nodes[0].parent_from_local.translation.y = -8.0;
    assert!(render(&scene, &above, &[]).pixels.iter().all(|pixel| pixel[3] == 0.0), "behind the far plane");
}
