//! Tests of layers: an edit draws only the edited light, and the picture is that of a fresh renderer.

use std::task::Poll;
use std::time::Duration;

use glam::{DVec3, Vec4};
use light::parameters::{COLOR, DIFFUSE, ENABLED, EXPOSURE, INTENSITY, RANGE, SHADOW_COLOR, SPECULAR, TRANSLATION};
use light::{Light, LightInstance};
use render::{
    Aov, Backend, Cause, MapScale, MemoryBudget, MemoryKind, Pass, PassCounts, Pixels, Renderer, ShadowSettings,
    TiledPicture, View, ViewSlot,
};
use scene::{Material, Scene};

use crate::support::{
    BACKENDS, floor, instances, oblique, renderer, renderer_of, renderer_within, scene_of, since, spot, unstraightened,
};

fn tables() -> Scene {
    let shiny = Material { roughness: 0.3, ..Material::default() };
    scene_of([floor(3.0, 0.0), floor(0.5, 1.0)], vec![shiny])
}

/// Returns lights of every shape in turn, around the table, each with its own factors.
fn lights(count: usize) -> Vec<Light> {
    let light = |k: usize| {
        let (z, x) = (k as f64 * 2.4).sin_cos();
        let spot = spot(DVec3::new(x, 3.0, z), DVec3::ZERO);
        let shape = match k % 4 {
            0 => spot,
            1 => light::bend(&spot.with(RANGE, Some(6.0)), 2).unwrap(),
            2 => Light::omni().with_transform(spot.transform()),
            _ => Light::directional().with_transform(spot.transform()),
        };
        let share = 4.0 / count.max(4) as f64;
        shape
            .with(INTENSITY, share * (1.0 + (k % 3) as f64))
            .with(EXPOSURE, (k % 2) as f64 - 0.5)
            .with(COLOR, DVec3::new(1.0, 0.5 + 0.1 * (k % 5) as f64, 0.6))
            .with(DIFFUSE, 0.3 + 0.2 * (k % 4) as f64)
            .with(SPECULAR, 1.5 - 0.3 * (k % 3) as f64)
            .with(SHADOW_COLOR, DVec3::new(0.0, 0.05, 0.1))
    };
    (0..count).map(light).collect()
}

fn camera() -> View {
    oblique([75, 61], Aov::Beauty)
}

/// Returns the same picture with lights added one after another.
fn added_up(renderer: &mut Renderer, lights: &[LightInstance]) -> Vec<u8> {
    let mut picture = TiledPicture::for_screen(&View { slot: ViewSlot(9), ..camera() }, lights).unwrap();
    while !renderer.advance_tiled(&mut picture, Duration::from_secs(9)).unwrap() {}
    let Pixels::Display { bytes, .. } = picture.into_pixels() else { panic!("bytes") };
    bytes
}

/// Returns a renderer of the tables with small shadow maps, which draw forty lights in a moment.
fn of_tables(backend: Backend) -> Renderer {
    let mut renderer = renderer_of(backend, &tables());
    renderer.set_shadow_settings(ShadowSettings { resolution: 256, ..unstraightened() }).unwrap();
    renderer
}

/// Returns a renderer with a device of its own and small shadow maps, so that layers take most of the memory.
fn with_coarse_maps(memory: &MemoryBudget, backend: Backend) -> Renderer {
    let mut renderer = renderer_within(memory, backend, &tables());
    renderer.set_shadow_settings(ShadowSettings { resolution: 64, ..unstraightened() }).unwrap();
    renderer
}

fn farthest(a: &[u8], b: &[u8]) -> u8 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

/// Draws in turns of zero time, one piece each, with a picture of another view between every two.
fn in_turns(renderer: &mut Renderer, lights: &[LightInstance]) -> (Vec<u8>, usize) {
    let other = View { slot: ViewSlot(8), width: 40, ..camera() };
    let mut turns = 1;
    loop {
        match renderer.advance_display(&camera(), lights, Duration::ZERO).unwrap() {
            Poll::Ready(bytes) => return (bytes, turns),
            Poll::Pending => turns += 1,
        }
        assert!(turns < 1_000, "it never ends");
        renderer.render_display(&other, lights).unwrap();
    }
}

