//! Moving pictures that the processor lights are those that the graphics device does.
//!
//! Both start from one G-buffer and draw their own maps. What they share, and what these tests can tell: ARCHITECTURE.md,
//! "The native path".

use std::path::PathBuf;
use std::sync::Arc;

use assets::Loaded;
use glam::DVec3;
use light::parameters::{
    CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, CUT_ON, DECAY, DIFFUSE, DIRECTION, END_MODE, FAR_EDGE,
    FRAME, LIGHT_LINK, NEAR_EDGE, PROFILE, PROFILE_POWER, RADIAL_FALLOFF, SECTION_HEIGHT, SECTION_ROUNDNESS,
    SECTION_WIDTH, SHADOW_COLOR, SHADOW_ENABLE, SHADOW_LINK, SPECULAR, TRANSLATION,
};
use light::{
    CheckedLight, CrossSection, Decay, Direction, EndMode, Frame, Light, LightId, LightInstance, Links,
    PeriodicCurve, ProfileCurve,
};
use render::{Aov, Backend, Gpu, MemoryBudget, Renderer, ShadowFilter, ShadowSettings, View};
use scene::Scene;

/// Pixels of each picture.
const SIZE: [u32; 2] = [343, 191];

/// Both ways to make a picture.
struct Both {
    wgpu: Renderer,
    native: Renderer,
    view: View,
}

/// How the pictures of both differ.
#[derive(Debug)]
struct Difference {
    /// Pixels of the picture with some light in them.
    lit: usize,
    /// Pixels at edges of shadows.
    at_edges: usize,
    /// Pixels there that differ by more than 1 of 255.
    off_at_edges: usize,
    /// Pixels elsewhere that do.
    off: usize,
}

impl Difference {
    /// What is wrong with it, or nothing.
    ///
    /// Roundings apart, both compute the same, so that of 255 steps they may differ by one. At an edge a texel of the map may
    /// have another triangle: both rasterisers move corners to 1/256 of a texel, from places that differ in their last bits. A
    /// corner that lies so near to where rounding turns is moved the other way: one coordinate in some thousand, and then one
    /// of hundreds of centres changes sides. One pixel in a thousand is more than was ever seen.
    fn fault(&self) -> Option<&'static str> {
        if self.lit < 2000 {
            return Some("little to see");
        }
        if self.off > 0 {
            return Some("they differ far from edges of shadows");
        }
        (self.off_at_edges > 1 + self.at_edges / 1000)
            .then_some("they differ in many places at edges of shadows")
    }
}

fn renderer(backend: Backend, scene: &Scene) -> Renderer {
    let gpu = Gpu::open(MemoryBudget::default(), Some(backend)).expect("there is a device");
    let mut renderer = Renderer::new(Arc::new(gpu)).expect("it starts");
    renderer.set_scene(&scene::pose(scene.clone())).expect("the scene fits");
    renderer
}

fn instances(lights: &[Light]) -> Vec<LightInstance> {
    let checked = |light: &Light| Arc::new(CheckedLight::new(light.clone()).expect("the light is sound"));
    lights
        .iter()
        .zip(0..)
        .map(|(light, id)| LightInstance { id: LightId(id), light: checked(light) })
        .collect()
}

impl Both {
    fn new(loaded: &Loaded) -> Self {
        let camera = loaded.contents.cameras[0].clone();
        Self {
            wgpu: renderer(Backend::Wgpu, &loaded.scene),
            native: renderer(Backend::Native, &loaded.scene),
            view: View::beauty(camera, SIZE),
        }
    }

    fn set(&mut self, shadows: ShadowSettings) {
        self.wgpu.set_shadow_settings(shadows).expect("they are sound");
        self.native.set_shadow_settings(shadows).expect("they are sound");
    }

    /// How the processor's picture under `ours` differs from the device's under `lights`.
    fn difference_of(&mut self, lights: &[Light], ours: &[Light]) -> Difference {
        let (lights, ours) = (instances(lights), instances(ours));
        let wgpu = self.wgpu.render_display(&self.view, &lights).expect("it can be drawn");
        let native = self.native.render_display(&self.view, &ours).expect("it can be drawn");
        let dark = self.wgpu.render_display(&self.view, &[]).expect("it can be drawn");
        let edges = self.edges(&lights);
        let mut found = Difference { lit: 0, at_edges: 0, off_at_edges: 0, off: 0 };
        let pixels = wgpu.chunks(4).zip(native.chunks(4)).zip(dark.chunks(4)).zip(edges);
        for (((wgpu, native), dark), is_edge) in pixels {
            let most = wgpu.iter().zip(native).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
            found.lit += usize::from(wgpu != dark);
            found.at_edges += usize::from(is_edge);
            found.off_at_edges += usize::from(is_edge && most > 1);
            found.off += usize::from(!is_edge && most > 1);
        }
        found
    }

    fn difference(&mut self, lights: &[Light]) -> Difference {
        self.difference_of(lights, lights)
    }

