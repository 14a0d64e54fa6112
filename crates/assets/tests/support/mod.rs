//! What the tests over whole files share.

use std::path::PathBuf;

use glam::DVec3;
use light::LightKind;
use scene::{Projection, Scene};

/// The folder of test assets, or `None` after saying that the test is skipped. Fails instead where `CI=true`.
pub fn assets_folder() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets"));
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(std::env::var("CI").as_deref() != Ok("true"), "{} is missing", folder.display());
    println!("skipped: {} is missing", folder.display());
    None
}

/// Every promise of the scene document, and every number finite and in its documented domain.
pub fn assert_sound(scene: &Scene, what: &str) {
    scene.check().unwrap_or_else(|error| panic!("{what}: {error}"));
    for primitive in scene.meshes.iter().flat_map(|m| &m.primitives) {
        assert!(
            primitive.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5),
            "{what}: normals are unit"
        );
        assert!(primitive.uvs.iter().all(|uv| uv.is_finite()), "{what}: texture coordinates are finite");
        assert!(primitive.colors.iter().all(|c| c.is_finite()), "{what}: colours are finite");
    }
    for m in &scene.materials {
        let unit = m.base_color.to_array().into_iter().chain([m.metallic, m.roughness]).chain(m.alpha_cutoff);
        assert!(unit.into_iter().all(|x| (0.0..=1.0).contains(&x)), "{what}: {m:?}");
    }
    for posed in scene::pose(scene) {
        let world = |v: &glam::Vec3| posed.world_from_local.transform_point3(v.as_dvec3());
        assert!(posed.primitive.positions.iter().all(|v| world(v).is_finite()), "{what}: world positions");
    }
    for camera in &scene.cameras {
        let axes = camera.world_from_camera().matrix3;
        assert!((axes.determinant() - 1.0).abs() < 1e-9 && axes.is_finite(), "{what}: {camera:?} is rigid");
        let sound = match camera.projection {
            Projection::Perspective { yfov, znear, zfar, .. } => {
                0.0 < yfov
                    && yfov < std::f64::consts::PI
                    && 0.0 < znear
                    && zfar.is_none_or(|zfar| znear < zfar)
            }
            Projection::Orthographic { ymag, znear, zfar, .. } => 0.0 < ymag && 0.0 <= znear && znear < zfar,
        };
        assert!(sound, "{what}: {camera:?}");
    }
    for light in &scene.lights {
        let LightKind::Spot(spot) = &light.kind else { panic!("{what}: glTF has no {light:?}") };
        light::check_spot(spot).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(spot.color.cmpge(DVec3::ZERO).all(), "{what}: {spot:?}");
        assert!(spot.intensity >= 0.0, "{what}: {spot:?}");
    }
}
