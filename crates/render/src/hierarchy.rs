//! Bounding-volume hierarchy of the scene's triangles, for ray tests near a receiver (`nearby.wgsl`).

use glam::{Vec3, Vec3A};
use hierarchy::Aabb;

use crate::gpu_structs::HierarchyNode;

/// Nodes in depth-first order, and the triangles of the leaves.
#[derive(Debug, Default)]
pub(crate) struct Hierarchy {
    pub nodes: Vec<HierarchyNode>,
    pub triangles: Vec<u32>,
}

/// Only node of the hierarchy of a scene without triangles. No ray meets it. It exists because a binding must not be
/// empty.
const NOWHERE: HierarchyNode = HierarchyNode { min: [f32::MAX; 3], triangle_count: 0, max: [f32::MIN; 3], next: 1 };

impl Hierarchy {
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let bounds = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|k| Vec3A::from_array(positions[k as usize]));
            Aabb { min: a.min(b).min(c), max: a.max(b).max(c) }
        };
        let built = hierarchy::Hierarchy::new(triangles.iter().map(bounds));
        let nodes = if triangles.is_empty() { vec![NOWHERE] } else { depth_first(&built) };
        Self { nodes, triangles: built.order }
    }
}

/// Returns the nodes in depth-first order, first children first.
fn depth_first(built: &hierarchy::Hierarchy) -> Vec<HierarchyNode> {
    let mut nodes = Vec::with_capacity(built.nodes.len());
    let mut open: Vec<u32> = vec![0];
    while let Some(index) = open.pop() {
        let node = &built.nodes[index as usize];
        let Aabb { min, max } = node.bounds;
        nodes.push(HierarchyNode {
            min: Vec3::from(min).to_array(),
            triangle_count: node.count,
            max: Vec3::from(max).to_array(),
            next: node.first,
        });
        if !node.is_leaf() {
            open.extend([node.first + 1, node.first]);
        }
    }
    // From the back, every subtree is complete when its root follows.
    let mut sizes: Vec<u32> = Vec::new();
    for index in (0..nodes.len()).rev() {
        let node = &mut nodes[index];
        if node.triangle_count > 0 {
            sizes.push(1);
            continue;
        }
        let children = sizes.pop().unwrap_or(0) + sizes.pop().unwrap_or(0);
        node.next = index as u32 + 1 + children;
        sizes.push(1 + children);
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a grid of `side` by `side` small triangles at a distance of 1, each 0.01 wide. Returns positions and
    /// indices.
    fn grid(side: u16) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let places = (0..side).flat_map(|x| (0..side).map(move |y| (f32::from(x), f32::from(y))));
        let positions: Vec<_> =
            places.flat_map(|(x, y)| [[x, y, 0.0], [x + 0.01, y, 0.0], [x, y + 0.01, 0.0]]).collect();
        let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        (positions, triangles)
    }

    /// Traverses the hierarchy like `nearby.wgsl`. Returns the triangles of all leaves whose boxes contain `point`, and
    /// the number of visited nodes.
    fn walk(hierarchy: &Hierarchy, point: [f32; 3]) -> (Vec<u32>, usize) {
        let (mut found, mut looked_at, mut index) = (Vec::new(), 0, 0);
        while let Some(node) = hierarchy.nodes.get(index) {
            looked_at += 1;
            let inside = (0..3).all(|k| node.min[k] <= point[k] && point[k] <= node.max[k]);
            let is_leaf = node.triangle_count > 0;
            if inside && is_leaf {
                let (first, count) = (node.next as usize, node.triangle_count as usize);
                found.extend(&hierarchy.triangles[first..first + count]);
            }
            index = if inside || is_leaf { index + 1 } else { node.next as usize };
        }
        (found, looked_at)
    }

    #[test]
    fn a_walk_finds_what_is_there_and_passes_by_the_rest() {
        let (positions, triangles) = grid(20);
        let hierarchy = Hierarchy::new(&positions, &triangles);
        for (index, corners) in triangles.iter().enumerate() {
            let (found, looked_at) = walk(&hierarchy, positions[corners[0] as usize]);
            assert!(found.contains(&(index as u32)), "triangle {index}: {found:?}");
            assert!(looked_at < hierarchy.nodes.len() / 4, "{looked_at} of {}", hierarchy.nodes.len());
        }
        assert_eq!(walk(&hierarchy, [0.5, 0.5, 0.0]).0, []);
    }

    #[test]
    fn nothing_is_met_nowhere() {
        let nothing = Hierarchy::new(&[], &[]);
        assert_eq!(walk(&nothing, [0.0; 3]), (Vec::new(), 1));
        let one = Hierarchy::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
        assert_eq!(walk(&one, [0.1, 0.1, 0.0]), (vec![0], 1));
    }
}
