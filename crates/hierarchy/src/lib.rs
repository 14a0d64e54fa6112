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

use std::ops::Range;

use glam::Vec3A;

pub use bounds::Aabb;
pub use split::MAX_DEPTH;
use split::{IndexedBox, split, union_of};

/// Node of a [`Hierarchy`], in the layout of a storage buffer: `nearby.wgsl` has the same struct. Its box contains its two child
/// nodes or, in a leaf, the boxes of the leaf.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct HierarchyNode {
    /// Least corner of the box.
    pub min: [f32; 3],
    /// Number of entries of [`Hierarchy::order`] in a leaf; 0 for an inner node.
    pub count: u32,
    /// Greatest corner of the box.
    pub max: [f32; 3],
    /// Leaf: index in `order` of its first box. Inner node: index of the node after all its descendants, where a traversal goes
    /// that skips the node.
    pub next: u32,
}

/// Binary tree of boxes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// Nodes in depth-first order, the root first. The first child of a node follows it. Empty if there are no boxes.
    pub nodes: Vec<HierarchyNode>,
    /// Indices of the given boxes, leaf by leaf.
    pub order: Vec<u32>,
}

impl HierarchyNode {
    /// Node that no ray meets, for a buffer that must not be empty.
    pub const NOWHERE: Self = Self { min: [f32::MAX; 3], count: 0, max: [f32::MIN; 3], next: 1 };

    /// Returns true if the node holds boxes and no child nodes.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }

    pub fn bounds(&self) -> Aabb {
        Aabb { min: Vec3A::from(self.min), max: Vec3A::from(self.max) }
    }
}

/// Items of a node that is to be made.
struct OpenNode {
    items: Range<usize>,
    depth: u32,
}

impl Hierarchy {
    /// Builds a tree over `boxes`. No coordinate may be NaN.
    ///
    /// Each node is split where the surface area heuristic (`MacDonald` and Booth, 1990) costs least among 16 bins an
    /// axis (Wald, 2007). The time is proportional to n log n. The result is the same on every machine.
    pub fn new(boxes: impl IntoIterator<Item = Aabb>) -> Self {
        let mut items: Vec<IndexedBox> =
            boxes.into_iter().zip(0..).map(|(bounds, index)| IndexedBox { bounds, index }).collect();
        let mut nodes = Vec::new();
        let mut open = Vec::new();
        if !items.is_empty() {
            open.push(OpenNode { items: 0..items.len(), depth: 0 });
        }
        while let Some(OpenNode { items: Range { start, end }, depth }) = open.pop() {
            let below = &mut items[start..end];
            let bounds = union_of(below);
            let middle = split(below, bounds, depth).map(|left| start + left);
            let count = if middle.is_none() { (end - start) as u32 } else { 0 };
            let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
            nodes.push(HierarchyNode { min, count, max, next: start as u32 });
            if let Some(middle) = middle {
                // The first child is made next.
                open.push(OpenNode { items: middle..end, depth: depth + 1 });
                open.push(OpenNode { items: start..middle, depth: depth + 1 });
            }
        }
        link_past_descendants(&mut nodes);
        Self { nodes, order: items.iter().map(|item| item.index).collect() }
    }

    /// Returns the indices of the boxes in a leaf; none for an inner node.
    pub fn items(&self, node: &HierarchyNode) -> &[u32] {
        if node.is_leaf() { &self.order[node.next as usize..][..node.count as usize] } else { &[] }
    }

    /// Returns the indices of the two child nodes of an inner node.
    pub fn children(&self, index: u32) -> [u32; 2] {
        let first = &self.nodes[index as usize + 1];
        [index + 1, if first.is_leaf() { index + 2 } else { first.next }]
    }
}

/// Sets `next` of all inner nodes.
fn link_past_descendants(nodes: &mut [HierarchyNode]) {
    // From the back, the subtrees of both children are complete when their parent follows: their numbers of nodes.
    let mut sizes: Vec<u32> = Vec::new();
    for (index, node) in nodes.iter_mut().enumerate().rev() {
        if node.is_leaf() {
            sizes.push(1);
            continue;
        }
        let size = 1 + sizes.pop().unwrap_or(0) + sizes.pop().unwrap_or(0);
        node.next = index as u32 + size;
        sizes.push(size);
    }
}

#[cfg(test)]
mod tests;
