//! Pictures drawn in tiles equal those drawn at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use glam::{DAffine3, DQuat, DVec3, Vec4};
use light::LightInstance;
use light::parameters::{COLOR, RANGE, TRANSLATION};
use render::{
    Aov, Backend, Device, FileNeeds, Host, Picture, Pixels, RenderError, Renderer, SampleProgress, TiledPicture, View,
    ViewSlot, YieldPolicy,
};
use scene::{Image, Material, Primitive, Sampler, Scene, TextureRef};

use crate::support::{BACKENDS, ball, instances, oblique, renderer_of, renderer_on, scene_of, spot, square};

/// Returns a textured floor, a smooth ball of few triangles and a double-sided sheet on edge.
fn things() -> Scene {
    let textured = Material {
        base_color_texture: Some(TextureRef { image: 0, sampler: Sampler::default() }),
        ..Material::default()
    };
    let smooth = Material { double_sided: true, roughness: 0.3, ..Material::default() };
    let sheet = Material { double_sided: true, ..textured.clone() };
    let mut tiled = square();
    tiled.uvs = tiled.positions.iter().map(|p| glam::Vec2::new(p.x, p.z) * 7.0).collect();
    let mut upright = Primitive { material: 2, ..square() };
    upright.uvs = upright.positions.iter().map(|p| glam::Vec2::new(p.x, p.z) * 30.0).collect();
    let ball = Primitive { material: 1, ..colored_ball() };
    let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_z(1.5), DVec3::new(-0.8, 0.5, 0.0));
    let mut scene = scene_of(
        [
            (tiled, DAffine3::from_scale(DVec3::splat(3.0))),
            (ball, DAffine3::from_translation(DVec3::new(0.6, 0.8, 0.3))),
            (upright, turned),
        ],
        vec![textured, smooth, sheet],
    );
    let texel = |k: u32| if (k + k / 16).is_multiple_of(2) { [250, 200, 90, 255] } else { [20, 60, 160, 60] };
    let rgba8 = (0..256).flat_map(texel).collect();
    scene.images = vec![Image { width: 16, height: 16, rgba8 }];
    scene.fill.sky = DVec3::new(0.1, 0.2, 0.3);
    scene
}

/// Returns the same with holes in the sheet.
fn things_with_holes() -> Scene {
    let mut scene = things();
    scene.materials[2].alpha_cutoff = Some(0.5);
    scene
}

/// Returns a ball of radius 0.5, with its own normals and the colors of their axes.
fn colored_ball() -> Primitive {
    let ball = ball(12);
    Primitive {
        positions: ball.normals.iter().map(|normal| *normal * 0.5).collect(),
        colors: ball.normals.iter().map(|normal| (0.5 + 0.5 * *normal).extend(1.0)).collect(),
        ..ball
    }
}

fn lights() -> Vec<LightInstance> {
    let key = spot(DVec3::new(1.0, 3.0, 0.5), DVec3::ZERO);
    let low = spot(DVec3::new(-2.0, 1.0, 2.0), DVec3::ZERO).with(COLOR, DVec3::new(1.0, 0.3, 0.2));
    let bent = light::bend(&low.clone().with(RANGE, Some(6.0)), 3).unwrap();
    instances(&[key, low, bent])
}

fn camera(size: [u32; 2], aov: Aov, samples: u32) -> View {
    View { samples, ..oblique(size, aov) }
}

/// Draws in tiles of the smallest size, with other pictures in between.
fn tiled(
    renderer: &mut Renderer,
    mut picture: TiledPicture,
    between: &View,
    lights: &[LightInstance],
) -> (Pixels, usize) {
    let mut turns = 1;
    let mut progress = picture.progress();
    assert_eq!(progress.done, 0);
    while !renderer.advance_tiled(&mut picture, Duration::ZERO).unwrap() {
        turns += 1;
        assert!(picture.progress().done >= progress.done && picture.progress().total == progress.total);
        progress = picture.progress();
        if turns % 5 == 0 {
            renderer.render(between, &lights[1..2]).unwrap();
        }
    }
    assert_eq!(picture.progress().done, progress.total);
    (picture.into_pixels(), turns)
}

fn differences(a: &Picture, b: &Picture) -> (usize, f32) {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.filter(|(a, b)| a != b).fold((0, 0.0), |(count, most), (a, b)| (count + 1, (a - b).abs().max(most)))
}

/// Returns the picture's raw values, drawn in tiles with others in between.
fn raw(renderer: &mut Renderer, view: &View, lights: &[LightInstance]) -> (Picture, usize) {
    let between = View { slot: ViewSlot(9), ..camera([40, 30], Aov::Beauty, 1) };
    let picture = TiledPicture::for_files(view, lights, FileNeeds::Values).unwrap();
    let (Pixels::Raw(picture), turns) = tiled(renderer, picture, &between, lights) else { panic!("raw values") };
    (picture, turns)
}

