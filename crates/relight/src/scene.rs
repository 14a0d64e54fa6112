//! The scene's triangles as relighting asks for them.

use glam::Vec3;

use crate::alpha_test::AlphaTests;

/// Geometry in scene space: world axes, origin at the centre of the scene's bounds. Triangles with an alpha test come last.
#[derive(Clone, Copy, Debug)]
pub struct CasterScene<'a> {
    /// One a vertex.
    pub positions: &'a [[f32; 3]],
    /// Three a triangle, counter-clockwise seen from the front.
    pub indices: &'a [u32],
    /// One a triangle: unit normal towards its front, and its product with any point of it; zeros where the area is 0.
    pub planes: &'a [[f32; 4]],
    /// Boxes over all triangles.
    pub hierarchy: CasterHierarchy<'a>,
    /// Of each vertex: normal, uv, and colour with alpha.
    pub attributes: &'a [[f32; 9]],
    /// How many triangles have no alpha test.
    pub opaque_triangles: u32,
    /// The tests of the others.
    pub alpha_tests: AlphaTests<'a>,
    /// What the light's links leave.
    pub links: CasterLinks<'a>,
}

/// Boxes over triangles, depth first.
#[derive(Clone, Copy, Debug)]
pub struct CasterHierarchy<'a> {
    /// A node before those within it.
    pub nodes: &'a [CasterHierarchyNode],
    /// Triangles in the order of the leaves.
    pub triangles: &'a [u32],
}

/// Of a node that is passed by the next to look at is `next`, of others the following one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct CasterHierarchyNode {
    /// Least corner.
    pub min: [f32; 3],
    /// Of a leaf: how many triangles it has, from `next` on in [`CasterHierarchy::triangles`]. Zero: the node has children.
    pub triangle_count: u32,
    /// Greatest corner.
    pub max: [f32; 3],
    /// See `triangle_count`.
    pub next: u32,
}

/// Which triangles count for a light.
#[derive(Clone, Copy, Debug, Default)]
pub struct CasterLinks<'a> {
    /// Two bits a triangle, 32 of them a word: in `[0]` whether the light shows on it, in `[1]` whether it throws shadows.
    /// `None` where all do.
    pub bits: Option<&'a [[u32; 2]]>,
}

impl CasterLinks<'_> {
    /// Whether the light shows on a triangle.
    pub(crate) fn is_light_linked(&self, triangle: u32) -> bool {
        self.has_bit(0, triangle)
    }

    /// Whether a triangle throws shadows.
    pub(crate) fn casts_shadow(&self, triangle: u32) -> bool {
        self.has_bit(1, triangle)
    }

    fn has_bit(&self, which: usize, triangle: u32) -> bool {
        self.bits.is_none_or(|bits| bits[triangle as usize / 32][which] >> (triangle % 32) & 1 != 0)
    }
}

impl CasterScene<'_> {
    /// A triangle's corners.
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let first = 3 * triangle as usize;
        [0, 1, 2].map(|k| Vec3::from(self.positions[self.indices[first + k] as usize]))
    }

    /// Whether a triangle has a hole at a point of it, given the corners' shares of that.
    pub(crate) fn has_hole(&self, triangle: u32, weights: Vec3) -> bool {
        let Some(tested) = triangle.checked_sub(self.opaque_triangles) else { return false };
        self.alpha_tests.has_hole(tested, self.uv_alpha(triangle), weights)
    }

    /// (u, v, alpha) of a triangle's corners.
    pub(crate) fn uv_alpha(&self, triangle: u32) -> [Vec3; 3] {
        let first = 3 * triangle as usize;
        [0, 1, 2].map(|k| {
            let [.., u, v, _, _, _, alpha] = self.attributes[self.indices[first + k] as usize];
            Vec3::new(u, v, alpha)
        })
    }

    /// A triangle's plane: unit normal, and its product with any point of it.
    pub(crate) fn plane(&self, triangle: u32) -> (Vec3, f32) {
        let [x, y, z, w] = self.planes[triangle as usize];
        (Vec3::new(x, y, z), w)
    }
}

/// Weights of the corners at a point of the triangle's plane, one of them below zero outside of it; 0 where the triangle has
/// no area.
pub(crate) fn weights_at([a, b, c]: [Vec3; 3], point: Vec3) -> Vec3 {
    let (ab, ac, at) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let area2 = normal.dot(normal);
    if area2 <= 1e-37 {
        return Vec3::ZERO;
    }
    let (beta, gamma) = (at.cross(ac).dot(normal) / area2, ab.cross(at).dot(normal) / area2);
    Vec3::new(1.0 - beta - gamma, beta, gamma)
}
