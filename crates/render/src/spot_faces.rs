//! The faces of a spotlight's shadow map: one perspective picture each, fitted to what casts shadows there.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use light::Light;
use light::parameters::CONE_ANGLE;

use crate::clusters::{Clusters, OpenSide};

/// Largest half angle, in degrees, that one face holds. On a wider one the texels at its middle, where they are
/// widest as angles, would be wider than those of the faces of a cube at half the resolution.
const MAX_FACE_HALF_ANGLE_DEGREES: f64 = 60.0;
/// Texels around what may cast shadows, so that the filter reaches no texel that is left out.
const MARGIN_TEXELS: f64 = 2.0;
/// A face is fitted to no less than this share of it, and neither way to less than a quarter of the other way: finer
/// texels than that are lost in the rounding of positions.
const SMALLEST_SHARE: f64 = 1.0 / 128.0;
const SMALLEST_RATIO: f64 = 0.25;

/// Takes light space to a face's (x, y, depth).
const FRONT: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z);
/// The front of a cube about the light's axis, +x, -x, +y and -y, as `spot_faces.wgsl` has them.
const CUBE: [DMat3; 5] = [
    FRONT,
    DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::NEG_Y),
    DMat3::from_cols(DVec3::NEG_Z, DVec3::X, DVec3::NEG_Y),
    DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
    DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y),
];

/// How many faces a light's map has.
pub(crate) fn face_count(light: &Light) -> usize {
    if light.get(CONE_ANGLE) > MAX_FACE_HALF_ANGLE_DEGREES { CUBE.len() } else { 1 }
}

/// A face of a map: what of it is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpotFace {
    /// From light space to (x, y, depth).
    pub axes: DMat3,
    /// Middle of what is drawn, as x / depth and y / depth.
    pub center: DVec2,
    /// Half its size.
    pub half: DVec2,
    /// Nothing casts shadows where this is false: it need not be drawn.
    pub has_casters: bool,
}

/// The faces of a light's map, fitted to a scene.
#[derive(Clone, Debug)]
pub(crate) struct FittedFaces {
    pub faces: Vec<SpotFace>,
    /// The least depth of what may cast shadows; infinity where nothing does.
    pub nearest: f64,
}

impl FittedFaces {
    /// Of a light without a map.
    pub const NONE: Self = Self { faces: Vec::new(), nearest: f64::INFINITY };

    /// Of `side` texels, fitted to what of `clusters` may lie in the light.
    pub fn new(light: &Light, side: f64, light_from_scene: DAffine3, clusters: &Clusters) -> Self {
        let tan_outer = light.get(CONE_ANGLE).to_radians().tan();
        // What lies beyond the edge is drawn as far as the filter reaches.
        let grown = side / (side - 2.0 * MARGIN_TEXELS);
        // Straight light that starts inside does not come back.
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
            // Grown, but no farther than the filter reaches beyond the face.
            let room = widest - half;
            let center = ((low + high) / 2.0).clamp(middle - room, middle + room);
            SpotFace { axes, center, half, has_casters: casts }
        };
        let faces =
            CUBE.into_iter().take(face_count(light)).enumerate().map(|(k, axes)| face(k, axes)).collect();
        Self { faces, nearest }
    }
}

/// What of a face boxes cover.
#[derive(Clone, Copy, Debug)]
struct SpotFaceCover {
    low: DVec2,
    high: DVec2,
    /// The least depth.
    depth: f64,
}

impl SpotFaceCover {
    const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, depth: f64::INFINITY };

    /// Those of a box with these corners in the face's (x, y, depth), from the slopes `least` to `most`; `None` where
    /// none of it is there.
    fn of(corners: &[DVec3; 8], least: DVec2, most: DVec2) -> Option<Self> {
        let (min, max) =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        // Whatever lies on the face is as far ahead as it lies aside.
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
