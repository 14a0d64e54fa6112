//! Trees of boxes around shadow casters. Shadow maps are fitted to them, and use them to select triangles.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::closed_components::{ClosedComponents, TriangleComponent};
use crate::bounds::BoundsF32;
use crate::settings::Culling;

/// Most triangles of a leaf. The workgroups of `bent_map_triangles.wgsl` have as many threads.
pub const TRIANGLES_PER_LEAF: usize = 64;
/// Vertices of a block. The workgroups of `bent_map_vertices.wgsl` have as many threads.
pub const VERTICES_PER_BLOCK: usize = 64;

/// Distance to a plane below which a box counts as intersecting the plane, as a share of the numbers that the distance
/// is computed from. It covers rounding on the CPU and the GPU.
const ROUNDING: f64 = 1e-6;

/// Largest distance of a triangle from a side of the casters' bounds at which the triangle counts as lying in that
/// side, as a share of the size of the bounds.
const SIDE_THICKNESS: f32 = 1e-6;

/// Boxes around shadow casters. Triangles in a side of the casters' bounds, such as floors and walls, are separate from
/// the others.
///
/// Nothing is behind a side, so it casts no visible shadow unless light enters through it.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    pub leaves: Vec<ClusterLeaf>,
    /// Number of leading triangles without an alpha test.
    pub opaque_triangles: u32,
    /// Indices of the blocks of vertices that the leaves use, leaf by leaf.
    blocks: Vec<u32>,
    /// Number of blocks of all vertices.
    pub block_count: u32,
    inner: ClusterTree,
    sides: Vec<(OpenSide, ClusterTree)>,
    /// True if the triangles are a simplification of the scene's surface.
    is_simplified: bool,
}

/// Group of up to `TRIANGLES_PER_LEAF` neighbouring triangles, which are adjacent in the list of casters.
#[derive(Clone, Debug)]
pub struct ClusterLeaf {
    pub triangles: Range<u32>,
    pub component: TriangleComponent,
    /// Bounds of all closed components that the leaf's triangles belong to.
    pub component_bounds: ClusterBounds,
    /// Range of the leaf's entries in `Clusters::blocks`.
    blocks: Range<usize>,
}

/// A side of the casters' bounds: the plane `normal . p = offset`, with nothing beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenSide {
    pub normal: DVec3,
    pub offset: f64,
}

/// Set of the sides of the casters' bounds that light enters through, as bits; see [`Clusters::open_sides`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct OpenSides(u8);

/// Tree of boxes. Nodes are in depth-first order: each comes before its descendants.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClusterTree {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    min: Vec3,
    max: Vec3,
    /// Index after the node's last descendant.
    end: usize,
    /// Index of the leaf, if the node has no descendants.
    leaf: u32,
}

/// An axis-aligned box in scene space.
#[derive(Clone, Copy, Debug)]
pub struct ClusterBounds {
    pub center: DVec3,
    /// Half its size along each axis.
    pub half: DVec3,
}

/// Selection of the leaves within a box. If several slabs of a light request different selections, the last one in this
/// order applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum BoxSelection {
    Skip,
    Descend,
    TakeAll,
}

impl ClusterLeaf {
    /// Returns the kind of the leaf's component for light from `source`. A closed component counts as open if the
    /// source may be inside of it.
    fn component_from(&self, source: Option<&ClusterBounds>) -> TriangleComponent {
        if source.is_some_and(|source| self.component_bounds.touches(source)) {
            TriangleComponent::Open
        } else {
            self.component
        }
    }
}

