//! Boxes around the scene's triangles, in a tree: what shadow maps are fitted to.

use glam::{DVec3, Vec3};

/// Most triangles of a box that has no boxes within.
const TRIANGLES_A_LEAF: usize = 64;

/// How far from a side of the scene's bounds a triangle may be that lies in it, as a share of their size: rounding.
const SIDE_THICKNESS: f32 = 1e-6;

/// Boxes around a scene's triangles: those that lie in a side of its bounds, as floors and walls do, and the others.
///
/// Nothing lies behind a side, so a side casts no shadow that can be seen, unless light comes in through it.
#[derive(Debug, Default)]
pub(crate) struct Clusters {
    inner: Tree,
    sides: Vec<(Side, Tree)>,
}

/// A side of the scene's bounds: the plane `normal . p = offset`, whose outer side holds nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Side {
    pub normal: DVec3,
    pub offset: f64,
}

/// A node before those within it.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    min: Vec3,
    max: Vec3,
    /// Where the nodes within this one end.
    end: usize,
}

/// A box along the axes of scene space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster {
    pub center: DVec3,
    /// Half its extents.
    pub half: DVec3,
}

impl Clusters {
    /// Boxes around triangles in scene space.
    pub fn new(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        let triangles = indices.as_chunks::<3>().0;
        let corners = |triangle: u32| triangles[triangle as usize].map(|k| Vec3::from(positions[k as usize]));
        let extend = |(min, max): (Vec3, Vec3), p: Vec3| (min.min(p), max.max(p));
        let all = (0..triangles.len() as u32).flat_map(corners);
        let (min, max) = all.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), extend);
        let thickness = SIDE_THICKNESS * (max - min).max_element();
        // Two for each axis: the lower side and the upper one.
        let side_of = |corners: [Vec3; 3]| {
            (0..6).find(|side| {
                let axis = side / 2;
                corners.iter().all(|p| {
                    let depth = if side % 2 == 0 { p[axis] - min[axis] } else { max[axis] - p[axis] };
                    depth <= thickness
                })
            })
        };
        let mut groups: [Vec<(Vec3, u32)>; 7] = Default::default();
        for triangle in 0..triangles.len() as u32 {
            let corners = corners(triangle);
            let center = corners.into_iter().sum::<Vec3>() / 3.0;
            groups[side_of(corners).unwrap_or(6)].push((center, triangle));
        }
        let [sides @ .., mut inner] = groups;
        let side = |(side, mut centers): (usize, Vec<_>)| {
            let axis = DVec3::AXES[side / 2];
            let (normal, offset) =
                if side % 2 == 0 { (-axis, -min[side / 2]) } else { (axis, max[side / 2]) };
            (Side { normal, offset: offset.into() }, Tree::new(&mut centers, &corners))
        };
        let sides =
            sides.into_iter().enumerate().filter(|(_, centers)| !centers.is_empty()).map(side).collect();
        Self { inner: Tree::new(&mut inner, &corners), sides }
    }

    /// The trees of what may cast shadows that can be seen, where casters stray from the surface by `margin`. `comes_in`
    /// says through which sides light does.
    pub fn casting(&self, margin: f64, comes_in: impl Fn(&Side) -> bool) -> impl Iterator<Item = &Tree> {
        // Casters that stray from a side have something behind them.
        let sides = self.sides.iter().filter(move |(side, _)| margin > 0.0 || comes_in(side));
        std::iter::once(&self.inner).chain(sides.map(|(_, tree)| tree))
    }
}

impl Side {
    /// How far outside a position in scene space lies.
    pub fn height(&self, position: DVec3) -> f64 {
        self.normal.dot(position) - self.offset
    }
}

impl Tree {
    /// Of triangles by their centres, split at the medians of those.
    fn new(centers: &mut [(Vec3, u32)], corners: &impl Fn(u32) -> [Vec3; 3]) -> Self {
        let mut tree = Self::default();
        if !centers.is_empty() {
            tree.add(centers, corners);
        }
        tree
    }

