//! Alpha tests on the GPU against the reference: what passes stays the same with distance, and holes throw their
//! shadows.
//!
//! `BENDYLIGHTS_ACCURACY_SIZE=686x382` compares full pictures, `BENDYLIGHTS_ACCURACY_PICTURES=DIR` keeps the
//! differences as pictures.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

use std::path::Path;
use std::sync::{Arc, LazyLock};

use bench::compare::{Comparison, Drawn, Expected, Subject};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};
use light::parameters::{CONE_ANGLE, DECAY, RANGE, ROTATION, TRANSLATION};
use light::{Decay, Light, LightInstance, Owner};
use reference::Reference;
use render::{Gpu, Renderer, ShadowSettings};
use scene::{
    Aov, Camera, Image, Material, Mesh, Node, Primitive, Projection, Sampler, Scene, TextureRef, View,
};

static GPU: LazyLock<Arc<Gpu>> = LazyLock::new(|| Arc::new(Gpu::new().expect("a graphics driver")));

fn renderer(scene: &Scene) -> Renderer {
    let mut renderer = Renderer::new(Arc::clone(&GPU)).expect("a renderer");
    renderer.set_scene(&scene::pose(scene.clone())).expect("the scene fits");
    renderer
}

fn camera(eye: [f64; 3], target: [f64; 3], yfov: f64) -> Camera {
    let (eye, target) = (DVec3::from_array(eye), DVec3::from_array(target));
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    Camera {
        name: String::new(),
        translation: eye,
        rotation: DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)),
        projection: Projection::Perspective { yfov, aspect_ratio: None, znear: 0.05, zfar: None },
    }
}

/// An even sequence of 0 to 1 that never repeats.
fn spread(k: u32, step: f64) -> f64 {
    (0.5 + f64::from(k) * step).fract()
}

/// Small leaves with soft edges, strewn over a repeating picture.
fn foliage() -> Image {
    const SIDE: u32 = 128;
    let leaf = |k: u32| [spread(k, 0.754_877_666), spread(k, 0.569_840_291), spread(k, 0.618_033_989)];
    let inside = |x: f64, y: f64| {
        let from = |k: u32| {
            let [at_x, at_y, turn] = leaf(k);
            let offset = |a: f64, b: f64| ((a - b).rem_euclid(1.0) + 0.5) % 1.0 - 0.5;
            let (dx, dy) = (offset(x, at_x + 0.5), offset(y, at_y + 0.5));
            let (sin, cos) = (turn * std::f64::consts::TAU).sin_cos();
            let (along, across) = ((dx * cos + dy * sin) / 0.07, (dy * cos - dx * sin) / 0.02);
            (1.0 - along.hypot(across)) * 0.02 * f64::from(SIDE)
        };
        (0..90).map(from).fold(f64::NEG_INFINITY, f64::max)
    };
    let texel = |k: u32| {
        let [x, y] = [k % SIDE, k / SIDE].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE));
        [60, 120, 40, ((0.5 + 0.5 * inside(x, y)).clamp(0.0, 1.0) * 255.0).round() as u8]
    };
    Image { width: SIDE, height: SIDE, rgba8: (0..SIDE * SIDE).flat_map(texel).collect() }
}

