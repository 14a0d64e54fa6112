//! A light that can be evaluated.

use std::cell::Cell;
use std::sync::Arc;

use crate::bend::spotlight_if_straight;
use crate::revision::{LightDigest, Revisions};
use crate::{Cone, Light, LightError, LightId, LightProfile, LightShape, Omni, Parallel, Tube};

thread_local! {
    static CHECK_COUNT: Cell<u64> = const { Cell::new(0) };
}

/// A light that passed every check, with what evaluates it: made once, where a change is applied, and carried from there
/// to all who evaluate it. Nothing downstream checks a light again.
#[derive(Clone, Debug)]
pub struct CheckedLight {
    light: Light,
    rays: LightRays,
    revisions: Revisions,
    /// See [`Self::straightened`].
    equivalent_spotlight: Option<Arc<Self>>,
}

/// How a point is found in a light.
#[derive(Clone, Debug)]
pub enum LightRays {
    /// Straight lines from a point, in a cone.
    Cone(Cone),
    /// Curves along a tube.
    Bent(Tube<f64>),
    /// Parallel lines.
    Parallel(Parallel),
    /// Straight lines from a point to all sides.
    Omni(Omni),
}

/// A light under the name that it keeps for as long as its session lives.
#[derive(Clone, Debug)]
pub struct LightInstance {
    /// Its name.
    pub id: LightId,
    /// As it is now.
    pub light: Arc<CheckedLight>,
}

impl LightInstance {
    /// Lights of no session, checked, which go by their numbers from 0.
    pub fn numbered(lights: impl IntoIterator<Item = Light>) -> Result<Vec<Self>, LightError> {
        let checked = lights.into_iter().zip(0..).map(|(light, number)| {
            Ok(Self { id: LightId(number), light: Arc::new(CheckedLight::new(light)?) })
        });
        checked.collect()
    }
}

impl CheckedLight {
    /// Checks a light: every value against its row, a BendyLight's control points, its tube for folds.
    pub fn new(light: Light) -> Result<Self, LightError> {
        CHECK_COUNT.set(CHECK_COUNT.get() + 1);
        let checked = Self::of(light)?;
        let spot = spotlight_if_straight(&checked.light).and_then(|spot| Self::of(spot).ok());
        Ok(Self { equivalent_spotlight: spot.map(Arc::new), ..checked })
    }

    fn of(light: Light) -> Result<Self, LightError> {
        let rays = match light.shape() {
            LightShape::Spot => LightRays::Cone(Cone::new(&light)?),
            LightShape::Bendy(_) => LightRays::Bent(Tube::new(&light)?),
            LightShape::Directional => LightRays::Parallel(Parallel::new(&light)?),
            LightShape::Omni => LightRays::Omni(Omni::new(&light)?),
        };
        let revisions = Revisions::of(&light);
        Ok(Self { light, rays, revisions, equivalent_spotlight: None })
    }

    /// How many checks this thread has made: what tests count to see that a light is checked once.
    pub fn check_count() -> u64 {
        CHECK_COUNT.get()
    }

    /// The light as it is written down.
    pub fn light(&self) -> &Light {
        &self.light
    }

    /// How a point is found in it.
    pub fn rays(&self) -> &LightRays {
        &self.rays
    }

    /// The tube of a BendyLight.
    pub fn tube(&self) -> Option<&Tube<f64>> {
        if let LightRays::Bent(tube) = &self.rays { Some(tube) } else { None }
    }

    /// The spotlight that a BendyLight is whose tube is still a cone: made with it, and the same light at every point but
    /// for the roundings and its `t`.
    pub fn equivalent_spotlight(&self) -> Option<&Arc<Self>> {
        self.equivalent_spotlight.as_ref()
    }

    /// What becomes of its light on the way.
    pub fn light_profile(&self) -> &LightProfile {
        match &self.rays {
            LightRays::Cone(cone) => &cone.light_profile,
            LightRays::Omni(omni) => &omni.light_profile,
            LightRays::Parallel(parallel) => &parallel.light_profile,
            LightRays::Bent(tube) => &tube.light_profile,
        }
    }

    /// Names of what pictures keep of it.
    pub fn revisions(&self) -> Revisions {
        self.revisions
    }

    /// Of all its values.
    pub fn digest(&self) -> LightDigest {
        self.revisions.content
    }
}

impl PartialEq for CheckedLight {
    /// Whether all values are the same.
    fn eq(&self, other: &Self) -> bool {
        self.light == other.light
    }
}
