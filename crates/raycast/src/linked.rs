//! What of a scene counts for a light, by its links.

use light::parameters::{LIGHT_LINK, SHADOW_LINK};
use light::{CheckedLight, Key, Links};
use scene::PosedScene;

/// The nodes of a scene that count for a light. By default all do.
#[derive(Clone, Debug, Default)]
pub struct Linked {
    /// One a node: whether it is lit.
    lit: Option<Vec<bool>>,
    /// One a node: whether it throws shadows.
    throwing: Option<Vec<bool>>,
}

impl Linked {
    /// What the links of `light` leave of a scene.
    pub fn new(posed: &PosedScene, light: &CheckedLight) -> Self {
        let left =
            |links: Key<Option<Links>>| light.light().get(links).map(|links| posed.nodes().linked(&links));
        Self { lit: left(LIGHT_LINK), throwing: left(SHADOW_LINK) }
    }

    /// Whether light shows on a node, by its index.
    pub fn lights(&self, node: usize) -> bool {
        self.lit.as_ref().is_none_or(|lit| lit[node])
    }

    /// Whether a node is in the light's way.
    pub fn stops_at(&self, node: usize) -> bool {
        self.throwing.as_ref().is_none_or(|throwing| throwing[node])
    }
}
