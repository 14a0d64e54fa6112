//! Compares pictures of both backends with the reference: real scenes and the demo under a bent light.
//!
//! `BENDYLIGHTS_ACCURACY_SIZE=WIDTHxHEIGHT` compares pictures of another size, `BENDYLIGHTS_ACCURACY_PICTURES=DIR`
//! saves the differences as pictures.

use std::sync::LazyLock;

use assets::LoadedScene;
use bench::compare::{Comparison, ComparisonSubject, ExpectedPicture, RenderedSubject};
use glam::DVec3;
use light::parameters::{SPECULAR, TRANSLATION};
use light::{Light, ParameterOwner};
use render::{Backend, Renderer, ShadowSettings};
use scene::View;

use crate::pictures::{alone, compared_size, expected, reduced_culling, renderer_of, save_panels, shared_asset};

/// File of a scene, and control points and radii in world units of a light of three segments with strong bends.
struct AccuracyScene {
    file: &'static str,
    points: [[f64; 3]; 5],
    radii: [f64; 5],
    intensity: f64,
}

const SETTINGS: [AccuracyScene; 4] = [
    AccuracyScene {
        file: "bench.glb",
        points: [[-2.6, 2.4, 0.9], [-1.9, 3.1, 0.8], [-0.5, 3.5, 0.4], [0.7, 2.2, 0.1], [1.0, -0.8, -0.1]],
        radii: [0.25, 0.5, 0.75, 0.85, 1.5],
        intensity: 4.0,
    },
    AccuracyScene {
        file: "vases_bowl.glb",
        points: [[-4.4, 2.0, 1.6], [-3.2, 3.4, 1.5], [-0.9, 4.2, 0.8], [0.3, 2.2, 0.2], [0.5, -1.2, -0.3]],
        radii: [0.4, 0.8, 1.0, 1.25, 2.2],
        intensity: 3.0,
    },
    AccuracyScene {
        file: "bedroom.glb",
        points: [[2.4, 1.6, 2.2], [2.0, 2.5, 1.7], [0.7, 3.0, 0.6], [-0.3, 1.6, -0.4], [-0.5, -0.8, -0.8]],
        radii: [0.2, 0.5, 0.7, 0.95, 1.8],
        intensity: 4.0,
    },
    AccuracyScene {
        file: "outdoor.glb",
        points: [[-9.0, 6.0, 4.0], [-6.5, 10.0, 3.5], [-1.0, 12.0, 1.5], [1.5, 6.0, -1.0], [1.8, -3.5, -2.0]],
        radii: [0.8, 2.0, 2.4, 3.2, 5.5],
        intensity: 4.0,
    },
];

fn light(setting: &AccuracyScene) -> Light {
    let [source, ..] = setting.points.map(DVec3::from_array);
    let points = setting.points.map(|point| DVec3::from_array(point) - source).to_vec();
    Light::bendy(points, setting.radii.to_vec())
        .with(TRANSLATION, source)
        .map_points(|_, point| point.intensity = setting.intensity)
}

fn subject(setting: &AccuracyScene) -> ComparisonSubject {
    let loaded = assets::load(&shared_asset("scenes").join(setting.file)).expect("the scene is sound");
    seen_by_its_camera(setting.file.trim_end_matches(".glb"), loaded, light(setting))
}

/// The demo under its own light.
fn demo() -> ComparisonSubject {
    let loaded = assets::demo("vases").expect("it is one of the demos");
    let light = loaded.contents.lights[0].light().clone();
    assert_eq!(light.owner(), ParameterOwner::Bendy, "the demo's light is bent");
    seen_by_its_camera("demo:vases", loaded, light)
}

fn seen_by_its_camera(name: &str, loaded: LoadedScene, light: Light) -> ComparisonSubject {
    // The size of the table in docs/accuracy.md.
    let view = View::beauty(loaded.contents.cameras[0].clone(), compared_size([686, 382]));
    ComparisonSubject::new(name, loaded.scene, light, view)
}