impl Clusters {
    /// Builds the boxes around triangles in scene space, the first `opaque` of which have no alpha test. Also returns
    /// the order of the leaves' triangles: alpha-tested ones follow the others in their original order.
    pub(crate) fn new(
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        (opaque, is_simplified): (usize, bool),
    ) -> (Self, Vec<u32>) {
        let corners = |triangle: u32| triangles[triangle as usize].map(|k| Vec3::from(positions[k as usize]));
        let bounds = BoundsF32::of(triangles.iter().flatten().map(|&k| Vec3::from(positions[k as usize])));
        let thickness = SIDE_THICKNESS * (bounds.max - bounds.min).max_element();
        // Two per axis: the lower side and the upper one.
        let side_of = |triangle: u32| {
            (0..INNER).find(|side| {
                let axis = side / 2;
                corners(triangle).iter().all(|p| {
                    let depth = if side % 2 == 0 { p[axis] - bounds.min[axis] } else { bounds.max[axis] - p[axis] };
                    depth <= thickness
                })
            })
        };
        let shells = ClosedComponents::new(positions, &triangles[..opaque]);
        let mut groups: [Vec<(Vec3, u32)>; 3 * (INNER + 1)] = Default::default();
        for triangle in 0..opaque as u32 {
            let group = 3 * side_of(triangle).unwrap_or(INNER) + shells.component_of(triangle) as usize;
            groups[group].push((corners(triangle).into_iter().sum::<Vec3>() / 3.0, triangle));
        }
        let mut order = Vec::with_capacity(triangles.len());
        let mut leaves_of: [Vec<(BoundsF32, u32)>; INNER + 1] = Default::default();
        let mut clusters = Self { is_simplified, opaque_triangles: opaque as u32, ..Self::default() };
        let mut add = |side: usize, shell: TriangleComponent, own: &mut dyn Iterator<Item = u32>| {
            let first = order.len();
            order.extend(own);
            let own = &order[first..];
            let shell_bounds = own.iter().map(|&triangle| shells.bounds(triangle));
            leaves_of[side].push((BoundsF32::of(own.iter().copied().flat_map(corners)), clusters.leaves.len() as u32));
            clusters.leaves.push(ClusterLeaf {
                triangles: first as u32..order.len() as u32,
                component: shell,
                component_bounds: if shell == TriangleComponent::Open {
                    ClusterBounds::NOTHING
                } else {
                    BoundsF32::union(shell_bounds).into()
                },
                blocks: 0..0,
            });
        };
        for (index, group) in groups.iter_mut().enumerate() {
            split(group, TRIANGLES_PER_LEAF, &mut |leaf| {
                add(index / 3, TriangleComponent::ALL[index % 3], &mut leaf.iter().map(|&(_, triangle)| triangle));
            });
        }
        let masked: Vec<u32> = (opaque as u32..triangles.len() as u32).collect();
        for run in masked.chunk_by(|&a, &b| side_of(a) == side_of(b)) {
            for leaf in run.chunks(TRIANGLES_PER_LEAF) {
                add(side_of(leaf[0]).unwrap_or(INNER), TriangleComponent::Open, &mut leaf.iter().copied());
            }
        }
        let [sides @ .., mut inner] = leaves_of;
        let side = |(side, mut leaves): (usize, Vec<_>)| {
            let axis = DVec3::AXES[side / 2];
            let (normal, offset) =
                if side % 2 == 0 { (-axis, -bounds.min[side / 2]) } else { (axis, bounds.max[side / 2]) };
            (OpenSide { normal, offset: offset.into() }, ClusterTree::new(&mut leaves))
        };
        clusters.sides = sides.into_iter().enumerate().filter(|(_, leaves)| !leaves.is_empty()).map(side).collect();
        clusters.inner = ClusterTree::new(&mut inner);
        (clusters, order)
    }

    /// Records the blocks of vertices that each leaf uses. `indices` are the corners of the triangles, in the order of
    /// the leaves.
    pub(crate) fn note_blocks(&mut self, indices: &[u32]) {
        self.block_count = indices.iter().max().map_or(0, |last| last / VERTICES_PER_BLOCK as u32 + 1);
        for leaf in &mut self.leaves {
            let corners = &indices[3 * leaf.triangles.start as usize..3 * leaf.triangles.end as usize];
            let mut own: Vec<u32> = corners.iter().map(|vertex| vertex / VERTICES_PER_BLOCK as u32).collect();
            own.sort_unstable();
            own.dedup();
            leaf.blocks = self.blocks.len()..self.blocks.len() + own.len();
            self.blocks.extend(own);
        }
    }

