//! How far from a scene lights may be, and how large and small, for single precision to hold both.

use glam::DVec3;
use thiserror::Error;

use crate::{CheckedLight, MAX_EXTENT, Rays};

/// The box of a scene, against which its lights are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Middle of the box, in the world.
    pub middle: DVec3,
    /// The box reaches from minus to plus this about the middle.
    pub half_extent: DVec3,
}

/// A light that cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OutOfReach {
    /// It reaches too far away.
    #[error(
        "light `{name}` reaches {distance:.3e} units from the scene's middle, but at most {MAX_EXTENT:e} can be \
         drawn: bring it nearer, or make it smaller"
    )]
    Far {
        /// Which.
        name: String,
        /// How far, in world units.
        distance: f64,
    },
    /// It is too small for how far the scene reaches from it.
    #[error(
        "the scene reaches {sizes:.3e} times the size of light `{name}` from it, but at most {MAX_EXTENT:e} times can \
         be drawn: make the light larger, or bring it nearer"
    )]
    Small {
        /// Which.
        name: String,
        /// How far, in sizes of the light.
        sizes: f64,
    },
}

impl Reach {
    /// Refuses a light that cannot be drawn with this scene.
    pub fn check(&self, light: &CheckedLight) -> Result<(), OutOfReach> {
        let name = || light.light().name().to_owned();
        let far = |distance: f64| {
            // Also true of NaN.
            if distance <= MAX_EXTENT { Ok(()) } else { Err(OutOfReach::Far { name: name(), distance }) }
        };
        let across = |source: DVec3| ((source - self.middle).abs() + self.half_extent).length();
        let small = |sizes: f64| {
            if sizes <= MAX_EXTENT { Ok(()) } else { Err(OutOfReach::Small { name: name(), sizes }) }
        };
        let transform = light.light().transform();
        let tube = match light.rays() {
            Rays::Bent(tube) => tube,
            Rays::Cone(_) | Rays::Omni(_) => return far(across(transform.translation)),
            Rays::Parallel(parallel) => {
                // It comes from infinitely far away: only its window stands anywhere, and only across the light.
                let distance = parallel.beside(self.middle).length() + self.half_extent.length();
                far(distance)?;
                return parallel.half.into_iter().flatten().try_for_each(|half| small(distance / half));
            }
        };
        let reaches = light.light().points().iter().map(|point| {
            across(transform.translation) + (point.position.length() + point.radius) * transform.scale
        });
        far(reaches.fold(0.0, f64::max))?;
        small(across(tube.placement.translation) / tube.placement.world_per_tube.min(1.0))
    }

    /// Which of `lights` a picture leaves out, and why.
    pub fn left_out<'a>(&self, lights: impl IntoIterator<Item = &'a CheckedLight>) -> Vec<OutOfReach> {
        lights.into_iter().filter_map(|light| self.check(light).err()).collect()
    }
}
