//! Tests of caches: the passes that each change runs again.

use glam::DVec3;
use light::parameters::{COLOR, CONE_ANGLE, CONE_SOFTNESS, EXPOSURE, INTENSITY, RANGE, TRANSLATION};
use light::{Light, LightInstance, Setting};
use render::{Aov, Backend, MapScale, PassCounts, Picture, RenderError, Renderer, View, ViewSlot};
use scene::{Material, Scene};

use crate::support::{
    BACKENDS, device_of, floor, instances, oblique, picture, renderer, renderer_of, scene_of, since, spot, tables, view,
};

fn seen(aov: Aov) -> View {
    oblique([33, 21], aov)
}

fn key() -> Light {
    spot(DVec3::new(1.0, 3.0, 0.5), DVec3::ZERO)
}

/// Returns the number of passes that `change` causes.
fn runs(backend: Backend, change: impl FnOnce(&mut Renderer, &mut View, &mut Vec<Light>)) -> PassCounts {
    let mut renderer = renderer_of(backend, &tables());
    let mut view = seen(Aov::Beauty);
    let mut lights = vec![key(), spot(DVec3::new(-1.0, 3.0, 0.5), DVec3::ZERO)];
    renderer.render(&view, &instances(&lights)).unwrap();
    let before = renderer.counts();
    assert_eq!(before, PassCounts { gbuffer: 1, shadow: 2, lighting: 1, ..PassCounts::default() });
    change(&mut renderer, &mut view, &mut lights);
    renderer.render(&view, &instances(&lights)).unwrap();
    since(before, renderer.counts())
}

/// Changes the first light, which keeps its id.
fn edit(lights: &mut [Light], change: Setting) {
    lights[0].set(change);
}

const LIT: PassCounts = PassCounts { gbuffer: 0, shadow: 0, lighting: 1, layers: 0, display: 0 };

#[test]
fn only_what_changed_is_drawn_again() {
    for backend in BACKENDS {
        assert_eq!(runs(backend, |_, _, _| {}), PassCounts::default());
        assert_eq!(runs(backend, |_, _, lights| edit(lights, INTENSITY.to(5.0))), LIT);
        assert_eq!(runs(backend, |_, _, lights| edit(lights, EXPOSURE.to(-2.0))), LIT);
        assert_eq!(runs(backend, |_, _, lights| edit(lights, COLOR.to(DVec3::X))), LIT);
        assert_eq!(runs(backend, |_, _, lights| edit(lights, CONE_SOFTNESS.to(0.5))), LIT);
        if backend == Backend::Wgpu {
            // On the wgpu backend only: a spotlight that is bent for the CPU has this range as its length.
            assert_eq!(runs(backend, |_, _, lights| edit(lights, RANGE.to(Some(9.0)))), LIT);
        }
        let shadow = PassCounts { shadow: 1, ..LIT };
        assert_eq!(runs(backend, |_, _, lights| edit(lights, TRANSLATION.to(DVec3::new(1.5, 3.0, 0.5)))), shadow);
        assert_eq!(runs(backend, |_, _, lights| edit(lights, CONE_ANGLE.to(20.0))), shadow);
        let gbuffer = PassCounts { gbuffer: 1, ..LIT };
        assert_eq!(runs(backend, |_, view, _| view.camera.translation.x += 0.1), gbuffer);
        assert_eq!(runs(backend, |_, view, _| view.width = 34), gbuffer);
        assert_eq!(runs(backend, |_, view, _| view.camera.name = "other".into()), LIT);
        let everything = PassCounts { gbuffer: 1, shadow: 2, ..LIT };
        assert_eq!(
            runs(backend, |renderer, _, _| renderer.set_scene(&scene::pose(tables(), 0.0)).unwrap()),
            everything
        );
        // Each sample has its own G-buffer, but shadows are drawn once.
        assert_eq!(runs(backend, |_, view, _| view.samples = 4), PassCounts { gbuffer: 4, lighting: 4, ..LIT });
        assert_eq!(runs(backend, |renderer, view, _| renderer.drop_view(view.slot)), everything);
        // AOVs of the surface need no light, those of a light only that one.
        let one_light = |renderer: &mut Renderer, view: &mut View, lights: &mut Vec<Light>| {
            (view.aov, view.light) = (Aov::T, 1);
            edit(lights, CONE_ANGLE.to(20.0));
            let lights = instances(lights);
            assert_eq!(renderer.render(view, &lights).unwrap().pixels.len(), 33 * 21);
        };
        assert_eq!(runs(backend, one_light), LIT);
    }
}

