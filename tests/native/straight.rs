//! Lights with straight rays: every shape, filter and parameter, over alpha-tested casters and with links.

use std::sync::{Arc, LazyLock};

use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, CONE_SOFTNESS, CUT_OFF, CUT_ON, DECAY, DECAY_START, DIFFUSE,
    ENABLE_COLOR_TEMPERATURE, EXPOSURE, FAR_EDGE, HEIGHT, INTENSITY, LIGHT_LINK, NEAR_EDGE, PROFILE, PROFILE_POWER,
    RADIAL_FALLOFF, RANGE, ROTATION, SHADOW_COLOR, SHADOW_ENABLE, SHADOW_LINK, SPECULAR, TRANSLATION, WIDTH,
};
use light::{Decay, Light, Links, PeriodicCurve, ProfileCurve};
use render::{Culling, ShadowFilter, ShadowSettings};
use scene::{Aov, PosedScene, View};

use super::both::{SIZE, ViewedScene, assert_same_and_visible, assert_the_same, compared, demo, with_superellipse};
use crate::boxes::{self, aimed, room, room_view};

/// View of the room of boxes, which is posed once.
pub fn in_room() -> ViewedScene {
    static ROOM: LazyLock<Arc<PosedScene>> = LazyLock::new(|| scene::pose(room(), 0.0));
    let view = View { aov: Aov::Beauty, width: SIZE[0], height: SIZE[1], ..room_view() };
    ViewedScene { scene: Arc::clone(&ROOM), view, shadows: ShadowSettings::default() }
}

fn lamp(degrees: f64) -> Light {
    let lamp = aimed(Light::spot(), DVec3::new(-1.5, 3.4, 2.2), DVec3::new(0.2, 0.4, -0.8));
    lamp.with(CONE_ANGLE, degrees).with(INTENSITY, 40.0)
}

/// Omni light between the posts.
fn bulb() -> Light {
    boxes::bulb(DVec3::new(0.2, 1.7, 0.1), 10.0)
}

fn sun() -> Light {
    boxes::sun(DVec3::new(-1.0, 1.2, 0.6), 2.0)
}

/// Directional light with a window, rotated about its axis.
fn window() -> Light {
    sun().with(TRANSLATION, DVec3::new(0.3, 0.2, -0.4)).with(WIDTH, Some(3.0)).with(HEIGHT, Some(2.0))
}

/// A light of every shape and kind of map.
pub fn shapes() -> [(&'static str, Light); 5] {
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

/// The light above one side of a demo, aimed at it.
fn over_the_demo(light: Light) -> Light {
    aimed(light, DVec3::new(-1.2, 3.0, 1.6), DVec3::new(0.0, 0.3, 0.0))
}

#[test]
fn casters_with_holes_throw_the_devices_shadows() {
    let looked = ViewedScene::at(&demo("arbor"));
    let spot = over_the_demo(Light::spot()).with(INTENSITY, 30.0);
    let lights = [
        ("spot", spot.clone().with(CONE_ANGLE, 30.0)),
        ("wide spot", spot.with(CONE_ANGLE, 75.0)),
        ("omni", over_the_demo(Light::omni()).with(ROTATION, DQuat::IDENTITY).with(INTENSITY, 30.0)),
        ("sun", over_the_demo(Light::directional()).with(TRANSLATION, DVec3::ZERO).with(INTENSITY, 2.0)),
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
        for shape in [Light::spot(), Light::omni(), Light::directional()] {
            let bright = if shape.value(&TRANSLATION).is_some() { 30.0 } else { 2.0 };
            let light = over_the_demo(shape).with(INTENSITY, bright);
            for link in [SHADOW_LINK, LIGHT_LINK] {
                let linked = light.clone().with(link, Some(without.clone()));
                // The planted fault: links that name nothing.
                assert_same_and_visible(&format!("{name} without {last}"), &looked, &light, &linked);
            }
        }
    }
}

/// Each parameter that a layer depends on, or that its sum is multiplied by.
#[test]
fn every_parameter_does_what_it_does_on_the_device() {
    let curve = || PeriodicCurve::new(vec![[0.0, 1.0], [90.0, 0.4], [200.0, 0.9]]).expect("a curve");
    let does_what_it_does =
        |what: &str, plain: &Light, light: &Light| assert_same_and_visible(what, &in_room(), plain, light);
    let spots = [
        ("linear", lamp(40.0).with(PROFILE, ProfileCurve::Linear).with(CONE_SOFTNESS, 0.6)),
        ("power", lamp(40.0).with(PROFILE, ProfileCurve::Power).with(PROFILE_POWER, 2.5)),
        ("cosine", lamp(60.0).with(PROFILE, ProfileCurve::Cosine).with(PROFILE_POWER, 4.0)),
        ("hard", lamp(40.0).with(CONE_SOFTNESS, 0.0)),
        ("superellipse", with_superellipse(lamp(45.0), 0.9, 0.5, 0.4)),
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
