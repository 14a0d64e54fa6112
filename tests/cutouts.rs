//! Compares alpha tests on the GPU with the reference: coverage of foliage at all distances, and shadows of
//! alpha-tested geometry.
//!
//! `BENDYLIGHTS_ACCURACY_SIZE=686x382` compares full pictures, `BENDYLIGHTS_ACCURACY_PICTURES=DIR` saves the
//! differences as pictures.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

use std::collections::BTreeSet;
use std::sync::LazyLock;

use bench::compare::{Comparison, ComparisonSubject, ExpectedPicture, RenderedSubject};
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3, Vec4};
use light::parameters::{CONE_ANGLE, DECAY, RANGE, ROTATION, TRANSLATION};
use light::{Decay, Light, ParameterOwner};
use rayon::prelude::*;
use reference::Reference;
use render::{Renderer, ShadowSettings};
use scene::{Aov, Camera, Image, Material, Primitive, Sampler, Scene, TextureRef, View, ViewRay};

use crate::boxes::{add_mesh, camera};
use crate::pictures::{alone, compared_size, expected, save_panels, shared_asset};

fn renderer(scene: &Scene) -> Renderer {
    let mut renderer = crate::pictures::renderer();
    renderer.set_scene(&scene::pose(scene.clone(), 0.0)).expect("the scene fits");
    renderer
}

/// Element `k` of an even sequence in 0 to 1 without repetition.
fn spread(k: u32, step: f64) -> f64 {
    (0.5 + f64::from(k) * step).fract()
}

/// Texels per side of the picture of leaves.
const SIDE: u32 = 128;

