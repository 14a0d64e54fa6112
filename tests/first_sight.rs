//! Tests that a scene without lights is bright enough with the default light.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use assets::LoadedScene;
use glam::{DQuat, DVec3};
use light::LightInstance;
use light::parameters::ROTATION;
use render::Renderer;
use scene::{DEFAULT_ASPECT, View, framing_camera};

use crate::pictures::{renderer, shared_asset};

const SIZE: [u32; 2] = [160, 90];

/// Minimum ratio of a lit scene's mean radiance to that of the fill alone.
///
/// The darkest base color in glTF is that of its default material, a metal of roughness 1. If it faces the camera, with
/// the light of pi lux 32 degrees beside it, it reflects `pi D V cos = (1 / 4) / (1 + (1 / cos - 1) / 2)` = 0.23 of its
/// color; from the fill it reflects 0.05 to 0.1. So it is at least 3.3 times as bright as by the fill, and 2 times if
/// half of that light is lost to shadows and surfaces that face away. Matte surfaces are at least twice as bright.
const READABLE: f64 = 2.0;

/// Scene files in a folder and its subfolders.
fn scene_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|e| e == "gltf" || e == "glb");
    let found = entries.map(|path| if path.is_dir() { scene_files(&path) } else { vec![path] });
    found.flatten().filter(is_scene).collect()
}

/// Mean radiance of the visible surfaces, from the scene's first camera or, without one, from the camera that frames
/// it.
fn mean_radiance(renderer: &mut Renderer, loaded: &LoadedScene) -> f64 {
    let posed = scene::pose(loaded.scene.clone(), 0.0);
    let first = loaded.contents.cameras.first().cloned();
    let camera = first.unwrap_or_else(|| framing_camera(&posed.subject_bounds(), DEFAULT_ASPECT));
    let number = |(light, id)| LightInstance { id: light::LightId(id), light };
    let lights: Vec<_> = loaded.contents.lights.iter().map(Arc::clone).zip(0..).map(number).collect();
    renderer.set_scene(&posed).expect("it fits");
    let picture = renderer.render(&View::beauty(camera, SIZE), &lights).expect("it can be drawn");
    let seen: Vec<f64> = (picture.pixels.iter().filter(|pixel| pixel[3] > 0.0))
        .map(|pixel| pixel[..3].iter().copied().map(f64::from).sum::<f64>() / 3.0)
        .collect();
    assert!(seen.len() > 30, "{} pixels are seen", seen.len());
    seen.iter().sum::<f64>() / seen.len() as f64
}

/// The scene with its key light turned by 180 degrees.
fn from_behind(mut lit: LoadedScene) -> LoadedScene {
    for light in &mut lit.contents.lights {
        let turned = light.light().get(ROTATION) * DQuat::from_axis_angle(DVec3::Y, std::f64::consts::PI);
        let light_from_behind = light.light().clone().with(ROTATION, turned);
        *light = Arc::new(light::CheckedLight::new(light_from_behind).expect("it is only turned"));
    }
    lit
}

#[test]
#[ignore = "needs ../shared/assets"]
fn scenes_of_shared_assets_without_lights_are_readable() {
    let mut renderer = renderer();
    let (mut tried, mut dark_from_behind) = (0, 0);
    for path in ["gltf", "scenes"].map(|folder| scene_files(&shared_asset(folder))).concat() {
        let Ok(unlit) = assets::load(&path) else { continue };
        let lit = unlit.clone().with_default_light();
        if lit.contents.lights.len() == unlit.contents.lights.len() {
            continue;
        }
        let by_fill = mean_radiance(&mut renderer, &unlit);
        let gain = mean_radiance(&mut renderer, &lit) / by_fill;
        let gain_from_behind = mean_radiance(&mut renderer, &from_behind(lit)) / by_fill;
        println!("{gain:.1} {gain_from_behind:.1} {}", path.display());
        assert!(gain > READABLE, "{}: {gain} times as bright as by the fill", path.display());
        tried += 1;
        // The planted faults: without the key light the scene is as bright as by the fill alone, a ratio of 1; and a
        // key light that shines into the camera.
        dark_from_behind += usize::from(gain_from_behind < READABLE);
    }
    println!("{tried} scenes, {dark_from_behind} of them dark by a key from behind");
    assert!(tried > 30 && dark_from_behind * 10 > tried * 9, "{tried} {dark_from_behind}");
}
