//! What of a scene counts for a light, by its links.

use light::parameters::{LIGHT_LINK, SHADOW_LINK};
use light::{CheckedLight, Links, ParameterKey};
use scene::PosedScene;

/// The nodes of a scene that count for a light. By default all do.
#[derive(Clone, Debug, Default)]
pub struct LinkedNodes {
    /// One a node: whether it is lit.
    lit: Option<Vec<bool>>,
    /// One a node: whether it throws shadows.
    casting: Option<Vec<bool>>,
}

impl LinkedNodes {
    /// What the links of `light` leave of a scene.
    pub fn new(posed: &PosedScene, light: &CheckedLight) -> Self {
        let left = |links: ParameterKey<Option<Links>>| {
            light.light().get(links).map(|links| posed.node_tree().selected_nodes(&links))
        };
        Self { lit: left(LIGHT_LINK), casting: left(SHADOW_LINK) }
    }

    /// Whether light shows on a node, by its index.
    pub fn is_lit(&self, node: usize) -> bool {
        self.lit.as_ref().is_none_or(|lit| lit[node])
    }

    /// Whether a node is in the light's way.
    pub fn casts_shadow(&self, node: usize) -> bool {
        self.casting.as_ref().is_none_or(|throwing| throwing[node])
    }
}
