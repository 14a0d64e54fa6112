//! Compares links on the GPU with the reference, which traces every ray: of spotlights and bent lights, with
//! alpha-tested geometry, with two nodes of one mesh, and with nested nodes.

use std::sync::{Arc, LazyLock, Mutex};

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
use light::parameters::{CONE_ANGLE, DECAY, LIGHT_LINK, RANGE, ROTATION, SHADOW_LINK, TRANSLATION};
use light::{Decay, Light, Links};
use reference::Reference;
use render::Renderer;
use scene::{Aov, Image, Material, Mesh, Node, PosedScene, Primitive, Sampler, TextureRef, View};

use crate::pictures::{PictureError, alone, around, draw_with, renderer};

const SIZE: [u32; 2] = [160, 90];

static RENDERER: LazyLock<Mutex<Renderer>> = LazyLock::new(|| Mutex::new(renderer()));

/// The demo's table, and on it a shelf with two vases of the same name and two alpha-tested cards, which share one
/// mesh.
static SHELF: LazyLock<(Arc<PosedScene>, View)> = LazyLock::new(|| {
    let loaded = assets::demo("vases").expect("the demo");
    let mut scene = loaded.scene;
    let [table, blue, orange] = &scene.nodes[..] else { panic!("a table and two vases") };
    let node =
        |name: &str, parent, parent_from_local, mesh| Node { name: name.into(), parent, parent_from_local, mesh };
    let vase = |vase: &Node| node("vase", Some(1), vase.parent_from_local, vase.mesh);
    let card = |at: [f64; 3]| {
        let tilted = DQuat::from_rotation_z(-0.4);
        let placement = DAffine3::from_rotation_translation(tilted, DVec3::from_array(at));
        node("card", Some(1), placement, Some(scene.meshes.len()))
    };
    let (first, second) = (card([-1.2, 1.3, 0.7]), card([0.0, 0.6, 0.5]));
    let shelf = node("shelf", None, DAffine3::IDENTITY, None);
    scene.nodes = vec![table.clone(), shelf, vase(blue), vase(orange), first, second];
    let corners = [(-0.4, -0.4), (-0.4, 0.4), (0.4, 0.4), (0.4, -0.4)];
    let cut_out = Primitive {
        positions: corners.map(|(x, z)| Vec3::new(x, 0.0, z)).into(),
        normals: vec![Vec3::Y; 4],
        uvs: corners.map(|(x, z)| Vec2::new(x, z) / 0.8 + 0.5).into(),
        indices: vec![0, 1, 2, 0, 2, 3],
        material: scene.materials.len(),
        ..Primitive::default()
    };
    scene.meshes.push(Mesh { name: "card".into(), primitives: vec![cut_out] });
    scene.materials.push(Material {
        alpha_cutoff: Some(0.5),
        double_sided: true,
        base_color_texture: Some(TextureRef {
            image: scene.images.len(),
            sampler: Sampler { nearest: true, ..Sampler::default() },
        }),
        ..Material::default()
    });
    let alpha = (0..9).map(|texel: u8| if texel.is_multiple_of(2) { 255 } else { 0 });
    let rgba8 = alpha.flat_map(|alpha| [255, 255, 255, alpha]).collect();
    scene.images.push(Image { width: 3, height: 3, rgba8 });
    scene.check().expect("sound");
    let view = View { fill: 0.0, ..View::beauty(loaded.contents.cameras[0].clone(), SIZE) };
    (scene::pose(scene, 0.0), view)
});

/// The demo's own light, and a spotlight from the same side.
fn keys() -> [Light; 2] {
    let bent = assets::demo("vases").expect("the demo").contents.lights[0].light().clone();
    let (source, target) = (DVec3::new(-2.9, 3.5, 2.2), DVec3::new(0.2, 0.2, -0.1));
    let spot = Light::spot()
        .with(TRANSLATION, source)
        .with(ROTATION, DQuat::from_rotation_arc(DVec3::NEG_Z, (target - source).normalize()))
        .with(CONE_ANGLE, 24.0)
        .with(RANGE, Some(9.0))
        .with(DECAY, Decay::None);
    [bent, spot]
}