/// A picture with others in between is the same, and no part of it is drawn twice.
#[test]
fn a_picture_in_turns_is_the_picture() {
    for backend in BACKENDS {
        for count in [1, 4, 9, 42] {
            let lights = instances(&lights(count));
            let (mut whole, mut turned) = (of_tables(backend), of_tables(backend));
            let drawn = whole.render_display(&camera(), &lights).unwrap();
            let (bytes, turns) = in_turns(&mut turned, &lights);
            assert_eq!(bytes, drawn, "{count} lights, {backend:?}");
            // The G-buffer, then each light's map and its layer. A light without a map has no turn for it.
            assert!(turns > count, "{turns} turns for {count} lights, {backend:?}");
            let (of_whole, of_turned) = (whole.counts(), turned.counts());
            assert_eq!(of_turned.shadow, of_whole.shadow, "maps, {backend:?}");
            assert_eq!(of_turned.layers, 2 * of_whole.layers, "layers of two views, {backend:?}");
            // Deliberate fault that the check must detect: a picture of the first turn alone lacks lights.
            let (mut begun, later) = (of_tables(backend), &lights[..count - 1]);
            assert!(begun.advance_display(&camera(), &lights, Duration::ZERO).unwrap().is_pending());
            assert_ne!(begun.render_display(&camera(), later).unwrap(), drawn);
        }
    }
}

/// Layers, groups of them, and groups of groups add up to the picture, except for another order of roundings: a byte
/// may fall to the other side of a step.
#[test]
fn layers_add_up_to_the_picture() {
    for backend in BACKENDS {
        for count in [0, 1, 4, 8, 9, 42, 130] {
            let mut renderer = of_tables(backend);
            let mut lights = instances(&lights(count));
            let drawn = renderer.render_display(&camera(), &lights).unwrap();
            assert_eq!(renderer.counts().layers, count as u64);
            let farthest_byte = farthest(&drawn, &added_up(&mut renderer, &lights));
            // The CPU adds up to eight layers, in floats, in the order of the lights.
            let most = u8::from(backend == Backend::Wgpu || count > 8);
            assert!(farthest_byte <= most, "{count} lights, {backend:?}: {farthest_byte}");
            // Deliberate fault that the check must detect: the lights of one group are missing.
            if count > 0 {
                lights.truncate(count - count.div_ceil(8));
                let other = renderer.render_display(&camera(), &lights).unwrap();
                assert!(farthest(&drawn, &other) > 1, "{count} lights");
            }
        }
    }
}

/// Lights are added one after another, as in tiles, if their layers would take more than half of the budget: the bytes
/// are those of tiles, and no layer is cached. The difference from layers is as above.
#[test]
fn more_lights_than_layers_fit_are_added_one_by_one() {
    for backend in BACKENDS {
        let draw = |budget: u64| {
            let mut renderer = with_coarse_maps(&MemoryBudget::new(budget), backend);
            let lights = instances(&lights(12));
            let drawn = renderer.render_display(&camera(), &lights).unwrap();
            (drawn, renderer.counts().layers, added_up(&mut renderer, &lights))
        };
        // Twelve layers and sums of 75 x 61 pixels: 240 bytes per pixel on the GPU, 360 on the CPU.
        let (rich, layers, _) = draw(1 << 30);
        let (poor, none, in_tiles) = draw(2 * 75 * 61 * 239);
        assert_eq!([layers, none], [12, 0], "{backend:?}");
        assert_eq!(farthest(&poor, &in_tiles), 0, "{backend:?}");
        assert!(farthest(&poor, &rich) <= 1, "{backend:?}");
    }
}

