//! Lights with straight rays: every shape, filter and parameter, over alpha-tested casters and with links.

use std::sync::{Arc, LazyLock};

use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, CUT_ON, DECAY, DECAY_START,
    DIFFUSE, ENABLE_COLOR_TEMPERATURE, EXPOSURE, FAR_EDGE, HEIGHT, INTENSITY, LIGHT_LINK, NEAR_EDGE, PROFILE,
    PROFILE_POWER, RADIAL_FALLOFF, RANGE, ROTATION, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH,
    SHADOW_COLOR, SHADOW_ENABLE, SHADOW_LINK, SPECULAR, TRANSLATION, WIDTH,
};
use light::{CrossSection, Decay, Light, Links, PeriodicCurve, ProfileCurve};
use render::{Culling, ShadowFilter, ShadowSettings};
use scene::{Aov, PosedScene, View};

use super::both::{SIZE, ViewedScene, assert_the_same, compared, demo, differing_pixels};
use crate::boxes::{looking, room, view};

/// View of the room of boxes, which is posed once.
fn in_room() -> ViewedScene {
    static ROOM: LazyLock<Arc<PosedScene>> = LazyLock::new(|| scene::pose(room()));
    let eye = DVec3::new(1.2, 3.6, 4.4);
    let view = view(eye, DVec3::new(-0.3, 0.7, -0.8));
    let view = View { aov: Aov::Beauty, width: SIZE[0], height: SIZE[1], ..view };
    ViewedScene { scene: Arc::clone(&ROOM), view, shadows: ShadowSettings::default() }
}

fn lamp(degrees: f64) -> Light {
    let at = DVec3::new(-1.5, 3.4, 2.2);
    let turned = looking(at, DVec3::new(0.2, 0.4, -0.8), DVec3::Y);
    let lamp = Light::spot().with(TRANSLATION, at).with(ROTATION, turned);
    lamp.with(CONE_ANGLE, degrees).with(INTENSITY, 40.0)
}

/// Omni light between the posts, rotated so that no face of its map is parallel to a wall.
fn bulb() -> Light {
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.5);
    Light::omni().with(TRANSLATION, DVec3::new(0.2, 1.7, 0.1)).with(ROTATION, turned).with(INTENSITY, 10.0)
}

fn sun() -> Light {
    let from = DVec3::new(-1.0, 1.2, 0.6);
    Light::directional().with(ROTATION, looking(from, DVec3::ZERO, DVec3::X)).with(INTENSITY, 2.0)
}

/// Directional light with a window, rotated about its axis.
fn window() -> Light {
    sun().with(TRANSLATION, DVec3::new(0.3, 0.2, -0.4)).with(WIDTH, Some(3.0)).with(HEIGHT, Some(2.0))
}

