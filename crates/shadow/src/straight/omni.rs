//! Omni lights. The map has the six faces of a cube around the light.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use light::Omni;
use relight::OmniMapParams;
use scene::PosedScene;

use super::cover::FaceCover;
use super::perspective::{PerspectiveFace, PerspectiveFit, far_distance, range_in_f32};
use super::{PlacedStraight, StraightCoords};
use crate::bounds::box_corners;
use crate::casters::{ClusterBounds, Clusters, MapCover, OpenSide};
use crate::settings::{MARGIN_TEXELS, SMALLEST_SHARE, ShadowSettings};

/// Number of faces: +x, -x, +y, -y, +z and -z in the light's axes, as in `omni_lookup.wgsl`.
pub(crate) const FACES: usize = 6;

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

/// Fits the faces of a light's map to `clusters`.
pub(crate) fn fit_map(
    omni: &Omni,
    posed: &PosedScene,
    clusters: &Clusters,
    settings: &ShadowSettings,
) -> PerspectiveFit {
    let side = f64::from(settings.map_size(FACES).side);
    fit_faces(light_from_scene(omni, posed.origin_in_world), clusters, side)
}

fn light_from_scene(omni: &Omni, scene_origin: DVec3) -> DAffine3 {
    let source = omni.translation - scene_origin;
    let matrix3 = omni.rotation.transpose();
    DAffine3 { matrix3, translation: -(matrix3 * source) }
}

/// Places a checked light within reach of a scene, with its fitted map.
pub(crate) fn placed(
    omni: &Omni,
    posed: &PosedScene,
    settings: &ShadowSettings,
    fit: &PerspectiveFit,
) -> PlacedStraight {
    let (near, light_profile) = fit.near_plane(far_distance(omni.translation, posed), &omni.light_profile);
    PlacedStraight {
        light_from_scene: light_from_scene(omni, posed.origin_in_world).into(),
        source_in_scene: Some(omni.translation - posed.origin_in_world),
        light_profile,
        coords: StraightCoords::Omni {
            range: range_in_f32(omni.range),
            map: OmniMapParams {
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

/// Returns the indices of the light axes that point right and up on a face, and the index and sign of the axis that
/// points ahead.
fn axes(index: usize) -> ([usize; 2], usize, f64) {
    let ahead = index / 2;
    ([(ahead + 1) % 3, (ahead + 2) % 3], ahead, if index.is_multiple_of(2) { 1.0 } else { -1.0 })
}

/// Returns the matrix from light space to a face's (right, up, ahead).
fn face_from_light(index: usize) -> DMat3 {
    let ([right, up], ahead, sign) = axes(index);
    let mut columns = [DVec3::ZERO; 3];
    (columns[right], columns[up], columns[ahead]) = (DVec3::X, DVec3::Y, DVec3::Z * sign);
    let [x, y, z] = columns;
    DMat3::from_cols(x, y, z)
}

/// Returns the cover of a box along the light's axes on a face with slopes up to `widest`; `None` if no part of it is
/// there.
fn cover_of_box([min, max]: [DVec3; 2], index: usize, widest: f64) -> Option<FaceCover> {
    let ([right, up], ahead, sign) = axes(index);
    let [a, b] = [min[ahead] * sign, max[ahead] * sign];
    let (nearest, farthest) = (a.min(b), a.max(b));
    // A point on the face is aside by at most `widest` times its distance ahead.
    let aside = |axis: usize| min[axis].max(-max[axis]).max(0.0) / widest;
    let nearest = nearest.max(aside(right)).max(aside(up)).max(0.0);
    if nearest > farthest || farthest <= 0.0 {
        return None;
    }
    // A slope is largest at the nearest point. A box that reaches the source covers all slopes.
    let slope = |aside: f64, over: f64, every: f64| if over > 0.0 { aside / over } else { every };
    let least = |axis: usize| slope(min[axis], if min[axis] > 0.0 { farthest } else { nearest }, -widest);
    let most = |axis: usize| slope(max[axis], if max[axis] > 0.0 { nearest } else { farthest }, widest);
    let low = DVec2::new(least(right), least(up)).max(DVec2::splat(-widest));
    let high = DVec2::new(most(right), most(up)).min(DVec2::splat(widest));
    low.cmple(high).all().then_some(FaceCover { low, high, nearest })
}

/// Fits the faces of a map, `side` texels a side, to `clusters`.
fn fit_faces(light_from_scene: DAffine3, clusters: &Clusters, side: f64) -> PerspectiveFit {
    let source = light_from_scene.inverse().translation;
    // Light that starts inside a side of the scene's bounds leaves through it and does not return.
    let comes_in = |side: &OpenSide| side.height(source) >= 0.0;
    // Beyond its edge a face is drawn as far as the filter reads.
    let grown = side / (side - 2.0 * MARGIN_TEXELS);
    let in_light = |cluster: &ClusterBounds| {
        let m = light_from_scene.matrix3;
        let reach = m.x_axis.abs() * cluster.half.x + m.y_axis.abs() * cluster.half.y + m.z_axis.abs() * cluster.half.z;
        let middle = light_from_scene.transform_point3(cluster.center);
        [middle - reach, middle + reach]
    };
    let mut nearest = f64::INFINITY;
    let mut face = |index: usize| {
        let mut cover = FaceCover::EMPTY;
        cover.extend_by_leaves(clusters.casting_trees(clusters.open_sides(comes_in)), |cluster| {
            cover_of_box(in_light(cluster), index, grown)
        });
        nearest = nearest.min(cover.nearest);
        let fitted = cover.fitted([DVec2::NEG_ONE, DVec2::ONE], grown, SMALLEST_SHARE);
        PerspectiveFace { axes: face_from_light(index), fitted }
    };
    PerspectiveFit { faces: (0..FACES).map(&mut face).collect(), nearest }
}
