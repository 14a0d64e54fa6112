//! Tests of `eval --scene` for points that were read from surfaces and rounded.

use assets::LoadedScene;
use glam::DVec3;
use light::Tube;
use protocol::light_file;
use reference::{LinkedNodes, Reference};

use crate::program::{Folder, TRIANGLE, json_of, run};

/// Returns the visibility of the light from each point of a list, as typed; `None` outside the light.
fn visible(folder: &Folder, scene: &str, light: &str, points: &[String], more: &[&str]) -> Vec<Option<bool>> {
    let points = folder.file("points.json", format!("[{}]", points.join(",")));
    let answers = json_of(&[&["eval", light, &points, "--scene", scene], more].concat());
    answers.as_array().expect("an array").iter().map(|answer| answer["visible"].as_bool()).collect()
}

/// Returns deterministic numbers from 0 to 1.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Demo scene, its light, and points on all of its surfaces.
struct Demo {
    reference: Reference,
    tube: Tube<f64>,
    points: Vec<DVec3>,
}

impl Demo {
    fn new(loaded: &LoadedScene) -> Self {
        let light = &loaded.contents.lights[0];
        let reference = Reference::new(scene::pose(loaded.scene.clone(), 0.0));
        let bvh = &reference.bvh;
        let mut seed = 1;
        let points = (0..600).map(|_| {
            let triangle = bvh.triangle((random(&mut seed) * bvh.triangle_count() as f64) as usize);
            let (a, b) = (random(&mut seed).sqrt(), random(&mut seed));
            triangle.position_at(DVec3::new(1.0 - a, a * (1.0 - b), a * b)) + bvh.posed.origin_in_world
        });
        let points = points.collect();
        Self { reference, tube: light.tube().expect("the demo's light is bent").clone(), points }
    }

    fn visible(&self, point: DVec3) -> Option<bool> {
        let place = self.tube.locate(point).point?;
        Some(self.reference.occluding_node(&self.tube, &LinkedNodes::default(), &place, point).is_none())
    }

    /// Returns true if surface points within `distance` of `point` have different answers, as at an edge of a
    /// shadow or of the light.
    fn is_at_edge(&self, point: DVec3, distance: f64) -> bool {
        let mut seed = 7;
        let expected = self.visible(point);
        (0..400).any(|_| {
            let mut around = || DVec3::from_array([0; 3].map(|_| 2.0 * random(&mut seed) - 1.0)) * distance;
            let surface = self.reference.surface_near(point + around(), distance);
            surface.is_some_and(|near| self.visible(near) != expected)
        })
    }
}

fn typed(point: DVec3, decimals: usize) -> String {
    format!("[{:.decimals$}, {:.decimals$}, {:.decimals$}]", point.x, point.y, point.z)
}

/// A point with few decimals has the answer of the surface it was read from.
#[test]
fn rounded_points_have_the_answers_of_their_surface() {
    let scene = assets::demo("vases").expect("the demo");
    let demo = Demo::new(&scene);
    let folder = Folder::new();
    let light = folder.file("light.json", light_file::to_json(scene.contents.lights[0].light()));
    let exact: Vec<_> = demo.points.iter().map(|&point| demo.visible(point)).collect();
    let lit = exact.iter().filter(|visible| **visible == Some(true)).count();
    assert!(lit > 100, "{lit} lit points");
    for (decimals, last_digit) in [(3, 1e-3), (4, 1e-4), (5, 1e-5)] {
        let points: Vec<_> = demo.points.iter().map(|&point| typed(point, decimals)).collect();
        let wrong = |more: &[&str]| {
            let found = visible(&folder, "demo:vases", &light, &points, more);
            let differ = (0..points.len()).filter(|&i| found[i] != exact[i]);
            // The rounded point and the surface nearest to it are each within the precision.
            let precision = 3.0_f64.sqrt() * 0.5 * last_digit;
            differ.filter(|&i| !demo.is_at_edge(demo.points[i], 2.0 * precision)).count()
        };
        assert_eq!(wrong(&[]), 0, "{decimals} decimals");
        // Deliberate fault that the check must detect: each point counts as exact, within a billionth of the light's
        // size.
        let planted = wrong(&["--precision", "0"]);
        println!("{decimals} decimals: {planted} of {lit} lit points wrong where they are taken for exact");
        assert!(planted > lit / 4, "{decimals} decimals: {planted} of {lit}");
    }
}

