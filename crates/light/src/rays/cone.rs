//! Spotlights: straight rays from a point.

use glam::{DMat3, DVec2, DVec3};

use crate::build::check_values;
use crate::parameters::{CONE_ANGLE, RANGE};
use crate::{Light, LightCoords, LightError, LightProfile};

/// Checked spotlight, prepared for evaluation (light model, section 6). It shines along its -z.
#[derive(Clone, Debug)]
pub struct Cone {
    /// World position of the source.
    pub translation: DVec3,
    /// Rotation from light axes to world axes.
    pub rotation: DMat3,
    /// Tangent of the half angle.
    pub tan_outer: f64,
    /// Axial distance at which the light ends, in world units; `None` for no end.
    pub range: Option<f64>,
    pub light_profile: LightProfile,
}

impl Cone {
    /// Checks and prepares a spotlight.
    pub fn new(light: &Light) -> Result<Self, LightError> {
        check_values(light)?;
        let transform = light.transform();
        Ok(Self {
            translation: transform.translation,
            rotation: transform.world_from_local_axes(),
            tan_outer: libm::tan(light.get(CONE_ANGLE).to_radians()),
            range: light.get(RANGE),
            light_profile: LightProfile::of(light, 0.0),
        })
    }

    /// Locates a point, given from the source in world axes; `None` outside the cone.
    ///
    /// ```
    /// use glam::DVec3;
    /// use light::parameters::RANGE;
    /// use light::{Cone, Light};
    ///
    /// let cone = Cone::new(&Light::spot().with(RANGE, Some(4.0)))?;
    /// let coords = cone.locate(DVec3::new(0.0, 0.0, -2.0)).expect("on the axis");
    /// assert_eq!((coords.t, coords.s, coords.direction), (0.5, 2.0, DVec3::Z));
    /// assert_eq!(cone.irradiance(&coords), DVec3::splat(0.25));
    /// assert_eq!(cone.locate(DVec3::Z), None);
    /// # Ok::<(), light::LightError>(())
    /// ```
    pub fn locate(&self, from_source: DVec3) -> Option<LightCoords> {
        let position = self.rotation.transpose() * from_source;
        let (depth, s) = (-position.z, position.length());
        let slope = position.truncate() / depth;
        let in_range = self.range.is_none_or(|range| depth <= range);
        if !(depth > 0.0 && slope.length() <= self.tan_outer && in_range) {
            return None;
        }
        // Axes as of a BendyLight's cross-section: w_hat is up, v_hat = w_hat x u_hat is to the left of +x.
        let DVec2 { x: v, y: w } = DVec2::new(-slope.x, slope.y) / self.tan_outer;
        let t = self.range.map_or(0.0, |range| depth / range);
        Some(LightCoords { t, v, w, s, direction: self.rotation * (-position / s) })
    }

    /// Returns the irradiance on a surface perpendicular to the light, linear RGB, without visibility.
    pub fn irradiance(&self, coords: &LightCoords) -> DVec3 {
        self.light_profile.irradiance(DVec3::ONE, coords)
    }
}
