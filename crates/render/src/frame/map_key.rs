//! Keys of shadow maps.

use light::{LightDigest, LightId, LightInstance};

use crate::frame::pass_runs::Cause;

/// Identifies a light's map over a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapKey {
    light: LightId,
    /// Digest of the light's values that its map depends on.
    revision: LightDigest,
    scene: u64,
}

impl MapKey {
    pub fn of(instance: &LightInstance, scene: u64) -> Self {
        Self { light: instance.id, revision: instance.light.revisions().shadow_map, scene }
    }

    pub fn light(&self) -> LightId {
        self.light
    }

    /// Returns the cause for drawing a map with this key after one of the same light with the key `before`.
    pub fn cause_after(&self, before: &Self) -> Cause {
        if before.scene != self.scene {
            Cause::Scene
        } else if before.revision != self.revision {
            Cause::Light
        } else {
            Cause::Evicted
        }
    }
}
