//! Spotlights. The map has one face, or those of a cube around the light's axis if the light opens wide. They share no
//! code with bent lights, so each can test the other.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use light::parameters::CONE_ANGLE;
use light::{Cone, Light};
use relight::SpotMapParams;
use scene::PosedScene;

use super::cover::FaceCover;
use super::perspective::{PerspectiveFace, PerspectiveFit, far_distance, range_in_f32};
use super::{PlacedStraight, StraightCoords};
use crate::casters::{Clusters, MapCover, OpenSide};
use crate::settings::{MARGIN_TEXELS, SMALLEST_SHARE, ShadowSettings};

/// Largest half angle of a single face, in degrees. With a wider one the texels at its center, where they are widest as
/// angles, would be wider than those of cube faces at half the resolution.
const MAX_FACE_HALF_ANGLE_DEGREES: f64 = 60.0;

/// Matrix from light space to a face's (x, y, depth).
const FRONT: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z);
/// The front of a cube around the light's axis, +x, -x, +y and -y, as in `spot_faces.wgsl`.
const CUBE: [DMat3; 5] = [
    FRONT,
    DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::NEG_Y),
    DMat3::from_cols(DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
    DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
    DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y),
];

/// Returns the number of faces of a light's map.
pub(crate) fn face_count(light: &Light) -> usize {
    if light.get(CONE_ANGLE) > MAX_FACE_HALF_ANGLE_DEGREES { CUBE.len() } else { 1 }
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(cone: &Cone, posed: &PosedScene) -> [DVec3; 5] {
    let end = cone.range.unwrap_or_else(|| far_distance(cone.translation, posed));
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| DVec3::new(x * cone.tan_outer, y * cone.tan_outer, -1.0) * end);
    let [a, b, c, d] = corners.map(|local| cone.translation + cone.rotation * local);
    [cone.translation, a, b, c, d]
}

/// Places a checked light within reach of a scene, with its fitted map.
pub(crate) fn placed(
    cone: &Cone,
    posed: &PosedScene,
    settings: &ShadowSettings,
    fit: &PerspectiveFit,
) -> PlacedStraight {
    let light_from_scene = light_from_scene(cone, posed.origin_in_world);
    let (near, light_profile) = fit.near_plane(far_distance(cone.translation, posed), &cone.light_profile);
    PlacedStraight {
        light_from_scene: light_from_scene.into(),
        source_in_scene: Some(cone.translation - posed.origin_in_world),
        light_profile,
        coords: StraightCoords::Spot {
            tan_outer: cone.tan_outer as f32,
            range: range_in_f32(cone.range),
            map: SpotMapParams {
                near: near as f32,
                mesh_error: settings.mesh_error_in_f32(),
                fits: fit.fits(),
                filter: settings.filter,
            },
        },
        near: Some(near),
        clip_from_light: fit.clip_from_light(near),
    }
}

/// Fits the faces of a light's map to `clusters`.
pub(crate) fn fit_map(
    light: &Light,
    cone: &Cone,
    posed: &PosedScene,
    clusters: &Clusters,
    settings: &ShadowSettings,
) -> PerspectiveFit {
    let side = f64::from(settings.map_size(face_count(light)).side);
    fit_faces(light, side, light_from_scene(cone, posed.origin_in_world), clusters)
}

fn light_from_scene(cone: &Cone, scene_origin: DVec3) -> DAffine3 {
    DAffine3 { matrix3: cone.rotation, translation: cone.translation - scene_origin }.inverse()
}

/// Fits faces of `side` texels to the part of `clusters` that may be in the light.
fn fit_faces(light: &Light, side: f64, light_from_scene: DAffine3, clusters: &Clusters) -> PerspectiveFit {
    let tan_outer = libm::tan(light.get(CONE_ANGLE).to_radians());
    // Casters beyond the edge are drawn as far as the filter reads.
    let grown = side / (side - 2.0 * MARGIN_TEXELS);
    // Straight light that starts inside does not return.
    let source = light_from_scene.inverse().translation;
    let comes_in = |side: &OpenSide| side.height(source) >= 0.0;
    let mut nearest = f64::INFINITY;
    let mut face = |index: usize, axes: DMat3| {
        let (low, high) = match (index, face_count(light)) {
            (0, 1) => (DVec2::splat(-tan_outer), DVec2::splat(tan_outer)),
            (0, _) => (DVec2::NEG_ONE, DVec2::ONE),
            // The cone ends there before the face does.
            _ => (DVec2::new(-1.0, tan_outer.recip()), DVec2::ONE),
        };
        let (middle, widest) = ((low + high) / 2.0, (high - low) / 2.0 * grown);
        let mut cover = FaceCover::EMPTY;
        cover.extend_by_leaves(clusters.casting_trees(clusters.open_sides(comes_in)), |cluster| {
            let corners = cluster.corners().map(|p| axes * light_from_scene.transform_point3(p));
            cover_of_box(&corners, middle - widest, middle + widest)
        });
        nearest = nearest.min(cover.nearest);
        PerspectiveFace { axes, fitted: cover.fitted([low, high], grown, widest.max_element() * SMALLEST_SHARE) }
    };
    let faces = CUBE.into_iter().take(face_count(light)).enumerate().map(|(k, axes)| face(k, axes)).collect();
    PerspectiveFit { faces, nearest }
}

/// Returns the cover of a box with these corners in a face's (x, y, depth), within the slopes `least` to `most`; `None`
/// if no part of it is there.
fn cover_of_box(corners: &[DVec3; 8], least: DVec2, most: DVec2) -> Option<FaceCover> {
    let (min, max) = corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    // Depth on a face is at least the distance from the axis divided by the face's limit.
    let aside = min.max(-max).max(DVec3::ZERO);
    let aside = aside.truncate() / least.abs().max(most.abs());
    let depth = min.z.max(aside.max_element());
    if !(max.z > 0.0 && depth <= max.z) {
        return None;
    }
    let (low, high) = if min.z > 0.0 {
        let slopes = corners.map(|p| p.truncate() / p.z);
        (slopes.into_iter().fold(DVec2::INFINITY, DVec2::min), slopes.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max))
    } else if depth > 0.0 {
        let least = |x: f64| if x > 0.0 { x / max.z } else { x / depth };
        (DVec2::new(least(min.x), least(min.y)), -DVec2::new(least(-max.x), least(-max.y)))
    } else {
        (DVec2::NEG_INFINITY, DVec2::INFINITY)
    };
    let (low, high) = (low.max(least), high.min(most));
    low.cmple(high).all().then_some(FaceCover { low, high, nearest: depth.max(0.0) })
}

#[cfg(test)]
mod tests;