/// Small leaves with soft edges, scattered over a repeating picture.
fn foliage() -> Image {
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

/// Halves the size of `image` `times` times by averages, as mip levels do.
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

/// Picture and material of cards.
struct Leaves {
    image: Image,
    /// Used texels per side, from the corner of the picture; `None` if cards begin anywhere and the picture repeats.
    used_texels: Option<f64>,
    cutoff: f32,
    /// Alpha of the material.
    factor: f32,
    /// Minimum alpha of vertices.
    vertices: f64,
}

impl Leaves {
    /// Cards that show any part of a repeating picture.
    fn strewn() -> Self {
        Self { image: foliage(), used_texels: None, cutoff: 0.5, factor: 1.0, vertices: 1.0 }
    }

    /// Cards that show a quarter of a picture whose rest is solid, with alpha factors of the material and of vertices.
    fn of_atlas() -> Self {
        let (leaves, used) = (foliage(), 2 * SIDE);
        let texel = |k: u32| {
            let (x, y) = (k % (2 * used), k / (2 * used));
            if x.max(y) >= used {
                return [60, 120, 40, 255];
            }
            let at = 4 * (y % SIDE * SIDE + x % SIDE) as usize;
            [0, 1, 2, 3].map(|channel| leaves.rgba8[at + channel])
        };
        let rgba8 = (0..4 * used * used).flat_map(texel).collect();
        let image = Image { width: 2 * used, height: 2 * used, rgba8 };
        Self { image, used_texels: Some(f64::from(used)), cutoff: 0.3, factor: 0.6, vertices: 0.8 }
    }

    fn material(&self) -> Material {
        Material {
            base_color: Vec4::new(1.0, 1.0, 1.0, self.factor),
            base_color_texture: Some(TextureRef { image: 0, sampler: Sampler::default() }),
            alpha_cutoff: Some(self.cutoff),
            ..Material::default()
        }
    }
}

/// Sides of the compared pictures, in pixels. The noise of the covered area with one sample per pixel is
/// `sqrt((1 - p) / (p n))` = 0.8 %, and less if adjacent pixels see the same leaf.
const PICTURE: u32 = 160;
const YFOV: f64 = 0.02;
const DISTANCE: f64 = 10.0;
/// Side of a card in pixels if seen face on, unless less of the picture is used.
const CARD: f64 = 32.0;

/// A wall of cards that leans back by `slant` degrees and fills the picture. A pixel covers `texels` texels across, and
/// more along the slant.
fn wall(leaves: &Leaves, texels: f64, slant: f64) -> Scene {
    let pixel = 2.0 * DISTANCE * (0.5 * YFOV).tan() / f64::from(PICTURE);
    let shown = leaves.used_texels.unwrap_or(f64::INFINITY).min(CARD * texels);
    let (side, up) = (shown / texels * pixel, DVec3::new(0.0, slant.to_radians().cos(), -slant.to_radians().sin()));
    // Larger than the picture, which is rotated, and larger again because distant parts fill less of it.
    let half = 0.75 * f64::from(PICTURE) * pixel;
    let (columns, rows) = ((half / side).ceil() as i32, (half / up.y / side).ceil() as i32);
    let texture = f64::from(leaves.image.width);
    let mut cards = Primitive::default();
    for (count, (row, column)) in
        (0_u32..).zip((-rows..rows).flat_map(|row| (-columns..columns).map(move |column| (row, column))))
    {
        let free = leaves.used_texels.map_or(texture, |used| used - shown);
        let start = [0.754_877_666, 0.569_840_291].map(|step| spread(count, step) * free);
        let alpha = 1.0 - (1.0 - leaves.vertices) * spread(count, 0.618_033_989);
        let first = cards.positions.len() as u32;
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let across = DVec3::X * (f64::from(column) + x) * side;
            let at = DVec3::new(0.0, 0.0, -DISTANCE) + across + up * (f64::from(row) + y) * side;
            let uv = [start[0] + x * shown, start[1] + (1.0 - y) * shown].map(|texel| (texel / texture) as f32);
            cards.positions.push(at.as_vec3());
            cards.normals.push(Vec3::Z);
            cards.uvs.push(Vec2::from(uv));
            cards.colors.push(Vec4::new(1.0, 1.0, 1.0, alpha as f32));
        }
        cards.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    scene_of(leaves, vec![cards])
}

fn scene_of(leaves: &Leaves, primitives: Vec<Primitive>) -> Scene {
    let (materials, images) = (vec![leaves.material()], vec![leaves.image.clone()]);
    let mut scene = Scene { materials, images, ..Scene::default() };
    add_mesh(&mut scene, DAffine3::IDENTITY, primitives);
    scene
}

/// Share of each pixel that a scene covers, in views of equal size, one below the other.
struct Coverage {
    width: usize,
    pixels: Vec<f64>,
}

impl Coverage {
    /// Coverage in the GPU's pictures, with one sample per pixel.
    fn drawn(scene: &Scene, views: &[View]) -> Self {
        let mut renderer = renderer(scene);
        let mut drawn = |view: &View| {
            let depth = renderer.render(&View { aov: Aov::Depth, ..view.clone() }, &[]);
            depth.expect("it can be drawn").pixels.into_iter().map(|pixel| f64::from(pixel[3]))
        };
        let pixels = views.iter().flat_map(|view| drawn(view).collect::<Vec<_>>()).collect();
        Self { width: views[0].width as usize, pixels }
    }

    /// Coverage of the scene with alpha at full resolution, with `grid` times `grid` samples per pixel.
    fn cast(reference: &Reference, views: &[View], grid: u32) -> Self {
        let seen = |view: &View, pixel: u32, k: u32| {
            let position = |pixel: u32, k: u32| f64::from(pixel) + (f64::from(k) + 0.5) / f64::from(grid);
            let at = DVec2::new(position(pixel % view.width, k % grid), position(pixel / view.width, k / grid));
            let origin = reference.bvh.posed.origin_in_world;
            reference.bvh.visible_point(&ViewRay::new(&view.camera, [view.width, view.height], at, origin)).is_some()
        };
        let share = |(view, pixel): &(&View, u32)| {
            let count = (0..grid * grid).filter(|k| seen(view, *pixel, *k)).count();
            count as f64 / f64::from(grid * grid)
        };
        let pixels: Vec<_> =
            views.iter().flat_map(|view| (0..view.width * view.height).map(move |pixel| (view, pixel))).collect();
        Self { width: views[0].width as usize, pixels: pixels.par_iter().map(share).collect() }
    }

    /// Share of the whole picture that is covered.
    fn area(&self) -> f64 {
        self.pixels.iter().sum::<f64>() / self.pixels.len() as f64
    }

    /// Root mean square of the differences in blocks of 8x8 pixels.
    fn noise(&self, truth: &Self) -> f64 {
        let blocks = |coverage: &Self| {
            let across = coverage.width / 8;
            let mut sums = vec![0.0; across * (coverage.pixels.len() / coverage.width / 8)];
            for (k, share) in coverage.pixels.iter().enumerate() {
                if let (x, y) = (k % coverage.width / 8, k / coverage.width / 8)
                    && x < across
                    && let Some(sum) = sums.get_mut(y * across + x)
                {
                    *sum += share / 64.0;
                }
            }
            sums
        };
        let (own, others) = (blocks(self), blocks(truth));
        let squares: f64 = own.iter().zip(&others).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / own.len() as f64).sqrt()
    }

    /// Share of pixels in which two pictures differ.
    fn differences(&self, other: &Self) -> f64 {
        let different = self.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b);
        different.count() as f64 / self.pixels.len() as f64
    }
}