/// Mirrored light may be ten thousand times as bright as scattered light at the same point. Without it, the scattered
/// light is unchanged. With one exponent for both, it would have steps of 2^-18 of the highlight, several bytes each.
#[test]
fn a_highlight_does_not_take_from_what_is_scattered() {
    let black = Material { roughness: 0.1, base_color: Vec4::new(1e-3, 1e-3, 1e-3, 1.0), ..Material::default() };
    let mut renderer = renderer(&scene_of([floor(3.0, 0.0)], vec![black]));
    let across = DVec3::new(-2.0, 3.0, -4.0);
    let light = Light::omni().with(TRANSLATION, across).with(INTENSITY, 4e4);
    let draw = |renderer: &mut Renderer, specular: f64| {
        let lights = instances(&[light.clone().with(SPECULAR, specular)]);
        let drawn = renderer.render_display(&camera(), &lights).unwrap();
        let layers = renderer.counts().layers;
        (drawn, added_up(renderer, &lights), layers)
    };
    let (bright, _, _) = draw(&mut renderer, 1.0);
    let (dark, anew, layers) = draw(&mut renderer, 0.0);
    assert_eq!(layers, 1);
    assert!(farthest(&dark, &anew) <= 1);
    let middle = |picture: &[u8]| picture[4 * (30 * 75 + 37)];
    assert!(middle(&bright) == 255 && (64..192).contains(&middle(&dark)), "{}", middle(&dark));
}

#[test]
fn passes_say_why_they_ran() {
    let (mut renderer, mut lights, mut view) = (renderer(&tables()), lights(2), camera());
    let ran = |renderer: &mut Renderer, view: &View, lights: &[Light]| -> Vec<(Pass, Option<u64>, Cause)> {
        renderer.render_display(view, &instances(lights)).unwrap();
        let runs = renderer.runs().to_vec();
        assert!(runs.iter().all(|run| run.runs == 1), "{runs:?}");
        runs.into_iter().map(|run| (run.pass, run.light.map(|id| id.0), run.cause)).collect()
    };
    let shown = (Pass::Display, None, Cause::NotKept);
    let of_light = |light: u64, map: Option<Cause>, layer: Cause| {
        let map = map.map(|cause| (Pass::ShadowMap, Some(light), cause));
        map.into_iter().chain([(Pass::Layer, Some(light), layer)]).collect::<Vec<_>>()
    };
    let base = |cause| vec![(Pass::Gbuffer, None, cause), (Pass::Lighting, None, cause)];
    let first = Cause::First;
    let ids: Vec<u64> = instances(&lights).iter().map(|light| light.id.0).collect();
    let both = |map: Option<Cause>, layer| [of_light(ids[0], map, layer), of_light(ids[1], map, layer)].concat();
    let all = |base: Vec<_>, lights: Vec<_>| [base, lights, vec![shown]].concat();

    assert_eq!(ran(&mut renderer, &view, &lights), all(base(first), both(Some(first), first)));
    assert_eq!(ran(&mut renderer, &view, &lights), [shown]);
    lights[0].set(INTENSITY.to(3.0));
    assert_eq!(ran(&mut renderer, &view, &lights), [shown]);
    lights[0].set(TRANSLATION.to(DVec3::new(0.1, 3.0, 0.2)));
    let moved = of_light(ids[0], Some(Cause::Light), Cause::Light);
    assert_eq!(ran(&mut renderer, &view, &lights), all(Vec::new(), moved));
    view.camera.translation += DVec3::X * 0.01;
    assert_eq!(ran(&mut renderer, &view, &lights), all(base(Cause::Camera), both(None, Cause::Gbuffer)));
    renderer.set_scene(&scene::pose(tables(), 0.0)).unwrap();
    let scene = both(Some(Cause::Scene), Cause::Gbuffer);
    assert_eq!(ran(&mut renderer, &view, &lights), all(base(Cause::Scene), scene));
    // Coarser maps serve until finer ones are needed.
    lights[1].set(TRANSLATION.to(DVec3::new(0.5, 3.0, 0.2)));
    view.shadow_map = MapScale::Half;
    assert_eq!(ran(&mut renderer, &view, &lights), all(Vec::new(), of_light(ids[1], Some(Cause::Light), Cause::Light)));
    view.shadow_map = MapScale::Full;
    let finer = of_light(ids[1], Some(Cause::Resolution), Cause::Resolution);
    assert_eq!(ran(&mut renderer, &view, &lights), all(Vec::new(), finer));
}

