//! Nodes of a scene that a light's links select.

use light::parameters::{LIGHT_LINK, SHADOW_LINK};
use light::{CheckedLight, Links, ParameterKey};
use scene::PosedScene;

/// Nodes that a light affects. By default it affects all.
#[derive(Clone, Debug, Default)]
pub struct LinkedNodes {
    /// One entry for each node, true if the light illuminates it. `None` if the light illuminates all nodes.
    lit: Option<Vec<bool>>,
    /// One entry for each node, true if it casts shadows. `None` if all nodes do.
    casting: Option<Vec<bool>>,
}

impl LinkedNodes {
    /// Evaluates the links of `light` in a scene.
    pub fn new(posed: &PosedScene, light: &CheckedLight) -> Self {
        let left = |links: ParameterKey<Option<Links>>| {
            light.light().get(links).map(|links| posed.node_tree().selected_nodes(&links))
        };
        Self { lit: left(LIGHT_LINK), casting: left(SHADOW_LINK) }
    }

    /// Returns true if the light illuminates a node, by its index.
    pub fn is_lit(&self, node: usize) -> bool {
        self.lit.as_ref().is_none_or(|lit| lit[node])
    }

    /// Returns true if a node, by its index, casts shadows in the light.
    pub fn casts_shadow(&self, node: usize) -> bool {
        self.casting.as_ref().is_none_or(|throwing| throwing[node])
    }
}