/// Returns a floor of one color, and on it a carpet of another that is higher by less than f32 resolves.
fn carpeted() -> Scene {
    let colored = |base_color| Material { base_color, ..Material::default() };
    let carpet = Primitive { material: 1, ..square() };
    let turned =
        DAffine3::from_scale_rotation_translation(DVec3::splat(1.7), DQuat::from_rotation_y(0.4), DVec3::Y * 3e-8);
    let lamp = (colored_ball(), DAffine3::from_translation(DVec3::new(-2.1, 2.3, -1.6)));
    let floor = (square(), DAffine3::from_scale(DVec3::splat(3.0)));
    let colors = [Vec4::new(0.9, 0.8, 0.6, 1.0), Vec4::new(0.02, 0.3, 0.02, 1.0)];
    scene_of([(carpet, turned), floor, lamp], colors.map(colored).into())
}

/// The choice between two coincident surfaces does not depend on the start of a tile, and is the same all over.
#[test]
fn surfaces_in_one_place_are_the_same_ones_in_every_tile() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &carpeted());
        let view = camera([700, 410], Aov::Beauty, 1);
        let whole = renderer.render(&view, &lights()).unwrap();
        let (tiled, turns) = raw(&mut renderer, &view, &lights());
        assert_eq!((differences(&whole, &tiled), turns >= 6), ((0, 0.0), true));
        // The middle of the picture shows the middle of the carpet, which alone is green.
        let rows = whole.pixels.chunks(700).skip(150).take(110);
        let seen: Vec<_> = rows.flat_map(|row| &row[270..430]).filter(|pixel| pixel[0] > 0.0).collect();
        let green = seen.iter().filter(|pixel| pixel[1] > pixel[0]).count();
        assert!(seen.len() > 10_000 && [0, seen.len()].contains(&green), "{green} of {}", seen.len());
    }
}

/// The same pixels are covered and every ray is the same to the last bit, and so is everything that depends on them:
/// holes, colors of textures and the rest.
#[test]
fn tiles_make_up_the_picture() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &things_with_holes());
        for aov in [Aov::Beauty, Aov::Depth, Aov::Normal, Aov::T, Aov::Visibility] {
            let view = View { light: 2, ..camera([700, 410], aov, 2) };
            let whole = renderer.render(&view, &lights()).unwrap();
            let (tiled, turns) = raw(&mut renderer, &view, &lights());
            let (count, error) = differences(&whole, &tiled);
            assert_eq!(count, 0, "{aov:?}: {count} values differ, by up to {error}");
            // 3 x 2 tiles of at least 128 x 128 pixels, each with its samples and lights.
            assert!(turns >= 6, "{turns}");
            // Deliberate faults that the check must detect: a tile shifted by one pixel, and one sample in place of
            // two.
            let mut shifted = tiled.clone();
            shifted.pixels.rotate_right(1);
            assert!(differences(&whole, &shifted).1 > 1e-2, "{aov:?}");
            if aov.can_be_multisampled() {
                let (single, _) = raw(&mut renderer, &View { samples: 1, ..view.clone() }, &lights());
                assert!(differences(&whole, &single).1 > 1e-2);
            }
        }
    }
}

/// A screen's picture agrees as closely.
#[test]
fn tiles_make_up_the_screen() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &things_with_holes());
        let view = camera([500, 300], Aov::Beauty, 2);
        let whole = renderer.render_display(&view, &lights()).unwrap();
        let picture = TiledPicture::for_screen(&view, &lights()).unwrap();
        let (Pixels::Display { bytes, .. }, _) = tiled(&mut renderer, picture, &view, &lights()) else {
            panic!("bytes")
        };
        assert!(whole.iter().zip(&bytes).all(|(a, b)| a.abs_diff(*b) <= 1));
        // Deliberate fault that the check must detect: rows in another order.
        let turned: Vec<u8> = bytes.chunks(4 * 500).rev().flatten().copied().collect();
        assert!(whole.iter().zip(&turned).any(|(a, b)| a.abs_diff(*b) > 50));
    }
}

