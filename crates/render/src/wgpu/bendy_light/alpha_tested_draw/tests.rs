//! Compares shadows of alpha-tested casters under bent lights with those under spotlights, where samplers do the test.

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
use light::parameters::{CONE_ANGLE, DECAY, RANGE, ROTATION, TRANSLATION};
use light::{Decay, Light};
use scene::{Image, Material, Mesh, Node, Primitive, Sampler, Scene, TextureRef, Wrap};

use crate::wgpu::bendy_light::shadow_buffers::Capacity;
use crate::wgpu::bendy_light::tests::{alone, renderer, view};
use crate::{Aov, Picture, ShadowSettings};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
/// Number of cards along each side of the sheet.
const CARDS: u32 = 6;

/// Returns a 12 x 8 arrow, whose alpha differs under every rotation and reflection.
fn arrow() -> Image {
    let rows = [
        "..........#.",
        ".##########.",
        ".#########..",
        ".####.......",
        ".######.....",
        ".##..###....",
        "##....###...",
        "........####",
    ];
    let alpha = rows.concat().bytes().map(|c| if c == b'#' { 230 } else { 10 }).collect::<Vec<u8>>();
    Image { width: 12, height: 8, rgba8: alpha.into_iter().flat_map(|a| [200, 200, 200, a]).collect() }
}

/// Returns a floor of many triangles under a sheet of cards with 18 materials: every wrap mode, nearest and linear
/// magnification, several cutoffs and factors, and alpha at vertices.
fn scene(wraps: [Wrap; 3]) -> Scene {
    let points = (0..400).map(|k| Vec3::new((k % 20) as f32 - 9.5, 0.0, (k / 20) as f32 - 9.5) * 0.4);
    let quads = (0..19).flat_map(|i| (0..19).map(move |j| 20 * i + j));
    let floor = Primitive {
        positions: points.collect(),
        normals: vec![Vec3::Y; 400],
        indices: quads.flat_map(|k| [k, k + 20, k + 21, k, k + 21, k + 1]).collect(),
        ..Primitive::default()
    };
    let card = |k: u32| {
        let (column, row) = (k % CARDS, k / CARDS);
        let corners = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)];
        let at = |(x, z): (f32, f32)| {
            Vec3::new((column as f32 + x) / CARDS as f32 - 0.5, 0.0, (row as f32 + z) / CARDS as f32 - 0.5) * 2.0
        };
        Primitive {
            positions: corners.map(at).into(),
            normals: vec![Vec3::Y; 4],
            uvs: corners.map(|(x, z)| Vec2::new(3.3 * x - 1.4, 2.9 * z - 0.8)).into(),
            colors: corners.map(|(x, _)| Vec4::new(1.0, 1.0, 1.0, 1.0 - 0.3 * x)).into(),
            indices: vec![0, 1, 2, 0, 2, 3],
            material: 1 + k as usize % 18,
        }
    };
    let material = |k: usize| {
        let (wrap_u, wrap_v) = (wraps[k % 3], wraps[k / 3 % 3]);
        let sampler = Sampler { wrap_u, wrap_v, nearest: k >= 9 };
        let factor = 1.0 - 0.02 * k as f32;
        Material {
            base_color: Vec4::new(1.0, 1.0, 1.0, factor),
            base_color_texture: Some(TextureRef { image: 0, sampler }),
            alpha_cutoff: Some(0.5 * factor),
            ..Material::default()
        }
    };
    let sheet = Mesh { name: String::new(), primitives: (0..CARDS * CARDS).map(card).collect() };
    let node = |mesh, parent_from_local| Node { name: String::new(), parent: None, parent_from_local, mesh };
    let above = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.75),
        DQuat::from_rotation_z(0.3),
        DVec3::new(0.0, 2.6, 0.0),
    );
    let scene = Scene {
        nodes: vec![node(Some(0), DAffine3::IDENTITY), node(Some(1), above)],
        meshes: vec![Mesh { name: String::new(), primitives: vec![floor] }, sheet],
        materials: std::iter::once(Material::default()).chain((0..18).map(material)).collect(),
        images: vec![arrow()],
        ..Scene::default()
    };
    scene.check().expect("sound");
    scene
}