    /// Which pixels lie within two pixels of where a light's visibility changes.
    fn edges(&mut self, lights: &[LightInstance]) -> Vec<bool> {
        let [width, height] = SIZE.map(|side| side as usize);
        let mut edges = vec![false; width * height];
        for index in 0..lights.len() {
            let view = View { aov: Aov::Visibility, light: index, ..self.view.clone() };
            let Ok(picture) = self.wgpu.render(&view, lights) else { continue };
            let seen = |x: usize, y: usize| picture.pixels[y * width + x][0];
            for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
                let rows = y.saturating_sub(2)..(y + 3).min(height);
                let around = || {
                    rows.clone().flat_map(|y| (x.saturating_sub(2)..(x + 3).min(width)).map(move |x| (x, y)))
                };
                edges[y * width + x] |=
                    around().any(|(other_x, other_y)| seen(other_x, other_y) != seen(x, y));
            }
        }
        edges
    }
}

fn through<const N: usize>(points: [[f64; 3]; N], radii: [f64; N]) -> Light {
    let points = points.map(DVec3::from_array);
    let from_source = points.iter().map(|point| *point - points[0]).collect();
    Light::bendy(from_source, radii.to_vec())
        .with(TRANSLATION, points[0])
        .with_points(|_, point| point.intensity = 4.0)
}

fn demo(name: &str) -> Loaded {
    assets::demo(name).expect("it is one of the demos")
}

/// The demo's light, with what it is called by.
fn key(loaded: &Loaded) -> Light {
    loaded.contents.lights[0].light().clone()
}

/// `light` in many ways: each parameter that a layer or a map depends on has another value in one of them at least.
fn varied(light: &Light) -> Vec<(&'static str, Light)> {
    let with = || light.clone();
    let without = |names: &[&str]| Links::new(Vec::new(), names.iter().map(ToString::to_string).collect());
    let radial = PeriodicCurve::new(vec![[10.0, 1.0], [120.0, 0.5], [250.0, 0.8]]).expect("it is sound");
    let section = |roundness: f64| {
        with()
            .with(CROSS_SECTION, CrossSection::Superellipse)
            .with(SECTION_WIDTH, 0.8)
            .with(SECTION_HEIGHT, 0.5)
            .with(SECTION_ROUNDNESS, roundness)
    };
    vec![
        ("inverse square", with().with(DECAY, Decay::InverseSquare)),
        ("linear decay", with().with(DECAY, Decay::Linear)),
        (
            "cut",
            with().with(CUT_ON, Some(3.0)).with(NEAR_EDGE, 1.0).with(CUT_OFF, Some(4.5)).with(FAR_EDGE, 0.7),
        ),
        ("hard", with().with(CONE_SOFTNESS, 0.0)),
        ("linear profile", with().with(PROFILE, ProfileCurve::Linear)),
        ("power", with().with(PROFILE, ProfileCurve::Power).with(PROFILE_POWER, 3.0)),
        ("cosine", with().with(PROFILE, ProfileCurve::Cosine).with(PROFILE_POWER, 2.0)),
        ("wide angle", with().with(CONE_ANGLE, 80.0)),
        ("rectangle", section(0.0)),
        ("rounded", section(0.4)),
        ("radial", with().with(RADIAL_FALLOFF, Some(radial))),
        ("shadow color", with().with(SHADOW_COLOR, DVec3::new(0.1, 0.2, 0.6))),
        ("no shadow", with().with(SHADOW_ENABLE, false)),
        ("scattered", with().with(SPECULAR, 0.0)),
        ("mirrored", with().with(DIFFUSE, 0.0)),
        ("path", with().with(DIRECTION, Direction::Path)),
        ("up", with().with(FRAME, Frame::Up)),
        ("extended", with().with(END_MODE, EndMode::Extend)),
        ("lights some", with().with(LIGHT_LINK, without(&["orange vase", "leaves"]))),
        ("shadows of some", with().with(SHADOW_LINK, without(&["blue vase", "leaves"]))),
    ]
}

/// Holds both pictures of each light to each other.
fn look_the_same<'a>(both: &mut Both, lights: impl IntoIterator<Item = (&'a str, Light)>) {
    for (what, light) in lights {
        let found = both.difference(std::slice::from_ref(&light));
        println!("{what}: {found:?}");
        assert_eq!(found.fault(), None, "{what}: {found:?}");
    }
}

#[test]
fn a_bent_light_looks_the_same() {
    for (name, _) in assets::DEMO_NAMES {
        let loaded = demo(name);
        let light = key(&loaded);
        let mut both = Both::new(&loaded);
        look_the_same(&mut both, [(*name, light.clone())]);
        look_the_same(&mut both, varied(&light));
        // The planted fault: a light that stands a hand's breadth aside.
        let aside = light.clone().with(TRANSLATION, light.get(TRANSLATION) + DVec3::X * 0.05);
        let found = both.difference_of(&[light], &[aside]);
        assert!(found.fault().is_some(), "{name} with the light aside: {found:?}");
    }
}

