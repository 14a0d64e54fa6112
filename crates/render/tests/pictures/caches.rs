//! What is drawn again, and what is not.

use std::sync::Arc;

use glam::DVec3;
use light::SpotLight;
use light::{Light, LightKind};
use render::{Aov, Gpu, PassCounts, Picture, RenderError, Renderer, View, ViewSlot};
use scene::{Material, Scene};

use crate::support::{floor, named, picture, renderer, scene_of, spot, view};

fn tables() -> Scene {
    scene_of([floor(3.0, 0.0), floor(0.5, 1.0)], vec![Material::default()])
}

fn key() -> SpotLight {
    spot(DVec3::new(1.0, 3.0, 0.5), DVec3::ZERO)
}

/// Which passes `change` makes run again.
fn runs(change: impl FnOnce(&mut Renderer, &mut View, &mut Vec<Light>)) -> PassCounts {
    let mut renderer = renderer(&tables());
    let mut view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let mut lights = vec![named(key()), named(spot(DVec3::new(-1.0, 3.0, 0.5), DVec3::ZERO))];
    renderer.render(&view, &lights).unwrap();
    let before = renderer.counts();
    assert_eq!(before, PassCounts { gbuffer: 1, shadow: 2, lighting: 1, display: 0 });
    change(&mut renderer, &mut view, &mut lights);
    renderer.render(&view, &lights).unwrap();
    since(before, renderer.counts())
}

fn since(before: PassCounts, after: PassCounts) -> PassCounts {
    PassCounts {
        gbuffer: after.gbuffer - before.gbuffer,
        shadow: after.shadow - before.shadow,
        lighting: after.lighting - before.lighting,
        display: after.display - before.display,
    }
}

/// Changes the first light.
fn edit(lights: &mut [Light], change: impl FnOnce(&mut SpotLight)) {
    match &mut lights[0].kind {
        LightKind::Spot(spot) => change(spot),
        LightKind::Bendy(_) => unreachable!("the tests' lights are spots"),
    }
}

const LIT: PassCounts = PassCounts { gbuffer: 0, shadow: 0, lighting: 1, display: 0 };

#[test]
fn only_what_changed_is_drawn_again() {
    assert_eq!(runs(|_, _, _| {}), PassCounts::default());
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.intensity = 5.0)), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.color = DVec3::X)), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.cone_softness = 0.5)), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.range = Some(9.0))), LIT);
    let shadow = PassCounts { shadow: 1, ..LIT };
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.transform.translation.x = 1.5)), shadow);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.cone_angle = 20.0)), shadow);
    let gbuffer = PassCounts { gbuffer: 1, ..LIT };
    assert_eq!(runs(|_, view, _| view.camera.translation.x += 0.1), gbuffer);
    assert_eq!(runs(|_, view, _| view.width = 34), gbuffer);
    assert_eq!(runs(|_, view, _| view.camera.name = "other".into()), LIT);
    let everything = PassCounts { gbuffer: 1, shadow: 2, ..LIT };
    assert_eq!(runs(|renderer, _, _| renderer.set_scene(&tables()).unwrap()), everything);
    // Each sample has its own G-buffer, but shadows are drawn once.
    assert_eq!(runs(|_, view, _| view.samples = 4), PassCounts { gbuffer: 4, lighting: 4, ..LIT });
    assert_eq!(runs(|renderer, view, _| renderer.forget(view.slot)), everything);
    // Quantities of the surface need no light, those of a light only that one.
    let one_light = |renderer: &mut Renderer, view: &mut View, lights: &mut Vec<Light>| {
        (view.aov, view.light) = (Aov::T, 1);
        edit(lights, |l| l.cone_angle = 20.0);
        assert_eq!(renderer.render(view, lights).unwrap().pixels.len(), 33 * 21);
    };
    assert_eq!(runs(one_light), LIT);
}