/// Another exposure of the view only runs the display pass.
#[test]
fn exposure_of_the_view_draws_nothing_but_what_is_shown() {
    let mut renderer = renderer(&tables());
    let view = seen(Aov::Beauty);
    let lights = instances(&[key()]);
    let first = renderer.render_display(&view, &lights).unwrap();
    let before = renderer.counts();
    let brighter = View { exposure: 1.5, ..view.clone() };
    assert_ne!(renderer.render_display(&brighter, &lights).unwrap(), first);
    assert_eq!(renderer.render_display(&view, &lights).unwrap(), first);
    let shown = PassCounts { display: 2, ..PassCounts::default() };
    assert_eq!(since(before, renderer.counts()), shown);
    // Deliberate fault that the check must detect: the softness of a light's edge belongs to the light.
    let soft = instances(&[key().with(CONE_SOFTNESS, 0.7)]);
    renderer.render_display(&view, &soft).unwrap();
    assert_eq!(since(before, renderer.counts()), PassCounts { layers: 1, display: 3, ..shown });
}

/// Maps are fitted to the scene, regardless of the camera's view. A camera that moves close to a small part and back
/// draws no map, and its picture is that of a fresh renderer.
#[test]
fn a_moved_camera_draws_no_map() {
    let wide = key().with(CONE_ANGLE, 85.0);
    let bent = |spot: &Light| light::bend(&spot.clone().with(RANGE, Some(5.0)), 2).unwrap();
    let lights = [key(), bent(&key()), bent(&wide), wide];
    let mut kept = renderer(&tables());
    let eyes = [DVec3::new(2.0, 3.0, 4.0), DVec3::new(0.1, 1.2, 0.1), DVec3::new(-9.0, 4.0, 2.0)];
    for (k, eye) in eyes.into_iter().enumerate() {
        let view = view(eye, DVec3::new(0.3, 0.0, 0.2), [33, 21], Aov::Beauty);
        let drawn = kept.render(&view, &instances(&lights)).unwrap();
        assert_eq!(kept.counts().shadow, 4, "camera {k}");
        assert_eq!(drawn, picture(&tables(), &view, &lights));
    }
    // Deliberate fault that the check must detect: a changed scene has maps of its own.
    kept.set_scene(&scene::pose(scene_of([floor(3.0, 0.0)], vec![Material::default()]), 0.0)).unwrap();
    kept.render(&view(eyes[0], DVec3::ZERO, [33, 21], Aov::Beauty), &instances(&lights)).unwrap();
    assert_eq!(kept.counts().shadow, 8);
}

/// A light without anything in it lights and shadows nothing. In an empty scene a light is drawn all the same.
#[test]
fn a_light_with_nothing_in_it_has_an_empty_map() {
    let up = spot(DVec3::new(0.0, 1.5, 0.0), DVec3::new(0.1, 9.0, 0.0));
    let bent = light::bend(&up, 2).unwrap();
    let view = seen(Aov::Beauty);
    for light in [up, bent] {
        let dark = picture(&tables(), &view, std::slice::from_ref(&light));
        assert!(dark.pixels.iter().all(|pixel| pixel[..3] == [0.0; 3]));
        assert!(picture(&Scene::default(), &view, &[light]).pixels.iter().all(|pixel| *pixel == [0.0; 4]));
    }
}

/// Passes of each picture, in a renderer that has drawn nothing before.
fn steps<'a>(pictures: impl IntoIterator<Item = (&'a View, &'a [LightInstance])>) -> Vec<PassCounts> {
    let mut renderer = renderer(&tables());
    let mut step = |(view, lights): (&View, &[LightInstance])| {
        let before = renderer.counts();
        renderer.render(view, lights).unwrap();
        since(before, renderer.counts())
    };
    pictures.into_iter().map(&mut step).collect()
}

