//! A posed scene, ready for rays.

use std::sync::Arc;

use scene::PosedScene;

use crate::Triangle;
use crate::hierarchy::TriangleHierarchy;

/// Every triangle of a posed scene under a bounding-volume hierarchy.
#[derive(Debug)]
pub struct Bvh {
    /// The scene.
    pub posed: Arc<PosedScene>,
    /// Its triangles, primitive by primitive.
    pub triangles: Vec<Triangle>,
    pub(crate) hierarchy: TriangleHierarchy,
}

impl Bvh {
    /// Builds the hierarchy.
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
