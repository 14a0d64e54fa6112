//! Faces of a spotlight's shadow map: perspective pictures, each fitted to its casters.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use light::Light;
use light::parameters::CONE_ANGLE;

use crate::clusters::{Clusters, OpenSide};

/// Largest half angle of a single face, in degrees. With a wider one the texels at its center, where they are widest as
/// angles, would be wider than those of cube faces at half the resolution.
const MAX_FACE_HALF_ANGLE_DEGREES: f64 = 60.0;
/// Margin around casters in texels, so that the filter reads only texels that are drawn.
const MARGIN_TEXELS: f64 = 2.0;
/// Smallest fitted share of a face. Neither axis is fitted to less than a quarter of the other. Finer texels are below
/// the rounding error of positions.
const SMALLEST_SHARE: f64 = 1.0 / 128.0;
const SMALLEST_RATIO: f64 = 0.25;

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
    /// Center of the drawn part, as x / depth and y / depth.
    pub center: DVec2,
    /// Half the size of the drawn part.
    pub half: DVec2,
    /// False if there are no casters: the face need not be drawn.
    pub has_casters: bool,
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
            let mut bounds = SpotFaceCover::EMPTY;
            for tree in clusters.casting_trees(clusters.open_sides(comes_in)) {
                tree.walk(|cluster, has_more| {
                    let corners = cluster.corners().map(|p| axes * light_from_scene.transform_point3(p));
                    let Some(here) = SpotFaceCover::of(&corners, middle - widest, middle + widest) else {
                        return false;
                    };
                    if !has_more {
                        bounds.extend(&here);
                    }
                    has_more && !bounds.contains(&here)
                });
            }
            nearest = nearest.min(bounds.depth);
            let casts = bounds.depth < f64::INFINITY;
            let (low, high) = if casts { (bounds.low, bounds.high) } else { (low, high) };
            let half = (high - low) / 2.0;
            let least = (half.max_element() * SMALLEST_RATIO).max(widest.max_element() * SMALLEST_SHARE);
            let half = (half.max(DVec2::splat(least)) * grown).min(widest);
            // Grown, but no farther than the filter reads beyond the face.
            let room = widest - half;
            let center = ((low + high) / 2.0).clamp(middle - room, middle + room);
            SpotFace { axes, center, half, has_casters: casts }
        };
        let faces =
            CUBE.into_iter().take(face_count(light)).enumerate().map(|(k, axes)| face(k, axes)).collect();
        Self { faces, nearest }
    }
}

/// Part of a face that boxes cover.
#[derive(Clone, Copy, Debug)]
struct SpotFaceCover {
    low: DVec2,
    high: DVec2,
    depth: f64,
}

impl SpotFaceCover {
    const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, depth: f64::INFINITY };

    /// Returns the cover of a box with these corners in the face's (x, y, depth), within the slopes `least` to `most`;
    /// `None` if no part of it is there.
    fn of(corners: &[DVec3; 8], least: DVec2, most: DVec2) -> Option<Self> {
        let (min, max) =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        // Depth on a face is at least the distance from the axis divided by the face's limit.
        let aside = min.max(-max).max(DVec3::ZERO);
        let aside = aside.truncate() / least.abs().max(most.abs());
        let depth = min.z.max(aside.max_element());
        if !(max.z > 0.0 && depth <= max.z) {
            return None;
        }
        let (low, high) = if min.z > 0.0 {
            let slopes = corners.map(|p| p.truncate() / p.z);
            (
                slopes.into_iter().fold(DVec2::INFINITY, DVec2::min),
                slopes.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max),
            )
        } else if depth > 0.0 {
            let least = |x: f64| if x > 0.0 { x / max.z } else { x / depth };
            (DVec2::new(least(min.x), least(min.y)), -DVec2::new(least(-max.x), least(-max.y)))
        } else {
            (DVec2::NEG_INFINITY, DVec2::INFINITY)
        };
        let (low, high) = (low.max(least), high.min(most));
        low.cmple(high).all().then_some(Self { low, high, depth: depth.max(0.0) })
    }

    fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all() && self.depth <= other.depth
    }

    fn extend(&mut self, other: &Self) {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self.depth = self.depth.min(other.depth);
    }
}

#[cfg(test)]
mod tests;