/// `image` at a half of its size as often, by averages: what plain mip levels show.
fn averaged(image: &Image, times: u32) -> Image {
    (0..times).fold(image.clone(), |image, _| {
        let (width, height) = (image.width / 2, image.height / 2);
        let byte = |k: u32| {
            let (x, y, channel) = (k / 4 % width, k / 4 / width, k % 4);
            let at = |dx: u32, dy: u32| {
                u32::from(image.rgba8[((4 * (2 * y + dy) * width + 2 * (2 * x + dx)) * 2 + channel) as usize])
            };
            ((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8
        };
        Image { width, height, rgba8: (0..4 * width * height).map(byte).collect() }
    })
}

/// Pixels of a card in the nearest band; half as many in each of the others.
const NEAREST_PIXELS: u32 = 32;
const BANDS: u32 = 6;
const FIELD: [u32; 2] = [8 * NEAREST_PIXELS, BANDS * NEAREST_PIXELS];
const FIELD_YFOV: f64 = 0.4;

/// Bands of cards, each twice as far away as the one below and full of cards of one size. Every card begins
/// elsewhere in the picture, so that pixels meet all of it.
fn field(image: Image, (cutoff, factor): (f32, f32)) -> Scene {
    let focal = f64::from(FIELD[1]) / 2.0 / (FIELD_YFOV / 2.0).tan();
    let mut cards = Primitive::default();
    let mut count = 0;
    for band in 0..BANDS {
        let distance = 3.0 * f64::from(1 << band);
        let world = |pixels: f64| pixels / focal * distance;
        let size = f64::from(NEAREST_PIXELS >> band);
        for k in 0..8 << (2 * band) {
            let (column, row) = (k % (8 << band), k / (8 << band));
            let left = f64::from(column) * size - f64::from(FIELD[0]) / 2.0;
            let low = f64::from(band * NEAREST_PIXELS) + f64::from(row) * size - f64::from(FIELD[1]) / 2.0;
            let start = Vec2::new(spread(count, 0.754_877_666) as f32, spread(count, 0.569_840_291) as f32);
            let first = cards.positions.len() as u32;
            for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                let at = DVec3::new(world(left + x * size), world(low + y * size), -distance);
                cards.positions.push(at.as_vec3());
                cards.normals.push(Vec3::Z);
                cards.uvs.push(start + Vec2::new(x as f32, -y as f32));
            }
            cards.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
            count += 1;
        }
    }
    let material = Material {
        base_color: Vec4::new(1.0, 1.0, 1.0, factor),
        base_color_texture: Some(TextureRef { image: 0, sampler: Sampler::default() }),
        alpha_cutoff: Some(cutoff),
        ..Material::default()
    };
    Scene {
        nodes: vec![Node {
            name: String::new(),
            parent: None,
            parent_from_local: DAffine3::IDENTITY,
            mesh: Some(0),
        }],
        meshes: vec![Mesh { name: String::new(), primitives: vec![cards] }],
        materials: vec![material],
        images: vec![image],
        ..Scene::default()
    }
}

/// The share of each band, the nearest first, in which `seen` says a pixel shows a card: 0 to 1.
fn coverage(seen: impl Fn(u32, u32) -> f64) -> Vec<f64> {
    let band = |band: u32| {
        let rows = (BANDS - 1 - band) * NEAREST_PIXELS..(BANDS - band) * NEAREST_PIXELS;
        let pixels = rows.flat_map(|y| (0..FIELD[0]).map(move |x| (x, y)));
        pixels.map(|(x, y)| seen(x, y)).sum::<f64>() / f64::from(FIELD[0] * NEAREST_PIXELS)
    };
    (0..BANDS).map(band).collect()
}

fn field_view() -> View {
    let camera = camera([0.0; 3], [0.0, 0.0, -1.0], FIELD_YFOV);
    View { aov: Aov::Depth, ..View::beauty(camera, FIELD) }
}

fn drawn_coverage(scene: &Scene) -> Vec<f64> {
    let depth = renderer(scene).render(&field_view(), &[]).expect("it can be drawn");
    coverage(|x, y| f64::from(depth.pixels[(y * FIELD[0] + x) as usize][3]))
}

/// As much is seen of foliage far away as the reference sees with 16 samples a pixel, within a tenth: that much a
/// level may be off (`crates/render/src/coverage.rs`).
#[test]
fn foliage_keeps_its_coverage() {
    for test in [(0.5, 1.0), (0.3, 0.6), (0.7, 0.9)] {
        let scene = field(foliage(), test);
        let reference = Reference::new(scene::pose(scene.clone()));
        let view = field_view();
        let expected = coverage(|x, y| {
            let hit = |k: u32| {
                let place = [k % 4, k / 4].map(|at| (f64::from(at) + 0.5) / 4.0);
                let at = glam::DVec2::new(f64::from(x) + place[0], f64::from(y) + place[1]);
                reference.surface(&view, at).is_some()
            };
            (0..16).filter(|k| hit(*k)).count() as f64 / 16.0
        });
        let off = |found: &[f64]| -> Vec<f64> {
            found.iter().zip(&expected).map(|(found, expected)| found / expected - 1.0).collect()
        };
        let found = off(&drawn_coverage(&scene));
        println!("cut-off {test:?}: expected {expected:.3?}, off by {found:.3?}");
        assert!(found.iter().all(|off| off.abs() <= 0.1), "{found:.3?}");
        // The planted fault: a picture of plain averages, as levels were before.
        let plain = off(&drawn_coverage(&field(averaged(&foliage(), 4), test)));
        println!("plain averages: off by {plain:.3?}");
        assert!(plain.iter().all(|off| off.abs() > 0.2), "{plain:.3?}");
    }
}

/// Pixels: small enough for every build, or as the environment says.
fn size() -> [u32; 2] {
    let Ok(size) = std::env::var("BENDYLIGHTS_ACCURACY_SIZE") else { return [240, 134] };
    let (width, height) = size.split_once('x').expect("the size is written WIDTHxHEIGHT");
    [width, height].map(|side| side.parse().expect("a side is a number of pixels"))
}

/// The demo with cut-outs of four materials, each wrapped in its own way, two with alpha at their vertices.
fn arbor() -> Scene {
    assets::demo("arbor").expect("the demo").scene
}

fn key() -> Light {
    let light = assets::demo("arbor").expect("the demo").contents.lights[0].light().clone();
    assert_eq!(light.owner(), Owner::Bendy, "the key is a BendyLight");
    light
}

/// The light alone, as a renderer takes it.
fn alone(light: &Light) -> Vec<LightInstance> {
    LightInstance::numbered([light.clone()]).expect("a light")
}

/// A spotlight where the camera is, straight ahead.
fn spot_at(camera: &Camera) -> Light {
    Light::spot().with(TRANSLATION, camera.translation).with(ROTATION, camera.rotation)
}

/// A spotlight through the arbor, and the BendyLight that is the same light.
fn spot() -> (Light, Light) {
    let spot = spot_at(&camera([-2.6, 3.0, 2.2], [0.0, 0.35, -0.5], 1.0))
        .with(CONE_ANGLE, 14.0)
        .with(RANGE, Some(6.5))
        .with(DECAY, Decay::None);
    let bent = light::bend(&spot, 3).expect("it has a range");
    (spot, bent)
}

/// The shadows on the terrace, from above; and the leaves and the lantern as near as their pictures are large.
/// Each with the largest error of radiance.
///
/// The terrace has no picture. Those of the leaves are 8 bits of sRGB, level by level: at their 0.4 half a step is
/// 1.2 % of the light.
fn cameras() -> [(&'static str, Camera, f64); 3] {
    [
        ("shadows", camera([0.85, 3.2, 1.0], [0.85, 0.0, -0.15], 0.3), 1e-3),
        ("leaves", camera([-0.45, 1.1, 0.9], [-0.55, 0.95, -0.1], 0.2), 1.2e-2),
        ("lantern", camera([0.9, 0.9, 0.8], [0.85, 0.2, -0.35], 0.3), 1.2e-2),
    ]
}

fn subject(name: &str, scene: Scene, light: Light, camera: Camera) -> Subject {
    Subject::new(name, scene, light, View::beauty(camera, size()))
}

/// Compares what `scene` looks like under `drawn` with what `subject` should.
fn compared(subject: &Subject, scene: &Scene, drawn: &Light, shadows: ShadowSettings) -> Comparison {
    let drawn = Drawn::under(&mut renderer(scene), subject, &alone(drawn), shadows).expect("it can be drawn");
    let expected = Expected::new(subject, || {}).expect("the light is valid");
    let comparison = expected.compare(&drawn);
    if let Ok(folder) = std::env::var("BENDYLIGHTS_ACCURACY_PICTURES") {
        let file = Path::new(&folder).join(format!("{}.png", subject.name));
        expected.panels(&drawn, &comparison).save(file).expect("the picture can be written");
    }
    comparison
}

fn told(subject: &Subject, found: &Comparison) -> String {
    format!("{}: {}", subject.name, serde_json::to_string(found).expect("plain data"))
}

/// Under a bent light and under a spotlight, no pixel away from an edge is wrong.
#[test]
fn holes_throw_their_shadows() {
    let (spot, bent_spot) = spot();
    let lights = [("bent", key(), key()), ("spot", bent_spot, spot)];
    for (light, model, drawn) in lights {
        for (name, camera, radiance_error) in cameras() {
            let subject = subject(&format!("{light}-{name}"), arbor(), model.clone(), camera);
            let found = compared(&subject, &subject.scene, &drawn, ShadowSettings::default());
            let told = told(&subject, &found);
            println!("{told}");
            assert!(found.in_light > found.pixels / 4 && found.boundary > found.pixels / 200, "{told}");
            // Where leaves cross, a caster nearer than a texel is taken for the receiver.
            assert!(found.missed <= found.pixels / 10_000, "{told}");
            assert_eq!((found.false_shadow, found.not_finite), (0, 0), "{told}");
            // Where light grazes nothing is wrong. Shadows of holes may be narrower than the step between pixels.
            assert!(found.off_edge <= found.pixels / 5_000, "{told}");
            assert!(found.radiance_rmse <= radiance_error, "{told}");
        }
    }
}

/// What was drawn before: casters as if they had no holes.
#[test]
fn solid_shadows_are_seen() {
    let mut solid = arbor();
    solid.materials.iter_mut().for_each(|material| material.alpha_cutoff = None);
    let [(_, camera, _), ..] = cameras();
    let subject = subject("solid", arbor(), key(), camera);
    let found = compared(&subject, &solid, &key(), ShadowSettings::default());
    assert!(found.false_shadow > found.pixels / 20, "{}", told(&subject, &found));
}

/// Two triangles that face up, `side` wide and at a height, over which the picture repeats.
fn square(side: f32, height: f32, repeats: f32, material: usize) -> Primitive {
    let corners = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
    Primitive {
        positions: corners.map(|(x, z)| Vec3::new(side * (x - 0.5), height, side * (z - 0.5))).into(),
        normals: vec![Vec3::Y; 4],
        uvs: corners.map(|(x, z)| Vec2::new(x, z) * repeats).into(),
        indices: vec![0, 1, 2, 0, 2, 3],
        material,
        ..Primitive::default()
    }
}

/// The share of the light that falls through a sheet of `image` onto a floor, by maps of `resolution` texels.
fn share_of_light(image: Image, light: &Light, resolution: u32) -> f64 {
    let mut scene = field(image, (0.5, 1.0));
    scene.materials.push(Material::default());
    // Five or six texels of the picture lie in one of the map's 128.
    scene.meshes[0].primitives = vec![square(3.0, 2.0, 6.7, 0), square(20.0, 0.0, 1.0, 1)];
    let mut renderer = renderer(&scene);
    let shadows = ShadowSettings { resolution, straighten: false, ..ShadowSettings::default() };
    renderer.set_shadow_settings(shadows).expect("they are sound");
    // From below the sheet, onto what the light meets of the floor.
    let view = View {
        aov: Aov::Visibility,
        ..View::beauty(camera([0.0, 1.9, 0.1], [0.0, 0.0, 0.0], 0.9), [200, 200])
    };
    let picture = renderer.render(&view, &alone(light)).expect("it can be drawn");
    let inside: Vec<_> = picture.pixels.iter().filter(|pixel| pixel[3] == 1.0).collect();
    assert!(inside.len() > 20_000, "{}", inside.len());
    inside.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / inside.len() as f64
}

/// A map with few texels lets as much light through leaves as one with many.
#[test]
fn coarse_maps_keep_coverage() {
    let spot = spot_at(&camera([0.0, 4.5, 0.2], [0.0, 0.0, 0.0], 1.0))
        .with(CONE_ANGLE, 18.0)
        .with(RANGE, Some(5.0))
        .with(DECAY, Decay::None);
    let bent = light::bend(&spot, 2).expect("it has a range");
    for light in [spot, bent] {
        let fine = share_of_light(foliage(), &light, 4096);
        let coarse = share_of_light(foliage(), &light, 128);
        // The planted fault: plain averages, at the size that those texels of the map see.
        let plain = share_of_light(averaged(&foliage(), 3), &light, 128);
        println!("{fine:.3} of the light; {coarse:.3} by a coarse map, {plain:.3} by plain averages");
        assert!((0.5..0.8).contains(&fine), "{fine}");
        assert!((coarse / fine - 1.0).abs() <= 0.05, "{coarse} for {fine}");
        assert!((plain / fine - 1.0).abs() > 0.15, "{plain} for {fine}");
    }
}
