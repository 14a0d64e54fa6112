//! Tests of cached memory, of small budgets, and of its release.

use std::time::Duration;

use glam::DVec3;
use light::parameters::{CONE_ANGLE, INTENSITY, RANGE, SHADOW_ENABLE, SHADOW_LINK, TRANSLATION};
use light::{Light, LightInstance, Links};
use render::{
    Aov, Backend, FileNeeds, MemoryBudget, MemoryKind, Picture, Pixels, Renderer, TiledPicture, View, ViewSlot,
};

use crate::support::{BACKENDS, instances, oblique, renderer_within, spot, tables, view};

/// Bytes of a map of 2048 x 2048 texels.
const MAP: u64 = 4 << 22;

/// Returns a renderer with a device of its own, and that budget in bytes.
fn renderer(backend: Backend, budget: u64) -> (Renderer, MemoryBudget) {
    let memory = MemoryBudget::new(budget);
    (renderer_within(&memory, backend, &tables()), memory)
}

/// Spots and bent lights in turn, around the table.
fn lights(count: usize) -> Vec<Light> {
    let light = |k: usize| {
        let (z, x) = (k as f64 * 2.4).sin_cos();
        let intensity = 1.0 + k as f64;
        let spot = spot(DVec3::new(x, 3.0, z), DVec3::ZERO).with(INTENSITY, intensity);
        if k.is_multiple_of(2) {
            return spot;
        }
        light::bend(&spot.with(RANGE, Some(6.0)), 2).unwrap()
    };
    (0..count).map(light).collect()
}

fn camera(slot: u64) -> View {
    let slot = ViewSlot(slot);
    View { samples: 2, slot, ..oblique([150, 140], Aov::Beauty) }
}

/// Draws at once and in tiles. Also returns the largest number of cached bytes.
fn pictures(renderer: &mut Renderer, memory: &MemoryBudget, lights: &[LightInstance]) -> (Picture, Pixels, u64) {
    let whole = renderer.render(&camera(1), lights).unwrap();
    let mut most = memory.total();
    let mut picture = TiledPicture::for_files(&camera(2), lights, FileNeeds::Values).unwrap();
    while !renderer.advance_tiled(&mut picture, Duration::ZERO).unwrap() {
        most = most.max(memory.total());
    }
    (whole, picture.into_pixels(), most)
}

/// Maps that do not fit into the budget are drawn one after another and used at once. The picture is the same to the
/// last bit.
#[test]
fn a_small_budget_makes_the_same_pictures() {
    for backend in BACKENDS {
        let lights = instances(&lights(7));
        let (mut rich, rich_ledger) = renderer(backend, 1 << 30);
        let (whole, tiled, _) = pictures(&mut rich, &rich_ledger, &lights);
        assert_eq!(rich_ledger.bytes(MemoryKind::ShadowMaps), 7 * MAP);
        assert_eq!(rich.counts().shadow, 7);

        let budget = 4 * MAP;
        let (mut poor, poor_ledger) = renderer(backend, budget);
        let (poor_whole, poor_tiled, most) = pictures(&mut poor, &poor_ledger, &lights);
        assert!(poor_whole == whole && poor_tiled == tiled);
        assert!(poor.counts().shadow > 7, "maps were made again");
        assert!(most <= budget + MAP, "{most} bytes, and one map more may be in use");
        // Deliberate fault that the check must detect: a light with the map of another.
        let mut other = lights.clone();
        other.swap(0, 2);
        other.truncate(6);
        assert!(poor.render(&camera(1), &other).unwrap() != whole);
    }
}

