//! Node hierarchy of the drawn scene, parents first, with transforms in f64.

use glam::{DAffine3, DMat3, DVec3};
use gltf::json::{Node, Root};

use super::placement::compose;
use super::{ImportReport, ImportSource, display_name, instances};
use crate::fault::invalid_gltf;
use crate::{AssetFault, ImportLimit};

/// Node with its world transform.
#[derive(Debug)]
pub struct PlacedNode {
    /// Index of the glTF node; `None` for an instance from a node's extension.
    pub node: Option<usize>,
    /// Name for people.
    pub name: String,
    /// Index of the parent in the list of placed nodes. It is less than the node's own index.
    pub parent: Option<usize>,
    /// Transform to the parent's space.
    pub parent_from_local: DAffine3,
    /// Transform to world space. It may have overflowed; `check_extent` detects that later.
    pub world_from_local: DAffine3,
    /// Index of the glTF mesh of the node.
    pub mesh: Option<usize>,
}

/// Returns every node of the default scene, else of the first scene, else of the whole file.
pub fn place_nodes(source: &ImportSource, report: &mut ImportReport) -> Result<Vec<PlacedNode>, AssetFault> {
    let roots = roots(source.root, report);
    let mut placed: Vec<PlacedNode> = Vec::new();
    // The document is a checked forest, so each node is visited once.
    let mut waiting: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
    while let Some((index, parent)) = waiting.pop() {
        report.budget.spend(ImportLimit::Nodes, 1)?;
        let node = &source.root.nodes[index];
        let parent_from_local =
            transform(node).ok_or_else(|| invalid_gltf(format!("node {index} has no finite place")))?;
        let world_from_parent = parent.map_or(DAffine3::IDENTITY, |p| placed[p].world_from_local);
        let (placed_index, instances) = (placed.len(), instances::read(source, node, report)?);
        placed.push(PlacedNode {
            node: Some(index),
            name: display_name(node.name.as_deref(), "node", index),
            parent,
            parent_from_local,
            world_from_local: world_from_parent * parent_from_local,
            mesh: node.mesh.filter(|_| instances.is_none()).map(|m| m.value()),
        });
        for node_from_instance in instances.into_iter().flatten() {
            placed.push(PlacedNode {
                node: None,
                name: placed[placed_index].name.clone(),
                parent: Some(placed_index),
                parent_from_local: node_from_instance,
                world_from_local: placed[placed_index].world_from_local * node_from_instance,
                mesh: node.mesh.map(|m| m.value()),
            });
        }
        waiting.extend(node.children.iter().flatten().rev().map(|child| (child.value(), Some(placed_index))));
    }
    Ok(placed)
}

fn roots(root: &Root, report: &mut ImportReport) -> Vec<usize> {
    let drawn = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(drawn) {
        if root.scenes.len() > 1 {
            let which = format!("{} of {}", display_name(scene.name.as_deref(), "scene", drawn), root.scenes.len());
            report.notes.add("only one scene is drawn", which);
        }
        return scene.nodes.iter().map(gltf::json::Index::value).collect();
    }
    let mut is_root = vec![true; root.nodes.len()];
    root.nodes.iter().flat_map(|n| n.children.iter().flatten()).for_each(|child| is_root[child.value()] = false);
    (0..root.nodes.len()).filter(|&node| is_root[node]).collect()
}

/// Returns a node's matrix, or the composition of its translation, rotation and scale; `None` if it is not
/// finite.
fn transform(node: &Node) -> Option<DAffine3> {
    let transform = if let Some(m) = node.matrix {
        let column = |i: usize| DVec3::new(f64::from(m[i]), f64::from(m[i + 1]), f64::from(m[i + 2]));
        DAffine3 { matrix3: DMat3::from_cols(column(0), column(4), column(8)), translation: column(12) }
    } else {
        compose(
            node.translation.unwrap_or_default(),
            node.rotation.unwrap_or_default().0,
            node.scale.unwrap_or([1.0; 3]),
        )
    };
    transform.is_finite().then_some(transform)
}
