//! Omni lights. The map has the six faces of a cube around the light.

use glam::{DAffine3, DMat4, DVec3};
use light::{LightProfile, MAX_EXTENT, Omni};
use scene::PosedScene;

use crate::camera::columns;
use crate::gpu_scene::GpuScene;
use crate::map_views::MapViews;
use crate::omni_faces::{CubeFace, FACES, FittedCube};
use crate::shadow_settings::MapSize;
use crate::{ShadowSettings, gpu_structs};

/// Near plane of a shadow map that begins at the source, as a share of the distance to the far end of the scene. It is
/// near enough for a bulb inside its shade.
const NEAR_SHARE: f64 = 1e-3;

/// Omni light in a scene: its uniform, and the projections of its map.
#[derive(Clone, Debug)]
pub(crate) struct GpuOmni {
    pub uniform: gpu_structs::Omni,
    /// Profile of the light, in f64. `uniform` has it in f32.
    pub light_profile: LightProfile,
    pub views: MapViews,
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene; empty if it
/// lights nothing.
pub(crate) fn corners_in_world(omni: &Omni, posed: &PosedScene) -> Vec<DVec3> {
    let source = omni.translation - posed.origin_in_world;
    // The part of the scene's box within the light's range.
    let range = DVec3::splat(omni.range.unwrap_or(f64::INFINITY));
    let (low, high) = ((source - range).max(-posed.half_extent), (source + range).min(posed.half_extent));
    let corner = |k: u32| {
        let pick = |bit: u32, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        let [x, y, z] = [0, 1, 2].map(|axis| pick(axis, low[axis as usize], high[axis as usize]));
        posed.origin_in_world + DVec3::new(x, y, z)
    };
    let corners = if low.cmple(high).all() { 0..8 } else { 0..0 };
    corners.map(corner).collect()
}

pub(crate) fn map_size(shadows: &ShadowSettings) -> MapSize {
    shadows.map_size(FACES)
}

/// Fits the faces of a light's map over `scene`.
pub(crate) fn fit_map(omni: &Omni, scene: &GpuScene, shadows: &ShadowSettings) -> FittedCube {
    FittedCube::new(
        light_from_scene(omni, scene.posed.origin_in_world),
        &scene.casters.clusters,
        f64::from(map_size(shadows).side),
    )
}

fn light_from_scene(omni: &Omni, scene_origin: DVec3) -> DAffine3 {
    let source = omni.translation - scene_origin;
    let matrix3 = omni.rotation.transpose();
    DAffine3 { matrix3, translation: -(matrix3 * source) }
}

impl GpuOmni {
    /// Places a checked light within reach of a scene, with its fitted map.
    pub fn new(omni: &Omni, scene: &GpuScene, shadows: &ShadowSettings, fitted: &FittedCube) -> Self {
        let posed = &scene.posed;
        let light_from_scene = light_from_scene(omni, posed.origin_in_world);
        let source = omni.translation - posed.origin_in_world;
        let far = (source.abs() + posed.half_extent).length();
        let least_distance = (NEAR_SHARE * far).max(f64::MIN_POSITIVE);
        let near = (0.99 * fitted.nearest.min(far)).max(least_distance);
        let view = |face: &CubeFace| face.has_casters.then(|| face.clip_from_light(near));
        let fits = fitted.faces.map(|face| {
            let scale = face.half.recip();
            [face.middle.x, face.middle.y, scale.x, scale.y].map(|x| x as f32)
        });
        let least_distance = least_distance.max(omni.light_profile.min_distance);
        let light_profile = LightProfile { min_distance: least_distance, ..omni.light_profile.clone() };
        Self {
            uniform: gpu_structs::Omni {
                light_from_scene: columns(&DMat4::from(light_from_scene)),
                light_profile: (&light_profile).into(),
                range: omni.range.unwrap_or(0.0).min(2.0 * MAX_EXTENT) as f32,
                shadow_near: near as f32,
                mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
                pad0: 0.0,
                fits,
            },
            light_profile,
            views: MapViews {
                light_from_scene: light_from_scene.into(),
                near: Some(near),
                clip_from_light: fitted.faces.iter().map(view).collect(),
            },
        }
    }
}
