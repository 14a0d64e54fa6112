//! What is drawn again, and what is not.

use std::sync::Arc;

use bendy::SpotLight;
use glam::DVec3;
use render::{Aov, Gpu, PassCounts, RenderError, Renderer};
use scene::{Light, LightKind, Material, Scene};

use crate::support::{floor, named, renderer, scene_of, spot, view};

fn tables() -> Scene {
    scene_of([floor(3.0, 0.0), floor(0.5, 1.0)], vec![Material::default()])
}

fn key() -> SpotLight {
    spot(DVec3::new(1.0, 3.0, 0.5), DVec3::ZERO)
}

/// Which passes `change` makes run again.
fn runs(change: impl FnOnce(&mut Renderer, &mut render::View, &mut Vec<Light>)) -> PassCounts {
    let mut renderer = renderer(&tables());
    let mut view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, [33, 21], Aov::Beauty);
    let mut lights = vec![named(key()), named(SpotLight { intensity: 3.0, ..key() })];
    renderer.render(&view, &lights).unwrap();
    let before = renderer.counts();
    assert_eq!(before, PassCounts { gbuffer: 1, shadow: 2, lighting: 1, display: 0 });
    change(&mut renderer, &mut view, &mut lights);
    renderer.render(&view, &lights).unwrap();
    let after = renderer.counts();
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
    assert_eq!(runs(|_, _, _| {}), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.intensity = 5.0)), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.color = DVec3::X)), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.cone_softness = 0.5)), LIT);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.range = Some(9.0))), LIT);
    let shadow = PassCounts { shadow: 1, ..LIT };
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.transform.translation.x = 1.5)), shadow);
    assert_eq!(runs(|_, _, lights| edit(lights, |l| l.cone_angle = 20.0)), shadow);
    let gbuffer = PassCounts { gbuffer: 1, ..LIT };
    assert_eq!(runs(|_, view, _| view.camera.world_from_camera.translation.x += 0.1), gbuffer);
    assert_eq!(runs(|_, view, _| view.width = 34), gbuffer);
    assert_eq!(runs(|_, view, _| view.camera.name = "other".into()), LIT);
    let everything = PassCounts { gbuffer: 1, shadow: 2, ..LIT };
    assert_eq!(runs(|renderer, _, _| renderer.set_scene(&tables()).unwrap()), everything);
    // Each sample has its own G-buffer, but shadows are drawn once.
    assert_eq!(runs(|_, view, _| view.samples = 4), PassCounts { gbuffer: 4, lighting: 4, ..LIT });
    // Quantities of the surface need no light, those of a light only that one.
    let one_light = |renderer: &mut Renderer, view: &mut render::View, lights: &mut Vec<Light>| {
        (view.aov, view.light) = (Aov::T, 1);
        edit(lights, |l| l.cone_angle = 20.0);
        assert_eq!(renderer.render(view, lights).unwrap().pixels.len(), 33 * 21);
    };
    assert_eq!(runs(one_light), PassCounts { lighting: 2, ..LIT });
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
}
