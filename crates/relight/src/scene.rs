//! Triangles of the scene in the form that relighting needs.

use glam::Vec3;
use hierarchy::HierarchyNode;

use crate::alpha_test::AlphaTests;

/// Geometry in scene space: world axes, origin at the center of the scene's bounds. Triangles with an alpha test come
/// last.
#[derive(Clone, Copy, Debug)]
pub struct CasterScene<'a> {
    /// One per vertex.
    pub positions: &'a [[f32; 3]],
    /// Three per triangle, counter-clockwise seen from the front.
    pub indices: &'a [u32],
    /// One per triangle: the unit normal towards its front, and the product of the normal with any point of it; zeros
    /// if the area is 0.
    pub planes: &'a [[f32; 4]],
    /// Boxes over all triangles.
    pub hierarchy: CasterHierarchy<'a>,
    /// Normal, uv, and color with alpha of each vertex: nine numbers.
    pub attributes: &'a [[f32; 9]],
    /// Number of triangles without an alpha test.
    pub opaque_triangles: u32,
    /// Tests of the other triangles.
    pub alpha_tests: AlphaTests<'a>,
    /// Light and shadow links of the light.
    pub links: CasterLinks<'a>,
}

/// Tree of boxes over triangles ([`hierarchy::Hierarchy`]), whose leaves name triangles by [`CasterScene`]'s order.
#[derive(Clone, Copy, Debug)]
pub struct CasterHierarchy<'a> {
    pub nodes: &'a [HierarchyNode],
    /// Triangles in the order of the leaves.
    pub triangles: &'a [u32],
}

/// Triangles that a light illuminates, and those that cast its shadows.
#[derive(Clone, Copy, Debug, Default)]
pub struct CasterLinks<'a> {
    /// Two bits per triangle, in words of 32 triangles: in `[0]` set if the light illuminates it, in `[1]` if it casts
    /// shadows. `None` sets all.
    pub bits: Option<&'a [[u32; 2]]>,
}

impl CasterLinks<'_> {
    /// True if the light illuminates a triangle.
    pub(crate) fn is_light_linked(&self, triangle: u32) -> bool {
        self.has_bit(0, triangle)
    }

    /// True if a triangle casts shadows.
    pub(crate) fn casts_shadow(&self, triangle: u32) -> bool {
        self.has_bit(1, triangle)
    }

    fn has_bit(&self, which: usize, triangle: u32) -> bool {
        self.bits.is_none_or(|bits| bits[triangle as usize / 32][which] >> (triangle % 32) & 1 != 0)
    }
}

impl CasterScene<'_> {
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let first = 3 * triangle as usize;
        [0, 1, 2].map(|k| Vec3::from(self.positions[self.indices[first + k] as usize]))
    }

    /// True if a triangle has a hole at the point with these barycentric `weights`.
    pub(crate) fn has_hole(&self, triangle: u32, weights: Vec3) -> bool {
        let Some(tested) = triangle.checked_sub(self.opaque_triangles) else { return false };
        self.alpha_tests.has_hole(tested, self.uv_alpha(triangle), weights)
    }

    /// Returns (u, v, alpha) of a triangle's corners.
    pub(crate) fn uv_alpha(&self, triangle: u32) -> [Vec3; 3] {
        let first = 3 * triangle as usize;
        [0, 1, 2].map(|k| {
            let [.., u, v, _, _, _, alpha] = self.attributes[self.indices[first + k] as usize];
            Vec3::new(u, v, alpha)
        })
    }

    /// Returns a triangle's plane: the unit normal, and its product with any point of the plane.
    pub(crate) fn plane(&self, triangle: u32) -> (Vec3, f32) {
        let [x, y, z, w] = self.planes[triangle as usize];
        (Vec3::new(x, y, z), w)
    }
}

/// Computes the barycentrics of a point of the triangle's plane. One of them is negative outside the triangle. All are
/// 0 for a triangle without area.
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
