//! Tests of the position and orientation of surfaces.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
use render::{Aov, Picture, View};
use scene::{Image, Material, Projection, Sampler, Scene, TextureRef, Wrap};

use crate::support::{EPS, floor, picture, ray_in_world, scene_of, spot, square, view};

/// Returns a square tilted in all axes about `center`, and its unit normal.
fn tilted(center: DVec3) -> (Scene, DVec3) {
    let rotation = DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(-0.3);
    let placement = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), rotation, center);
    (scene_of([(square(), placement)], vec![Material::default()]), rotation * DVec3::Y)
}

/// Returns the largest error of a depth picture of the plane through `center`, relative to its bound, and the number of
/// compared pixels.
///
/// The bound: the plane's offset, the eye's distance from it and the ray's closing speed are each a sum of three
/// products of rounded numbers no larger than the scene and the eye's distance from its center: 8 roundings.
fn depth_error(depths: &Picture, view: &View, center: DVec3, normal: DVec3) -> (f64, usize) {
    let mut worst = (0.0, 0);
    for (i, pixel) in depths.pixels.iter().enumerate().filter(|(_, p)| p[3] == 1.0) {
        let (origin, direction) = ray_in_world(view, i % depths.width as usize, i / depths.width as usize);
        let closing = normal.dot(direction);
        let depth = normal.dot(center - origin) / closing;
        let size = (origin - center).length() + 4.0 + depth * direction.length();
        let bound = 8.0 * EPS * size / closing.abs();
        worst.0 = f64::max(worst.0, (f64::from(pixel[0]) - depth).abs() / bound);
        worst.1 += 1;
    }
    worst
}

#[test]
fn depth_is_where_the_ray_meets_the_plane() {
    let projections = [
        Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 0.05, zfar: None },
        Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 1e-3, zfar: Some(100.0) },
        Projection::Orthographic { ymag: 2.0, aspect_ratio: None, znear: 0.0, zfar: 50.0 },
    ];
    for projection in projections {
        let (scene, normal) = tilted(DVec3::ZERO);
        let mut view = view(DVec3::new(1.0, 4.0, 5.0), DVec3::ZERO, [61, 47], Aov::Depth);
        view.camera.projection = projection;
        let depths = picture(&scene, &view, &[]);
        let (worst, compared) = depth_error(&depths, &view, DVec3::ZERO, normal);
        assert!(compared > 300);
        assert!(worst <= 1.0, "{projection:?}: {worst} times the bound");
        // Deliberate fault that the check must detect: rays through the corners of the pixels instead of their centers.
        let shift = ray_in_world(&view, 1, 1).1 - ray_in_world(&view, 0, 0).1;
        let mut shifted = view.clone();
        match &mut shifted.camera.projection {
            Projection::Perspective { .. } => {
                shifted.camera.rotation *= DQuat::from_rotation_y(shift.length() / 2.0);
            }
            Projection::Orthographic { .. } => shifted.camera.translation.x += 0.02,
        }
        assert!(depth_error(&depths, &shifted, DVec3::ZERO, normal).0 > 100.0);
    }
}

#[test]
fn a_scene_far_from_the_origin_looks_the_same() {
    let offset = DVec3::new(1e6, -3e6, 2e6);
    let (eye, target) = (DVec3::new(1.03, 4.11, 5.07), DVec3::ZERO);
    let (near_scene, normal) = tilted(DVec3::ZERO);
    let (far_scene, _) = tilted(offset);
    let near = picture(&near_scene, &view(eye, target, [61, 47], Aov::Depth), &[]);
    let far_view = view(eye + offset, target + offset, [61, 47], Aov::Depth);
    let far = picture(&far_scene, &far_view, &[]);
    assert!(near.pixels.iter().zip(&far.pixels).all(|(a, b)| a[3] == b[3]));
    // f64 rounds 3e6 by 5e-10, far below the bound; f32, the fault, by 0.25.
    let (worst, compared) = depth_error(&far, &far_view, offset, normal);
    assert!(compared > 300 && worst <= 1.0, "{worst} times the bound at {compared} pixels");
    let rounded = (eye + offset).as_vec3().as_dvec3();
    assert!(depth_error(&far, &view(rounded, rounded - eye, [61, 47], Aov::Depth), offset, normal).0 > 100.0);
}

/// Returns the normal of the pixel in the middle, and its alpha.
fn middle(scene: &Scene, eye: DVec3) -> [f32; 4] {
    picture(scene, &view(eye, DVec3::ZERO, [5, 5], Aov::Normal), &[]).pixels[12]
}

#[test]
fn normals_face_the_viewer_and_one_sided_backs_are_not_drawn() {
    let (above, below) = (DVec3::new(0.3, 2.0, 0.2), DVec3::new(0.3, -2.0, 0.2));
    let (up, down, nothing) = ([0.0, 1.0, 0.0, 1.0], [0.0, -1.0, 0.0, 1.0], [0.0; 4]);
    let (mirrored, upside_down) = (DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0));
    // Octahedral normals in 16 bits: the axes are exact.
    for (double_sided, scale, eye, expected) in [
        (false, DVec3::ONE, above, up),
        (false, DVec3::ONE, below, nothing),
        (true, DVec3::ONE, below, down),
        (false, mirrored, above, up),
        (false, mirrored, below, nothing),
        (false, upside_down, above, nothing),
        (false, upside_down, below, down),
    ] {
        let material = Material { double_sided, ..Material::default() };
        let scene = scene_of([(square(), DAffine3::from_scale(scale))], vec![material]);
        assert_eq!(middle(&scene, eye), expected, "double-sided {double_sided}, scale {scale}, from {eye}");
    }
}

