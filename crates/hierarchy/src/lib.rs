//! Bounding-volume hierarchies over axis-aligned boxes, for rays in f64 (`raycast`) and for the GPU (`render`).
//!
//! The crate builds trees and does not traverse them. It knows no triangles, rays, scenes or devices: a caller gives
//! boxes and gets their indices back, leaf by leaf. Boxes are in f32, so callers round them outwards.
//!
//! The builder is our own because other crates assume well-shaped scenes: `obvhs` 0.4 takes the square of the number of
//! boxes if they lie in one place or along a line. Here each level costs time proportional to the number of boxes. The
//! depth is at most [`MAX_DEPTH`] levels plus the number of levels that halving takes, whatever the boxes are.
//!
//! Begin with [`Hierarchy::new`]. `split` has the surface area heuristic.

mod bounds;
mod split;

pub use bounds::Aabb;
pub use split::MAX_DEPTH;
use split::{IndexedBox, split, union_of};

/// Node of a [`Hierarchy`]. Its box contains its two child nodes or, in a leaf, the boxes of the leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchyNode {
    pub bounds: Aabb,
    /// Inner node: index in [`Hierarchy::nodes`] of the first of its two children. Leaf: index in [`Hierarchy::order`]
    /// of its first box.
    pub first: u32,
    /// Number of entries of `order` in a leaf; 0 for an inner node.
    pub count: u32,
}

/// Binary tree of boxes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// Nodes, the root first. The two children of a node are adjacent and come after it. Empty if there are no boxes.
    pub nodes: Vec<HierarchyNode>,
    /// Indices of the given boxes, leaf by leaf.
    pub order: Vec<u32>,
}

impl HierarchyNode {
    /// Returns true if the node holds boxes and no child nodes.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

impl Hierarchy {
    /// Builds a tree over `boxes`. No coordinate may be NaN.
    ///
    /// Each node is split where the surface area heuristic (`MacDonald` and Booth, 1990) costs least among 16 bins an
    /// axis (Wald, 2007). The time is proportional to n log n. The result is the same on every machine.
    pub fn new(boxes: impl IntoIterator<Item = Aabb>) -> Self {
        let mut items: Vec<IndexedBox> =
            boxes.into_iter().zip(0..).map(|(bounds, index)| IndexedBox { bounds, index }).collect();
        let (mut nodes, mut open) = (Vec::with_capacity(items.len()), Vec::new());
        if !items.is_empty() {
            nodes.push(HierarchyNode { bounds: union_of(&items), first: 0, count: items.len() as u32 });
            open.push((0, 0));
        }
        while let Some((index, depth)) = open.pop() {
            let HierarchyNode { bounds, first, count } = nodes[index];
            let (begin, end) = (first as usize, (first + count) as usize);
            let below = &mut items[begin..end];
            let Some(left) = split(below, bounds, depth) else { continue };
            let (one, other) = below.split_at(left);
            let children = nodes.len();
            nodes.push(HierarchyNode { bounds: union_of(one), first, count: left as u32 });
            nodes.push(HierarchyNode {
                bounds: union_of(other),
                first: first + left as u32,
                count: count - left as u32,
            });
            nodes[index] = HierarchyNode { bounds, first: children as u32, count: 0 };
            open.extend([(children + 1, depth + 1), (children, depth + 1)]);
        }
        Self { nodes, order: items.iter().map(|item| item.index).collect() }
    }

    /// Returns the indices of the boxes in a leaf; none for an inner node.
    pub fn items(&self, node: &HierarchyNode) -> &[u32] {
        &self.order[node.first as usize..][..node.count as usize]
    }
}

#[cfg(test)]
mod tests;
