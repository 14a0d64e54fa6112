//! Tree of boxes over the triangles of a posed scene.

use glam::{DVec3, Vec3A};
use hierarchy::{Aabb, Hierarchy};

/// Builds the tree over triangles, given by their corners. Their indices are their places in the order given.
pub(crate) fn triangle_hierarchy(triangles: impl Iterator<Item = [DVec3; 3]>) -> Hierarchy {
    Hierarchy::new(triangles.map(outward_box))
}

/// Returns the box of a triangle, with each side rounded outwards: safe, not exact.
fn outward_box([a, b, c]: [DVec3; 3]) -> Aabb {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let low = low.to_array().map(|x| (x as f32).next_down());
    let high = high.to_array().map(|x| (x as f32).next_up());
    Aabb { min: Vec3A::from(low), max: Vec3A::from(high) }
}
