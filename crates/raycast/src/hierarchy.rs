//! Traversal of a scene's bounding-volume hierarchy. Its boxes are in f32, so that f64 is spent on triangles only.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use hierarchy::HierarchyNode;
use scene::PosedScene;

use crate::Aabb64;

pub(crate) struct TriangleHierarchy(Arc<hierarchy::Hierarchy>);

impl fmt::Debug for TriangleHierarchy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Hierarchy({} nodes)", self.0.nodes.len())
    }
}

/// Straight line with a thickness: all points within `radius` of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThickLine {
    pub from: DVec3,
    pub to: DVec3,
    pub radius: f64,
}

/// Returns the cost of visiting a node, in steps: one for the boxes, six for each triangle.
fn node_cost_steps(node: &HierarchyNode) -> u64 {
    1 + if node.is_leaf() { 6 * u64::from(node.count) } else { 0 }
}

impl TriangleHierarchy {
    pub fn new(posed: &PosedScene) -> Self {
        Self(Arc::clone(posed.hierarchy()))
    }

    /// Returns the box around all triangles; `None` if there are none.
    pub fn bounds(&self) -> Option<Aabb64> {
        let hierarchy::Aabb { min, max } = self.0.nodes.first()?.bounds();
        Some(Aabb64 { min: min.as_dvec3(), max: max.as_dvec3() })
    }

    /// Returns the distance from `point` beyond which there are no triangles.
    pub fn max_distance_from(&self, point: DVec3) -> f64 {
        self.bounds().map_or(0.0, |Aabb64 { min, max }| 1.01 * (min - point).abs().max((max - point).abs()).length())
    }

    /// Calls `meet` with every triangle whose box is close enough to `point`: within the distance that `meet` returned
    /// last, and at first within `within`. Stops if `spend` refuses further steps.
    pub fn visit_near_point(
        &self,
        point: DVec3,
        mut within: f64,
        spend: impl Fn(u64) -> bool,
        mut meet: impl FnMut(usize) -> f64,
    ) {
        let mut stack: Vec<u32> = if self.0.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = stack.pop() {
            let node = &self.0.nodes[index as usize];
            if !spend(node_cost_steps(node)) {
                return;
            }
            let hierarchy::Aabb { min, max } = node.bounds();
            if point.clamp(min.as_dvec3(), max.as_dvec3()).distance(point) > within {
                continue;
            }
            if node.is_leaf() {
                for &triangle in self.0.items(node) {
                    within = meet(triangle as usize);
                }
            } else {
                stack.extend(self.0.children(index));
            }
        }
    }

    /// Calls `meet` with every triangle whose box the line may touch. Nearer boxes come first. Boxes beyond the share
    /// of the line's length that `meet` returned last are skipped. Stops if `spend` refuses further steps.
    pub fn visit_along_line(&self, line: ThickLine, spend: impl Fn(u64) -> bool, mut meet: impl FnMut(usize) -> f64) {
        let Some(root) = self.0.nodes.first() else { return };
        let line = PreparedLine::new(line);
        let mut limit = 1.0;
        let Some(entry) = line.entry_share(root.bounds()) else { return };
        let mut stack = vec![(entry, 0_u32)];
        while let Some((entry, index)) = stack.pop() {
            if entry > limit {
                continue;
            }
            let node = &self.0.nodes[index as usize];
            if !spend(node_cost_steps(node)) {
                return;
            }
            if node.is_leaf() {
                for &triangle in self.0.items(node) {
                    limit = meet(triangle as usize);
                }
                continue;
            }
            let children = self.0.children(index);
            let entered =
                |child: u32| line.entry_share(self.0.nodes[child as usize].bounds()).map(|entry| (entry, child));
            match children.map(entered) {
                [Some(a), Some(b)] if a.0 <= b.0 => stack.extend([b, a]),
                [Some(a), Some(b)] => stack.extend([a, b]),
                [one, other] => stack.extend(one.or(other)),
            }
        }
    }
}

/// Line prepared for intersection with boxes.
struct PreparedLine {
    from: DVec3,
    step: DVec3,
    inverse: DVec3,
    radius: f64,
}

impl PreparedLine {
    fn new(ThickLine { from, to, radius }: ThickLine) -> Self {
        // Rounding of the following computation is some ulps of the largest coordinate.
        let slack = 1e-14 * (from.abs().max_element() + to.abs().max_element());
        Self { from, step: to - from, inverse: (to - from).recip(), radius: radius + slack }
    }

    /// Returns the share of the length at which the line enters the box; `None` if it misses.
    fn entry_share(&self, bounds: hierarchy::Aabb) -> Option<f64> {
        let low = bounds.min.as_dvec3() - self.from - self.radius;
        let high = bounds.max.as_dvec3() - self.from + self.radius;
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            if self.step[axis] == 0.0 {
                if low[axis] > 0.0 || high[axis] < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low[axis] * self.inverse[axis], high[axis] * self.inverse[axis]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        // Quotients round too.
        (enter <= leave + 1e-12).then_some(enter)
    }
}