/// A light of every shape and kind of map.
fn shapes() -> [(&'static str, Light); 5] {
    [("spot", lamp(35.0)), ("wide spot", lamp(75.0)), ("omni", bulb()), ("sun", sun()), ("window", window())]
}

#[test]
fn lights_of_every_shape_show_what_the_device_shows() {
    let looked = in_room();
    for (name, light) in shapes() {
        assert_the_same(name, &looked, &light);
        // The planted fault: a hundredth of the room's width to one side, and half a degree.
        let moved = light.get(TRANSLATION) + DVec3::new(0.1, 0.0, 0.0);
        let turned = light.get(ROTATION) * DQuat::from_rotation_x(0.5_f64.to_radians());
        let other = light.clone().with(TRANSLATION, moved).with(ROTATION, turned);
        let seen = compared(&looked, &light, &other);
        println!("{name} elsewhere: {seen:?}");
        assert!(seen.fault().is_some(), "{name} elsewhere goes unseen: {seen:?}");
    }
}

#[test]
fn every_filter_and_all_that_is_left_out_or_not_shows_what_the_device_shows() {
    let whole = Culling { clusters: false, backs: false, ..Culling::default() };
    let default = ShadowSettings::default();
    let settings = [
        ("nearest", ShadowSettings { filter: ShadowFilter::Nearest, ..default }),
        ("3 x 3", ShadowSettings { filter: ShadowFilter::Pcf3x3, ..default }),
        ("nothing left out", ShadowSettings { culling: whole, ..default }),
        ("simplified casters", ShadowSettings { mesh_error: 0.01, ..default }),
        ("coarse", ShadowSettings { resolution: 256, ..default }),
    ];
    for (setting, shadows) in settings {
        let looked = ViewedScene { shadows, ..in_room() };
        for (name, light) in shapes() {
            assert_the_same(&format!("{name}, {setting}"), &looked, &light);
        }
    }
}

#[test]
fn casters_with_holes_throw_the_devices_shadows() {
    let looked = ViewedScene::at(&demo("arbor"));
    let at = DVec3::new(-1.2, 3.0, 1.6);
    let turned = looking(at, DVec3::new(0.0, 0.3, 0.0), DVec3::Y);
    let spot = Light::spot().with(TRANSLATION, at).with(ROTATION, turned).with(INTENSITY, 30.0);
    let sun = Light::directional().with(ROTATION, turned).with(INTENSITY, 2.0);
    let lights = [
        ("spot", spot.clone().with(CONE_ANGLE, 30.0)),
        ("wide spot", spot.with(CONE_ANGLE, 75.0)),
        ("omni", Light::omni().with(TRANSLATION, at).with(INTENSITY, 30.0)),
        ("sun", sun),
    ];
    for (name, light) in lights {
        assert_the_same(&format!("{name} over the arbor"), &looked, &light);
    }
}

#[test]
fn links_leave_what_they_leave_on_the_device() {
    for name in ["vases", "arbor"] {
        let looked = ViewedScene::at(&demo(name));
        let named = |node: &scene::Node| !node.name.is_empty() && node.mesh.is_some();
        let names: Vec<_> = looked.scene.scene.nodes.iter().filter(|node| named(node)).collect();
        let last = &names.last().expect("a node with a name").name;
        let without = Links::new(vec![], vec![last.clone()]).expect("it names a node");
        let at = DVec3::new(-1.2, 3.0, 1.6);
        let turned = looking(at, DVec3::new(0.0, 0.3, 0.0), DVec3::Y);
        for shape in [Light::spot(), Light::omni(), Light::directional()] {
            let bright = if shape.value(&TRANSLATION).is_some() { 30.0 } else { 2.0 };
            let light = shape.with(TRANSLATION, at).with(ROTATION, turned).with(INTENSITY, bright);
            for linked in [
                light.clone().with(SHADOW_LINK, Some(without.clone())),
                light.clone().with(LIGHT_LINK, Some(without.clone())),
            ] {
                assert_the_same(&format!("{name} without {last}"), &looked, &linked);
                // The planted fault: links that name nothing.
                let changed = differing_pixels(&looked, &light, &linked);
                assert!(changed > 100, "{name}: {last} is left out of {changed} pixels");
            }
        }
    }
}

/// Tests that both pictures of `light` agree, and that they differ visibly from those of `plain`.
fn does_what_it_does(what: &str, plain: &Light, light: &Light) {
    let looked = in_room();
    assert_the_same(what, &looked, light);
    let changed = differing_pixels(&looked, plain, light);
    assert!(changed > 100, "{what}: dropping it goes unseen but for {changed} pixels");
}

/// Each parameter that a layer depends on, or that its sum is multiplied by.
#[test]
fn every_parameter_does_what_it_does_on_the_device() {
    let curve = || PeriodicCurve::new(vec![[0.0, 1.0], [90.0, 0.4], [200.0, 0.9]]).expect("a curve");
    let superellipse = |light: Light| {
        light
            .with(CROSS_SECTION, CrossSection::Superellipse)
            .with(SECTION_WIDTH, 0.9)
            .with(SECTION_HEIGHT, 0.5)
            .with(SECTION_ROUNDNESS, 0.4)
    };
    let spots = [
        ("linear", lamp(40.0).with(PROFILE, ProfileCurve::Linear).with(CONE_SOFTNESS, 0.6)),
        ("power", lamp(40.0).with(PROFILE, ProfileCurve::Power).with(PROFILE_POWER, 2.5)),
        ("cosine", lamp(60.0).with(PROFILE, ProfileCurve::Cosine).with(PROFILE_POWER, 4.0)),
        ("hard", lamp(40.0).with(CONE_SOFTNESS, 0.0)),
        ("superellipse", superellipse(lamp(45.0))),
        ("radial", lamp(45.0).with(RADIAL_FALLOFF, Some(curve()))),
        ("range", lamp(45.0).with(RANGE, Some(4.0))),
        ("without shadow", lamp(75.0).with(SHADOW_ENABLE, false)),
    ];
    for (name, light) in spots {
        let plain = lamp(light.get(CONE_ANGLE));
        does_what_it_does(&format!("spot, {name}"), &plain, &light);
    }
    does_what_it_does("omni, range", &bulb(), &bulb().with(RANGE, Some(2.5)));
    for (name, plain) in [("spot", lamp(40.0)), ("omni", bulb())] {
        let light = || plain.clone();
        let cut = light().with(CUT_ON, Some(2.5)).with(NEAR_EDGE, 0.5);
        for (what, intensity, light) in [
            ("linear decay", 5.0, light().with(DECAY, Decay::Linear)),
            ("no decay", 2.0, light().with(DECAY, Decay::None)),
            ("decay start", 10.0, light().with(DECAY_START, 3.0)),
            ("cut", 40.0, cut.with(CUT_OFF, Some(3.5)).with(FAR_EDGE, 0.7)),
        ] {
            let [plain, light] = [&plain, &light].map(|light| light.clone().with(INTENSITY, intensity));
            does_what_it_does(&format!("{name}, {what}"), &plain, &light);
        }
    }
    for (name, plain) in shapes() {
        let light = || plain.clone();
        for (what, light) in [
            ("shadow color", light().with(SHADOW_COLOR, DVec3::new(0.4, 0.1, 0.7))),
            ("color", light().with(COLOR, DVec3::new(0.9, 0.4, 0.1)).with(EXPOSURE, 0.7)),
            ("temperature", light().with(ENABLE_COLOR_TEMPERATURE, true).with(COLOR_TEMPERATURE, 3000.0)),
            ("diffuse", light().with(SPECULAR, 0.0)),
            ("specular", light().with(DIFFUSE, 0.3).with(SPECULAR, 2.0)),
            ("without shadow", light().with(SHADOW_ENABLE, false)),
        ] {
            does_what_it_does(&format!("{name}, {what}"), &plain, &light);
        }
    }
}