/// Maps are fitted to the scene, whatever the camera sees of it: where only that moves, near to where little is to be
/// seen and back, no map is drawn again, and a picture is that of a renderer that has seen nothing else.
#[test]
fn a_moved_camera_draws_no_map() {
    let wide = SpotLight { cone_angle: 85.0, ..key() };
    let bent = |spot: &SpotLight| Light {
        name: "bent".into(),
        kind: LightKind::Bendy(light::bend(&SpotLight { range: Some(5.0), ..spot.clone() }, 2).unwrap()),
    };
    let lights = [named(key()), bent(&key()), bent(&wide), named(wide)];
    let mut kept = renderer(&tables());
    let eyes = [DVec3::new(2.0, 3.0, 4.0), DVec3::new(0.1, 1.2, 0.1), DVec3::new(-9.0, 4.0, 2.0)];
    for (k, eye) in eyes.into_iter().enumerate() {
        let view = view(eye, DVec3::new(0.3, 0.0, 0.2), [33, 21], Aov::Beauty);
        let drawn = kept.render(&view, &lights).unwrap();
        assert_eq!(kept.counts().shadow, 4, "camera {k}");
        assert_eq!(drawn, picture(&tables(), &view, &lights));
    }
    // The planted fault: a scene that changes has maps of its own.
    kept.set_scene(&scene_of([floor(3.0, 0.0)], vec![Material::default()])).unwrap();
    kept.render(&view(eyes[0], DVec3::ZERO, [33, 21], Aov::Beauty), &lights).unwrap();
    assert_eq!(kept.counts().shadow, 8);
}

/// A light with nothing in it lights nothing and shades nothing, and one whose scene is empty is drawn all the same.
#[test]
fn a_light_with_nothing_in_it_has_an_empty_map() {
    let up = spot(DVec3::new(0.0, 1.5, 0.0), DVec3::new(0.1, 9.0, 0.0));
    let bent = Light { name: "bent".into(), kind: LightKind::Bendy(light::bend(&up, 2).unwrap()) };
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    for light in [named(up), bent] {
        let dark = picture(&tables(), &view, std::slice::from_ref(&light));
        assert!(dark.pixels.iter().all(|pixel| pixel[..3] == [0.0; 3]));
        assert!(picture(&Scene::default(), &view, &[light]).pixels.iter().all(|pixel| *pixel == [0.0; 4]));
    }
}

/// What each picture makes run, in a renderer that has drawn nothing before.
fn steps<'a>(pictures: impl IntoIterator<Item = (&'a View, &'a [Light])>) -> Vec<PassCounts> {
    let mut renderer = renderer(&tables());
    let mut step = |(view, lights): (&View, &[Light])| {
        let before = renderer.counts();
        renderer.render(view, lights).unwrap();
        since(before, renderer.counts())
    };
    pictures.into_iter().map(&mut step).collect()
}

/// Two viewers who move nothing cost each other nothing; in one slot they would.
#[test]
fn viewers_keep_their_pictures() {
    let lights = [[named(key())], [named(SpotLight { intensity: 3.0, ..key() })]];
    let near = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let mut far = View { width: 24, slot: ViewSlot(7), ..near.clone() };
    far.camera.translation *= 2.0;
    let turns = |other: &View| {
        steps([(&near, &lights[0][..]), (other, &lights[0]), (&near, &lights[1]), (other, &lights[1])])
    };
    let first = PassCounts { gbuffer: 1, shadow: 1, ..LIT };
    let second = PassCounts { gbuffer: 1, ..LIT };
    assert_eq!(turns(&far), [first, second, LIT, LIT]);
    // The planted fault: one slot for both.
    assert_eq!(turns(&View { slot: near.slot, ..far.clone() }), [first, second, second, second]);
}

/// The pictures of the viewers above are their own.
#[test]
fn viewers_see_their_own_cameras() {
    let lights = [named(key())];
    let near = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let mut far = View { slot: ViewSlot(7), ..near.clone() };
    far.camera.translation *= 2.0;
    let mut shared = renderer(&tables());
    for view in [&near, &far, &near, &far] {
        assert_eq!(shared.render(view, &lights).unwrap(), picture(&tables(), view, &lights));
    }
    assert_ne!(shared.render(&near, &lights).unwrap(), shared.render(&far, &lights).unwrap());
}

