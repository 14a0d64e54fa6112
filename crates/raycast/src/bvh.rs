//! Triangles of a posed scene, prepared for rays.

use std::sync::Arc;

use scene::PosedScene;

use crate::Triangle;
use crate::hierarchy::TriangleHierarchy;

/// Triangles of a posed scene under a bounding-volume hierarchy.
#[derive(Debug)]
pub struct Bvh {
    pub posed: Arc<PosedScene>,
    /// Triangles, primitive by primitive.
    pub triangles: Vec<Triangle>,
    pub(crate) hierarchy: TriangleHierarchy,
}

impl Bvh {
    /// Builds the hierarchy of a scene.
    pub fn new(posed: Arc<PosedScene>) -> Self {
        let mut all = Vec::with_capacity(posed.triangle_count());
        all.extend((0..posed.primitives.len()).flat_map(|index| triangles_of_primitive(&posed, index)));
        let hierarchy = TriangleHierarchy::new(&all);
        Self { posed, triangles: all, hierarchy }
    }
}

fn triangles_of_primitive(posed: &PosedScene, primitive: usize) -> impl Iterator<Item = Triangle> {
    let of = &posed.primitives[primitive];
    let positions = &posed.positions[of.first_vertex..];
    posed.triangles(of).map(move |vertices| Triangle {
        corners: vertices.map(|vertex| positions[vertex as usize]),
        node: of.node,
        primitive,
        vertices,
    })
}
