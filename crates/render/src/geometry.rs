//! Triangles of a posed scene in GPU layout.

use std::ops::Range;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use hierarchy::{Hierarchy, HierarchyNode};
use light::MAX_EXTENT;
use scene::{Material, PosedPrimitive, PosedScene};
use wgpu::{Buffer, BufferUsages};

use crate::{Gpu, RenderError};

/// Vertices and triangles of a posed scene, in f32, in draw order.
#[derive(Debug, Default)]
pub(crate) struct Vertices {
    pub positions: Vec<[f32; 3]>,
    pub attributes: Vec<Attributes>,
    /// Three per triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// One plane per triangle: the unit normal, and its dot product with any point of the triangle. All zeros if the
    /// area is 0.
    pub planes: Vec<[f32; 4]>,
    /// Ranges of triangles with one material, one per material in use. Those without an alpha test come first.
    pub draws: Vec<MaterialRange>,
    /// Ranges of triangles of each posed primitive, in the same order as the primitives.
    pub runs: Vec<DrawRun>,
}

/// Attributes of a vertex besides its position.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Attributes {
    pub normal: [f32; 3],
    pub uv: [f32; 2],
    pub color: [f32; 4],
}

/// Triangles of one posed primitive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DrawRun {
    pub node: usize,
    /// Index in [`PosedScene::primitives`].
    pub primitive: usize,
    pub first_vertex: u32,
    pub indices: Range<u32>,
}

/// A run of triangles with one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MaterialRange {
    pub material: usize,
    pub indices: Range<u32>,
}

impl Vertices {
    /// Converts `scene`. Returns an error if f32 cannot hold it.
    pub fn new(scene: &PosedScene) -> Result<Self, RenderError> {
        let reach = scene.half_extent.max_element();
        if !(reach <= MAX_EXTENT && scene.origin_in_world.is_finite()) {
            return Err(RenderError::TooLarge { what: "half the scene's size", size: reach, limit: MAX_EXTENT });
        }
        let mut vertices = Self::default();
        let mut primitives: Vec<_> = scene.primitives.iter().enumerate().collect();
        primitives.sort_by_key(|(_, posed)| draw_order(&scene.scene.materials, scene.geometry(posed).material));
        for (number, primitive) in primitives {
            vertices.add(scene, number, primitive)?;
        }
        Ok(vertices)
    }

    fn add(&mut self, scene: &PosedScene, number: usize, posed: &PosedPrimitive) -> Result<(), RenderError> {
        let primitive = scene.geometry(posed);
        let index = |count: usize| {
            RenderError::check_size("the number of vertices or indices", count as u64, u32::MAX.into())?;
            Ok::<_, RenderError>(count as u32)
        };
        let first_vertex = index(self.positions.len())?;
        let normal_matrix = posed.normal_matrix();
        let positions = &scene.positions[posed.first_vertex..][..primitive.positions.len()];
        self.positions.extend(positions.iter().map(|position| position.as_vec3().to_array()));
        for (i, normal) in primitive.normals.iter().enumerate() {
            self.attributes.push(Attributes {
                normal: (normal_matrix * normal.as_dvec3()).normalize_or_zero().as_vec3().to_array(),
                uv: primitive.uvs.get(i).map_or([0.0; 2], Vec2::to_array),
                color: primitive.colors.get(i).map_or([1.0; 4], Vec4::to_array),
            });
        }
        let first_index = index(self.indices.len())?;
        for triangle in scene.triangles(posed) {
            let corners = triangle.map(|k| first_vertex + k);
            self.indices.extend(corners);
            self.planes.push(plane(corners.map(|k| self.positions[k as usize])));
        }
        let end = index(self.indices.len())?;
        let indices = first_index..end;
        self.runs.push(DrawRun { node: posed.node, primitive: number, first_vertex, indices });
        match self.draws.last_mut() {
            Some(draw) if draw.material == primitive.material => draw.indices.end = end,
            _ => self.draws.push(MaterialRange { material: primitive.material, indices: first_index..end }),
        }
        Ok(())
    }
}

/// Returns the sort key of draws. Those without an alpha test come first, in one run that a shadow pass draws with one
/// call.
fn draw_order(materials: &[Material], index: usize) -> (bool, usize) {
    (materials[index].alpha_cutoff.is_some(), index)
}