    /// Returns the blocks of vertices that a leaf uses.
    pub(crate) fn blocks_of(&self, leaf: &ClusterLeaf) -> &[u32] {
        &self.blocks[leaf.blocks.clone()]
    }

    /// Returns the sides of the bounds that may cast visible shadows: those for which `comes_in` returns true, because
    /// light enters through them.
    pub(crate) fn open_sides(&self, comes_in: impl Fn(&OpenSide) -> bool) -> OpenSides {
        // Simplified casters may have surfaces behind a side.
        let open = |side: &OpenSide| self.is_simplified || comes_in(side);
        OpenSides(self.sides.iter().enumerate().filter(|(_, (side, _))| open(side)).map(|(k, _)| 1 << k).sum())
    }

    /// Returns the trees of all casters that may cast visible shadows: the inner ones, and those in the given sides.
    pub(crate) fn casting_trees(&self, open: OpenSides) -> impl Iterator<Item = &ClusterTree> {
        let sides = self.sides.iter().enumerate().filter(move |(k, _)| open.0 >> k & 1 != 0);
        std::iter::once(&self.inner).chain(sides.map(|(_, (_, tree))| tree))
    }

    /// Passes the leaves of those casters that `select` does not skip to `take`, with their component for light from
    /// `source`.
    pub(crate) fn select(
        &self,
        open: OpenSides,
        culling: Culling,
        source: Option<&ClusterBounds>,
        select: impl Fn(&ClusterBounds) -> BoxSelection,
        mut take: impl FnMut(&ClusterLeaf, TriangleComponent),
    ) {
        for tree in self.casting_trees(open) {
            tree.select(
                |cluster| if culling.clusters { select(cluster) } else { BoxSelection::TakeAll },
                |leaf| {
                    let leaf = &self.leaves[leaf as usize];
                    take(leaf, if culling.backs { leaf.component_from(source) } else { TriangleComponent::Open });
                },
            );
        }
    }
}

/// Index of the group of triangles that lie in no side of the bounds; smaller indices are the sides.
const INNER: usize = 6;

impl From<BoundsF32> for ClusterBounds {
    fn from(BoundsF32 { min, max }: BoundsF32) -> Self {
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        Self { center: (min + max) / 2.0, half: (max - min) / 2.0 }
    }
}

/// Splits items at the medians of their centers until a group has at most `most`, and passes each group to `leaf`.
fn split<T>(items: &mut [(Vec3, T)], most: usize, leaf: &mut impl FnMut(&[(Vec3, T)])) {
    if items.is_empty() {
        return;
    }
    if items.len() <= most {
        leaf(items);
        return;
    }
    let (left, right) = halves(items, |(center, _)| *center);
    split(left, most, leaf);
    split(right, most, leaf);
}

fn halves<T>(items: &mut [T], center: impl Fn(&T) -> Vec3) -> (&mut [T], &mut [T]) {
    let BoundsF32 { min, max } = BoundsF32::of(items.iter().map(&center));
    let axis = (max - min).max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| center(a)[axis].total_cmp(&center(b)[axis]));
    items.split_at_mut(middle)
}

impl OpenSide {
    /// Returns the distance of a position in scene space beyond the side.
    pub fn height(&self, position: DVec3) -> f64 {
        self.normal.dot(position) - self.offset
    }
}

impl ClusterTree {
    /// Builds a tree over leaves, given their bounds and indices.
    fn new(leaves: &mut [(BoundsF32, u32)]) -> Self {
        let mut tree = Self::default();
        if !leaves.is_empty() {
            tree.add(leaves);
        }
        tree
    }

