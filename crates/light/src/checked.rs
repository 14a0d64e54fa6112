//! Lights that passed every check.

use std::cell::Cell;
use std::sync::Arc;

use crate::bend::spotlight_if_straight;
use crate::revision::{LightDigest, Revisions};
use crate::{Cone, Light, LightError, LightId, LightProfile, LightShape, Omni, Parallel, Tube};

thread_local! {
    static CHECK_COUNT: Cell<u64> = const { Cell::new(0) };
}

/// Light that passed every check, prepared for evaluation. It is made once, when a change is applied. No later code
/// checks the light again.
#[derive(Clone, Debug)]
pub struct CheckedLight {
    light: Light,
    rays: LightRays,
    revisions: Revisions,
    /// Spotlight that lights every point equally, as [`Self::equivalent_spotlight()`] returns it.
    equivalent_spotlight: Option<Arc<Self>>,
}

/// Rays of a light, prepared for evaluation, by shape. They give the light coordinates of a point.
#[derive(Clone, Debug)]
pub enum LightRays {
    Cone(Cone),
    Bent(Tube<f64>),
    Parallel(Parallel),
    Omni(Omni),
}

/// Light with its id, which stays the same for the life of its session.
#[derive(Clone, Debug)]
pub struct LightInstance {
    pub id: LightId,
    pub light: Arc<CheckedLight>,
}

impl LightInstance {
    /// Checks lights that belong to no session and numbers them from 0.
    pub fn numbered(lights: impl IntoIterator<Item = Light>) -> Result<Vec<Self>, LightError> {
        let checked = lights
            .into_iter()
            .zip(0..)
            .map(|(light, number)| Ok(Self { id: LightId(number), light: Arc::new(CheckedLight::new(light)?) }));
        checked.collect()
    }
}

impl LightRays {
    /// Returns the falloff, tint and shadow of the light.
    pub fn light_profile(&self) -> &LightProfile {
        match self {
            Self::Cone(cone) => &cone.light_profile,
            Self::Omni(omni) => &omni.light_profile,
            Self::Parallel(parallel) => &parallel.light_profile,
            Self::Bent(tube) => &tube.light_profile,
        }
    }
}

impl CheckedLight {
    /// Checks a light: every value against its row, the control points of a BendyLight, and its tube for folds.
    ///
    /// ```
    /// use light::parameters::CONE_ANGLE;
    /// use light::{CheckedLight, Light};
    ///
    /// let light = CheckedLight::new(Light::spot())?;
    /// assert!(light.tube().is_none());
    /// let refused = CheckedLight::new(Light::spot().with(CONE_ANGLE, 90.0)).unwrap_err();
    /// assert!(refused.to_string().starts_with("`coneAngle` is 90, but it must be"));
    /// # Ok::<(), light::LightError>(())
    /// ```
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

    /// Returns the number of checks on this thread. Tests use it to verify that a light is checked only once.
    pub fn check_count() -> u64 {
        CHECK_COUNT.get()
    }

    pub fn light(&self) -> &Light {
        &self.light
    }

    pub fn rays(&self) -> &LightRays {
        &self.rays
    }

    /// Returns the tube, if this is a BendyLight.
    pub fn tube(&self) -> Option<&Tube<f64>> {
        if let LightRays::Bent(tube) = &self.rays { Some(tube) } else { None }
    }

    /// Returns the spotlight equal to a BendyLight whose tube is a cone. It is made with the light. It has the same
    /// light at every point, except for roundings and for `t`.
    pub fn equivalent_spotlight(&self) -> Option<&Arc<Self>> {
        self.equivalent_spotlight.as_ref()
    }

    /// Returns the falloff, tint and shadow of the light.
    pub fn light_profile(&self) -> &LightProfile {
        self.rays.light_profile()
    }

    /// Returns the digests that caches of the light use as keys.
    pub fn revisions(&self) -> Revisions {
        self.revisions
    }

    /// Returns the digest of all values.
    pub fn digest(&self) -> LightDigest {
        self.revisions.content
    }
}

impl PartialEq for CheckedLight {
    /// Compares all values.
    fn eq(&self, other: &Self) -> bool {
        self.light == other.light
    }
}
