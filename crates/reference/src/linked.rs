//! A light with what of a scene counts for it.

use light::CheckedLight;
use raycast::LinkedNodes;
use scene::PosedScene;

use crate::ReferenceLight;

/// A light with the nodes that count for it.
#[derive(Clone, Debug)]
pub struct LinkedReferenceLight {
    source: ReferenceLight,
    linked: LinkedNodes,
}

impl LinkedReferenceLight {
    /// A checked light over a scene.
    pub fn new(posed: &PosedScene, light: &CheckedLight) -> Self {
        Self { source: ReferenceLight::new(light), linked: LinkedNodes::new(posed, light) }
    }

    /// The light, and the nodes.
    pub(crate) fn parts(&self) -> (&ReferenceLight, &LinkedNodes) {
        (&self.source, &self.linked)
    }
}
