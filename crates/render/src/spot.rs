//! Spotlights, drawn with their own perspective matrix. They share no code with bent lights, so each can test the
//! other.

use glam::{DAffine3, DMat4, DVec3, DVec4};
use light::{Cone, Light, MAX_EXTENT};
use scene::PosedScene;

use crate::camera::columns;
use crate::gpu_scene::GpuScene;
use crate::map_views::{FittedFace, LightUniform, MapViews, PlacedLight, far_distance, near_plane};
use crate::spot_faces::{FittedFaces, SpotFace, face_count};
use crate::{ShadowSettings, gpu_structs};

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(cone: &Cone, posed: &PosedScene) -> [DVec3; 5] {
    let end = cone.range.unwrap_or_else(|| far_distance(cone.translation, posed));
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| DVec3::new(x * cone.tan_outer, y * cone.tan_outer, -1.0) * end);
    let [a, b, c, d] = corners.map(|local| cone.translation + cone.rotation * local);
    [cone.translation, a, b, c, d]
}

/// Places a checked light within reach of a scene, with its fitted map.
pub(crate) fn placed(cone: &Cone, scene: &GpuScene, shadows: &ShadowSettings, fitted: &FittedFaces) -> PlacedLight {
    let light_from_scene = light_from_scene(cone, scene.posed.origin_in_world);
    let far = far_distance(cone.translation, &scene.posed);
    let FittedFaces { faces, nearest } = fitted;
    let (shadow_near, light_profile) = near_plane(*nearest, far, &cone.light_profile);
    let view = |SpotFace { axes, fitted }: &SpotFace| {
        fitted.has_casters.then(|| clip_from_face(fitted, shadow_near) * DMat4::from_mat3(*axes))
    };
    let mut fits = [[0.0; 4]; gpu_structs::SPOT_FACES];
    for (fit, face) in fits.iter_mut().zip(faces) {
        *fit = face.fitted.for_uniform();
    }
    PlacedLight {
        uniform: LightUniform::Spot(gpu_structs::Spot {
            light_from_scene: columns(&DMat4::from(light_from_scene)),
            light_profile: (&light_profile).into(),
            tan_outer: cone.tan_outer as f32,
            range: cone.range.unwrap_or(0.0).min(2.0 * MAX_EXTENT) as f32,
            shadow_near: shadow_near as f32,
            mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
            fits,
        }),
        light_profile,
        views: MapViews {
            light_from_scene: light_from_scene.into(),
            near: Some(shadow_near),
            clip_from_light: faces.iter().map(view).collect(),
        },
    }
}

/// Fits the faces of a light's map over `scene`.
pub(crate) fn fit_map(light: &Light, cone: &Cone, scene: &GpuScene, shadows: &ShadowSettings) -> FittedFaces {
    let side = f64::from(shadows.map_size(face_count(light)).side);
    FittedFaces::new(light, side, light_from_scene(cone, scene.posed.origin_in_world), &scene.casters.clusters)
}

fn light_from_scene(cone: &Cone, scene_origin: DVec3) -> DAffine3 {
    DAffine3 { matrix3: cone.rotation, translation: cone.translation - scene_origin }.inverse()
}

/// Returns the projection with reversed depth, from `near` to infinity.
fn clip_from_face(face: &FittedFace, near: f64) -> DMat4 {
    let (scale, shift) = (face.half.recip(), -face.center / face.half);
    DMat4::from_cols(
        DVec4::X * scale.x,
        DVec4::Y * scale.y,
        DVec4::new(shift.x, shift.y, 0.0, 1.0),
        DVec4::new(0.0, 0.0, near, 0.0),
    )
}
