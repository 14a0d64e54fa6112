//! Lights with their links, resolved for a scene.

use light::CheckedLight;
use raycast::LinkedNodes;
use scene::PosedScene;

use crate::ReferenceLight;

/// Light, with the nodes that it illuminates and the nodes that cast shadows in it.
#[derive(Clone, Debug)]
pub struct LinkedReferenceLight {
    pub(crate) source: ReferenceLight,
    pub(crate) linked: LinkedNodes,
}

impl LinkedReferenceLight {
    /// Resolves the links of a light in a scene.
    pub fn new(posed: &PosedScene, light: &CheckedLight) -> Self {
        Self { source: ReferenceLight::new(light), linked: LinkedNodes::new(posed, light) }
    }
}
