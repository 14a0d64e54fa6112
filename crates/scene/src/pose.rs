//! Posed scenes. This module alone decides the origin of scene space and reverses the winding of mirrored triangles.

use std::sync::{Arc, OnceLock};

use glam::{DAffine3, DMat3, DVec3};

use hierarchy::Hierarchy;
use light::SceneBounds;

use crate::triangle_hierarchy::triangle_hierarchy;
use crate::{NodeTree, Primitive, Scene};

/// Maximum height of a floor, and of its top above the bottom of the scene, as a share of the scene's size.
const MAX_FLOOR_HEIGHT_SHARE: f64 = 0.02;
/// Minimum area of a floor as a share of the scene's area seen from above.
const MIN_FLOOR_AREA_SHARE: f64 = 0.6;

/// Scene with every vertex transformed into scene space, for rasterizers, ray tracers and picks.
///
/// Scene space has world axes and its origin at the centre of the scene's bounds, so that numbers keep their precision
/// wherever the scene stands.
#[derive(Debug, Default)]
pub struct PosedScene {
    pub scene: Arc<Scene>,
    /// Origin of scene space in world space: the centre of the bounds.
    pub origin_in_world: DVec3,
    /// Half the size of the bounds along each axis. In scene space the bounds extend this far from the origin in both
    /// directions.
    pub half_extent: DVec3,
    /// Every primitive of every node, in node order.
    pub primitives: Vec<PosedPrimitive>,
    /// Vertices of all primitives in scene space, in the same order.
    pub positions: Vec<DVec3>,
    /// Paths of the nodes, made on first use.
    nodes: OnceLock<NodeTree>,
    /// Tree of boxes, made on first use.
    hierarchy: OnceLock<Arc<Hierarchy>>,
    pub(crate) depth_complexity: OnceLock<f64>,
}

/// Primitive of a node, with its transform.
#[derive(Clone, Copy, Debug)]
pub struct PosedPrimitive {
    pub node: usize,
    /// Index of its mesh in [`Scene::meshes`], and its own index in that mesh.
    pub mesh_and_primitive: [usize; 2],
    /// Transform from mesh-local to world space, composed in f64.
    pub world_from_local: DAffine3,
    /// Index in [`PosedScene::positions`] of its first vertex.
    pub first_vertex: usize,
}

/// Poses a scene that passes [`Scene::check`] at a time, in frames. No scene moves yet: every time gives the rest pose.
///
/// The origin and the bounds are those of the rest pose at every time, so that what depends on them stays valid while
/// objects move.
pub fn pose(scene: impl Into<Arc<Scene>>, _time_in_frames: f64) -> Arc<PosedScene> {
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
    Arc::new(PosedScene { scene, origin_in_world, half_extent, primitives, positions, ..PosedScene::default() })
}

impl PosedScene {
    /// Bounds in the world, against which lights are measured.
    pub fn bounds(&self) -> SceneBounds {
        SceneBounds { center: self.origin_in_world, half_extent: self.half_extent }
    }

    /// Bounds of the scene without its floors, for a camera that frames the scene. If nothing stands on a floor, these
    /// are the whole bounds.
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

    /// Returns true if a box in scene space is a floor: flat, at the bottom, and under most of the scene.
    fn is_floor(&self, min: DVec3, max: DVec3) -> bool {
        let (whole, size) = (2.0 * self.half_extent, max - min);
        let flat = size.y <= MAX_FLOOR_HEIGHT_SHARE * whole.x.max(whole.z);
        let low = max.y + self.half_extent.y <= MAX_FLOOR_HEIGHT_SHARE * whole.max_element();
        flat && low && size.x * size.z >= MIN_FLOOR_AREA_SHARE * whole.x * whole.z && whole.y > size.y
    }

    /// Returns the paths of the scene's nodes, built on the first call.
    pub fn node_tree(&self) -> &NodeTree {
        self.nodes.get_or_init(|| NodeTree::new(&self.scene))
    }

    /// Returns the tree of boxes over all triangles, built on the first call: one for rays on processors and on GPUs. A triangle's
    /// index is its place in the order of [`Self::primitives`]. Boxes are in scene space, rounded outwards to f32.
    pub fn hierarchy(&self) -> &Arc<Hierarchy> {
        self.hierarchy.get_or_init(|| {
            let corners = self.primitives.iter().flat_map(|primitive| {
                let positions = &self.positions[primitive.first_vertex..];
                self.triangles(primitive).map(|triangle| triangle.map(|vertex| positions[vertex as usize]))
            });
            Arc::new(triangle_hierarchy(corners))
        })
    }

    pub fn triangle_count(&self) -> usize {
        self.primitives.iter().map(|posed| self.geometry(posed).indices.len() / 3).sum()
    }

    /// Returns the geometry of one of [`Self::primitives`].
    pub fn geometry(&self, posed: &PosedPrimitive) -> &Primitive {
        posed.geometry_in(&self.scene)
    }

    /// Returns the triangles of one of [`Self::primitives`], as indices of its own vertices. They are counter-clockwise
    /// seen from the front, also in a mirrored primitive.
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

    /// Returns true if the transform mirrors, which reverses the winding of triangles.
    fn is_mirrored(&self) -> bool {
        self.world_from_local.matrix3.determinant() < 0.0
    }

    /// Returns the matrix that transforms normals into world space, up to a positive factor.
    ///
    /// The cofactor matrix is `det M` times the inverse transpose and exists for singular matrices too: a mesh
    /// flattened onto a plane gets that plane's normal.
    pub fn normal_matrix(&self) -> DMat3 {
        let m = self.world_from_local.matrix3;
        let cofactor = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        if self.is_mirrored() { -cofactor } else { cofactor }
    }
}

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

/// Returns the least and greatest corner of the bounds in world space; `None` for a scene without vertices.
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
    /// Computes the bounds in world space from all vertices.
    fn from(scene: &Scene) -> Self {
        let (min, max) = world_bounds(scene).unwrap_or_default();
        Self { center: min / 2.0 + max / 2.0, half_extent: max / 2.0 - min / 2.0 }
    }
}
