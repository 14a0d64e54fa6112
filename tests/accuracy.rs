//! The GPU's pictures are what the reference says they should be: real scenes under a bent light.
//!
//! `BENDYLIGHTS_ACCURACY_SIZE=686x382` compares full pictures, `BENDYLIGHTS_ACCURACY_PICTURES=DIR` keeps the
//! differences as pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bench::compare::{Comparison, Drawn, Expected, Subject};
use bendy::BendyLight;
use glam::DVec3;
use render::{Gpu, Renderer, ShadowSettings};
use scene::{Aov, View, ViewSlot};

/// A scene's file, and control points and radii in the world of a light of three segments that bends strongly.
struct Setting {
    file: &'static str,
    points: [[f64; 3]; 5],
    radii: [f64; 5],
    intensity: f64,
}

const SETTINGS: [Setting; 4] = [
    Setting {
        file: "bench.glb",
        points: [[-2.6, 2.4, 0.9], [-1.9, 3.1, 0.8], [-0.5, 3.5, 0.4], [0.7, 2.2, 0.1], [1.0, -0.8, -0.1]],
        radii: [0.25, 0.5, 0.75, 0.85, 1.5],
        intensity: 4.0,
    },
    Setting {
        file: "vases_bowl.glb",
        points: [[-4.4, 2.0, 1.6], [-3.2, 3.4, 1.5], [-0.9, 4.2, 0.8], [0.3, 2.2, 0.2], [0.5, -1.2, -0.3]],
        radii: [0.4, 0.8, 1.0, 1.25, 2.2],
        intensity: 3.0,
    },
    Setting {
        file: "bedroom.glb",
        points: [[2.4, 1.6, 2.2], [2.0, 2.5, 1.7], [0.7, 3.0, 0.6], [-0.3, 1.6, -0.4], [-0.5, -0.8, -0.8]],
        radii: [0.2, 0.5, 0.7, 0.95, 1.8],
        intensity: 4.0,
    },
    Setting {
        file: "outdoor.glb",
        points: [[-9.0, 6.0, 4.0], [-6.5, 10.0, 3.5], [-1.0, 12.0, 1.5], [1.5, 6.0, -1.0], [1.8, -3.5, -2.0]],
        radii: [0.8, 2.0, 2.4, 3.2, 5.5],
        intensity: 4.0,
    },
];

/// The folder of scenes, or `None` after saying that the test is skipped. Fails instead where `CI=true`.
fn scenes_folder() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets/scenes"));
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(std::env::var("CI").as_deref() != Ok("true"), "{} is missing", folder.display());
    println!("skipped: {} is missing", folder.display());
    None
}

/// Pixels: small enough for every build, or as the environment says.
fn size() -> [u32; 2] {
    let Ok(size) = std::env::var("BENDYLIGHTS_ACCURACY_SIZE") else { return [240, 134] };
    let (width, height) = size.split_once('x').expect("the size is written WIDTHxHEIGHT");
    [width, height].map(|side| side.parse().expect("a side is a number of pixels"))
}

fn subject(folder: &Path, setting: &Setting) -> Subject {
    let scene = assets::load(&folder.join(setting.file)).expect("the scene is sound").scene;
    let [source, ..] = setting.points.map(DVec3::from_array);
    let points = setting.points.map(|point| DVec3::from_array(point) - source).to_vec();
    let mut light = BendyLight::new(points, setting.radii.to_vec());
    light.transform.translation = source;
    light.intensities.fill(setting.intensity);
    let [width, height] = size();
    let camera = scene.cameras[0].clone();
    let view =
        View { camera, width, height, samples: 1, aov: Aov::Beauty, light: 0, slot: ViewSlot::default() };
    Subject::new(setting.file.trim_end_matches(".glb"), scene, light, view)
}

fn compared(renderer: &mut Renderer, subject: &Subject) -> Comparison {
    renderer.set_scene(&subject.scene).expect("the scene fits");
    let drawn = Drawn::new(renderer, subject, ShadowSettings::default()).expect("it can be drawn");
    let expected = Expected::new(subject, || {}).expect("the light is valid");
    let comparison = expected.compare(&drawn);
    if let Ok(folder) = std::env::var("BENDYLIGHTS_ACCURACY_PICTURES") {
        let file = Path::new(&folder).join(format!("{}.png", subject.name));
        expected.panels(&drawn, &comparison).save(file).expect("the picture can be written");
    }
    comparison
}

/// Radiance is right where both see the same surface, and shadows lie where they should.
#[test]
fn pictures_are_what_the_reference_says() {
    let Some(folder) = scenes_folder() else { return };
    let mut renderer = Renderer::new(Arc::new(Gpu::new().expect("a graphics driver"))).expect("a renderer");
    for setting in &SETTINGS {
        let subject = subject(&folder, setting);
        let found = compared(&mut renderer, &subject);
        let told = format!("{}: {}", subject.name, serde_json::to_string(&found).expect("plain data"));
        println!("{told}");
        let pixels = found.pixels;
        assert!(
            found.in_light > pixels / 20 && found.displacement_pixels.count > 30,
            "little to see: {told}"
        );
        assert_eq!(found.not_finite, 0, "{told}");
        assert!(found.silhouettes + found.rim <= pixels / 1000, "more left out than silhouettes: {told}");
        // The bedroom's carpets have two layers in one place; no other scene has.
        assert!(found.coincident == 0 || setting.file == "bedroom.glb", "{told}");
        assert!(found.radiance_rmse <= 1e-3, "{told}");
        assert!(found.displacement_texels.p99 <= 1.5, "{told}");
        assert!(found.missed + found.false_shadow == 0, "{told}");
    }
}
