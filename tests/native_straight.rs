//! The processor's pictures of lights with straight rays are the device's: the same bytes but for one in 255, except
//! along edges of shadows.
//!
//! There the maps of both ways may differ: corners of triangles are rounded to 1/256 of a texel after other roundings
//! of 24 bits, some 1/1000 of a texel of maps thousands of texels wide. So one edge in some thousand falls on the other
//! side of a texel's centre, a pixel looks at four texels or sixteen, and of those beside an edge a hundredth may
//! differ.

mod boxes;

use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use boxes::{looking, room};
use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, CUT_ON, DECAY, DECAY_START,
    DIFFUSE, ENABLE_COLOR_TEMPERATURE, EXPOSURE, FAR_EDGE, HEIGHT, INTENSITY, LIGHT_LINK, NEAR_EDGE, PROFILE,
    PROFILE_POWER, RADIAL_FALLOFF, RANGE, ROTATION, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH,
    SHADOW_COLOR, SHADOW_ENABLE, SHADOW_LINK, SPECULAR, TRANSLATION, WIDTH,
};
use light::{CrossSection, Decay, Light, LightInstance, Links, PeriodicCurve, ProfileCurve};
use render::{Backend, Culling, Gpu, MemoryBudget, Renderer, ShadowFilter, ShadowSettings};
use scene::{Aov, PosedScene, View};

const SIZE: [u32; 2] = [240, 160];
/// Pixels beside an edge that a filter of four texels may reach.
const BESIDE: usize = 2;

/// One renderer a way.
struct Both {
    wgpu: Renderer,
    native: Renderer,
}

static BOTH: LazyLock<Mutex<Both>> = LazyLock::new(|| {
    let renderer = |backend| {
        let gpu = Gpu::open(MemoryBudget::default(), Some(backend)).expect("tests need a graphics driver");
        Renderer::new(Arc::new(gpu)).expect("the device works")
    };
    Mutex::new(Both { wgpu: renderer(Backend::Wgpu), native: renderer(Backend::Native) })
});

/// Where and how a comparison looks.
#[derive(Clone)]
struct Looked {
    scene: Arc<PosedScene>,
    view: View,
    shadows: ShadowSettings,
}

/// What the two ways show of a light.
#[derive(Debug, PartialEq, Eq)]
struct Compared {
    /// Pixels that the light reaches, and that differ by more than 1 of 255 away from edges of shadows, and beside
    /// them.
    lit: usize,
    away: usize,
    beside: usize,
    /// How many pixels are beside an edge of a shadow or of the light.
    edges: usize,
}

impl Compared {
    fn is_the_same(&self) -> bool {
        self.away == 0 && 100 * self.beside <= self.edges
    }
}

fn instances(light: &Light) -> Vec<LightInstance> {
    LightInstance::numbered(vec![light.clone()]).expect("a light")
}

/// Of each pixel, whether the light's volume holds what it sees, and whether a pixel beside it has another visibility.
fn beside_edges(renderer: &mut Renderer, looked: &Looked, light: &Light) -> Vec<(bool, bool)> {
    let view = View { aov: Aov::Visibility, ..looked.view.clone() };
    let picture = renderer.render(&view, &instances(light)).expect("it can be drawn");
    let [width, height] = SIZE.map(|side| side as usize);
    let differs = |pixel: usize| {
        let (x, y) = (pixel % width, pixel / width);
        let columns = x.saturating_sub(BESIDE)..(x + BESIDE + 1).min(width);
        let mut around = (y.saturating_sub(BESIDE)..(y + BESIDE + 1).min(height))
            .flat_map(|y| columns.clone().map(move |x| y * width + x));
        around.any(|other| picture.pixels[other] != picture.pixels[pixel])
    };
    (0..width * height).map(|pixel| (picture.pixels[pixel][0] > 0.0, differs(pixel))).collect()
}

/// Compares `native` as the processor shows it with `wgpu` as the device does, which but for planted faults is the
/// same.
fn compared(looked: &Looked, wgpu: &Light, native: &Light) -> Compared {
    let mut both = BOTH.lock().unwrap_or_else(PoisonError::into_inner);
    let Both { wgpu: device, native: processor } = &mut *both;
    let bytes = |renderer: &mut Renderer, light: &Light| {
        renderer.set_shadow_settings(looked.shadows).expect("settings");
        renderer.set_scene(&looked.scene).expect("it fits");
        renderer.render_display(&looked.view, &instances(light)).expect("it can be drawn")
    };
    let (of_device, of_processor) = (bytes(device, wgpu), bytes(processor, native));
    let known = beside_edges(device, looked, wgpu);
    let mut compared = Compared { lit: 0, away: 0, beside: 0, edges: 0 };
    let pixels = of_device.as_chunks::<4>().0.iter().zip(of_processor.as_chunks::<4>().0);
    for ((a, b), (is_lit, is_edge)) in pixels.zip(known) {
        let differs = a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
        compared.lit += usize::from(is_lit);
        compared.edges += usize::from(is_edge);
        compared.away += usize::from(differs && !is_edge);
        compared.beside += usize::from(differs && is_edge);
    }
    compared
}

fn assert_the_same(name: &str, looked: &Looked, light: &Light) {
    let compared = compared(looked, light, light);
    println!("{name}: {compared:?}");
    assert!(compared.lit > 500, "{name} shows on little: {compared:?}");
    assert!(compared.is_the_same(), "{name}: {compared:?}");
}