    /// Adds the node of those triangles, by their centres, and all within; returns its bounds.
    fn add(&mut self, centers: &mut [(Vec3, u32)], corners: &impl Fn(u32) -> [Vec3; 3]) -> (Vec3, Vec3) {
        let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let extend = |(min, max): (Vec3, Vec3), p: Vec3| (min.min(p), max.max(p));
        let index = self.nodes.len();
        self.nodes.push(Node { min: nothing.0, max: nothing.1, end: index + 1 });
        let (min, max) = if centers.len() <= TRIANGLES_A_LEAF {
            centers.iter().flat_map(|&(_, triangle)| corners(triangle)).fold(nothing, extend)
        } else {
            let (low, high) = centers.iter().map(|(center, _)| *center).fold(nothing, extend);
            let axis = (high - low).max_position();
            let middle = centers.len() / 2;
            centers.select_nth_unstable_by(middle, |(a, _), (b, _)| a[axis].total_cmp(&b[axis]));
            let (left, right) = centers.split_at_mut(middle);
            let (left, right) = (self.add(left, corners), self.add(right, corners));
            (left.0.min(right.0), left.1.max(right.1))
        };
        self.nodes[index] = Node { min, max, end: self.nodes.len() };
        (min, max)
    }

    /// Shows `visit` boxes grown by `margin`, from the largest on, and whether one has boxes within. Where it says no,
    /// those are left out.
    pub fn walk(&self, margin: f64, mut visit: impl FnMut(&Cluster, bool) -> bool) {
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let (min, max) = (node.min.as_dvec3(), node.max.as_dvec3());
            let cluster = Cluster { center: (min + max) / 2.0, half: (max - min) / 2.0 + margin };
            let has_more = node.end > index + 1;
            index = if visit(&cluster, has_more) { index + 1 } else { node.end };
        }
    }
}

impl Cluster {
    /// The least and the greatest value of `normal . p + offset` in the box.
    pub fn range(&self, normal: DVec3, offset: f64) -> [f64; 2] {
        let (middle, reach) = (normal.dot(self.center) + offset, normal.abs().dot(self.half));
        [middle - reach, middle + reach]
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|k| {
            let sign =
                DVec3::new(f64::from(k as u8 & 1), f64::from(k as u8 >> 1 & 1), f64::from(k as u8 >> 2));
            self.center + self.half * (sign * 2.0 - 1.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each triangle lies in a leaf, leaves are small, and boxes hold those within them.
    #[test]
    fn boxes_hold_their_triangles() {
        let positions: Vec<[f32; 3]> =
            (0..3000).map(|k| [0.37, 0.71, 0.19].map(|x| (x * k as f32).fract())).collect();
        let indices: Vec<u32> = (0..3000).collect();
        let clusters = Clusters::new(&positions, &indices);
        let mut leaves = Vec::new();
        clusters.inner.walk(0.0, |cluster, has_more| {
            if !has_more {
                leaves.push(*cluster);
            }
            true
        });
        assert_eq!(leaves.len(), 16, "1000 triangles, halved until there are 64 or fewer");
        let holds = |cluster: &Cluster, point: DVec3, slack: f64| {
            (point - cluster.center).abs().cmple(cluster.half + slack).all()
        };
        for triangle in positions.as_chunks::<3>().0 {
            let inside = |leaf: &&Cluster| {
                triangle.iter().all(|&corner| holds(leaf, Vec3::from(corner).as_dvec3(), 1e-12))
            };
            assert!(leaves.iter().any(|leaf| inside(&leaf)));
        }
        let mut outer = None;
        clusters.inner.walk(0.5, |cluster, _| {
            outer = Some(*cluster);
            false
        });
        let outer = outer.expect("there is a root");
        assert!(leaves.iter().flat_map(Cluster::corners).all(|corner| holds(&outer, corner, -0.499)));
        Clusters::new(&[], &[]).inner.walk(0.0, |_, _| unreachable!("nothing has no box"));
    }

    /// A floor under everything lies in a side, with nothing behind it; a table on it does not.
    #[test]
    fn floors_are_sides() {
        let square =
            |y: f32, half: f32| [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(x, z)| [x * half, y, z * half]);
        let positions = [square(-1.0, 5.0), square(1.0, 1.0), square(3.0, 0.5), square(-1.0, 2.0)].concat();
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        let clusters = Clusters::new(&positions, &indices);
        let sides: Vec<_> = clusters.sides.iter().map(|(side, _)| *side).collect();
        let [floor, ceiling] =
            [(DVec3::NEG_Y, 1.0), (DVec3::Y, 3.0)].map(|(normal, offset)| Side { normal, offset });
        assert_eq!(sides, [floor, ceiling]);
        assert_eq!((floor.height(DVec3::ZERO), floor.height(DVec3::NEG_Y * 3.0)), (-1.0, 2.0));
        let boxes = |margin: f64, comes_in: bool| clusters.casting(margin, move |_| comes_in).count();
        assert_eq!([boxes(0.0, false), boxes(0.0, true), boxes(0.1, false)], [1, 3, 3]);
    }
}