/// A very wide light's map has five faces of half the size, and cannot reuse the memory of another light.
#[test]
fn wide_lights_are_counted_by_their_faces() {
    let backend = Backend::Wgpu;
    let (mut renderer, memory) = renderer(backend, 1 << 30);
    let maps = |angles: &[f64], renderer: &mut Renderer| {
        let spots = angles.iter().map(|&cone_angle| spot(DVec3::Y * 3.0, DVec3::ZERO).with(CONE_ANGLE, cone_angle));
        let bent = |spot: &Light| light::bend(&spot.clone().with(RANGE, Some(6.0)), 2).unwrap();
        let lights: Vec<_> = spots.flat_map(|spot| [bent(&spot), spot]).collect();
        renderer.render(&camera(1), &instances(&lights)).unwrap();
        memory.bytes(MemoryKind::ShadowMaps)
    };
    assert_eq!(maps(&[25.0], &mut renderer), 2 * MAP);
    assert_eq!(maps(&[25.0, 85.0], &mut renderer), 2 * MAP + 2 * 5 * MAP / 4);
    // The memory of the one cannot hold the other.
    assert_eq!(maps(&[70.0], &mut renderer), 2 * MAP + 2 * 5 * MAP / 4);
    assert_eq!(renderer.counts().shadow, 6);
}

/// Returns the bytes of `count` views of 150 x 140 pixels, each with the lights of a picture.
fn bytes_of_views(backend: Backend, count: u64) -> std::ops::RangeInclusive<u64> {
    let pixels = 150 * 140;
    match backend {
        // The G-buffer, radiance and a screen's bytes.
        Backend::Wgpu => count * pixels * 44..=count * pixels * 44,
        // Radiance; surfaces and their sum, 64 bytes per pixel, in whole blocks with at least one surface.
        Backend::Native => {
            let least = pixels * 16;
            count * least..=count * (least + 64 * 152 * 140)
        }
    }
}

#[test]
fn memory_is_freed_with_the_last_view_that_needs_it() {
    for backend in BACKENDS {
        let memory = MemoryBudget::default();
        let mut renderer = renderer_within(&memory, backend, &tables());
        let at_rest = lights(3);
        let lights = instances(&at_rest);
        // The work buffers of bent maps stay with the scene.
        renderer.render(&camera(1), &lights).unwrap();
        renderer.drop_view(ViewSlot(1));
        let before = memory.total();

        // Views close. Maps are freed with the last view that needs them.
        renderer.render(&camera(1), &lights).unwrap();
        renderer.render(&camera(2), &lights[..2]).unwrap();
        assert_eq!(memory.bytes(MemoryKind::ShadowMaps), 3 * MAP);
        let views = memory.bytes(MemoryKind::Views);
        assert!(bytes_of_views(backend, 2).contains(&views), "{backend:?}: {views}");
        renderer.drop_view(ViewSlot(1));
        assert_eq!(memory.bytes(MemoryKind::ShadowMaps), 2 * MAP);
        renderer.drop_view(ViewSlot(2));
        assert_eq!(memory.total(), before);

        // A still that is cancelled in the middle.
        let mut still = TiledPicture::for_files(&camera(3), &lights, FileNeeds::Values).unwrap();
        for _ in 0..4 {
            assert!(!renderer.advance_tiled(&mut still, Duration::ZERO).unwrap());
        }
        assert!(memory.bytes(MemoryKind::Tiled) > 150 * 140 * 16 && memory.bytes(MemoryKind::ShadowMaps) > 0);
        drop(still);
        renderer.drop_view(ViewSlot(3));
        assert_eq!(memory.total(), before);

        // A drag leaves no trail of maps.
        let moved = |step: u32| {
            let mut moved = at_rest.clone();
            let translation = moved[0].transform().translation + DVec3::X * (0.1 * f64::from(step));
            moved[0].set(TRANSLATION.to(translation));
            instances(&moved)
        };
        for step in 0..5 {
            renderer.render(&camera(1), &moved(step)).unwrap();
            assert_eq!(memory.bytes(MemoryKind::ShadowMaps), 3 * MAP);
        }
        // Neither does a drag that other views watch: each shows a step of it, and a picture under way loses nothing.
        let mut still = TiledPicture::for_files(&camera(4), &lights, FileNeeds::Values).unwrap();
        let before = renderer.counts().shadow;
        while renderer.counts().shadow == before {
            assert!(!renderer.advance_tiled(&mut still, Duration::ZERO).unwrap());
        }
        for step in 6..12 {
            renderer.render_display(&camera(10 + u64::from(step)), &moved(step)).unwrap();
            // Deliberate fault that the check must detect: every map that a view has shown is needed.
            assert!(memory.bytes(MemoryKind::ShadowMaps) <= 4 * MAP, "{backend:?}, step {step}");
        }
        assert_eq!(renderer.counts().shadow, before + 7);
        while !renderer.advance_tiled(&mut still, Duration::ZERO).unwrap() {}
        assert_eq!(renderer.counts().shadow, before + 7, "the still's maps were drawn again");
        drop((still, renderer));
        assert_eq!(memory.total(), 0);
    }
}