/// Returns the scene without alpha tests.
fn solid() -> Scene {
    let mut scene = scene(WRAPS);
    scene.materials.iter_mut().for_each(|material| material.alpha_cutoff = None);
    scene
}

/// Returns the same light as a spotlight and as a bent light.
fn lights() -> [Light; 2] {
    let spot = Light::spot()
        .with(CONE_ANGLE, 18.0)
        .with(RANGE, Some(7.0))
        .with(DECAY, Decay::None)
        .with(TRANSLATION, DVec3::Y * 6.0)
        .with(ROTATION, DQuat::from_rotation_x(-FRAC_PI_2));
    let bent = light::bend(&spot, 2).expect("sound");
    [spot, bent]
}

fn visibility(scene: &Scene, light: &Light, shadows: ShadowSettings) -> Picture {
    let mut renderer = renderer(scene);
    renderer.set_shadow_settings(ShadowSettings { straighten: false, ..shadows }).expect("sound");
    renderer.render(&view(Aov::Visibility), &alone(light)).expect("drawn")
}

/// Returns the share of the pixels in the light on which two pictures disagree.
fn differing(a: &Picture, b: &Picture) -> f64 {
    let both: Vec<_> = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a[3] == 1.0 && b[3] == 1.0).collect();
    assert!(both.len() > 2000, "{}", both.len());
    both.iter().filter(|(a, b)| (a[0] >= 0.5) != (b[0] >= 0.5)).count() as f64 / both.len() as f64
}

/// Holes span many texels, so few pixels are near an edge.
#[test]
fn holes_are_where_samplers_find_them() {
    let [spot, bent] = lights();
    let fine = ShadowSettings::default();
    let expected = visibility(&scene(WRAPS), &spot, fine);
    let found = differing(&visibility(&scene(WRAPS), &bent, fine), &expected);
    assert!(found < 0.01, "{found}");
    // Deliberate faults that the check must detect: two wrap modes exchanged, and no holes.
    let [repeat, mirror, clamp] = WRAPS;
    let swapped = differing(&visibility(&scene([mirror, repeat, clamp]), &bent, fine), &expected);
    assert!(swapped > 10.0 * found && swapped > 0.05, "{swapped} after {found}");
    let solid = differing(&visibility(&solid(), &bent, fine), &expected);
    assert!(solid > 0.1, "{solid}");
}

/// Simplified casters have other vertices but the same holes.
#[test]
fn simplified_casters_keep_their_holes() {
    let [_, bent] = lights();
    let exact = visibility(&scene(WRAPS), &bent, ShadowSettings::default());
    let mut renderer = renderer(&scene(WRAPS));
    let shadows = ShadowSettings { mesh_error: 0.02, ..ShadowSettings::default() };
    renderer.set_shadow_settings(ShadowSettings { straighten: false, ..shadows }).expect("sound");
    let staged = &renderer.wgpu().scene;
    let (before, after) = (staged.triangle_count, staged.casters.triangle_count);
    assert!(after + 300 < before, "{after} of {before} triangles");
    let found = renderer.render(&view(Aov::Visibility), &alone(&bent)).expect("drawn");
    let found = differing(&found, &exact);
    assert!(found < 0.01, "{found}");
}

/// A map without room for alpha-tested vertices is drawn again. A scene without alpha tests has neither buffers nor a
/// table for them.
#[test]
fn only_holes_take_room() {
    let [_, bent] = lights();
    let expected = visibility(&scene(WRAPS), &bent, ShadowSettings::default());
    let mut cramped = renderer(&scene(WRAPS));
    cramped.wgpu().backend.bent_buffers.capacity =
        Capacity { work: 1, patches: 1, split_vertices: 3, masked_vertices: 3 };
    let found = cramped.render(&view(Aov::Visibility), &alone(&bent)).expect("drawn");
    assert_eq!(found, expected);
    assert!(cramped.wgpu().backend.bent_buffers.capacity.masked_vertices >= 3 * 2 * CARDS * CARDS);

    let mut solid = renderer(&solid());
    solid.render(&view(Aov::Visibility), &alone(&bent)).expect("drawn");
    assert_eq!(solid.wgpu().backend.bent_buffers.capacity.masked_vertices, 0);
    assert!(solid.wgpu().scene.alpha_tests.is_none());
}