/// A file's picture equals that of one long turn. It reports its progress in samples of pixels, after every sample of
/// every tile.
#[test]
fn a_file_says_how_far_it_is() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &things());
        let pixels = 700 * 410;
        for (aov, samples, of) in [
            (Aov::Beauty, 3, 3 * pixels),
            (Aov::Visibility, 3, 3 * pixels),
            (Aov::Depth, 3, pixels),
            (Aov::Wireframe, 1, pixels),
        ] {
            let view = camera([700, 410], aov, samples);
            let mut reports: Vec<SampleProgress> = Vec::new();
            let report = |progress| reports.push(progress);
            let drawn = renderer.render_for_files(&view, &lights(), FileNeeds::Values, report).unwrap();
            assert!(reports.iter().all(|progress| progress.total == of), "{aov:?}: {reports:?}");
            assert!(reports.is_sorted_by(|a, b| a.done < b.done), "{aov:?}: {reports:?}");
            assert_eq!(reports.last().map(|last| last.done), Some(of), "{aov:?}");
            // Tiles begin with 256 pixels a side, so the first row has three.
            let least = if aov == Aov::Wireframe { 1 } else { 3 * (of / pixels) as usize };
            assert!(reports.len() >= least, "{aov:?}: {reports:?}");

            let mut whole = TiledPicture::for_files(&view, &lights(), FileNeeds::Values).unwrap();
            while !renderer.advance_tiled(&mut whole, Duration::MAX).unwrap() {}
            assert!(whole.into_pixels() == drawn, "{aov:?}");
        }
    }
}

/// Without interpolated uv nothing differs, for any number of samples and interruptions.
#[test]
fn samples_in_tiles_are_those_of_the_picture_to_the_bit() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &carpeted());
        let view = View { fill: 0.7, ..camera([390, 270], Aov::Beauty, 3) };
        let whole = renderer.render(&view, &lights()).unwrap();
        let (tiled, turns) = raw(&mut renderer, &view, &lights());
        // 2 x 2 tiles or more, with a turn for each light of each sample.
        assert!(turns >= 4 * 3 * 3, "{turns}");
        assert_eq!(differences(&whole, &tiled), (0, 0.0), "{backend:?}");
        // Deliberate fault that the check must detect: lights in another order add up to other bits.
        let mut turned = lights();
        turned.rotate_left(1);
        assert_ne!(differences(&whole, &renderer.render(&view, &turned).unwrap()).0, 0);
    }
}

/// Each shadow map is drawn once, for any number of turns, and a final picture uses those of the moving one.
#[test]
fn tiles_share_their_shadow_maps() {
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &things());
        let view = camera([700, 410], Aov::Beauty, 3);
        renderer.render_display(&View { samples: 1, ..view.clone() }, &lights()).unwrap();
        assert_eq!(renderer.counts().shadow, 3);
        let mut picture = TiledPicture::for_screen(&view, &lights()).unwrap();
        let mut turns = 0;
        while !renderer.advance_tiled(&mut picture, Duration::ZERO).unwrap() {
            turns += 1;
        }
        // One for each light over each sample of each tile.
        assert!(turns > 3 * 3 * 6 - 1, "{turns}");
        assert_eq!(renderer.counts().shadow, 3);
    }
}

/// A bent map on the GPU yields in the middle. After a cancellation at any point, the next picture is correct.
#[test]
fn a_bent_map_of_the_device_yields_in_its_middle() {
    let left = Arc::new(AtomicU32::new(u32::MAX));
    let counted = Arc::clone(&left);
    let yields = move || counted.fetch_sub(1, Ordering::Relaxed) > 1;
    let run = |work: &mut (dyn FnMut() + Send)| {
        work();
        true
    };
    let yielding = YieldPolicy::new(|| true, yields, run);
    let host = Host::default().with_yield_policy(yielding);
    let device = Device::open(host, Some(Backend::Wgpu)).expect("tests need a graphics driver");
    let mut renderer = renderer_on(&device, &things());
    let view = camera([160, 90], Aov::Beauty, 1);
    let [lights, moved] = [0.0, 0.1].map(|by| {
        let [key, low, bent] = &lights()[..] else { unreachable!("three") };
        let [key, low, bent] = [key, low, bent].map(|instance| instance.light.light().clone());
        let at = bent.transform().translation + DVec3::X * by;
        instances(&[key, low, bent.with(TRANSLATION, at)])
    });
    // The picture and its number of yields; cancelled if there would be more than `most`.
    let mut draw = |lights: &[LightInstance], most: u32| {
        left.store(most + 1, Ordering::Relaxed);
        let mut picture = TiledPicture::for_screen(&view, lights).unwrap();
        while !renderer.advance_tiled(&mut picture, Duration::MAX)? {}
        let Pixels::Display { bytes, .. } = picture.into_pixels() else { unreachable!("it is for a screen") };
        Ok::<_, RenderError>((bytes, most + 1 - left.load(Ordering::Relaxed)))
    };
    draw(&lights, 1000).unwrap();
    let (at_rest, kept) = draw(&lights, 1000).unwrap();
    let (expected, new) = draw(&moved, 1000).unwrap();
    assert_eq!(new, kept + 1);
    assert!(at_rest != expected);
    for most in 0..new {
        draw(&lights, 1000).unwrap();
        assert_eq!(draw(&moved, most), Err(RenderError::Cancelled), "{most} of {new}");
        assert!(draw(&moved, 1000).unwrap().0 == expected, "after {most} of {new}");
    }
}
