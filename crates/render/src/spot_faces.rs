//! Faces of a spotlight's shadow map: perspective pictures, each fitted to its casters.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use light::Light;
use light::parameters::CONE_ANGLE;

use crate::clusters::{Clusters, MapCover, OpenSide};
use crate::map_views::{FaceCover, FittedFace, MARGIN_TEXELS, SMALLEST_SHARE};

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

#[derive(Clone, Copy, Debug)]
pub(crate) struct SpotFace {
    /// Matrix from light space to (x, y, depth).
    pub axes: DMat3,
    pub fitted: FittedFace,
}

/// The faces of a light's map, fitted to a scene.
#[derive(Clone, Debug)]
pub(crate) struct FittedFaces {
    pub faces: Vec<SpotFace>,
    /// Least depth of any caster; infinity without casters.
    pub nearest: f64,
}

impl FittedFaces {
    /// Faces of a light without a map.
    pub const NONE: Self = Self { faces: Vec::new(), nearest: f64::INFINITY };

    /// Makes faces of `side` texels, fitted to the part of `clusters` that may be in the light.
    pub fn new(light: &Light, side: f64, light_from_scene: DAffine3, clusters: &Clusters) -> Self {
        let tan_outer = light.get(CONE_ANGLE).to_radians().tan();
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
            SpotFace { axes, fitted: cover.fitted([low, high], grown, widest.max_element() * SMALLEST_SHARE) }
        };
        let faces = CUBE.into_iter().take(face_count(light)).enumerate().map(|(k, axes)| face(k, axes)).collect();
        Self { faces, nearest }
    }
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
