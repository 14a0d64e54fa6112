//! Triangles of a posed scene, prepared for rays.

use std::sync::Arc;

use scene::PosedScene;

use crate::Triangle;
use crate::hierarchy::TriangleHierarchy;

/// Triangles of a posed scene under its bounding-volume hierarchy.
#[derive(Debug)]
pub struct Bvh {
    pub posed: Arc<PosedScene>,
    /// Triangles, primitive by primitive, as the hierarchy has them.
    triangles: Vec<TriangleIndices>,
    pub(crate) hierarchy: TriangleHierarchy,
}

/// Triangle by its indices: a scene has many.
#[derive(Clone, Copy, Debug)]
struct TriangleIndices {
    /// Indices of the corners in [`PosedScene::positions`], counter-clockwise seen from the front.
    corners: [u32; 3],
    /// Index in [`PosedScene::primitives`].
    primitive: u32,
}

impl Bvh {
    /// Prepares the triangles of a scene, and builds its hierarchy if it has none yet.
    pub fn new(posed: Arc<PosedScene>) -> Self {
        let mut triangles = Vec::with_capacity(posed.triangle_count());
        for (primitive, of) in posed.primitives.iter().enumerate() {
            let corners = |vertices: [u32; 3]| vertices.map(|vertex| (of.first_vertex as u32) + vertex);
            let indices = |vertices| TriangleIndices { corners: corners(vertices), primitive: primitive as u32 };
            triangles.extend(posed.triangles(of).map(indices));
        }
        let hierarchy = TriangleHierarchy::new(&posed);
        Self { posed, triangles, hierarchy }
    }

    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Returns all triangles, primitive by primitive.
    pub fn triangles(&self) -> impl Iterator<Item = Triangle> + Clone {
        (0..self.triangles.len()).map(|index| self.triangle(index))
    }

    /// Returns the triangle with an index.
    pub fn triangle(&self, index: usize) -> Triangle {
        let TriangleIndices { corners, primitive } = self.triangles[index];
        let of = &self.posed.primitives[primitive as usize];
        Triangle {
            corners: corners.map(|corner| self.posed.positions[corner as usize]),
            node: of.node,
            primitive: primitive as usize,
            vertices: corners.map(|corner| corner - of.first_vertex as u32),
        }
    }
}
