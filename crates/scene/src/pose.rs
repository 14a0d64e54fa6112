//! Where everything stands in the world.

use glam::{DAffine3, DMat3};
use light::Reach;

use crate::{Primitive, Scene, world_bounds};

/// A primitive at its place in the world.
#[derive(Clone, Copy, Debug)]
pub struct PosedPrimitive<'a> {
    /// Index of the node that carries it.
    pub node: usize,
    /// The shared geometry.
    pub primitive: &'a Primitive,
    /// Its placement, composed in f64.
    pub world_from_local: DAffine3,
}

impl PosedPrimitive<'_> {
    /// Whether its placement mirrors, which turns triangles inside out.
    pub fn mirrors(&self) -> bool {
        self.world_from_local.matrix3.determinant() < 0.0
    }

    /// The matrix that takes normals into the world, up to a positive factor.
    ///
    /// The cofactor matrix is `det M` times the inverse transpose and exists for singular ones too: a mesh
    /// flattened onto a plane gets that plane's normal.
    pub fn normal_matrix(&self) -> DMat3 {
        let m = self.world_from_local.matrix3;
        let cofactor =
            DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        if self.mirrors() { -cofactor } else { cofactor }
    }
}

/// Every primitive of every node, in node order.
pub fn pose(scene: &Scene) -> impl Iterator<Item = PosedPrimitive<'_>> {
    let mut world_from_node: Vec<DAffine3> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        let parent = node.parent.map_or(DAffine3::IDENTITY, |p| world_from_node[p]);
        world_from_node.push(parent * node.parent_from_local);
    }
    scene.nodes.iter().enumerate().flat_map(move |(i, node)| {
        let world_from_local = world_from_node[i];
        let primitives = node.mesh.map_or(&[][..], |m| &scene.meshes[m].primitives);
        primitives.iter().map(move |primitive| PosedPrimitive { node: i, primitive, world_from_local })
    })
}

impl From<&Scene> for Reach {
    /// Looks at all vertices.
    fn from(scene: &Scene) -> Self {
        let (min, max) = world_bounds(scene).unwrap_or_default();
        Self { middle: min / 2.0 + max / 2.0, half_extent: max / 2.0 - min / 2.0 }
    }
}