    /// Adds a node for those leaves, with its descendants. Returns its bounds.
    fn add(&mut self, leaves: &mut [(BoundsF32, u32)]) -> BoundsF32 {
        let index = self.nodes.len();
        let BoundsF32 { min, max } = BoundsF32::NOTHING;
        self.nodes.push(Node { min, max, end: index + 1, leaf: leaves[0].1 });
        let bounds = if let [(bounds, _)] = leaves {
            *bounds
        } else {
            let (left, right) = halves(leaves, |(bounds, _)| bounds.min + (bounds.max - bounds.min) * 0.5);
            let (left, right) = (self.add(left), self.add(right));
            BoundsF32::union([left, right].into_iter())
        };
        let BoundsF32 { min, max } = bounds;
        self.nodes[index] = Node { min, max, end: self.nodes.len(), ..self.nodes[index] };
        bounds
    }

    /// Passes boxes to `visit`, parents first, with true if the box has descendants. Skips the descendants if `visit`
    /// returns false.
    pub fn walk(&self, mut visit: impl FnMut(&ClusterBounds, bool) -> bool) {
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let has_more = node.end > index + 1;
            index = if visit(&node.cluster(), has_more) { index + 1 } else { node.end };
        }
    }

    /// Passes boxes to `visit`, parents first, and the leaves that were not skipped to `take`.
    fn select(&self, visit: impl Fn(&ClusterBounds) -> BoxSelection, mut take: impl FnMut(u32)) {
        let (mut index, mut taken_to) = (0, 0);
        while let Some(node) = self.nodes.get(index) {
            let within = if index < taken_to { BoxSelection::TakeAll } else { visit(&node.cluster()) };
            match within {
                BoxSelection::Skip => {
                    index = node.end;
                    continue;
                }
                BoxSelection::TakeAll => taken_to = taken_to.max(node.end),
                BoxSelection::Descend => {}
            }
            if node.end == index + 1 {
                take(node.leaf);
            }
            index += 1;
        }
    }
}

/// Part of a shadow map that boxes cover.
pub(crate) trait MapCover: Sized {
    fn contains(&self, other: &Self) -> bool;
    fn extend(&mut self, other: &Self);

    /// Extends the cover by the boxes of leaves. `cover_of` returns the part that a box covers; `None` if it covers
    /// none.
    fn extend_by_leaves<'a>(
        &mut self,
        trees: impl Iterator<Item = &'a ClusterTree>,
        cover_of: impl Fn(&ClusterBounds) -> Option<Self>,
    ) {
        for tree in trees {
            tree.walk(|cluster, has_more| {
                let Some(here) = cover_of(cluster) else { return false };
                if !has_more {
                    self.extend(&here);
                }
                has_more && !self.contains(&here)
            });
        }
    }
}

impl Node {
    fn cluster(&self) -> ClusterBounds {
        BoundsF32 { min: self.min, max: self.max }.into()
    }
}

impl ClusterBounds {
    const NOTHING: Self = Self { center: DVec3::ZERO, half: DVec3::NEG_INFINITY };

    /// Classifies the box against planes in scene space, with `normal . p + offset` zero or more inside. It is taken if
    /// inside all planes, and skipped if outside one. `reach` scales the planes' rounding, in addition to the
    /// positions.
    pub(crate) fn select_by_planes(&self, planes: &[(DVec3, f64)], reach: f64) -> BoxSelection {
        let of = |&(normal, offset): &(DVec3, f64)| {
            let [low, high] = self.range(normal, offset);
            let reach = reach + offset.abs() + normal.abs().dot(self.center.abs() + self.half);
            let slack = ROUNDING * reach;
            if high < -slack {
                BoxSelection::Skip
            } else if low < slack {
                BoxSelection::Descend
            } else {
                BoxSelection::TakeAll
            }
        };
        planes.iter().map(of).min().unwrap_or(BoxSelection::TakeAll)
    }

