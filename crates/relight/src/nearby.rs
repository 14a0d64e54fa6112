//! Ray tests of the last piece of a light path against the scene, one pixel at a time. `nearby.wgsl` has the reasons.

use glam::{Vec3, Vec3Swizzles};
use hierarchy::HierarchyNode;

use crate::scene::{CasterScene, weights_at};

/// Surface that receives light, as the ray tests need it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReceiverPoint {
    pub position: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
    /// Unit normal of the triangle, towards the viewer.
    pub geometric_normal: Vec3,
    pub terminator_offset: f32,
    /// Distance along the view axis.
    pub depth: f32,
    pub triangle: u32,
}

impl ReceiverPoint {
    /// Returns the point at which light must arrive for the surface to be lit.
    pub fn shadow_position(&self) -> Vec3 {
        self.position + self.terminator_offset * self.normal
    }
}

/// Returns a bound of the rounding error of f32 positions of this size.
pub(crate) fn rounding_error(position: Vec3) -> f32 {
    position.abs().max_element() * (1.0 / 2_097_152.0)
}

/// True if light meets the surface's own triangle from behind, and so would have to pass through it. `arriving` is the
/// unit vector towards the light.
pub(crate) fn is_self_shadowed(scene: &CasterScene, surface: &ReceiverPoint, arriving: Vec3) -> bool {
    let facing = surface.geometric_normal.dot(arriving);
    if facing > 0.0 || !scene.links.casts_shadow(surface.triangle) {
        return false;
    }
    let height = surface.terminator_offset * surface.normal.dot(surface.geometric_normal);
    let through = surface.shadow_position() + arriving * (height / (-facing).max(1e-30));
    height <= 0.0 || weights_at(scene.corners(surface.triangle), through).min_element() >= 0.0
}

/// True if light that arrives at the front of the smooth surface has crossed the surface's own triangle before. `there`
/// is a point on its path just before it arrives. Only bent light can do so.
pub(crate) fn crosses_own_triangle(scene: &CasterScene, surface: &ReceiverPoint, there: Vec3) -> bool {
    let height = surface.geometric_normal.dot(there - surface.position);
    if height >= -(rounding_error(there) + surface.depth * (1.0 / 2_097_152.0))
        || !scene.links.casts_shadow(surface.triangle)
    {
        return false;
    }
    let weights = weights_at(scene.corners(surface.triangle), there);
    weights.min_element() >= 0.0 && !scene.has_hole(surface.triangle, weights)
}

/// True if a caster other than the triangle `own` lies between `start` and `start + span`. A triangle that `start` lies
/// on, within rounding, does not count. `depth` is the distance of the surface from the viewer, which the rounding
/// error of its position grows with.
pub(crate) fn is_segment_occluded(
    scene: &CasterScene,
    (start, span): (Vec3, Vec3),
    own: Option<u32>,
    depth: f32,
) -> bool {
    let end = start + span;
    let slack = rounding_error(start) + depth * (1.0 / 2_097_152.0);
    let (half, box_slack) = (0.5 * span, slack + rounding_error(end));
    let mut index = 0;
    while let Some(node) = scene.hierarchy.nodes.get(index) {
        let is_leaf = node.is_leaf();
        let passed_by = misses_box(node, start + half, half, box_slack);
        if is_leaf && !passed_by {
            let of_leaf = node.next as usize..(node.next + node.count) as usize;
            for &triangle in &scene.hierarchy.triangles[of_leaf] {
                if Some(triangle) != own && segment_hits_triangle(scene, triangle, (start, span), slack) {
                    return true;
                }
            }
        }
        index = if passed_by && !is_leaf { node.next as usize } else { index + 1 };
    }
    false
}

/// True if no point of a segment lies within `slack` of a node's box. The test uses axes that may separate the two:
/// those of the box, and their cross products with the segment (Ericson, Real-Time Collision Detection, 5.3.3). The
/// segment is `middle` plus up to `half` in both directions.
fn misses_box(node: &HierarchyNode, middle: Vec3, half: Vec3, slack: f32) -> bool {
    let (min, max) = (Vec3::from(node.min), Vec3::from(node.max));
    let between = 0.5 * (min + max) - middle;
    let box_half = (0.5 + 4.0 * f32::EPSILON) * (max - min) + slack;
    let reach = half.abs();
    let across = box_half.yzx() * reach.zxy() + box_half.zxy() * reach.yzx();
    between.abs().cmpgt(box_half + reach).any() || half.cross(between).abs().cmpgt(across).any()
}

/// True if the segment from `start` to `start + span` crosses a triangle that casts shadows. A triangle within `slack`
/// of `start` does not count.
fn segment_hits_triangle(scene: &CasterScene, triangle: u32, (start, span): (Vec3, Vec3), slack: f32) -> bool {
    let (normal, offset) = scene.plane(triangle);
    let (start_height, end_height) = (normal.dot(start) - offset, normal.dot(start + span) - offset);
    if start_height.abs() <= slack || start_height * end_height >= 0.0 {
        return false;
    }
    let at = start + span * (start_height / (start_height - end_height));
    let weights = weights_at(scene.corners(triangle), at);
    weights.min_element() >= -1e-6 && scene.links.casts_shadow(triangle) && !scene.has_hole(triangle, weights)
}

#[cfg(test)]
mod tests;
