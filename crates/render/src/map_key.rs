//! What a shadow map is of.

use light::{LightDigest, LightId, LightInstance};

use crate::pass_runs::Cause;

/// Which light's map over which scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapKey {
    light: LightId,
    /// The light's revision of what its map depends on.
    revision: LightDigest,
    /// The scene's.
    scene: u64,
}

impl MapKey {
    pub fn of(instance: &LightInstance, scene: u64) -> Self {
        Self { light: instance.id, revision: instance.light.revisions().shadow_map, scene }
    }

    /// Whose map it is.
    pub fn light(&self) -> LightId {
        self.light
    }

    /// Why a map with this key has to be drawn where the last one of its light had that key.
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
