//! Where everything stands: the one place that knows where scene space begins, and which corners of a mirrored
//! triangle change places.

use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DMat3, DVec3};

use light::SceneBounds;

use crate::{NodeTree, Primitive, Scene};

/// Of a scene's width, how high a floor may be, and how far above the bottom.
const MAX_FLOOR_HEIGHT_SHARE: f64 = 0.02;
/// Of the area that a scene has from above, how much lies over its floor.
const MIN_FLOOR_AREA_SHARE: f64 = 0.6;

/// A scene with every vertex at its place, for whoever draws it, follows light through it or picks from it.
///
/// Positions are in scene space: world axes, origin at the centre of the scene's bounds, so that no digit is lost
/// wherever the scene stands.
#[derive(Debug, Default)]
pub struct PosedScene {
    /// What was posed.
    pub scene: Arc<Scene>,
    /// Where scene space has its origin, in the world: the centre of the bounds.
    pub origin_in_world: DVec3,
    /// The bounds reach from minus to plus this, in scene space.
    pub half_extent: DVec3,
    /// Every primitive of every node, in node order.
    pub primitives: Vec<PosedPrimitive>,
    /// All their vertices in scene space, in the same order.
    pub positions: Vec<DVec3>,
    /// Made when somebody asks.
    nodes: OnceLock<NodeTree>,
    pub(crate) depth_complexity: OnceLock<f64>,
}

/// A primitive at its place in the world.
#[derive(Clone, Copy, Debug)]
pub struct PosedPrimitive {
    /// Index of the node that carries it.
    pub node: usize,
    /// Index of its mesh, and its own in that.
    pub mesh_and_primitive: [usize; 2],
    /// Its placement, composed in f64.
    pub world_from_local: DAffine3,
    /// Where its vertices begin in [`PosedScene::positions`].
    pub first_vertex: usize,
}

/// Poses a scene, whose promises hold ([`Scene::check`]).
pub fn pose(scene: impl Into<Arc<Scene>>) -> Arc<PosedScene> {
    let scene = scene.into();
    let SceneBounds { center: origin_in_world, half_extent } = SceneBounds::from(&*scene);
    let primitives: Vec<_> = posed_primitives(&scene).collect();
    let mut positions = Vec::new();
    for posed in &primitives {
        let mut scene_from_local = posed.world_from_local;
        scene_from_local.translation -= origin_in_world;
        let local = posed.geometry_in(&scene).positions.iter();
        positions.extend(local.map(|position| scene_from_local.transform_point3(position.as_dvec3())));
    }
    Arc::new(PosedScene {
        scene,
        origin_in_world,
        half_extent,
        primitives,
        positions,
        nodes: OnceLock::new(),
        depth_complexity: OnceLock::new(),
    })
}

impl PosedScene {
    /// The box that lights are measured against.
    pub fn bounds(&self) -> SceneBounds {
        SceneBounds { center: self.origin_in_world, half_extent: self.half_extent }
    }

    /// The box of what stands in it, for a camera that frames that: without the floors that it stands on. All of it where nothing stands
    /// on a floor.
    pub fn subject_bounds(&self) -> SceneBounds {
        let whole = self.bounds();
        let boxes = self.primitives.iter().filter_map(|posed| {
            let vertices = self.geometry(posed).positions.len();
            let mut positions = self.positions[posed.first_vertex..posed.first_vertex + vertices].iter();
            let first = *positions.next()?;
            Some(positions.fold((first, first), |(min, max), at| (min.min(*at), max.max(*at))))
        });
        let standing = boxes.filter(|(min, max)| !self.is_floor(*min, *max));
        let subject = standing.reduce(|(min, max), (low, high)| (min.min(low), max.max(high)));
        subject.map_or(whole, |(min, max)| {
            let middle = whole.center + (min + max) / 2.0;
            SceneBounds { center: middle, half_extent: (max - min) / 2.0 }
        })
    }

    /// Whether a box in scene space is that of a floor: flat, at the bottom, and under most of the scene.
    fn is_floor(&self, min: DVec3, max: DVec3) -> bool {
        let (whole, size) = (2.0 * self.half_extent, max - min);
        let flat = size.y <= MAX_FLOOR_HEIGHT_SHARE * whole.x.max(whole.z);
        let low = max.y + self.half_extent.y <= MAX_FLOOR_HEIGHT_SHARE * whole.max_element();
        flat && low && size.x * size.z >= MIN_FLOOR_AREA_SHARE * whole.x * whole.z && whole.y > size.y
    }

    /// Its nodes by their paths.
    pub fn node_tree(&self) -> &NodeTree {
        self.nodes.get_or_init(|| NodeTree::new(&self.scene))
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.primitives.iter().map(|posed| self.geometry(posed).indices.len() / 3).sum()
    }

    /// The geometry of one of [`Self::primitives`].
    pub fn geometry(&self, posed: &PosedPrimitive) -> &Primitive {
        posed.geometry_in(&self.scene)
    }

    /// The triangles of one of [`Self::primitives`] by its own vertices; counter-clockwise seen from the front, where
    /// it is mirrored too.
    pub fn triangles(&self, posed: &PosedPrimitive) -> impl Iterator<Item = [u32; 3]> {
        let mirrors = posed.is_mirrored();
        let triangles = posed.geometry_in(&self.scene).indices.as_chunks::<3>().0.iter();
        triangles.map(move |&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] })
    }
}

impl PosedPrimitive {
    fn geometry_in<'a>(&self, scene: &'a Scene) -> &'a Primitive {
        let [mesh, primitive] = self.mesh_and_primitive;
        &scene.meshes[mesh].primitives[primitive]
    }

    /// Whether its placement mirrors, which turns triangles inside out.
    fn is_mirrored(&self) -> bool {
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
        if self.is_mirrored() { -cofactor } else { cofactor }
    }
}

/// Every primitive of every node, in node order.
fn posed_primitives(scene: &Scene) -> impl Iterator<Item = PosedPrimitive> {
    let mut world_from_node: Vec<DAffine3> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        let parent = node.parent.map_or(DAffine3::IDENTITY, |p| world_from_node[p]);
        world_from_node.push(parent * node.parent_from_local);
    }
    let carried = scene.nodes.iter().enumerate().filter_map(|(node, at)| Some((node, at.mesh?)));
    let mut vertices = 0;
    carried.flat_map(move |(node, mesh)| {
        let world_from_local = world_from_node[node];
        let primitives = scene.meshes[mesh].primitives.iter().enumerate();
        let posed = primitives.map(|(primitive, geometry)| {
            let first_vertex = vertices;
            vertices += geometry.positions.len();
            PosedPrimitive { node, mesh_and_primitive: [mesh, primitive], world_from_local, first_vertex }
        });
        posed.collect::<Vec<_>>()
    })
}

/// Corners of the box around every vertex in the world, or `None` where there is none.
pub fn world_bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    posed_primitives(scene)
        .flat_map(|posed| {
            let local = posed.geometry_in(scene).positions.iter();
            local.map(move |position| posed.world_from_local.transform_point3(position.as_dvec3()))
        })
        .fold(None, |bounds, v| {
            let (min, max) = bounds.unwrap_or((v, v));
            Some((min.min(v), max.max(v)))
        })
}

impl From<&Scene> for SceneBounds {
    /// Looks at all vertices.
    fn from(scene: &Scene) -> Self {
        let (min, max) = world_bounds(scene).unwrap_or_default();
        Self { center: min / 2.0 + max / 2.0, half_extent: max / 2.0 - min / 2.0 }
    }
}
