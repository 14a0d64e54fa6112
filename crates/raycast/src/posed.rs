//! A scene at its place in the world, ready for rays.

use glam::DVec3;
use scene::{PosedPrimitive, Scene};

use crate::Triangle;
use crate::hierarchy::Hierarchy;

/// Every triangle of a scene in scene space, under a bounding-volume hierarchy.
#[derive(Debug)]
pub struct PosedScene<'a> {
    /// Where scene space has its origin, in the world: the centre of the scene's bounds.
    pub origin_in_world: DVec3,
    /// The scene's primitives, each where it stands in the world, in node order.
    pub primitives: Vec<PosedPrimitive<'a>>,
    /// All their triangles, in the same order.
    pub triangles: Vec<Triangle>,
    pub(crate) hierarchy: Hierarchy,
}

impl<'a> PosedScene<'a> {
    /// Poses `scene`, whose promises hold ([`Scene::check`]).
    pub fn new(scene: &'a Scene) -> Self {
        let (low, high) = scene::world_bounds(scene).unwrap_or_default();
        let origin_in_world = low / 2.0 + high / 2.0;
        let primitives: Vec<_> = scene::pose(scene).collect();
        let triangles: Vec<_> = primitives
            .iter()
            .enumerate()
            .flat_map(|(index, posed)| triangles(index, posed, origin_in_world))
            .collect();
        let hierarchy = Hierarchy::new(&triangles);
        Self { origin_in_world, primitives, triangles, hierarchy }
    }
}

fn triangles<'a>(
    primitive: usize,
    posed: &'a PosedPrimitive<'a>,
    origin_in_world: DVec3,
) -> impl Iterator<Item = Triangle> + 'a {
    let mirrored = posed.mirrors();
    let mut scene_from_local = posed.world_from_local;
    scene_from_local.translation -= origin_in_world;
    let corner = move |vertex: u32| {
        scene_from_local.transform_point3(posed.primitive.positions[vertex as usize].as_dvec3())
    };
    posed.primitive.indices.as_chunks::<3>().0.iter().map(move |&[a, b, c]| {
        let vertices = if mirrored { [a, c, b] } else { [a, b, c] };
        Triangle { corners: vertices.map(corner), node: posed.node, primitive, vertices }
    })
}
