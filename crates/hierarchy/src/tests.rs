use super::*;

use glam::Vec3A;
use proptest::prelude::*;

fn at(corner: [f32; 3], size: [f32; 3]) -> Aabb {
    let min = Vec3A::from_array(corner);
    Aabb { min, max: min + Vec3A::from_array(size) }
}

/// Returns the depth of the tree: number of levels below the root.
fn depth(hierarchy: &Hierarchy) -> u32 {
    let mut depths = vec![0; hierarchy.nodes.len()];
    for (index, _) in hierarchy.nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
        for child in hierarchy.children(index as u32) {
            depths[child as usize] = depths[index] + 1;
        }
    }
    depths.into_iter().max().unwrap_or(0)
}

/// Describes the first invariant of a hierarchy over `boxes` that does not hold.
fn broken_invariant(hierarchy: &Hierarchy, boxes: &[Aabb]) -> Option<String> {
    let mut order = hierarchy.order.clone();
    order.sort_unstable();
    if order != (0..boxes.len() as u32).collect::<Vec<_>>() {
        return Some("not each box is in it once".into());
    }
    let mut held = 0;
    for (index, node) in hierarchy.nodes.iter().enumerate() {
        let holds = |inner: Aabb| node.bounds().union(inner) == node.bounds();
        if node.is_leaf() {
            held += hierarchy.items(node).len();
            if hierarchy.items(node).iter().any(|&index| !holds(boxes[index as usize])) {
                return Some(format!("a leaf does not hold its boxes: {node:?}"));
            }
        } else if hierarchy.children(index as u32).iter().any(|&child| !holds(hierarchy.nodes[child as usize].bounds()))
        {
            return Some(format!("a node does not hold its nodes: {node:?}"));
        }
    }
    (held != boxes.len()).then(|| format!("leaves hold {held} of {}", boxes.len()))
}

/// Returns the number of nodes that a point query visits.
fn visited_nodes(hierarchy: &Hierarchy, point: Vec3A) -> usize {
    let (mut open, mut count) = (vec![0_u32], 0);
    while let Some(index) = open.pop() {
        let node: &HierarchyNode = &hierarchy.nodes[index as usize];
        count += 1;
        let Aabb { min, max } = node.bounds();
        let inside = min.cmple(point).all() && point.cmple(max).all();
        if inside && !node.is_leaf() {
            open.extend(hierarchy.children(index));
        }
    }
    count
}

/// Gives the box of an index.
type BoxOfIndex = &'static dyn Fn(f32) -> Aabb;

/// Inputs for which other builders take quadratic time: boxes in one place, growing around one point, along a line, and
/// at growing or shrinking distances.
#[test]
fn depth_is_bounded_for_any_boxes() {
    let count = 20_000_u16;
    let halvings = u32::from(count).ilog2() + 1;
    let shapes: [(&str, u32, BoxOfIndex); 6] = [
        ("in one place", halvings, &|_| at([0.0; 3], [1.0; 3])),
        ("points in one place", halvings, &|_| at([1.0; 3], [0.0; 3])),
        ("growing", MAX_DEPTH + halvings, &|k| at([-k; 3], [2.0 * k; 3])),
        ("along a line", 2 * halvings, &|k| at([k, 0.0, 0.0], [0.0, 1.0, 0.0])),
        ("ever farther", MAX_DEPTH + halvings, &|k| at([libm::expf(k * 0.004), 0.0, 0.0], [0.0, 1.0, 0.0])),
        ("too far apart", MAX_DEPTH + halvings, &|k| at([(k - 1e4) * 1e34; 3], [0.0; 3])),
    ];
    for (shape, levels, box_of) in shapes {
        let boxes: Vec<Aabb> = (0..count).map(|k| box_of(f32::from(k))).collect();
        let hierarchy = Hierarchy::new(boxes.iter().copied());
        assert_eq!(broken_invariant(&hierarchy, &boxes), None, "{shape}");
        assert!(depth(&hierarchy) <= levels, "{shape}: {} levels", depth(&hierarchy));
    }
}

