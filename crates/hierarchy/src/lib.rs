//! Bounding-volume hierarchies: boxes in boxes, for rays in f64 (`raycast`) and for the GPU (`render`).
//!
//! Our own, since crates that build them are made for scenes that are well shaped: `obvhs` 0.4 takes the square of
//! the number of boxes where they lie in one place or along a line. Here each level costs as much as there are boxes, and there are [`MAX_DEPTH`] levels and as many as halving takes at most, whatever the boxes are.

mod bounds;
mod split;

pub use bounds::Aabb;
pub use split::MAX_DEPTH;
use split::{IndexedBox, split, union_of};

/// A box around others: around two nodes, or, in a leaf, around what was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchyNode {
    /// Around all that is below it.
    pub bounds: Aabb,
    /// Where its two nodes are in [`Hierarchy::nodes`]; of a leaf, where what it holds is in [`Hierarchy::order`].
    pub first: u32,
    /// How many of `order` a leaf holds; 0 of a node that is none.
    pub count: u32,
}

/// A binary tree of boxes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// The root first, children beside each other and behind their parents; none where nothing was given.
    pub nodes: Vec<HierarchyNode>,
    /// Indices of the boxes that were given, leaf by leaf.
    pub order: Vec<u32>,
}

impl HierarchyNode {
    /// Whether it holds what was given, and no nodes.
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

impl Hierarchy {
    /// Over these boxes, none of which has a coordinate that is not a number.
    ///
    /// Each box is split where the surface area heuristic (`MacDonald` and Booth, 1990) costs least among 16 bins an axis
    /// (Wald, 2007). Takes n log n steps, and gives the same on every machine.
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
}

#[cfg(test)]
mod tests;
