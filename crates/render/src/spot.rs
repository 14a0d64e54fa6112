//! Spotlights, drawn with their own perspective matrix. They share no code with bent lights, so each can test the
//! other.

use glam::{DAffine3, DMat4, DVec3, DVec4};
use light::{CheckedLight, Cone, Light, LightProfile, MAX_EXTENT};
use scene::PosedScene;

use crate::baked_filter::BakedFilter;
use crate::camera::columns;
use crate::gpu_scene::GpuScene;
use crate::map_views::MapViews;
use crate::shadow_settings::{MapSize, with_filter};
use crate::spot_faces::{self, FittedFaces, SpotFace};
use crate::{ShadowFilter, ShadowSettings, gpu_structs};

/// Near plane of a shadow map that starts inside the scene, as a share of the distance to the scene's far end. It is
/// near enough for a lamp in its shade, and far enough for the map's depths to resolve a thousandth of that distance.
const NEAR_SHARE: f64 = 1e-3;

/// Spotlight in a scene: its uniform, and the projections of its map.
#[derive(Clone, Debug)]
pub(crate) struct GpuSpot {
    pub uniform: gpu_structs::Spot,
    /// Profile of the light, in f64. `uniform` has it in f32.
    pub light_profile: LightProfile,
    pub views: MapViews,
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(cone: &Cone, posed: &PosedScene) -> [DVec3; 5] {
    let end = cone.range.unwrap_or_else(|| far_distance(cone, posed));
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| DVec3::new(x * cone.tan_outer, y * cone.tan_outer, -1.0) * end);
    let [a, b, c, d] = corners.map(|local| cone.translation + cone.rotation * local);
    [cone.translation, a, b, c, d]
}

/// Returns an upper bound of the distance from the light to any point of the scene.
fn far_distance(cone: &Cone, posed: &PosedScene) -> f64 {
    ((cone.translation - posed.origin_in_world).abs() + posed.half_extent).length()
}

impl GpuSpot {
    /// Places a checked light within reach of a scene, with its fitted map.
    pub fn new(cone: &Cone, scene: &GpuScene, shadows: &ShadowSettings, fitted: &FittedFaces) -> Self {
        let light_from_scene = light_from_scene(cone, scene.posed.origin_in_world);
        let far = far_distance(cone, &scene.posed);

        let FittedFaces { faces, nearest } = fitted;
        let least_distance = (NEAR_SHARE * far).max(f64::MIN_POSITIVE);
        let shadow_near = (0.99 * nearest.min(far)).max(least_distance);
        let view = |face: &SpotFace| {
            face.has_casters.then(|| clip_from_face(face, shadow_near) * DMat4::from_mat3(face.axes))
        };
        let mut fits = [[0.0; 4]; gpu_structs::SPOT_FACES];
        for (fit, SpotFace { center, half, .. }) in fits.iter_mut().zip(faces) {
            let scale = half.recip();
            *fit = [center.x, center.y, scale.x, scale.y].map(|x| x as f32);
        }

        let least_distance = least_distance.max(cone.light_profile.min_distance);
        let light_profile = LightProfile { min_distance: least_distance, ..cone.light_profile.clone() };
        Self {
            uniform: gpu_structs::Spot {
                light_from_scene: columns(&DMat4::from(light_from_scene)),
                light_profile: (&light_profile).into(),
                tan_outer: cone.tan_outer as f32,
                range: cone.range.unwrap_or(0.0).min(2.0 * MAX_EXTENT) as f32,
                shadow_near: shadow_near as f32,
                mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
                fits,
            },
            light_profile,
            views: MapViews {
                light_from_scene: light_from_scene.into(),
                near: Some(shadow_near),
                clip_from_light: faces.iter().map(view).collect(),
            },
        }
    }
}

/// Fits the faces of a light's map over `scene`.
pub(crate) fn fit_map(
    (light, cone): (&Light, &Cone),
    scene: &GpuScene,
    shadows: &ShadowSettings,
) -> FittedFaces {
    let side = f64::from(map_size(light, shadows).side);
    FittedFaces::new(
        light,
        side,
        light_from_scene(cone, scene.posed.origin_in_world),
        &scene.casters.clusters,
    )
}

fn light_from_scene(cone: &Cone, scene_origin: DVec3) -> DAffine3 {
    DAffine3 { matrix3: cone.rotation, translation: cone.translation - scene_origin }.inverse()
}

/// Returns the projection with reversed depth, from `near` to infinity.
fn clip_from_face(face: &SpotFace, near: f64) -> DMat4 {
    let (scale, shift) = (face.half.recip(), -face.center / face.half);
    DMat4::from_cols(
        DVec4::X * scale.x,
        DVec4::Y * scale.y,
        DVec4::new(shift.x, shift.y, 0.0, 1.0),
        DVec4::new(0.0, 0.0, near, 0.0),
    )
}

pub(crate) fn map_size(light: &Light, shadows: &ShadowSettings) -> MapSize {
    shadows.map_size(spot_faces::face_count(light))
}

/// Values of a spotlight that are compiled into its lighting pass: the constants of `spot_faces.wgsl` and
/// `shadow_filter.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BakedSpot {
    filter: ShadowFilter,
    /// True if the map has the faces of a cube.
    cube: bool,
    light_profile: BakedFilter,
}

impl BakedSpot {
    pub fn of(light: &CheckedLight, filter: ShadowFilter) -> Self {
        let cube = spot_faces::face_count(light.light()) > 1;
        Self { filter, cube, light_profile: BakedFilter::of(light.light_profile()) }
    }

    #[cfg(test)]
    pub fn all() -> impl Iterator<Item = Self> {
        let [plain, others @ ..] = BakedFilter::samples();
        let with = move |filter| [false, true].map(move |cube| Self { filter, cube, light_profile: plain });
        let other = |light_profile| Self { filter: ShadowFilter::Nearest, cube: false, light_profile };
        ShadowFilter::ALL.into_iter().flat_map(with).chain(others.map(other))
    }

    pub fn into_wgsl(self, wgsl: &str) -> String {
        let Self { filter, cube, light_profile } = self;
        format!("const SHADOW_CUBE = {cube};\n{}", light_profile.into_wgsl(&with_filter(filter, wgsl)))
    }
}