/// Two viewers that change nothing cause each other no passes. In one slot they would.
#[test]
fn viewers_keep_their_pictures() {
    let lights = [key(), key().with(INTENSITY, 3.0)].map(|light| instances(&[light]));
    let near = seen(Aov::Beauty);
    let mut far = View { width: 24, slot: ViewSlot(7), ..near.clone() };
    far.camera.translation *= 2.0;
    let turns =
        |other: &View| steps([(&near, &lights[0][..]), (other, &lights[0]), (&near, &lights[1]), (other, &lights[1])]);
    let first = PassCounts { gbuffer: 1, shadow: 1, ..LIT };
    let second = PassCounts { gbuffer: 1, ..LIT };
    assert_eq!(turns(&far), [first, second, LIT, LIT]);
    // Deliberate fault that the check must detect: one slot for both.
    assert_eq!(turns(&View { slot: near.slot, ..far.clone() }), [first, second, second, second]);
}

/// Each of those viewers gets its own picture.
#[test]
fn viewers_see_their_own_cameras() {
    for backend in BACKENDS {
        let lights = instances(&[key()]);
        let near = seen(Aov::Beauty);
        let mut far = View { slot: ViewSlot(7), ..near.clone() };
        far.camera.translation *= 2.0;
        let mut shared = renderer_of(backend, &tables());
        for view in [&near, &far, &near, &far] {
            let alone = renderer_of(backend, &tables()).render(view, &lights).unwrap();
            assert_eq!(shared.render(view, &lights).unwrap(), alone);
        }
        assert_ne!(shared.render(&near, &lights).unwrap(), shared.render(&far, &lights).unwrap());
    }
}

/// A light added or removed in the middle leaves the shadow maps of the others, and finds its own again.
#[test]
fn shadow_maps_follow_their_lights() {
    let view = seen(Aov::Beauty);
    let light = |x: f64| spot(DVec3::new(x, 3.0, 0.5), DVec3::ZERO);
    let bent = light::bend(&light(1.0), 2).unwrap();
    let all = instances(&[light(0.0), bent, light(2.0), light(0.5)]);
    let [first, bent, last, late] = &all[..] else { unreachable!("an instance a light") };
    // One more in the middle; two removed; the order reversed; one back at the front.
    let lists: [&[_]; 5] =
        [&[first, bent, last], &[first, late, bent, last], &[late, last], &[last, late], &[bent, last, late]];
    let lists = lists.map(|lights| lights.iter().map(|&light| light.clone()).collect::<Vec<LightInstance>>());
    let runs = steps(lists.iter().map(|lights| (&view, &lights[..])));
    assert_eq!(runs.iter().map(|run| run.shadow).collect::<Vec<_>>(), [3, 1, 0, 0, 0]);

    let mut kept = renderer(&tables());
    let pictures: Vec<Picture> = lists.iter().map(|lights| kept.render(&view, lights).unwrap()).collect();
    for (lights, kept) in lists.iter().zip(&pictures) {
        let lights: Vec<_> = lights.iter().map(|instance| instance.light.light().clone()).collect();
        assert_eq!(*kept, picture(&tables(), &view, &lights));
    }
    // Deliberate fault that the check must detect: a map that stayed at its old index would show another light's
    // shadow.
    assert_ne!(pictures[0], pictures[1]);
}

/// Maps are keyed by light id: two lights with the same position and cone have a map each, and their own colors.
#[test]
fn each_light_has_a_map_of_its_own() {
    let view = seen(Aov::Beauty);
    let red = key().with(COLOR, DVec3::X);
    let blue = key().with(COLOR, DVec3::Z);
    let both = instances(&[red.clone(), blue]);
    let mut kept = renderer(&tables());
    let picture = kept.render(&view, &both).unwrap();
    assert_eq!(kept.counts().shadow, 2);
    let lit = picture.pixels.iter().filter(|p| p[0] > 0.0 || p[2] > 0.0);
    assert!(lit.clone().count() > 50 && lit.clone().all(|p| p[0] == p[2]), "as much of each");
    // Deliberate fault that the check must detect: one color for both.
    let twice = kept.render(&view, &instances(&[red.clone(), red])).unwrap();
    assert!(twice.pixels.iter().any(|p| p[0] != p[2]));
    // Another color needs no other map.
    assert_eq!(kept.counts().shadow, 2);
}

#[test]
fn cached_work_shows_the_new_state() {
    for backend in BACKENDS {
        let view = seen(Aov::Beauty);
        let mut kept = renderer_of(backend, &tables());
        let lights = [
            key(),
            key().with(INTENSITY, 5.0),
            key().with(CONE_ANGLE, 20.0),
            spot(DVec3::new(-1.0, 2.0, 0.5), DVec3::ZERO),
            key(),
        ];
        let mut pictures = Vec::new();
        for light in lights {
            let lights = instances(&[light]);
            let from_kept = kept.render(&view, &lights).unwrap();
            assert_eq!(from_kept, renderer_of(backend, &tables()).render(&view, &lights).unwrap());
            pictures.push(from_kept);
        }
        assert_eq!(pictures[0], pictures[4]);
        // The fault would be a cache that hides a change.
        assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    }
}