/// Pictures that several tests compare with. Each is drawn once, since the reference takes longest.
static OF_DEMO: LazyLock<ExpectedPicture> = LazyLock::new(|| expected(demo()));
static OF_SHARED_ASSETS: [LazyLock<ExpectedPicture>; 4] = [
    LazyLock::new(|| expected(subject(&SETTINGS[0]))),
    LazyLock::new(|| expected(subject(&SETTINGS[1]))),
    LazyLock::new(|| expected(subject(&SETTINGS[2]))),
    LazyLock::new(|| expected(subject(&SETTINGS[3]))),
];

fn renderers() -> [(Backend, Renderer); 2] {
    [Backend::Wgpu, Backend::Native].map(|backend| (backend, renderer_of(backend)))
}

/// Tests both backends' pictures of the subject by [`fault`].
fn is_what_the_reference_says(renderers: &mut [(Backend, Renderer)], expected: &ExpectedPicture) {
    let subject = expected.subject();
    for (backend, renderer) in renderers {
        renderer.set_scene(expected.posed()).expect("the scene fits");
        let (drawn, found) = compared_with(renderer, expected, ShadowSettings::default());
        save_panels(&format!("{}-{}", subject.name.replace(':', "-"), backend.name()), expected, &drawn, &found);
        let text = format!("{} by {}: {}", subject.name, backend.name(), text(&found));
        println!("{text}");
        assert_eq!(fault(subject, &found), None, "{text}");
    }
}

/// Compares a picture by a renderer that has the scene.
fn compared_with(
    renderer: &mut Renderer,
    expected: &ExpectedPicture,
    settings: ShadowSettings,
) -> (RenderedSubject, Comparison) {
    let drawn = RenderedSubject::new(renderer, expected.subject(), settings).expect("it can be drawn");
    let comparison = expected.compare(&drawn);
    (drawn, comparison)
}

fn text(found: &Comparison) -> String {
    serde_json::to_string(found).expect("plain data")
}

/// Tests a comparison by the columns of docs/accuracy.md. Returns the first violated one.
fn fault(subject: &ComparisonSubject, found: &Comparison) -> Option<&'static str> {
    let Comparison { pixels, .. } = *found;
    // The bedroom's carpets have two coincident layers; no other scene has.
    let may_coincide = subject.name == "bedroom";
    let faults = [
        (found.in_light <= pixels / 20 || found.displacement_pixels.count <= 30, "little to see"),
        (found.not_finite > 0, "numbers that are not finite"),
        (found.silhouettes + found.rim > pixels / 1000, "more left out than silhouettes"),
        (found.coincident > 0 && !may_coincide, "two surfaces in one place"),
        // Normals are packed to 2^-15, and at grazing light a cosine of 0.03 is off by a thousandth with them.
        (found.radiance_rmse > 1e-3, "another radiance"),
        (found.displacement_texels.p99 > 1.5, "edges more than 1.5 texels beside their place"),
        // A texel is half a pixel or less: 686 pixels show two or three radii, 2048 texels two.
        (found.displacement_pixels.p99 > 0.5, "edges more than half a pixel beside their place"),
        (found.missed + found.false_shadow > 0, "wrong far from an edge on the map"),
        (found.off_edge > 0, "wrong far from an edge in the picture"),
    ];
    faults.into_iter().find_map(|(wrong, what)| wrong.then_some(what))
}

/// Radiance is correct where both see the same surface, and shadows are at the right position.
#[test]
#[ignore = "needs ../shared/assets"]
fn pictures_of_shared_assets_are_what_the_reference_says() {
    let mut renderers = renderers();
    for expected in &OF_SHARED_ASSETS {
        is_what_the_reference_says(&mut renderers, expected);
    }
}

#[test]
fn pictures_of_the_demo_are_what_the_reference_says() {
    is_what_the_reference_says(&mut renderers(), &OF_DEMO);
}