fn in_room() -> Looked {
    let eye = DVec3::new(1.2, 3.6, 4.4);
    let view = boxes::view(eye, DVec3::new(-0.3, 0.7, -0.8));
    let view = View { aov: Aov::Beauty, width: SIZE[0], height: SIZE[1], ..view };
    Looked { scene: scene::pose(room()), view, shadows: ShadowSettings::default() }
}

fn in_demo(name: &str) -> Looked {
    let loaded = assets::demo(name).expect("a demo");
    let view = View::beauty(loaded.contents.cameras[0].clone(), SIZE);
    Looked { scene: scene::pose(loaded.scene), view, shadows: ShadowSettings::default() }
}

fn lamp(degrees: f64) -> Light {
    let at = DVec3::new(-1.5, 3.4, 2.2);
    let turned = looking(at, DVec3::new(0.2, 0.4, -0.8), DVec3::Y);
    let lamp = Light::spot().with(TRANSLATION, at).with(ROTATION, turned);
    lamp.with(CONE_ANGLE, degrees).with(INTENSITY, 40.0)
}

/// Between the posts, turned so that no face of its map lies along a wall.
fn bulb() -> Light {
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.5);
    Light::omni().with(TRANSLATION, DVec3::new(0.2, 1.7, 0.1)).with(ROTATION, turned).with(INTENSITY, 10.0)
}

fn sun() -> Light {
    let from = DVec3::new(-1.0, 1.2, 0.6);
    Light::directional().with(ROTATION, looking(from, DVec3::ZERO, DVec3::X)).with(INTENSITY, 2.0)
}

/// The sun through a window, turned about its axis.
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
        // The planted fault: a hundredth of the room's width aside, or half a degree.
        let moved = light.get(TRANSLATION) + DVec3::new(0.1, 0.0, 0.0);
        let turned = light.get(ROTATION) * DQuat::from_rotation_x(0.5_f64.to_radians());
        let other = light.clone().with(TRANSLATION, moved).with(ROTATION, turned);
        let seen = compared(&looked, &light, &other);
        println!("{name} elsewhere: {seen:?}");
        assert!(!seen.is_the_same(), "{name} elsewhere goes unseen: {seen:?}");
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
        let looked = Looked { shadows, ..in_room() };
        for (name, light) in shapes() {
            assert_the_same(&format!("{name}, {setting}"), &looked, &light);
        }
    }
}

#[test]
fn casters_with_holes_throw_the_devices_shadows() {
    let looked = in_demo("arbor");
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
    for demo in ["vases", "arbor"] {
        let looked = in_demo(demo);
        let named = |node: &scene::Node| !node.name.is_empty() && node.mesh.is_some();
        let names: Vec<_> = looked.scene.scene.nodes.iter().filter(|node| named(node)).collect();
        let last = &names.last().expect("a node with a name").name;
        let without = Links::new(vec![], vec![format!("/{last}")]).expect("it names a node");
        let at = DVec3::new(-1.2, 3.0, 1.6);
        let turned = looking(at, DVec3::new(0.0, 0.3, 0.0), DVec3::Y);
        for shape in [Light::spot(), Light::omni(), Light::directional()] {
            let bright = if shape.value(&TRANSLATION).is_some() { 30.0 } else { 2.0 };
            let light = shape.with(TRANSLATION, at).with(ROTATION, turned).with(INTENSITY, bright);
            for linked in [
                light.clone().with(SHADOW_LINK, Some(without.clone())),
                light.with(LIGHT_LINK, Some(without.clone())),
            ] {
                assert_the_same(&format!("{demo} without {last}"), &looked, &linked);
            }
        }
    }
}

/// Each parameter that a layer holds or a sum multiplies it by.
#[test]
fn every_parameter_does_what_it_does_on_the_device() {
    let looked = in_room();
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
        assert_the_same(&format!("spot, {name}"), &looked, &light);
    }
    assert_the_same("omni, range", &looked, &bulb().with(RANGE, Some(2.5)));
    for (name, light) in [("spot", lamp(40.0)), ("omni", bulb())] {
        let cut = light.clone().with(CUT_ON, Some(2.5)).with(NEAR_EDGE, 0.5);
        let cut = cut.with(CUT_OFF, Some(3.5)).with(FAR_EDGE, 0.7);
        for (what, light) in [
            ("linear decay", light.clone().with(DECAY, Decay::Linear).with(INTENSITY, 5.0)),
            ("no decay", light.clone().with(DECAY, Decay::None).with(INTENSITY, 2.0)),
            ("decay start", light.clone().with(DECAY_START, 3.0)),
            ("cut", cut),
        ] {
            assert_the_same(&format!("{name}, {what}"), &looked, &light);
        }
    }
    for (name, light) in shapes() {
        for (what, light) in [
            ("shadow color", light.clone().with(SHADOW_COLOR, DVec3::new(0.4, 0.1, 0.7))),
            ("color", light.clone().with(COLOR, DVec3::new(0.9, 0.4, 0.1)).with(EXPOSURE, 0.7)),
            (
                "temperature",
                light.clone().with(ENABLE_COLOR_TEMPERATURE, true).with(COLOR_TEMPERATURE, 3000.0),
            ),
            ("diffuse", light.clone().with(SPECULAR, 0.0)),
            ("specular", light.clone().with(DIFFUSE, 0.3).with(SPECULAR, 2.0)),
            ("without shadow", light.clone().with(SHADOW_ENABLE, false)),
        ] {
            assert_the_same(&format!("{name}, {what}"), &looked, &light);
        }
    }
}