/// Coverage by the reference, with 16 samples per pixel and with one. The noise of the 16 is a quarter of that of the one,
/// which adds a thirty-second to the quotient of two noises at most, and 0.2 % to an area.
fn truth(scene: &Scene, views: &[View]) -> (Coverage, Coverage) {
    let reference = Reference::new(scene::pose(scene.clone(), 0.0));
    (Coverage::cast(&reference, views, 4), Coverage::cast(&reference, views, 1))
}

/// Tests `drawn` against the true coverage, with the tolerance of one sample per pixel. Returns the fault, if any.
///
/// Areas are within 2 %, and blocks of 8x8 pixels at most 1.2 times as noisy as in the reference's picture.
fn fault(drawn: &Coverage, (truth, one): &(Coverage, Coverage)) -> Option<&'static str> {
    let area = drawn.area() / truth.area() - 1.0;
    let noise = drawn.noise(truth) / one.noise(truth);
    let different = drawn.differences(one);
    println!(
        "  {:.4} of the picture: off by {:+.2} % (one sample: {:+.2} %), {noise:.2} times the noise, \
         {:.2} % of pixels are others",
        truth.area(),
        100.0 * area,
        100.0 * (one.area() / truth.area() - 1.0),
        100.0 * different,
    );
    let faults = [(area.abs() > 0.02, "area"), (noise > 1.2, "noise")];
    faults.into_iter().find_map(|(wrong, what)| wrong.then_some(what))
}

/// The camera is rotated about its axis: rows of pixels along rows of cards would see the same texels again and again.
fn wall_view() -> [View; 1] {
    let camera = camera([0.0; 3], [0.0, 0.0, -1.0], YFOV);
    [View::beauty(Camera { rotation: DQuat::from_rotation_z(0.3), ..camera }, [PICTURE; 2])]
}

/// Foliage has the right coverage, and is no noisier than one sample per pixel implies: at all distances and slants,
/// for all parts of a picture that cards show, and for all alpha of vertices and materials.
#[test]
fn foliage_covers_what_it_should() {
    let views = wall_view();
    let (mut found, mut unseen) = (Vec::new(), Vec::new());
    for (name, leaves) in [("strewn", Leaves::strewn()), ("of an atlas", Leaves::of_atlas())] {
        for (texels, slant) in
            [1.0, 4.0, 16.0, 64.0].into_iter().flat_map(|texels| [0.0, 60.0, 80.0].map(|slant| (texels, slant)))
        {
            println!("{name}, {texels} texels a pixel, {slant} degrees:");
            let scene = wall(&leaves, texels, slant);
            let truth = truth(&scene, &views);
            found.push(fault(&Coverage::drawn(&scene, &views), &truth));
            // The planted faults: mip levels chosen by the shorter and by the longer extent of a pixel. Averages of two
            // texels are still leaves.
            let longer = texels / f64::cos(slant.to_radians());
            let levels = BTreeSet::from([texels, longer].map(|texels| (texels.log2() as u32).min(SIDE.ilog2())));
            for level in levels.into_iter().filter(|level| *level >= 2) {
                let images = vec![averaged(&leaves.image, level)];
                let averaged = Coverage::drawn(&Scene { images, ..scene.clone() }, &views);
                if fault(&averaged, &truth).is_none() {
                    unseen.push((name, texels, slant, level));
                }
            }
        }
    }
    assert!(found.iter().all(Option::is_none), "{found:?}");
    assert!(unseen.is_empty(), "faults go unseen: {unseen:?}");
}