/// A light that comes or goes in the middle leaves the shadow maps of the others, and finds its own again.
#[test]
fn shadow_maps_follow_their_lights() {
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let light = |x: f64| named(spot(DVec3::new(x, 3.0, 0.5), DVec3::ZERO));
    let bent = |x: f64| {
        let spot = spot(DVec3::new(x, 3.0, 0.5), DVec3::ZERO);
        Light { name: "bent".into(), kind: LightKind::Bendy(light::bend(&spot, 2).unwrap()) }
    };
    let lists = [
        vec![light(0.0), bent(1.0), light(2.0)],
        // One more in the middle; two gone; the order turned; one back at the front.
        vec![light(0.0), light(0.5), bent(1.0), light(2.0)],
        vec![light(0.5), light(2.0)],
        vec![light(2.0), light(0.5)],
        vec![bent(1.0), light(2.0), light(0.5)],
    ];
    let runs = steps(lists.iter().map(|lights| (&view, &lights[..])));
    assert_eq!(runs.iter().map(|run| run.shadow).collect::<Vec<_>>(), [3, 1, 0, 0, 0]);

    let mut kept = renderer(&tables());
    let pictures: Vec<Picture> = lists.iter().map(|lights| kept.render(&view, lights).unwrap()).collect();
    for (lights, kept) in lists.iter().zip(&pictures) {
        assert_eq!(*kept, picture(&tables(), &view, lights));
    }
    // The planted fault: a map that stayed at its old place would show another light's shadow.
    assert_ne!(pictures[0], pictures[1]);
}

/// Lights of one place and cone share a map, and keep colours of their own.
#[test]
fn lights_share_a_map() {
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let red = SpotLight { color: DVec3::X, ..key() };
    let blue = SpotLight { color: DVec3::Z, ..key() };
    let both = [named(red.clone()), named(blue)];
    let mut shared = renderer(&tables());
    let picture = shared.render(&view, &both).unwrap();
    assert_eq!(shared.counts().shadow, 1);
    let lit = picture.pixels.iter().filter(|p| p[0] > 0.0 || p[2] > 0.0);
    assert!(lit.clone().count() > 50 && lit.clone().all(|p| p[0] == p[2]), "as much of each");
    // The planted fault: one colour for both.
    let twice = shared.render(&view, &[named(red.clone()), named(red)]).unwrap();
    assert!(twice.pixels.iter().any(|p| p[0] != p[2]));
}

#[test]
fn what_is_kept_shows_the_new_state() {
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let mut kept = renderer(&tables());
    let lights = [
        key(),
        SpotLight { intensity: 5.0, ..key() },
        SpotLight { cone_angle: 20.0, ..key() },
        spot(DVec3::new(-1.0, 2.0, 0.5), DVec3::ZERO),
        key(),
    ];
    let mut pictures = Vec::new();
    for light in lights {
        let lights = [named(light)];
        let from_kept = kept.render(&view, &lights).unwrap();
        assert_eq!(from_kept, renderer(&tables()).render(&view, &lights).unwrap());
        pictures.push(from_kept);
    }
    assert_eq!(pictures[0], pictures[4]);
    // The fault: what was kept hiding a change.
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn a_failed_scene_leaves_the_one_before() {
    let mut renderer = renderer(&tables());
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Depth);
    let before = renderer.render(&view, &[]).unwrap();
    let mut huge = tables();
    huge.nodes[0].parent_from_local.translation.x = 1e200;
    assert!(matches!(renderer.set_scene(&huge), Err(RenderError::TooLarge { .. })));
    assert_eq!(renderer.render(&view, &[]).unwrap(), before);
}

#[test]
fn renderers_share_a_device() {
    let gpu: Arc<Gpu> = crate::support::gpu();
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Depth);
    let mut empty = Renderer::new(Arc::clone(&gpu)).unwrap();
    let mut full = renderer(&tables());
    assert!(full.render(&view, &[]).unwrap().pixels.iter().any(|p| p[3] == 1.0));
    assert!(empty.render(&view, &[]).unwrap().pixels.iter().all(|p| *p == [0.0; 4]));
    assert!(!gpu.adapter_name().is_empty());

    // By the same pipelines, and still each its own scene, viewers and counts.
    let mut another = full.another().unwrap();
    assert_eq!(another.render(&view, &[]).unwrap(), empty.render(&view, &[]).unwrap());
    another.set_scene(&tables()).unwrap();
    assert_eq!(another.render(&view, &[]).unwrap(), full.render(&view, &[]).unwrap());
    assert_eq!(another.counts(), PassCounts { gbuffer: 2, lighting: 2, ..PassCounts::default() });
}

/// Drawing every pipeline once changes nothing that can be seen.
#[test]
fn warming_up_leaves_the_scene() {
    let mut renderer = renderer(&tables());
    let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let before = renderer.render(&view, &[named(key())]).unwrap();
    let counts = renderer.counts();
    renderer.warm(|| true).unwrap();
    assert_eq!(renderer.counts(), counts);
    renderer.forget(view.slot);
    assert_eq!(renderer.render(&view, &[named(key())]).unwrap(), before);
}