fn links(include: &[&str], exclude: &[&str]) -> Option<Links> {
    let list = |paths: &[&str]| paths.iter().map(|path| String::from(*path)).collect();
    Links::new(list(include), list(exclude))
}

/// Radiance by the reference of the pixels away from edges: all adjacent pixels show the same node with the same
/// visibility.
struct ExpectedRadiance(Vec<Option<DVec3>>);

impl ExpectedRadiance {
    fn new(light: &Light) -> Self {
        let (posed, view) = &*SHELF;
        let reference = Reference::new(Arc::clone(posed));
        let render = |aov| {
            let view = View { aov, ..view.clone() };
            reference.render(&view, &alone(light), || {}).expect("it can be drawn").pixels
        };
        let width = SIZE[0] as usize;
        let at = |pixel: usize| DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        let shown: Vec<_> = render(Aov::Visibility)
            .iter()
            .enumerate()
            .map(|(pixel, seen)| {
                let node = reference.surface(view, at(pixel)).map(|surface| surface.node);
                (node, [seen[0], seen[3]].map(f64::to_bits))
            })
            .collect();
        let is_even = |pixel: usize| around(pixel, SIZE, 1).all(|other| shown[other] == shown[pixel]);
        let radiance = |(pixel, [r, g, b, _]): (usize, [f64; 4])| is_even(pixel).then_some(DVec3::new(r, g, b));
        Self(render(Aov::Beauty).into_iter().enumerate().map(radiance).collect())
    }

    /// Error of the GPU's picture under `light`.
    fn error(&self, light: &Light) -> PictureError {
        let (posed, view) = &*SHELF;
        assert!(self.0.iter().flatten().any(|radiance| *radiance != DVec3::ZERO), "something is lit");
        PictureError::new(&draw_with(&RENDERER, posed, view, &alone(light)), self.0.iter().copied())
    }
}

/// Rules: LINK-1, LINK-2
#[test]
fn links_are_what_the_reference_says() {
    let (shelf, vase, card) = ("shelf", "shelf/vase#2", "shelf/card#2");
    let cases = [
        (links(&[], &[vase]), None),
        (None, links(&[], &[card])),
        (None, links(&[], &[vase, card])),
        (None, links(&[card], &[])),
        (links(&["table", shelf], &[vase]), links(&[vase, card], &[shelf])),
    ];
    for key in keys() {
        for (lit, throwing) in &cases {
            let linked = key.clone().with(LIGHT_LINK, lit.clone()).with(SHADOW_LINK, throwing.clone());
            let expected = ExpectedRadiance::new(&linked);
            let PictureError { relative_rmse: error, compared: even } = expected.error(&linked);
            // The planted faults: no links, and those of the other vase and card.
            let other = |links: &Option<Links>| {
                let renamed = |paths: &[String]| paths.iter().map(|path| path.replace("#2", "")).collect();
                Links::new(renamed(links.as_ref()?.include()), renamed(links.as_ref()?.exclude()))
            };
            let unlinked = expected.error(&key).relative_rmse;
            let mistaken = key.clone().with(LIGHT_LINK, other(lit)).with(SHADOW_LINK, other(throwing));
            let mistaken = expected.error(&mistaken).relative_rmse;
            println!(
                "{:?} {lit:?} {throwing:?}: {error:.1e} of {even} pixels; {unlinked:.1e} {mistaken:.1e}",
                key.owner()
            );
            assert!(even > expected.0.len() / 2, "{even}");
            // The bound of pictures without links: normals are packed to 2^-15 (tests/accuracy.rs).
            assert!(error < 1e-3, "{error}");
            assert!(unlinked.min(mistaken) > 1e-2, "{unlinked} {mistaken}");
        }
    }
}
