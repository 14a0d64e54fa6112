//! A light with what of a scene counts for it.

use light::CheckedLight;
use raycast::Linked;
use scene::PosedScene;

use crate::Source;

/// A light with the nodes that count for it.
#[derive(Clone, Debug)]
pub struct LinkedSource {
    source: Source,
    linked: Linked,
}

impl LinkedSource {
    /// A checked light over a scene.
    pub fn new(posed: &PosedScene, light: &CheckedLight) -> Self {
        Self { source: Source::new(light), linked: Linked::new(posed, light) }
    }

    /// The light, and the nodes.
    pub(crate) fn parts(&self) -> (&Source, &Linked) {
        (&self.source, &self.linked)
    }
}
