//! Omni lights: straight rays from a point to all sides.

use glam::{DMat3, DVec3};

use crate::build::check_values;
use crate::parameters::RANGE;
use crate::{Light, LightCoords, LightError, LightProfile};

/// Checked omni light, prepared for evaluation.
#[derive(Clone, Debug)]
pub struct Omni {
    /// World position of the source.
    pub translation: DVec3,
    /// Rotation from light axes to world axes.
    pub rotation: DMat3,
    /// Distance at which the light ends, in world units; `None` for no end.
    pub range: Option<f64>,
    pub light_profile: LightProfile,
}

impl Omni {
    /// Checks and prepares an omni light.
    pub fn new(light: &Light) -> Result<Self, LightError> {
        check_values(light)?;
        let transform = light.transform();
        Ok(Self {
            translation: transform.translation,
            rotation: transform.world_from_local_axes(),
            range: light.get(RANGE),
            light_profile: LightProfile::of(light, 0.0),
        })
    }

    /// Locates a point, given from the source in world axes; `None` past the range, and at the source itself.
    pub fn locate(&self, from_source: DVec3) -> Option<LightCoords> {
        let s = from_source.length();
        if !(s > 0.0 && self.range.is_none_or(|range| s <= range)) {
            return None;
        }
        let [v, w] = on_cube(self.rotation.transpose() * from_source);
        let t = self.range.map_or(0.0, |range| s / range);
        Some(LightCoords { t, v, w, s, direction: -from_source / s })
    }

    /// Returns the irradiance on a surface perpendicular to the light, linear RGB, without visibility.
    pub fn irradiance(&self, coords: &LightCoords) -> DVec3 {
        self.light_profile.irradiance(DVec3::ONE, coords)
    }
}

/// Intersects the ray along the nonzero vector `direction` with a cube from -1 to 1. Returns the coordinates on the
/// face, to the left and upwards, seen from within. On the four faces around the light up is its +y. Ahead, at -z, is
/// down on the face above and up on the face below.
pub fn on_cube(direction: DVec3) -> [f64; 2] {
    let DVec3 { x, y, z } = direction;
    let size = direction.abs();
    if size.y > size.x.max(size.z) {
        [-x / size.y, if y > 0.0 { z } else { -z } / size.y]
    } else if size.x > size.z {
        [if x > 0.0 { -z } else { z } / size.x, y / size.x]
    } else {
        [if z < 0.0 { -x } else { x } / size.z, y / size.z]
    }
}