#[test]
fn a_failed_scene_leaves_the_one_before() {
    let mut renderer = renderer(&tables());
    let view = seen(Aov::Depth);
    let before = renderer.render(&view, &[]).unwrap();
    let mut huge = tables();
    huge.nodes[0].parent_from_local.translation.x = 1e200;
    assert!(matches!(renderer.set_scene(&scene::pose(huge.clone(), 0.0)), Err(RenderError::TooLarge { .. })));
    assert_eq!(renderer.render(&view, &[]).unwrap(), before);
}

#[test]
fn renderers_share_a_device() {
    let device = device_of(Backend::Wgpu);
    let view = seen(Aov::Depth);
    let mut empty = Renderer::new(&device).unwrap();
    let mut full = renderer(&tables());
    assert!(full.render(&view, &[]).unwrap().pixels.iter().any(|p| p[3] == 1.0));
    assert!(empty.render(&view, &[]).unwrap().pixels.iter().all(|p| *p == [0.0; 4]));
    assert!(!device.name().is_empty());

    // Shared pipelines, but each renderer has its own scene, viewers and counts.
    let mut another = full.with_same_pipelines().unwrap();
    assert_eq!(another.render(&view, &[]).unwrap(), empty.render(&view, &[]).unwrap());
    another.set_scene(&scene::pose(tables(), 0.0)).unwrap();
    assert_eq!(another.render(&view, &[]).unwrap(), full.render(&view, &[]).unwrap());
    assert_eq!(another.counts(), PassCounts { gbuffer: 2, lighting: 2, ..PassCounts::default() });
}

/// Drawing every pipeline once changes no picture.
#[test]
fn warming_up_leaves_the_scene() {
    let mut renderer = renderer(&tables());
    let view = seen(Aov::Beauty);
    let lights = instances(&[key()]);
    let before = renderer.render(&view, &lights).unwrap();
    let counts = renderer.counts();
    renderer.compile_pipelines(|| true).unwrap();
    assert_eq!(renderer.counts(), counts);
    renderer.drop_view(view.slot);
    assert_eq!(renderer.render(&view, &lights).unwrap(), before);
}

/// A map at half scale is separate: the full one stays, serves where half is enough, and is there when full is needed
/// again. Alternating between them draws nothing.
#[test]
fn maps_of_half_a_side_are_cached_beside_full_ones() {
    let mut renderer = renderer(&tables());
    let full = seen(Aov::Beauty);
    let half = View { shadow_map: MapScale::Half, ..full.clone() };
    let mut lights = vec![key(), spot(DVec3::new(-1.0, 3.0, 0.5), DVec3::ZERO)];
    let mut draws = |view: &View, lights: &[Light]| {
        let before = renderer.counts();
        let bytes = renderer.render_display(view, &instances(lights)).unwrap();
        let drawn = since(before, renderer.counts());
        ([drawn.shadow, drawn.layers], bytes)
    };
    let (first, in_full) = draws(&full, &lights);
    assert_eq!(first, [2, 2]);
    let (none, the_same) = draws(&half, &lights);
    assert_eq!(none, [0, 0], "what is there in full is fine enough");
    assert_eq!(the_same, in_full);
    edit(&mut lights, TRANSLATION.to(DVec3::new(1.5, 3.0, 0.5)));
    let (moved, coarse) = draws(&half, &lights);
    assert_eq!(moved, [1, 1], "only the light that moves");
    let (settled, fine) = draws(&full, &lights);
    assert_eq!(settled, [1, 1], "half is not enough for a full picture");
    assert_ne!(coarse, fine, "the edge of its shadow lies otherwise");
    for view in [&half, &full, &half] {
        assert_eq!(draws(view, &lights).0, [0, 0]);
    }
    // The last picture is that of a renderer that has drawn nothing else.
    let alone = |view| self::renderer(&tables()).render_display(view, &instances(&lights)).unwrap();
    assert_eq!(alone(&full), fine);
    assert_ne!(alone(&half), fine);
}
