//! What a shadow map is of.

use light::{Digest, LightId, LightInstance};

/// Which light's map over which scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapKey {
    light: LightId,
    /// The light's revision of what its map depends on.
    revision: Digest,
    /// The scene's.
    scene: u64,
}

impl MapKey {
    pub fn of(instance: &LightInstance, scene: u64) -> Self {
        Self { light: instance.id, revision: instance.light.revisions().shadow_map, scene }
    }
}