/// Returns the unit normal of the counter-clockwise side, and its dot product with the corners.
///
/// Computed from the rounded corners, the product with the rounded normal. Only the rounding of the product remains,
/// one ulp of the distance from the scene's center.
fn plane(corners: [[f32; 3]; 3]) -> [f32; 4] {
    let [a, b, c] = corners.map(|p| Vec3::from(p).as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
    let offset = normal.as_dvec3().dot((a + b + c) / 3.0);
    [normal.x, normal.y, normal.z, offset as f32]
}

/// [`Vertices`] on the GPU. Shaders can read every buffer, for instance to map casters into a light.
#[derive(Debug)]
pub(crate) struct Geometry {
    /// `array<f32>`, three per vertex.
    pub positions: Buffer,
    /// [`Attributes`] of each vertex.
    pub attributes: Buffer,
    /// Three per triangle.
    pub indices: Buffer,
    /// `array<vec4f>`, one per triangle.
    pub planes: Buffer,
    /// [`HierarchyNode`]s over all triangles.
    pub hierarchy: Buffer,
    /// The triangles in the order of the hierarchy's leaves.
    pub hierarchy_triangles: Buffer,
    /// Same data in CPU memory, for the native backend; `None` on the wgpu backend.
    pub host: Option<Arc<HostGeometry>>,
}

/// A scene's triangles in CPU memory, for lights on the native backend.
#[derive(Debug)]
pub(crate) struct HostGeometry {
    pub vertices: Vertices,
    /// Tree of the posed scene.
    pub hierarchy: Arc<Hierarchy>,
    /// The triangles in the order of the hierarchy's leaves.
    pub hierarchy_triangles: Vec<u32>,
}

impl HostGeometry {
    /// Returns the bytes of the arrays, without those that grow only with materials and nodes.
    fn bytes(&self) -> u64 {
        let Vertices { positions, attributes, indices, planes, .. } = &self.vertices;
        let of_triangles = size_of_val(&indices[..]) + size_of_val(&planes[..]);
        let of_vertices = size_of_val(&positions[..]) + size_of_val(&attributes[..]);
        let of_hierarchy = size_of_val(&self.hierarchy.nodes[..]) + size_of_val(&self.hierarchy_triangles[..]);
        (of_vertices + of_triangles + of_hierarchy) as u64
    }
}

impl Geometry {
    /// Returns the bytes of the buffers and of arrays in CPU memory.
    pub fn bytes(&self) -> u64 {
        let geometry = [&self.positions, &self.attributes, &self.indices, &self.planes];
        let buffers = geometry.into_iter().chain([&self.hierarchy, &self.hierarchy_triangles]);
        buffers.map(Buffer::size).sum::<u64>() + self.host.as_ref().map_or(0, |host| host.bytes())
    }

    /// Uploads the vertices of a scene, whose triangles are drawn in these `runs`.
    pub fn new(gpu: &Gpu, scene: &PosedScene, vertices: Vertices, runs: &[DrawRun]) -> Result<Self, RenderError> {
        let (hierarchy, hierarchy_triangles) = gpu.run_in_background(|| {
            let hierarchy = Arc::clone(scene.hierarchy());
            let triangles = in_draw_order(scene, runs, &hierarchy.order);
            (hierarchy, triangles)
        })?;
        // A binding must not be empty.
        let nodes = if hierarchy.nodes.is_empty() { &[HierarchyNode::NOWHERE] } else { &hierarchy.nodes[..] };
        let storage = BufferUsages::STORAGE;
        let (geometry, indices) = (storage | BufferUsages::VERTEX, storage | BufferUsages::INDEX);
        Ok(Self {
            positions: upload(gpu, "the scene's vertex positions in bytes", &vertices.positions, geometry)?,
            attributes: upload(gpu, "the scene's vertex attributes in bytes", &vertices.attributes, geometry)?,
            indices: upload(gpu, "the scene's triangle indices in bytes", &vertices.indices, indices)?,
            planes: upload(gpu, "the scene's triangles in bytes", &vertices.planes, storage)?,
            hierarchy: upload(gpu, "the boxes around the scene's triangles in bytes", nodes, storage)?,
            hierarchy_triangles: upload(
                gpu,
                "the order of the scene's triangles in bytes",
                &hierarchy_triangles,
                storage,
            )?,
            host: gpu.if_native(|| Arc::new(HostGeometry { vertices, hierarchy, hierarchy_triangles })),
        })
    }
}

/// Converts triangles in the order of the scene's primitives to their places in the draw order.
fn in_draw_order(scene: &PosedScene, runs: &[DrawRun], triangles: &[u32]) -> Vec<u32> {
    let mut by_primitive: Vec<_> = runs.iter().collect();
    by_primitive.sort_by_key(|run| run.primitive);
    let mut in_draws = Vec::with_capacity(scene.triangle_count());
    for run in by_primitive {
        in_draws.extend(run.indices.start / 3..run.indices.end / 3);
    }
    triangles.iter().map(|triangle| in_draws[*triangle as usize]).collect()
}

/// Creates a buffer with `data`. Returns an error if this device cannot hold it; `what` names the data with its unit.
pub(crate) fn upload<T: bytemuck::Pod>(
    gpu: &Gpu,
    what: &'static str,
    data: &[T],
    usage: BufferUsages,
) -> Result<Buffer, RenderError> {
    let bytes: &[u8] = bytemuck::cast_slice(data);
    let limits = gpu.device.limits();
    let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
    RenderError::check_size(what, bytes.len() as u64, limit)?;
    // An empty scene has buffers, too, because a binding must not be empty.
    let contents = if bytes.is_empty() { &[0; 16] } else { bytes };
    Ok(gpu.buffer_with(what, contents, usage))
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};
    use scene::{Primitive, Scene};

    use super::*;
    use crate::bendy_light::tests::add_mesh;

    /// Returns a triangle in the plane z = 0 that faces +z, transformed by `world_from_local`.
    fn scene_with(world_from_local: DAffine3) -> Scene {
        let primitive = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            indices: vec![0, 1, 2],
            ..Primitive::default()
        };
        let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
        add_mesh(&mut scene, primitive, world_from_local);
        scene
    }

    fn of(scene: Scene) -> Result<Vertices, RenderError> {
        Vertices::new(&scene::pose(scene, 0.0))
    }

    #[test]
    fn mirrored_nodes_keep_their_front() {
        for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(2.0, -0.5, 3.0)] {
            let posed = of(scene_with(DAffine3::from_scale(scale))).unwrap();
            assert_eq!(posed.attributes[0].normal, [0.0, 0.0, 1.0]);
            assert_eq!(posed.planes[0][..3], [0.0, 0.0, 1.0], "scale {scale}");
        }
        // Mirrored along z, the front faces the other way. The fault would be an unchanged winding.
        let posed = of(scene_with(DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)))).unwrap();
        assert_eq!((posed.attributes[0].normal, posed.planes[0][2]), ([0.0, 0.0, -1.0], -1.0));
    }

    #[test]
    fn singular_nodes_have_no_nan() {
        for scale in [DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::ZERO] {
            let posed = of(scene_with(DAffine3::from_scale(scale))).unwrap();
            assert!(posed.planes.iter().flatten().all(|x| x.is_finite()));
            assert!(posed.attributes.iter().all(|a| a.normal.iter().all(|x| x.is_finite())));
        }
        let flat = of(scene_with(DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)))).unwrap();
        assert_eq!(flat.attributes[0].normal, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn far_from_the_world_origin_nothing_is_lost() {
        let offset = DVec3::new(1e6, -2e6, 3e6);
        let (near, far) =
            (of(scene_with(DAffine3::IDENTITY)).unwrap(), of(scene_with(DAffine3::from_translation(offset))).unwrap());
        assert_eq!(near.positions, far.positions);
    }

    #[test]
    fn scenes_beyond_f32_are_refused() {
        let refused = of(scene_with(DAffine3::from_scale(DVec3::splat(1e16)))).unwrap_err();
        assert!(matches!(refused, RenderError::TooLarge { .. }));
    }

    #[test]
    fn alpha_tested_draws_come_last_and_equal_materials_merge() {
        let mut scene = scene_with(DAffine3::IDENTITY);
        scene.materials = vec![Material { alpha_cutoff: Some(0.5), ..Material::default() }, Material::default()];
        let alpha_tested = scene.meshes[0].primitives[0].clone();
        let opaque = Primitive { material: 1, ..alpha_tested.clone() };
        scene.meshes[0].primitives = vec![opaque.clone(), alpha_tested, opaque];
        let draws = of(scene).unwrap().draws;
        assert_eq!(draws, [MaterialRange { material: 1, indices: 0..6 }, MaterialRange { material: 0, indices: 6..9 }]);
    }
}