/// A light that reaches no visible surface draws neither map nor layer, whatever its edits, and the picture is the one
/// without it. In view, it is drawn.
#[test]
fn lights_outside_of_the_view_draw_nothing() {
    let away_by = DVec3::new(40.0, 0.0, 60.0);
    for count in [4, 16] {
        let lit = lights(count);
        // Every fourth light is directional: it shines everywhere.
        let away = |k: usize| k % 4 < 2;
        let mut beside = lit.clone();
        for (_, light) in beside.iter_mut().enumerate().filter(|(k, _)| away(*k)) {
            light.set(TRANSLATION.to(light.get(TRANSLATION) + away_by));
        }
        let without: Vec<Light> = (0..count).filter(|k| !away(*k)).map(|k| lit[k].clone()).collect();
        let draw =
            |renderer: &mut Renderer, lights: &[Light]| renderer.render_display(&camera(), &instances(lights)).unwrap();
        let mut renderer = renderer(&tables());
        let drawn = draw(&mut renderer, &beside);
        let before = renderer.counts();
        assert_eq!([before.layers, before.shadow], [without.len() as u64; 2]);
        assert_eq!(drawn, draw(&mut self::renderer(&tables()), &without), "{count} lights");
        let mut moved = beside.clone();
        moved[0] = moved[0].clone().with(INTENSITY, 9.0).with(TRANSLATION, DVec3::new(41.0, 3.0, 61.0));
        assert_eq!(draw(&mut renderer, &moved), drawn);
        assert_eq!(since(before, renderer.counts()), PassCounts { display: 1, ..PassCounts::default() });
        // Deliberate fault that the check must detect: they are in view.
        assert!(farthest(&draw(&mut renderer, &lit), &drawn) > 1);
        assert_eq!(since(before, renderer.counts()).shadow, (count - without.len()) as u64);
    }
}

/// Returns the passes after an edit of a picture of `lights`.
fn drawn_by(
    backend: Backend,
    renderer: &mut Renderer,
    lights: &[Light],
    edit: impl FnOnce(&mut View, &mut [Light]),
) -> PassCounts {
    let (mut view, mut lights) = (camera(), lights.to_vec());
    renderer.render_display(&view, &instances(&lights)).unwrap();
    let before = renderer.counts();
    edit(&mut view, &mut lights);
    let drawn = renderer.render_display(&view, &instances(&lights)).unwrap();
    let alone = of_tables(backend).render_display(&view, &instances(&lights)).unwrap();
    assert_eq!(drawn, alone);
    since(before, renderer.counts())
}

/// Each edit draws only what depends on it, and the result is that of a fresh renderer, to the last bit.
#[test]
fn an_edit_draws_what_it_touches() {
    for backend in BACKENDS {
        // Beyond eight lights there are sums.
        for count in [3, 30] {
            let (mut renderer, lights) = (of_tables(backend), lights(count));
            let shown = PassCounts { display: 1, ..PassCounts::default() };
            let mut edit = |change: fn(Light) -> Light| {
                drawn_by(backend, &mut renderer, &lights, |_, lights| lights[1] = change(lights[1].clone()))
            };
            assert_eq!(edit(|light| light), shown);
            assert_eq!(edit(|light| light.with(INTENSITY, 7.0)), shown);
            assert_eq!(edit(|light| light.with(EXPOSURE, -1.0)), shown);
            assert_eq!(edit(|light| light.with(COLOR, DVec3::Z)), shown);
            assert_eq!(edit(|light| light.with(DIFFUSE, 0.0)), shown);
            assert_eq!(edit(|light| light.with(SPECULAR, 0.0)), shown);
            assert_eq!(edit(|light| light.with(ENABLED, false)), shown);
            // Deliberate fault that the check must detect: an edit that the light's layer depends on.
            let layer = PassCounts { layers: 1, ..shown };
            assert_eq!(edit(|light| light.with(SHADOW_COLOR, DVec3::X)), layer);
            let moved = edit(|light| light.with(TRANSLATION, DVec3::new(0.2, 3.0, 0.9)));
            assert_eq!(moved, PassCounts { shadow: 1, ..layer });
            assert_eq!(drawn_by(backend, &mut renderer, &lights, |view, _| view.exposure = 1.0), shown);
            // The CPU has no separate pass for the fill; it shows the fill with the lights.
            let lighting = u64::from(backend == Backend::Wgpu);
            let all = PassCounts { gbuffer: 1, lighting, layers: count as u64, ..shown };
            assert_eq!(drawn_by(backend, &mut renderer, &lights, |view, _| view.camera.translation.x += 0.1), all);
        }
    }
}