/// Planted: casters that deviate from the scene by two hundredths of a unit, and a highlight without its factor.
#[test]
fn casters_with_errors_and_highlights_left_out_are_seen() {
    let expected = &*OF_DEMO;
    let subject = expected.subject();
    let simplified = ShadowSettings { mesh_error: 0.02, ..ShadowSettings::default() };
    let without = alone(&subject.light.clone().with(SPECULAR, 0.0));
    for (backend, mut renderer) in renderers() {
        renderer.set_scene(expected.posed()).expect("the scene fits");
        let (_, found) = compared_with(&mut renderer, expected, simplified);
        println!("{backend:?} simplified: {}", text(&found));
        assert!(fault(subject, &found).is_some(), "{backend:?}: casters with errors go unseen: {found:?}");
        let drawn = RenderedSubject::under(&mut renderer, subject, &without, ShadowSettings::default());
        let found = expected.compare(&drawn.expect("it can be drawn"));
        assert_eq!(fault(subject, &found), Some("another radiance"), "{backend:?}: {found:?}");
    }
}

/// Culling changes no pixel but where it changes the maps: with each kind of culling off, the pictures are the same to the
/// bit, or have no more errors.
fn looks_the_same_without_culling(renderers: &mut [(Backend, Renderer)], expected: &ExpectedPicture) {
    let subject = expected.subject();
    for (backend, renderer) in renderers {
        let name = format!("{} by {}", subject.name, backend.name());
        renderer.set_scene(expected.posed()).expect("the scene fits");
        let mut drawn = |settings| RenderedSubject::new(renderer, subject, settings).expect("it can be drawn");
        let usual = drawn(ShadowSettings::default());
        for (what, culling) in reduced_culling() {
            let drawn = drawn(ShadowSettings { culling, ..ShadowSettings::default() });
            if culling.sides {
                assert!(is_the_same_to_the_bit(&drawn, &usual), "{name} without {what}");
            } else {
                // With floors in them, maps are fitted to larger boxes. Their texels differ, and edges are off within those.
                let found = expected.compare(&drawn);
                println!("{name} without {what}: {}", text(&found));
                assert_eq!(fault(subject, &found), None, "{name} without {what}");
            }
        }
        // The planted fault: maps with slightly larger texels.
        let coarse = ShadowSettings { resolution: 2000, ..ShadowSettings::default() };
        assert!(!is_the_same_to_the_bit(&drawn(coarse), &usual), "{name}");
    }
}

fn is_the_same_to_the_bit(a: &RenderedSubject, b: &RenderedSubject) -> bool {
    fn bits(drawn: &RenderedSubject) -> impl Iterator<Item = u32> {
        let RenderedSubject { beauty, depth, normal, visibility, fine_visibility, .. } = drawn;
        let pictures = [beauty, depth, normal, visibility, fine_visibility].into_iter();
        pictures.flat_map(|picture| picture.pixels.as_flattened().iter().map(|value| value.to_bits()))
    }
    bits(a).eq(bits(b))
}

#[test]
fn culling_in_the_demo_changes_nothing() {
    looks_the_same_without_culling(&mut renderers(), &OF_DEMO);
}

#[test]
#[ignore = "needs ../shared/assets"]
fn culling_in_shared_assets_changes_nothing() {
    let mut renderers = renderers();
    for expected in &OF_SHARED_ASSETS {
        looks_the_same_without_culling(&mut renderers, expected);
    }
}

/// Nothing pops while a control point is dragged: each frame is correct where light grazes the neck of the goblet.
#[test]
#[ignore = "needs ../shared/assets"]
fn nothing_pops_while_a_light_is_dragged_in_shared_assets() {
    let still = subject(&SETTINGS[1]);
    let mut renderers = renderers();
    for step in 1..=4 {
        let mut dragged = still.clone();
        let points = dragged.light.points_mut().expect("it is bent");
        points[3].position += DVec3::new(0.02, -0.01, 0.015) * f64::from(step);
        println!("step {step}");
        is_what_the_reference_says(&mut renderers, &expected(dragged));
    }
}