/// The flowers of a vase, cards by another author: from the front and at slants, as large as a picture and small.
#[test]
#[ignore = "needs ../shared/assets"]
fn flowers_of_shared_assets_cover_what_they_should() {
    let file = shared_asset("gltf/khronos/GlassVaseFlowers.glb");
    let mut scene = assets::load(&file).expect("the scene is sound").scene;
    let Scene { meshes, materials, .. } = &mut scene;
    for mesh in meshes {
        mesh.primitives.retain(|primitive| materials[primitive.material].alpha_cutoff.is_some());
    }
    let posed = scene::pose(scene.clone(), 0.0);
    let (middle, reach) = (posed.origin_in_world, posed.half_extent.length());
    let averaged = Scene { images: scene.images.iter().map(|image| averaged(image, 6)).collect(), ..scene.clone() };
    // The total number of pixels is equal, and the flowers have a tenth of them.
    for (side, turns) in [(320, 1), (80, 16), (24, 178)] {
        for degrees in [0.0_f64, 60.0, 80.0] {
            let away = DVec3::new(degrees.to_radians().sin(), 0.2, degrees.to_radians().cos()).normalize();
            let eye = middle + 20.0 * reach * away;
            let camera = camera(eye, middle, 0.1);
            let turned = |turn: u32| {
                let rotation = camera.rotation * DQuat::from_rotation_z(0.3 + f64::from(turn));
                View::beauty(Camera { rotation, ..camera.clone() }, [side; 2])
            };
            let views: Vec<_> = (0..turns).map(turned).collect();
            println!("{side} pixels, {degrees} degrees:");
            let truth = truth(&scene, &views);
            assert_eq!(fault(&Coverage::drawn(&scene, &views), &truth), None);
            assert!(fault(&Coverage::drawn(&averaged, &views), &truth).is_some());
        }
    }
}

/// The demo with alpha-tested geometry of four materials, each with different wrapping, two with alpha at their
/// vertices.
fn arbor() -> Scene {
    assets::demo("arbor").expect("the demo").scene
}

fn key() -> Light {
    let light = assets::demo("arbor").expect("the demo").contents.lights[0].light().clone();
    assert_eq!(light.owner(), ParameterOwner::Bendy, "the key is a BendyLight");
    light
}

/// A spotlight at the camera, in its direction.
fn spot_at(camera: &Camera) -> Light {
    Light::spot().with(TRANSLATION, camera.translation).with(ROTATION, camera.rotation)
}

/// A spotlight through the arbor, and the BendyLight that equals it.
fn spot() -> (Light, Light) {
    let spot = spot_at(&camera([-2.6, 3.0, 2.2], [0.0, 0.35, -0.5], 1.0))
        .with(CONE_ANGLE, 14.0)
        .with(RANGE, Some(6.5))
        .with(DECAY, Decay::None);
    let bent = light::bend(&spot, 3).expect("it has a range");
    (spot, bent)
}

/// Cameras at the shadows on the terrace, from above, and at the leaves and the lantern, so near that a texel is about
/// a pixel. Each has its maximum error of radiance.
///
/// The terrace has no texture. The leaves' texture has 8 bits of sRGB: at their 0.4 half a step is 1.2 % of the light.
fn cameras() -> [(&'static str, Camera, f64); 3] {
    [
        ("shadows", camera([0.85, 3.2, 1.0], [0.85, 0.0, -0.15], 0.3), 1e-3),
        ("leaves", camera([-0.45, 1.1, 0.9], [-0.55, 0.95, -0.1], 0.2), 1.2e-2),
        ("lantern", camera([0.9, 0.9, 0.8], [0.85, 0.2, -0.35], 0.3), 1.2e-2),
    ]
}

fn subject(name: &str, scene: Scene, light: Light, camera: Camera) -> ComparisonSubject {
    // Small enough for every build.
    ComparisonSubject::new(name, scene, light, View::beauty(camera, compared_size([240, 134])))
}

/// The reference's pictures of the arbor under its key light, which two tests compare with.
static UNDER_KEY: [LazyLock<ExpectedPicture>; 3] =
    [LazyLock::new(|| under_key(0)), LazyLock::new(|| under_key(1)), LazyLock::new(|| under_key(2))];

fn under_key(camera: usize) -> ExpectedPicture<'static> {
    let (name, camera, _) = cameras()[camera].clone();
    expected(subject(&format!("bent-{name}"), arbor(), key(), camera))
}