/// Lights that are left out and come back, as by mute and solo, draw nothing.
#[test]
fn lights_that_come_back_are_still_cached() {
    for backend in BACKENDS {
        let (mut renderer, all) = (of_tables(backend), instances(&lights(12)));
        let mut show = |lights: &[LightInstance]| {
            let drawn = renderer.render_display(&camera(), lights).unwrap();
            (drawn, renderer.counts().layers)
        };
        let (first, _) = show(&all);
        let (alone, layers) = show(&all[5..6]);
        assert_ne!(alone, first);
        assert_eq!((show(&all), layers), ((first, 12), 12));
    }
}

/// The picture depends only on the current lights, not on the order of edits.
#[test]
fn the_picture_knows_no_history() {
    for backend in BACKENDS {
        let (mut renderer, mut lights) = (of_tables(backend), lights(17));
        let mut fresh = of_tables(backend);
        for turn in 0..24_usize {
            let which = turn * 7 % lights.len();
            let light = lights[which].clone();
            lights[which] = match turn % 4 {
                0 => light.with(INTENSITY, 0.1 * turn as f64),
                1 => light.with(TRANSLATION, DVec3::new(0.1 * turn as f64 - 1.0, 2.5, 0.4)),
                2 => light.with(ENABLED, turn % 8 == 2),
                _ => light.with(SHADOW_COLOR, DVec3::splat(0.01 * turn as f64)),
            };
            let lights = instances(&lights);
            let drawn = renderer.render_display(&camera(), &lights).unwrap();
            fresh.drop_view(camera().slot);
            assert_eq!(drawn, fresh.render_display(&camera(), &lights).unwrap(), "turn {turn}");
        }
    }
}

/// Views share a budget: layers of the least recently used view are evicted, and drawn again on demand.
#[test]
fn layers_are_bounded_and_made_again() {
    // Textures have 16 bytes per pixel of a layer and 8 of a sum; the CPU holds six floats and three.
    for (backend, layer, sum) in [(Backend::Wgpu, 16, 8), (Backend::Native, 24, 12)] {
        let bytes_of_a_view = (20 * layer + 5 * sum) * 75 * 61;
        let draw = |budget: u64| {
            let memory = MemoryBudget::new(budget);
            let mut renderer = with_coarse_maps(&memory, backend);
            let mut lights = lights(20);
            let mut most = 0;
            let pictures: Vec<Vec<u8>> = (0..12)
                .map(|turn| {
                    // Then each view needs a new layer of each group for its sums.
                    if turn % 4 == 0 {
                        for light in &mut lights {
                            light.set(INTENSITY.to(0.3 + 0.1 * f64::from(turn)));
                        }
                    }
                    let view = View { slot: ViewSlot(turn as u64 % 4), ..camera() };
                    let picture = renderer.render_display(&view, &instances(&lights)).unwrap();
                    most = most.max(memory.bytes(MemoryKind::Layers));
                    picture
                })
                .collect();
            (pictures, most, memory.total(), renderer.counts().layers)
        };
        let (rich, most, total, layers) = draw(1 << 30);
        assert_eq!((most, layers), (4 * bytes_of_a_view, 80));
        let budget = total - 2 * bytes_of_a_view;
        let (poor, most, total, layers) = draw(budget);
        assert!(poor == rich);
        assert!(most <= 4 * bytes_of_a_view && total <= budget && layers > 80, "{most} {total} {layers}");
    }
}
