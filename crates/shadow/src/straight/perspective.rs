//! Faces of the maps of lights with a source: perspective pictures, each fitted to its casters.

use glam::{DMat3, DMat4, DVec3, DVec4};
use light::{LightProfile, MAX_EXTENT};
use scene::PosedScene;

use super::cover::FittedFace;

/// Near plane of a shadow map that starts inside the scene, as a share of the distance to the scene's far end. It is
/// near enough for a lamp in its shade, and far enough for the map's depths to resolve a thousandth of that distance.
const NEAR_SHARE: f64 = 1e-3;

/// Faces of a light with a source, fitted to the casters.
#[derive(Clone, Debug)]
pub(crate) struct PerspectiveFit {
    pub faces: Vec<PerspectiveFace>,
    /// Least depth of any caster; infinity without casters.
    pub nearest: f64,
}

/// Face of a map: a perspective picture from the source.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PerspectiveFace {
    /// Matrix from light space to the face's (x, y, depth).
    pub axes: DMat3,
    /// Drawn part, as x / depth and y / depth.
    pub fitted: FittedFace,
}

impl PerspectiveFit {
    /// Fit of a light without a map.
    pub const NONE: Self = Self { faces: Vec::new(), nearest: f64::INFINITY };

    /// Returns the center and 1 / half size of each face, as lookups read them.
    pub fn fits<const FACES: usize>(&self) -> [[f32; 4]; FACES] {
        std::array::from_fn(|face| self.faces.get(face).map_or([0.0; 4], |face| face.fitted.for_lookup()))
    }

    /// Returns the distance of the map's near plane in a light whose source is at most `far` from any point of the
    /// scene, and the profile with the least distance at which the light lights.
    pub fn near_plane(&self, far: f64, profile: &LightProfile) -> (f64, LightProfile) {
        let least_distance = (NEAR_SHARE * far).max(f64::MIN_POSITIVE);
        let near = (0.99 * self.nearest.min(far)).max(least_distance);
        (near, LightProfile { min_distance: least_distance.max(profile.min_distance), ..profile.clone() })
    }

    pub fn clip_from_light(&self, near: f64) -> Vec<Option<DMat4>> {
        self.faces.iter().map(|face| face.fitted.has_casters.then(|| face.clip_from_light(near))).collect()
    }
}

impl PerspectiveFace {
    /// Returns the projection with reversed depth, from `near` to infinity.
    fn clip_from_light(&self, near: f64) -> DMat4 {
        let FittedFace { center, half, .. } = self.fitted;
        let (scale, shift) = (half.recip(), -center / half);
        let clip_from_face = DMat4::from_cols(
            DVec4::X * scale.x,
            DVec4::Y * scale.y,
            DVec4::new(shift.x, shift.y, 0.0, 1.0),
            DVec4::new(0.0, 0.0, near, 0.0),
        );
        clip_from_face * DMat4::from_mat3(self.axes)
    }
}

/// Returns the distance at which a light ends as lookups read it; `None` for a light without end in f32.
pub(crate) fn range_in_f32(range: Option<f64>) -> Option<f32> {
    range.map(|range| range.min(2.0 * MAX_EXTENT) as f32).filter(|range| *range > 0.0)
}

/// Returns an upper bound of the distance from a source to any point of the scene.
pub(crate) fn far_distance(source_in_world: DVec3, posed: &PosedScene) -> f64 {
    ((source_in_world - posed.origin_in_world).abs() + posed.half_extent).length()
}
