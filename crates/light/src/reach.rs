//! How far from a scene lights may be, and how large and small, for single precision to hold both.

use glam::DVec3;
use thiserror::Error;

use crate::{Light, LightKind, Tube};

/// Largest distance from the scene's middle of anything that is drawn, in world units: squares of it, and their
/// products with intensities, stay within f32.
pub const MAX_EXTENT: f64 = 1e15;

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
    /// Refuses a light that cannot be drawn with this scene. Lights that cannot be evaluated are not this check's.
    pub fn check(&self, light: &Light) -> Result<(), OutOfReach> {
        let far = |distance: f64| {
            // Also true of NaN.
            if distance <= MAX_EXTENT {
                return Ok(());
            }
            Err(OutOfReach::Far { name: light.name.clone(), distance })
        };
        let across = |source: DVec3| ((source - self.middle).abs() + self.half_extent).length();
        match &light.kind {
            LightKind::Spot(spot) => far(across(spot.transform.translation)),
            LightKind::Bendy(bendy) => {
                let transform = &bendy.transform;
                let reaches = bendy.points.iter().zip(&bendy.radii).map(|(point, radius)| {
                    across(transform.translation) + (point.length() + radius) * transform.scale
                });
                far(reaches.fold(0.0, f64::max))?;
                let Ok(tube) = Tube::<f64>::new(bendy) else { return Ok(()) };
                let sizes = across(tube.placement.translation) / tube.placement.world_per_tube.min(1.0);
                if sizes <= MAX_EXTENT {
                    return Ok(());
                }
                Err(OutOfReach::Small { name: light.name.clone(), sizes })
            }
        }
    }

    /// Which of `lights` a picture leaves out, and why.
    pub fn left_out<'a>(&self, lights: impl IntoIterator<Item = &'a Light>) -> Vec<OutOfReach> {
        lights.into_iter().filter_map(|light| self.check(light).err()).collect()
    }
}
