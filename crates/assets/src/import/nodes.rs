//! The node hierarchy of the scene that is drawn, parents first, placed in f64.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json::{Node, Root};

use super::{Report, Source, instances, name_or};
use crate::fault::broken;
use crate::{Fault, Limit};

/// A node at its place in the world.
#[derive(Debug)]
pub struct Place {
    /// Index of the glTF node; `None` for an instance that a node's extension added.
    pub node: Option<usize>,
    /// Name for people.
    pub name: String,
    /// Index of the parent place, less than this one's own.
    pub parent: Option<usize>,
    /// Placement in the parent's space.
    pub parent_from_local: DAffine3,
    /// Placement in the world; may have overflowed, which is found at the end.
    pub world_from_local: DAffine3,
    /// Index of the glTF mesh that stands here.
    pub mesh: Option<usize>,
}

/// Every node of the default scene, else of the first, else of the whole file.
pub fn place(source: &Source, report: &mut Report) -> Result<Vec<Place>, Fault> {
    let roots = roots(source.root, report);
    let mut places: Vec<Place> = Vec::new();
    // The check of the document has shown a forest, so each node is visited once.
    let mut waiting: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
    while let Some((index, parent)) = waiting.pop() {
        report.budget.spend(Limit::Nodes, 1)?;
        let node = &source.root.nodes[index];
        let parent_from_local =
            transform(node).ok_or_else(|| broken(format!("node {index} has no finite place")))?;
        let world_from_parent = parent.map_or(DAffine3::IDENTITY, |p| places[p].world_from_local);
        let (place, instances) = (places.len(), instances::read(source, node, report)?);
        places.push(Place {
            node: Some(index),
            name: name_or(node.name.as_deref(), "node", index),
            parent,
            parent_from_local,
            world_from_local: world_from_parent * parent_from_local,
            mesh: node.mesh.filter(|_| instances.is_none()).map(|m| m.value()),
        });
        for node_from_instance in instances.into_iter().flatten() {
            places.push(Place {
                node: None,
                name: places[place].name.clone(),
                parent: Some(place),
                parent_from_local: node_from_instance,
                world_from_local: places[place].world_from_local * node_from_instance,
                mesh: node.mesh.map(|m| m.value()),
            });
        }
        waiting.extend(node.children.iter().flatten().rev().map(|child| (child.value(), Some(place))));
    }
    Ok(places)
}

fn roots(root: &Root, report: &mut Report) -> Vec<usize> {
    let drawn = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(drawn) {
        if root.scenes.len() > 1 {
            let which =
                format!("{} of {}", name_or(scene.name.as_deref(), "scene", drawn), root.scenes.len());
            report.notes.add("only one scene is drawn", which);
        }
        return scene.nodes.iter().map(gltf::json::Index::value).collect();
    }
    let mut is_root = vec![true; root.nodes.len()];
    root.nodes
        .iter()
        .flat_map(|n| n.children.iter().flatten())
        .for_each(|child| is_root[child.value()] = false);
    (0..root.nodes.len()).filter(|&node| is_root[node]).collect()
}

/// A node's matrix, or its translation, rotation and scale; `None` where it is not finite.
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

/// `T * R * S`; a rotation of no length is none.
pub fn compose(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> DAffine3 {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let rotation = DQuat::from_array(rotation.map(f64::from));
    let length = rotation.length();
    let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
    DAffine3::from_scale_rotation_translation(vector(scale), rotation, vector(translation))
}

/// The rigid placement of something that has a direction, a camera or a light: scale and shear taken out.
///
/// Keeps the direction of local Z; local Y is made orthogonal to it. Where an axis has no length, or both lie
/// on one line, any that completes the frame will do.
pub fn rigid(world_from_local: &DAffine3) -> DAffine3 {
    let back = world_from_local.matrix3.z_axis.normalize_or(DVec3::Z);
    let up = world_from_local.matrix3.y_axis.normalize_or(DVec3::Y).reject_from_normalized(back);
    let up = if up.length() > 1e-6 { up.normalize() } else { back.any_orthonormal_vector() };
    DAffine3 {
        matrix3: DMat3::from_cols(up.cross(back), up, back),
        translation: world_from_local.translation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigid_placement_is_a_rotation_whatever_comes_in() {
        let turn = DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize();
        let scales = [
            DVec3::ONE,
            DVec3::new(2.0, -3.0, 0.5),
            DVec3::ZERO,
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::splat(1e-200),
        ];
        for scale in scales {
            let m = rigid(&DAffine3::from_scale_rotation_translation(scale, turn, DVec3::X)).matrix3;
            assert!((m.determinant() - 1.0).abs() < 1e-12, "{scale}");
            assert!((m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-12), "{scale}");
        }
        let kept =
            rigid(&DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 3.0, 5.0), turn, DVec3::X));
        assert!(kept.matrix3.abs_diff_eq(DMat3::from_quat(turn), 1e-12), "scale alone changes no direction");
    }
}