/// An occluder that is farther away than the precision casts a shadow, however near it is.
#[test]
fn a_thin_thing_before_the_point_shadows_it() {
    let folder = Folder::new();
    let scene = folder.file("scene.gltf", TRIANGLE);
    let light = r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [0.5,0.5,0.5],
        "transform": {"translation": [0, 0, 1]}}"#;
    let light = folder.file("light.json", light);
    // The triangle lies in z = 0, and the light comes from +Z. Three decimals have a precision of 0.00087.
    let cases = [
        ("[0, 0, 0]", true),
        ("[0, 0, -0.0004]", false),
        ("[0, 0, -0.000]", true),
        ("[0.001, 0, -0.0008]", false),
        ("[0.001, 0, -0.001]", false),
        ("[0.001, 0, 0.001]", true),
        ("[0, 0, -0.002]", false),
    ];
    let points = cases.map(|(point, _)| point.to_owned());
    let found = visible(&folder, &scene, &light, &points, &[]);
    assert_eq!(found, cases.map(|(_, visible)| Some(visible)));
    let within =
        |precision: &str| visible(&folder, &scene, &light, &["[0, 0, -0.0004]".into()], &["--precision", precision]);
    assert_eq!((within("0.0005"), within("0.0003")), (vec![Some(true)], vec![Some(false)]));
}

/// Single precision, on the CPU and the GPU, is accurate for points in a scene of a ten-thousandth of the
/// light's size.
#[test]
fn points_of_a_small_scene_under_a_long_light_keep_their_digits() {
    let folder = Folder::new();
    // The light reaches the origin at t = 1/2. It is 20,000 units long and bent, with a radius of 1.2.
    let light = r#"{"type": "bendy", "transform": {"translation": [4500, 9000, 4000]}, "radii": [1.2, 1.2, 1.2],
        "points": [[0, 0, 0], [-4000, -10000, -4000], [-10000, -16000, -8000]]}"#;
    let light = folder.file("light.json", light);
    let mut points: Vec<_> = (0..125).map(|k| [k % 5, k / 5 % 5, k / 25].map(|x| f64::from(x) * 0.4 - 0.8)).collect();
    let located = |points: &[[f64; 3]], on: &str| {
        let points = folder.file("points.json", serde_json::to_string(points).expect("numbers"));
        json_of(&["eval", &light, &points, "--on", on])
    };
    // In world units: across by the radius, along by the light's length.
    let worst = |points: &[[f64; 3]], on: &str| {
        let (found, exact) = (located(points, on), located(points, "f64"));
        let off = |i: usize, field: &str| Some(found[i][field].as_f64()? - exact[i][field].as_f64()?);
        let apart = (0..125).filter_map(|i| Some(off(i, "v")?.hypot(off(i, "w")?) * 1.2 + off(i, "t")?.abs() * 2e4));
        apart.reduce(f64::max).expect("points in the light")
    };
    let near = ["f32", "gpu"].map(|on| worst(&points, on));
    // Deliberate fault that the check must detect: with a point at the light's source, the whole light is used.
    points.push([4500.0, 9000.0, 4000.0]);
    let whole = ["f32", "gpu"].map(|on| worst(&points, on));
    println!("of a scene of 1.6 units: off by {near:?}, in all of the light {whole:?}");
    for (near, whole) in near.into_iter().zip(whole) {
        // Sixteen roundings of about five units: those of the scene and of the radius.
        assert!(near <= 16.0 * 5.0 * 2.0_f64.powi(-24), "{near:e}");
        assert!(whole > 50.0 * near, "{near:e} {whole:e}");
    }
}

#[test]
fn a_precision_is_a_length() {
    let said = |more: &[&str]| run(&[&["eval", "light.json", "--precision"], more].concat()).stderr;
    for bad in ["-1", "inf", "NaN", "fine"] {
        let precision = format!("--precision={bad}");
        let done = run(&["eval", "light.json", &precision, "--scene", "demo:vases"]);
        assert_eq!(done.code, 2);
        assert!(done.stderr.contains("0 or more"), "{}", done.stderr);
    }
    assert!(said(&["1"]).contains("--scene"), "without a scene nothing is in the way");
}