#[test]
fn shadows_are_filtered_alike() {
    let loaded = demo("vases");
    let light = key(&loaded);
    let mut both = Both::new(&loaded);
    for filter in ShadowFilter::ALL {
        for resolution in [64, 300, 512, 2048] {
            both.set(ShadowSettings { filter, resolution, ..ShadowSettings::default() });
            look_the_same(&mut both, [(format!("{filter:?} {resolution}").as_str(), light.clone())]);
        }
    }
}

/// Lights of one segment to eight, and one that opens so wide that its map has five faces.
#[test]
fn any_number_of_segments_looks_the_same() {
    let loaded = demo("vases");
    let mut both = Both::new(&loaded);
    let spot = light::straighten(&key(&loaded)).expect("the demo's light can be");
    for segments in [1, 2, 4, 6, 8] {
        let light = light::bend_to(&spot, segments, 6.0).expect("it can be bent");
        let bowed = light.with_points(|index, point| {
            point.position.x += 0.1 * (index * (segments + 1 - index)) as f64 / 4.0;
        });
        look_the_same(&mut both, [(format!("{segments} segments").as_str(), bowed)]);
    }
    let wide =
        through([[0.0, 1.6, 0.3], [0.0, 1.2, 0.3], [0.1, 0.4, 0.3], [0.1, -0.6, 0.3]], [0.05, 1.0, 3.0, 6.0]);
    look_the_same(&mut both, [("wide", wide)]);
}

fn scenes_folder() -> PathBuf {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets/scenes"));
    assert!(folder.is_dir(), "{} is missing", folder.display());
    folder
}

#[test]
#[ignore = "needs ../shared/assets"]
fn shared_assets_look_the_same() {
    let bent = |size: f64| {
        let points =
            [[-2.6, 2.4, 0.9], [-1.9, 3.1, 0.8], [-0.5, 3.5, 0.4], [0.7, 2.2, 0.1], [1.0, -0.8, -0.1]];
        let points = points.map(|point| point.map(|x: f64| size * x));
        through(points, [0.25, 0.5, 0.75, 0.85, 1.5].map(|radius: f64| size * radius))
    };
    // Of a wood as much is to be seen as of a room.
    for (file, size) in
        [("bench.glb", 1.0), ("vases_bowl.glb", 1.5), ("bedroom.glb", 1.0), ("outdoor.glb", 3.5)]
    {
        let loaded = assets::load(&scenes_folder().join(file)).expect("the scene is sound");
        let mut both = Both::new(&loaded);
        look_the_same(&mut both, [(file, bent(size))]);
    }
}

/// The picture of the demo as this process has it, and by how many threads.
fn shown_here() -> (Vec<u8>, usize) {
    let loaded = demo("vases");
    let mut native = renderer(Backend::Native, &loaded.scene);
    let view = View::beauty(loaded.contents.cameras[0].clone(), SIZE);
    let bytes = native.render_display(&view, &instances(&[key(&loaded)])).expect("it can be drawn");
    (bytes, threads_that_relight())
}

#[test]
#[ignore = "the child of any_number_of_threads_shows_the_same_bytes"]
fn child_that_shows_the_demo() {
    let (bytes, threads) = shown_here();
    println!("shown {} by {threads} threads", format!("{bytes:?}").replace(' ', ""));
}

/// How many threads of this process relight.
fn threads_that_relight() -> usize {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux tells");
    let names = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    names.filter(|name| name.starts_with("relight")).count()
}

#[test]
fn any_number_of_threads_shows_the_same_bytes() {
    let with = |threads: &str| {
        let program = std::env::current_exe().expect("it runs");
        let output = std::process::Command::new(program)
            .args(["--ignored", "--exact", "child_that_shows_the_demo", "--nocapture"])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .expect("it starts");
        let text = String::from_utf8(output.stdout).expect("text");
        let line = text.lines().find(|line| line.contains("shown ")).expect("it says what it shows");
        assert!(line.ends_with(&format!("by {threads} threads")), "{}", &line[line.len() - 30..]);
        line.split(' ').skip_while(|word| *word != "shown").nth(1).expect("bytes").to_owned()
    };
    let one = with("1");
    assert!(one.matches(',').count() + 1 == 4 * 343 * 191 && one.contains(",77,"), "no picture");
    for threads in ["2", "3", "8"] {
        assert!(with(threads) == one, "{threads} threads show something else");
    }
}

/// Another process, so that no other test has started any.
#[test]
#[ignore = "the child of where_the_device_draws_no_thread_relights"]
fn child_that_lets_the_device_draw() {
    let loaded = demo("vases");
    let view = View::beauty(loaded.contents.cameras[0].clone(), [64, 36]);
    renderer(Backend::Wgpu, &loaded.scene)
        .render_display(&view, &instances(&[key(&loaded)]))
        .expect("it can be drawn");
    assert_eq!(threads_that_relight(), 0);
}

#[test]
fn where_the_device_draws_no_thread_relights() {
    let program = std::env::current_exe().expect("it runs");
    let mut child = std::process::Command::new(program);
    child.args(["--ignored", "--exact", "child_that_lets_the_device_draw"]);
    assert!(child.status().expect("it starts").success());
}
