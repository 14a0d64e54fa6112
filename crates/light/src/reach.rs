//! Limits of distance and size within which single precision holds both scene and light.

use glam::DVec3;
use thiserror::Error;

use crate::{CheckedLight, LightRays, MAX_EXTENT};

/// Bounding box of a scene, against which lights are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneBounds {
    /// Centre of the box, in the world.
    pub center: DVec3,
    /// Half the size of the box along each axis. The box extends this far from its centre in both directions.
    pub half_extent: DVec3,
}

/// Light that cannot be drawn with a scene.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UndrawableLight {
    /// Light that reaches too far from the scene.
    #[error(
        "light `{name}` reaches {distance:.3e} units from the scene's middle, but at most {MAX_EXTENT:e} can be \
         drawn: bring it nearer, or make it smaller"
    )]
    TooFar {
        name: String,
        /// Distance in world units of the farthest part of the light from the scene's centre.
        distance: f64,
    },
    /// Light that is too small for its distance to the far end of the scene.
    #[error(
        "the scene reaches {sizes:.3e} times the size of light `{name}` from it, but at most {MAX_EXTENT:e} times can \
         be drawn: make the light larger, or bring it nearer"
    )]
    TooSmall {
        name: String,
        /// Greatest distance of the scene from the light, as a multiple of the light's size.
        sizes: f64,
    },
}

impl SceneBounds {
    /// Checks that a light can be drawn with this scene.
    pub fn check(&self, light: &CheckedLight) -> Result<(), UndrawableLight> {
        let name = || light.light().name().to_owned();
        let far = |distance: f64| {
            // Negated so that NaN is refused too.
            if distance <= MAX_EXTENT { Ok(()) } else { Err(UndrawableLight::TooFar { name: name(), distance }) }
        };
        let across = |source: DVec3| ((source - self.center).abs() + self.half_extent).length();
        let small = |sizes: f64| {
            if sizes <= MAX_EXTENT { Ok(()) } else { Err(UndrawableLight::TooSmall { name: name(), sizes }) }
        };
        let transform = light.light().transform();
        let tube = match light.rays() {
            LightRays::Bent(tube) => tube,
            LightRays::Cone(_) | LightRays::Omni(_) => return far(across(transform.translation)),
            LightRays::Parallel(parallel) => {
                // The source is infinitely far away. Only the window has a position, and only across the light.
                let distance = parallel.offset_in_window(self.center).length() + self.half_extent.length();
                far(distance)?;
                return parallel.half_size.into_iter().flatten().try_for_each(|half| small(distance / half));
            }
        };
        let reaches =
            light.light().points().iter().map(|point| {
                across(transform.translation) + (point.position.length() + point.radius) * transform.scale
            });
        far(reaches.fold(0.0, f64::max))?;
        small(across(tube.placement.translation) / tube.placement.world_per_tube.min(1.0))
    }

    /// Returns the errors of those of `lights` that a picture leaves out.
    pub fn undrawable_of<'a>(&self, lights: impl IntoIterator<Item = &'a CheckedLight>) -> Vec<UndrawableLight> {
        lights.into_iter().filter_map(|light| self.check(light).err()).collect()
    }
}