#[test]
fn normals_of_stretched_spheres_stay_perpendicular() {
    // A square with a slanted normal field, stretched: normals transform with the inverse transpose.
    let mut primitive = square();
    primitive.normals = vec![Vec3::new(0.6, 0.8, 0.0); 4];
    let scene = scene_of([(primitive, DAffine3::from_scale(DVec3::new(4.0, 0.5, 2.0)))], vec![Material::default()]);
    let expected = DVec3::new(0.6 / 4.0, 0.8 / 0.5, 0.0).normalize();
    let [x, y, z, _] = middle(&scene, DVec3::new(0.3, 2.0, 0.2)).map(f64::from);
    // Octahedral in 16 bits: half a step of 1 / 32767 in each of two coordinates, stretched up to sqrt(3) / 1.
    assert!((DVec3::new(x, y, z) - expected).length() < 1.0 / 32767.0 * 3.0_f64.sqrt());
    // The fault: normals transformed like directions.
    assert!((DVec3::new(0.6 * 4.0, 0.8 * 0.5, 0.0).normalize() - expected).length() > 0.5);
}

/// Texture of [`textured_floor`].
const HALVES: TextureRef =
    TextureRef { image: 0, sampler: Sampler { nearest: true, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat } };

/// Returns a square of that material, with texture coordinates that run along x. The left and right halves of its
/// texture have different colors.
fn textured_floor(material: Material, halves: [[u8; 4]; 2]) -> Scene {
    let mut primitive = square();
    primitive.uvs = primitive.positions.iter().map(|p| Vec2::new(p.x * 0.5 + 0.5, 0.5)).collect();
    let mut scene = scene_of([(primitive, DAffine3::IDENTITY)], vec![material]);
    scene.images.push(Image { width: 2, height: 1, rgba8: halves.concat() });
    scene
}

#[test]
fn surfaces_with_an_alpha_below_the_cutoff_are_not_drawn() {
    for (alpha_cutoff, left_there) in [(None, true), (Some(0.5), false)] {
        let material = Material { base_color_texture: Some(HALVES), alpha_cutoff, ..Material::default() };
        let scene = textured_floor(material, [[255, 255, 255, 100], [255, 255, 255, 200]]);
        let alphas = picture(&scene, &view(DVec3::Y * 2.0, DVec3::ZERO, [9, 9], Aov::Depth), &[]);
        assert_eq!(alphas.pixels[4 * 9 + 2][3] == 1.0, left_there);
        assert!(alphas.pixels[4 * 9 + 6][3] == 1.0);
    }
}

#[test]
fn textures_vertex_colours_and_factors_multiply_in_linear_light() {
    // 188 in sRGB is 0.5029 linear; the red factor is 0.5; a vertex color halves green.
    let base_color = Vec4::new(0.5, 1.0, 1.0, 1.0);
    let material = Material { base_color, base_color_texture: Some(HALVES), ..Material::default() };
    let mut scene = textured_floor(material, [[188, 188, 0, 255], [255, 255, 255, 255]]);
    scene.meshes[0].primitives[0].colors = vec![Vec4::new(1.0, 0.5, 1.0, 1.0); 4];
    (scene.fill.sky, scene.fill.ground) = (DVec3::ONE, DVec3::ONE);
    let beauty = picture(&scene, &view(DVec3::Y * 2.0, DVec3::ZERO, [9, 9], Aov::Beauty), &[]);
    // A fill of 1 returns the base color, stored as its square root in 8 bits: half a step is 1 / 255 relative at 1/4.
    let near = |a: [f32; 4], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1.1 * b.sqrt() / 255.0 + 1e-4);
    let (left, right) = (beauty.pixels[4 * 9 + 2], beauty.pixels[4 * 9 + 6]);
    assert!(near(left, [0.25145, 0.25145, 0.0]), "{left:?}");
    assert!(near(right, [0.5, 0.5, 1.0]), "{right:?}");
    // The fault: multiplying encoded values gives 188 / 255 / 2.
    assert!(!near(left, [0.3686, 0.3686, 0.0]));
}

#[test]
fn metal_and_roughness_come_from_blue_and_green() {
    // A metal mirrors the fill. This one is seen from above, so it mirrors the sky, whether rough or not.
    let material = Material { metallic: 1.0, metallic_roughness_texture: Some(HALVES), ..Material::default() };
    let scene = textured_floor(material, [[0, 255, 255, 255], [0, 0, 0, 255]]);
    let light = spot(DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO);
    let beauty = picture(&scene, &view(DVec3::Y * 2.0, DVec3::ZERO, [9, 9], Aov::Beauty), &[light]);
    // Rough metal next to a perfectly smooth dielectric: off the highlight, the first is GGX of a white metal, the
    // second Lambert.
    let (metal, dielectric) = (beauty.pixels[4 * 9 + 2][0], beauty.pixels[4 * 9 + 6][0]);
    assert!(metal > 0.0 && dielectric > 0.0 && (metal - dielectric).abs() > 0.05 * dielectric);
}

#[test]
fn hidden_surfaces_are_hidden() {
    let scene = scene_of([floor(3.0, 0.0), floor(0.5, 1.0), floor(0.2, -1.0)], vec![Material::default()]);
    let depths = picture(&scene, &view(DVec3::Y * 4.0, DVec3::ZERO, [31, 31], Aov::Depth), &[]);
    // Heights are rounded in f32 relative to the scene's center: a few ulps of 4.
    let is = |pixel: [f32; 4], depth: f32| (pixel[0] - depth).abs() < 8.0 * f32::EPSILON;
    assert!(is(depths.pixels[15 * 31 + 15], 3.0));
    assert!(is(depths.pixels[2 * 31 + 2], 4.0));
    assert!(depths.pixels.iter().all(|p| is(*p, 3.0) || is(*p, 4.0) || *p == [0.0; 4]));
}