    /// True if two boxes share a point.
    pub(crate) fn touches(&self, other: &Self) -> bool {
        (self.center - other.center).abs().cmple(self.half + other.half).all()
    }

    /// Returns the least and the greatest value of `normal . p + offset` over the box.
    pub(crate) fn range(&self, normal: DVec3, offset: f64) -> [f64; 2] {
        let (middle, reach) = (normal.dot(self.center) + offset, normal.abs().dot(self.half));
        [middle - reach, middle + reach]
    }

    pub(crate) fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|k| {
            let sign = DVec3::new(f64::from(k as u8 & 1), f64::from(k as u8 >> 1 & 1), f64::from(k as u8 >> 2));
            self.center + self.half * (sign * 2.0 - 1.0)
        })
    }
}

/// Builds the clusters of triangles without alpha tests.
#[cfg(test)]
pub(crate) fn of_opaque(positions: &[[f32; 3]], indices: &[u32]) -> Clusters {
    let triangles = indices.as_chunks().0;
    Clusters::new(positions, triangles, (triangles.len(), false)).0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that each triangle is in a leaf, that leaves are small, and that boxes contain their descendants.
    #[test]
    fn boxes_hold_their_triangles() {
        let positions: Vec<[f32; 3]> = (0..3000).map(|k| [0.37, 0.71, 0.19].map(|x| (x * k as f32).fract())).collect();
        let indices: Vec<u32> = (0..3000).collect();
        let clusters = of_opaque(&positions, &indices);
        let mut leaves = Vec::new();
        clusters.inner.walk(|cluster, has_more| {
            if !has_more {
                leaves.push(*cluster);
            }
            true
        });
        assert_eq!(leaves.len(), 16, "1000 triangles, halved until there are 64 or fewer");
        let holds = |cluster: &ClusterBounds, point: DVec3, slack: f64| {
            (point - cluster.center).abs().cmple(cluster.half + slack).all()
        };
        for triangle in positions.as_chunks::<3>().0 {
            let inside = |leaf: &&ClusterBounds| {
                triangle.iter().all(|&corner| holds(leaf, Vec3::from(corner).as_dvec3(), 1e-12))
            };
            assert!(leaves.iter().any(|leaf| inside(&leaf)));
        }
        let mut outer = None;
        clusters.inner.walk(|cluster, _| {
            outer = Some(*cluster);
            false
        });
        let outer = outer.expect("there is a root");
        assert!(leaves.iter().flat_map(ClusterBounds::corners).all(|corner| holds(&outer, corner, 1e-12)));
        of_opaque(&[], &[]).inner.walk(|_, _| unreachable!("nothing has no box"));
    }

    /// A floor under everything is in a side, with nothing behind it. A table on it is not.
    #[test]
    fn floors_are_sides() {
        let square = |y: f32, half: f32| [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(x, z)| [x * half, y, z * half]);
        let positions = [square(-1.0, 5.0), square(1.0, 1.0), square(3.0, 0.5), square(-1.0, 2.0)].concat();
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        let clusters = of_opaque(&positions, &indices);
        let sides: Vec<_> = clusters.sides.iter().map(|(side, _)| *side).collect();
        let [floor, ceiling] =
            [(DVec3::NEG_Y, 1.0), (DVec3::Y, 3.0)].map(|(normal, offset)| OpenSide { normal, offset });
        assert_eq!(sides, [floor, ceiling]);
        assert_eq!((floor.height(DVec3::ZERO), floor.height(DVec3::NEG_Y * 3.0)), (-1.0, 2.0));
        let stray = Clusters { is_simplified: true, ..clusters.clone() };
        let boxes =
            |clusters: &Clusters, comes_in: bool| clusters.casting_trees(clusters.open_sides(|_| comes_in)).count();
        assert_eq!([boxes(&clusters, false), boxes(&clusters, true), boxes(&stray, false)], [1, 3, 3]);
    }
}
