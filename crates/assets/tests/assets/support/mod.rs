//! Helpers of the tests with whole files.

use std::path::PathBuf;

use assets::LoadedScene;
use glam::DVec3;
use light::LightShape;
use light::parameters::{COLOR, INTENSITY};
use scene::Projection;

/// Returns the folder of test assets beside the checkout. Tests that need it are ignored by default.
pub fn assets_folder() -> PathBuf {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets"));
    assert!(folder.is_dir(), "{} is missing", folder.display());
    folder
}

/// Asserts every promise of the scene document, and that every number is finite and in its documented domain.
pub fn assert_sound(loaded: &LoadedScene, what: &str) {
    let LoadedScene { scene, contents, .. } = loaded;
    scene.check().unwrap_or_else(|error| panic!("{what}: {error}"));
    for primitive in scene.meshes.iter().flat_map(|m| &m.primitives) {
        assert!(primitive.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "{what}: normals are unit");
        assert!(primitive.uvs.iter().all(|uv| uv.is_finite()), "{what}: texture coordinates are finite");
        assert!(primitive.colors.iter().all(|c| c.is_finite()), "{what}: colours are finite");
    }
    for m in &scene.materials {
        let unit = m.base_color.to_array().into_iter().chain([m.metallic, m.roughness]).chain(m.alpha_cutoff);
        assert!(unit.into_iter().all(|x| (0.0..=1.0).contains(&x)), "{what}: {m:?}");
    }
    let posed = scene::pose(scene.clone(), 0.0);
    assert!(posed.origin_in_world.is_finite(), "{what}: the middle of the scene");
    assert!(posed.positions.iter().all(|position| position.is_finite()), "{what}: positions in the scene");
    for camera in &contents.cameras {
        let axes = camera.world_from_camera().matrix3;
        assert!((axes.determinant() - 1.0).abs() < 1e-9 && axes.is_finite(), "{what}: {camera:?} is rigid");
        let sound = match camera.projection {
            Projection::Perspective { yfov, znear, zfar, .. } => {
                0.0 < yfov && yfov < std::f64::consts::PI && 0.0 < znear && zfar.is_none_or(|zfar| znear < zfar)
            }
            Projection::Orthographic { ymag, znear, zfar, .. } => 0.0 < ymag && 0.0 <= znear && znear < zfar,
        };
        assert!(sound, "{what}: {camera:?}");
    }
    for light in contents.lights.iter().map(|light| light.light()) {
        assert!(!matches!(light.shape(), LightShape::Bendy(_)), "{what}: glTF has no {light:?}");
        assert!(light.get(COLOR).cmpge(DVec3::ZERO).all() && light.get(INTENSITY) >= 0.0, "{what}: {light:?}");
    }
}