/// Compares the picture of `scene` under `drawn` with the reference.
fn compared(expected: &ExpectedPicture, scene: &Scene, drawn: &Light) -> Comparison {
    let subject = expected.subject();
    let drawn = RenderedSubject::under(&mut renderer(scene), subject, &alone(drawn), ShadowSettings::default());
    let drawn = drawn.expect("it can be drawn");
    let comparison = expected.compare(&drawn);
    save_panels(&subject.name, expected, &drawn, &comparison);
    comparison
}

/// Under a bent light and under a spotlight, no pixel away from an edge is wrong.
#[test]
fn holes_throw_their_shadows() {
    let (spot, bent_spot) = spot();
    let under_spot = cameras()
        .map(|(name, camera, _)| expected(subject(&format!("spot-{name}"), arbor(), bent_spot.clone(), camera)));
    let under_key = UNDER_KEY.each_ref().map(|picture| &**picture);
    for (pictures, drawn) in [(under_key, key()), (under_spot.each_ref(), spot)] {
        for (expected, (_, _, radiance_error)) in pictures.into_iter().zip(cameras()) {
            let subject = expected.subject();
            let found = compared(expected, &subject.scene, &drawn);
            let text = format!("{}: {}", subject.name, serde_json::to_string(&found).expect("plain data"));
            println!("{text}");
            assert!(found.in_light > found.pixels / 4 && found.boundary > found.pixels / 200, "{text}");
            // Both see the same holes, to the pixel.
            assert!(found.silhouettes <= found.pixels / 10_000, "{text}");
            // If leaves cross, a caster nearer than a texel is taken for the receiver.
            assert!(found.missed <= found.pixels / 10_000, "{text}");
            assert_eq!((found.false_shadow, found.not_finite), (0, 0), "{text}");
            // Nothing is wrong at grazing light. Shadows of holes may be narrower than the step between pixels.
            assert!(found.off_edge <= found.pixels / 5_000, "{text}");
            // A pixel whose shadow is missed is wrong by all of its light.
            let missed = (found.missed as f64 / found.in_light as f64).sqrt();
            assert!(found.radiance_rmse <= radiance_error.hypot(missed), "{text}");
        }
    }
}

/// The planted fault: surfaces and casters without alpha tests.
#[test]
fn solid_shadows_are_seen() {
    let mut solid = arbor();
    solid.materials.iter_mut().for_each(|material| material.alpha_cutoff = None);
    let [shadows, leaves, _] = &UNDER_KEY;
    let [shadows, leaves] = [shadows, leaves].map(|expected| compared(expected, &solid, &key()));
    assert!(shadows.false_shadow > shadows.pixels / 20, "{shadows:?}");
    assert!(leaves.silhouettes > leaves.pixels / 20, "{leaves:?}");
}

/// Two triangles that face up at a height, `side` wide, over which the picture repeats.
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

/// Share of the light that passes a sheet of `image` onto a floor, with maps of `resolution` texels.
fn share_of_light(image: Image, light: &Light, resolution: u32) -> f64 {
    // One of the map's 128 texels covers five or six texels of the picture.
    let primitives = vec![square(3.0, 2.0, 6.7, 0), square(20.0, 0.0, 1.0, 1)];
    let mut scene = scene_of(&Leaves { image, ..Leaves::strewn() }, primitives);
    scene.materials.push(Material::default());
    let mut renderer = renderer(&scene);
    let shadows = ShadowSettings { resolution, straighten: false, ..ShadowSettings::default() };
    renderer.set_shadow_settings(shadows).expect("they are sound");
    // View from below the sheet of the lit part of the floor.
    let view = View { aov: Aov::Visibility, ..View::beauty(camera([0.0, 1.9, 0.1], [0.0, 0.0, 0.0], 0.9), [200, 200]) };
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
        println!("{fine:.4} of the light; {coarse:.4} by a coarse map, {plain:.4} by plain averages");
        assert!((0.5..0.8).contains(&fine), "{fine}");
        // Some 8000 texels of the coarse map have one visibility each: `sqrt((1 - p) / (p n))` = 0.9 %.
        assert!((coarse / fine - 1.0).abs() <= 0.02, "{coarse} for {fine}");
        assert!((plain / fine - 1.0).abs() > 0.15, "{plain} for {fine}");
    }
}