#[test]
fn a_point_query_visits_few_nodes() {
    let corners: Vec<[f32; 3]> = (0..125_000_u32).map(|k| [k % 50, k / 50 % 50, k / 2500].map(|k| k as f32)).collect();
    let boxes: Vec<Aabb> = corners.iter().map(|&corner| at(corner, [0.5; 3])).collect();
    let hierarchy = Hierarchy::new(boxes.iter().copied());
    // A balanced tree takes two nodes a level. Bins do not halve exactly, so a few more are allowed.
    let levels = libm::log2f(boxes.len() as f32);
    let most = corners.iter().step_by(997).map(|&[x, y, z]| visited_nodes(&hierarchy, Vec3A::new(x, y, z) + 0.25));
    assert!(most.clone().max() <= Some((3.0 * levels) as usize), "{:?}", most.max());
}

#[test]
fn no_boxes_make_an_empty_hierarchy() {
    assert_eq!(Hierarchy::new([]), Hierarchy::default());
}

/// Walks the nodes without a stack, as `nearby.wgsl` does: after a skipped node to `next`. Returns the boxes of all leaves that
/// contain `point`, and the number of visited nodes.
fn walk(nodes: &[HierarchyNode], order: &[u32], point: [f32; 3]) -> (Vec<u32>, usize) {
    let (mut found, mut visited, mut index) = (Vec::new(), 0, 0);
    while let Some(node) = nodes.get(index) {
        visited += 1;
        let inside = (0..3).all(|k| node.min[k] <= point[k] && point[k] <= node.max[k]);
        if inside && node.is_leaf() {
            found.extend(&order[node.next as usize..][..node.count as usize]);
        }
        index = if inside || node.is_leaf() { index + 1 } else { node.next as usize };
    }
    (found, visited)
}

#[test]
fn a_walk_without_a_stack_finds_each_box_and_skips_the_rest() {
    let places = (0..400_u16).map(|k| [f32::from(k / 20), f32::from(k % 20), 0.0]);
    let hierarchy = Hierarchy::new(places.clone().map(|corner| at(corner, [0.01, 0.01, 0.0])));
    for (index, corner) in places.enumerate() {
        let (found, visited) = walk(&hierarchy.nodes, &hierarchy.order, corner);
        assert!(found.contains(&(index as u32)), "box {index}: {found:?}");
        assert!(visited < hierarchy.nodes.len() / 4, "{visited} of {}", hierarchy.nodes.len());
    }
    assert_eq!(walk(&hierarchy.nodes, &hierarchy.order, [0.5, 0.5, 0.0]).0, []);
    assert_eq!(walk(&[HierarchyNode::NOWHERE], &[], [0.0; 3]), (Vec::new(), 1));
}

proptest! {
    #[test]
    fn each_box_is_held_once(
        corners in prop::collection::vec((prop::array::uniform3(-1e30_f32..1e30), prop::array::uniform3(0.0_f32..1e3)), 1..200),
        step in 1..8_usize,
    ) {
        let boxes: Vec<Aabb> = corners.iter().map(|&(corner, size)| at(corner, size)).collect();
        // Some boxes twice.
        let boxes: Vec<Aabb> = boxes.iter().chain(boxes.iter().step_by(step)).copied().collect();
        let hierarchy = Hierarchy::new(boxes.iter().copied());
        prop_assert_eq!(broken_invariant(&hierarchy, &boxes), None);
        // Deliberate fault that the check must detect: the check must notice a box outside its node.
        let mut lost = hierarchy;
        lost.nodes[0].max = lost.nodes[0].min;
        let is_one_point = boxes.iter().all(|bounds| *bounds == boxes[0] && bounds.min == bounds.max);
        prop_assert!(is_one_point || broken_invariant(&lost, &boxes).is_some());
    }
}