/// A light without shadows has a single map of minimal size, regardless of the number of pictures. The map from before
/// stays for when shadows are back.
#[test]
fn pictures_of_a_light_without_shadows_keep_nothing_more() {
    for backend in BACKENDS {
        let (mut renderer, memory) = renderer(backend, 1 << 30);
        let kept = |memory: &MemoryBudget| memory.bytes(MemoryKind::ShadowMaps);
        for light in lights(2) {
            let with = instances(std::slice::from_ref(&light));
            let without = instances(&[light.with(SHADOW_ENABLE, false)]);
            let pictures = |renderer: &mut Renderer| {
                for step in 0..5 {
                    let from = DVec3::new(2.0 + 0.1 * f64::from(step), 3.0, 4.0);
                    let moved = View { camera: view(from, DVec3::ZERO, [150, 140], Aov::Beauty).camera, ..camera(1) };
                    renderer.render(&moved, &without).unwrap();
                }
            };
            let before = kept(&memory);
            renderer.render(&camera(1), &without).unwrap();
            let first = kept(&memory);
            assert!(first < before + 100, "nothing is kept but something to bind");
            pictures(&mut renderer);
            assert_eq!(kept(&memory), first, "bytes of maps after more pictures");
            renderer.render(&camera(1), &with).unwrap();
            assert!(kept(&memory) >= first + MAP);
            pictures(&mut renderer);
            let drawn = renderer.counts().shadow;
            renderer.render(&camera(1), &with).unwrap();
            assert_eq!(renderer.counts().shadow, drawn, "the map is still there");
        }
    }
}

/// On the native backend, the arrays of the GPU's buffers are in CPU memory. They are counted, and freed with the scene.
#[test]
fn arrays_of_scenes_are_counted_on_the_native_backend() {
    // Two white texels on the GPU alone: a color of four times 16 bits, and data of four times 8.
    const TEXTURES: u64 = 8 + 4;
    // The material and a word of bits in CPU memory alone.
    const MATERIALS: u64 = size_of::<relight::MaterialRun>() as u64 + 4;
    let mut scene = tables();
    scene.nodes[1].name = "table".into();
    let linked = lights(2).remove(1).with(SHADOW_LINK, Links::new(vec![], vec!["table".into()]));
    let [by_wgpu, by_native] = [Backend::Wgpu, Backend::Native].map(|backend| {
        let memory = MemoryBudget::new(1 << 30);
        let mut renderer = renderer_within(&memory, backend, &scene);
        let unlinked = memory.bytes(MemoryKind::Scenes);
        renderer.render(&camera(1), &instances(std::slice::from_ref(&linked))).unwrap();
        let bytes = [unlinked, memory.bytes(MemoryKind::Scenes)];
        drop(renderer);
        assert_eq!(memory.total(), 0);
        bytes
    });
    assert!(by_wgpu[1] > by_wgpu[0], "what links leave is counted");
    assert_eq!(by_native, by_wgpu.map(|bytes| bytes - TEXTURES + MATERIALS));
}
