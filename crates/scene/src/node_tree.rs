//! Paths of nodes, and the nodes that links select.

use std::collections::BTreeMap;

use light::Links;

use crate::Scene;

/// Maximum length in bytes of a path by which programs name a node. Deeper nodes are named by an ancestor.
pub const MAX_PATH_BYTES: usize = 1_024;

/// Name in a path of a node without a name.
const NAMELESS: &str = "node";

/// Nodes of a scene by their paths.
///
/// A path has the names from the root down to the node, separated by `/`. Among siblings with the same name (roots are
/// siblings too) the second has the suffix `#2`, the third `#3`, in the order of the scene. In a name `~` is written
/// `~0`, `/` `~1` and `#` `~2`. A node without a name is called `node`.
#[derive(Debug, Default)]
pub struct NodeTree {
    /// Parent and last path component of each node.
    nodes: Vec<(Option<usize>, String)>,
    /// Inverse of `nodes`.
    by_parent_and_name: BTreeMap<(Option<usize>, String), usize>,
    /// For each node: true if it or a descendant has a mesh.
    has_mesh_below: Vec<bool>,
}

impl NodeTree {
    /// Makes the paths of a scene that passes [`Scene::check`].
    pub fn new(scene: &Scene) -> Self {
        let mut tree = Self::default();
        let mut named: BTreeMap<(Option<usize>, &str), usize> = BTreeMap::new();
        for (index, node) in scene.nodes.iter().enumerate() {
            let name = if node.name.is_empty() { NAMELESS } else { &node.name };
            let count = named.entry((node.parent, name)).or_default();
            *count += 1;
            let name = escaped(name);
            let step = if *count > 1 { format!("{name}#{count}") } else { name };
            tree.by_parent_and_name.insert((node.parent, step.clone()), index);
            tree.nodes.push((node.parent, step));
            tree.has_mesh_below.push(node.mesh.is_some());
        }
        for (index, node) in scene.nodes.iter().enumerate().rev() {
            if let Some(parent) = node.parent {
                tree.has_mesh_below[parent] |= tree.has_mesh_below[index];
            }
        }
        tree
    }

    /// Returns the path of a node by its index in [`Scene::nodes`].
    pub fn path(&self, node: usize) -> String {
        let above = |&node: &usize| self.nodes[node].0;
        let steps = std::iter::successors(Some(node), above).map(|node| self.nodes[node].1.as_str());
        steps.collect::<Vec<_>>().into_iter().rev().collect::<Vec<_>>().join("/")
    }

    /// Finds the node of a path; `None` if there is none.
    pub fn find(&self, path: &str) -> Option<usize> {
        path.split('/').try_fold(None, |parent, step| {
            self.by_parent_and_name.get(&(parent, step.to_owned())).map(|node| Some(*node))
        })?
    }

    /// Lists paths of nodes that have a mesh or a descendant with one: at most `most` paths, none longer than
    /// `most_bytes`, in the order of the scene. The second value is the number of such nodes left out.
    pub fn drawn_paths(&self, most: usize, most_bytes: usize) -> (Vec<String>, usize) {
        let drawn = || (0..self.nodes.len()).filter(|&node| self.has_mesh_below[node]);
        // Computes the lengths without the paths: paths of a chain of nodes would take the square of its length.
        let mut bytes: Vec<usize> = Vec::with_capacity(self.nodes.len());
        for (parent, step) in &self.nodes {
            bytes.push(step.len() + parent.map_or(0, |parent| bytes[parent] + 1));
        }
        let short = drawn().filter(|&node| bytes[node] <= most_bytes);
        let paths: Vec<String> = short.take(most).map(|node| self.path(node)).collect();
        let more = drawn().count() - paths.len();
        (paths, more)
    }

    /// Evaluates `links`: for each node, true if it is selected. Paths without a node have no effect.
    pub fn selected_nodes(&self, links: &Links) -> Vec<bool> {
        let mut listed: BTreeMap<usize, bool> = BTreeMap::new();
        // Excluded paths come last and overwrite included ones.
        for (paths, counts) in [(links.include(), true), (links.exclude(), false)] {
            listed.extend(paths.iter().filter_map(|path| Some((self.find(path)?, counts))));
        }
        let unlisted = links.include().is_empty();
        let mut selected: Vec<bool> = Vec::with_capacity(self.nodes.len());
        for (node, (parent, _)) in self.nodes.iter().enumerate() {
            let inherited = parent.map_or(unlisted, |parent| selected[parent]);
            selected.push(listed.get(&node).copied().unwrap_or(inherited));
        }
        selected
    }
}

/// Escapes a name for use in a path.
fn escaped(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1").replace('#', "~2")
}
