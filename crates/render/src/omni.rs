//! Omni lights. The map has the six faces of a cube around the light.

use glam::{DAffine3, DMat4, DVec3};
use light::{MAX_EXTENT, Omni};
use scene::PosedScene;

use crate::bounds::box_corners;
use crate::camera::columns;
use crate::gpu_scene::GpuScene;
use crate::map_views::{LightUniform, MapViews, PlacedLight, far_distance, near_plane};
use crate::omni_faces::{FACES, FittedCube, clip_from_light};
use crate::{ShadowSettings, gpu_structs};

/// Returns the world positions whose convex hull contains everything that a light can light in a scene; empty if it
/// lights nothing.
pub(crate) fn corners_in_world(omni: &Omni, posed: &PosedScene) -> Vec<DVec3> {
    let source = omni.translation - posed.origin_in_world;
    // The part of the scene's box within the light's range.
    let range = DVec3::splat(omni.range.unwrap_or(f64::INFINITY));
    let (low, high) = ((source - range).max(-posed.half_extent), (source + range).min(posed.half_extent));
    let corners = low.cmple(high).all().then(|| box_corners(low, high));
    corners.into_iter().flatten().map(|corner| posed.origin_in_world + corner).collect()
}

/// Fits the faces of a light's map over `scene`.
pub(crate) fn fit_map(omni: &Omni, scene: &GpuScene, shadows: &ShadowSettings) -> FittedCube {
    FittedCube::new(
        light_from_scene(omni, scene.posed.origin_in_world),
        &scene.casters.clusters,
        f64::from(shadows.map_size(FACES).side),
    )
}

fn light_from_scene(omni: &Omni, scene_origin: DVec3) -> DAffine3 {
    let source = omni.translation - scene_origin;
    let matrix3 = omni.rotation.transpose();
    DAffine3 { matrix3, translation: -(matrix3 * source) }
}

/// Places a checked light within reach of a scene, with its fitted map.
pub(crate) fn placed(omni: &Omni, scene: &GpuScene, shadows: &ShadowSettings, fitted: &FittedCube) -> PlacedLight {
    let light_from_scene = light_from_scene(omni, scene.posed.origin_in_world);
    let far = far_distance(omni.translation, &scene.posed);
    let (near, light_profile) = near_plane(fitted.nearest, far, &omni.light_profile);
    let views = fitted.faces.iter().enumerate();
    let views = views.map(|(index, face)| face.has_casters.then(|| clip_from_light(index, face, near)));
    PlacedLight {
        uniform: LightUniform::Omni(gpu_structs::Omni {
            light_from_scene: columns(&DMat4::from(light_from_scene)),
            light_profile: (&light_profile).into(),
            range: omni.range.unwrap_or(0.0).min(2.0 * MAX_EXTENT) as f32,
            shadow_near: near as f32,
            mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
            pad0: 0.0,
            fits: fitted.faces.map(|face| face.for_uniform()),
        }),
        light_profile,
        views: MapViews {
            light_from_scene: light_from_scene.into(),
            near: Some(near),
            clip_from_light: views.collect(),
        },
    }
}
