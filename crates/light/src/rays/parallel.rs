//! Directional lights: parallel rays from infinitely far away.

use glam::{DMat3, DVec2, DVec3};

use crate::build::check_values;
use crate::parameters::{HEIGHT, WIDTH};
use crate::{Light, LightCoords, LightError, LightProfile};

/// Checked directional light, prepared for evaluation. It shines along its -z. A window, if it has one, is a rectangle
/// about its axis and limits the light across it.
#[derive(Clone, Debug)]
pub struct Parallel {
    /// World position of the window's centre.
    pub translation: DVec3,
    /// Rotation from light axes to world axes.
    pub rotation: DMat3,
    /// Half the window's width along x and its height along y, in world units; `None` if unbounded.
    pub half_size: [Option<f64>; 2],
    pub light_profile: LightProfile,
}

impl Parallel {
    /// Checks and prepares a directional light.
    pub fn new(light: &Light) -> Result<Self, LightError> {
        check_values(light)?;
        let transform = light.transform();
        Ok(Self {
            translation: transform.translation,
            rotation: transform.world_from_local_axes(),
            half_size: [light.get(WIDTH), light.get(HEIGHT)].map(|side| side.map(|side| side / 2.0)),
            light_profile: LightProfile::of(light, 0.0),
        })
    }

    /// Returns the unit vector in world space towards the arriving light.
    pub fn direction(&self) -> DVec3 {
        self.rotation.z_axis
    }

    /// Returns the offset of a world position from the window's centre along x and y; 0 along an unbounded side.
    pub fn offset_in_window(&self, position: DVec3) -> DVec2 {
        let offset = position - self.translation;
        let along = |axis: DVec3, half: Option<f64>| half.map_or(0.0, |_| axis.dot(offset));
        let [width, height] = self.half_size;
        DVec2::new(along(self.rotation.x_axis, width), along(self.rotation.y_axis, height))
    }

    /// Locates a world position; `None` outside the window. A coordinate along the light and a path length do not
    /// exist: both are 0.
    pub fn locate(&self, position: DVec3) -> Option<LightCoords> {
        let offset = self.offset_in_window(position);
        let [x, y] = [0, 1].map(|k| self.half_size[k].map_or(0.0, |half| offset[k] / half));
        // Axes as of a BendyLight's cross-section: w_hat is up, v_hat = w_hat x u_hat is to the left of +x.
        let coords = LightCoords { t: 0.0, v: -x, w: y, s: 0.0, direction: self.direction() };
        (x.abs() <= 1.0 && y.abs() <= 1.0).then_some(coords)
    }

    /// Returns the irradiance on a surface perpendicular to the light, linear RGB, without visibility.
    pub fn irradiance(&self, coords: &LightCoords) -> DVec3 {
        self.light_profile.irradiance(DVec3::ONE, coords)
    }
}
