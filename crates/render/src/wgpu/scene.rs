//! A scene on the GPU.

use hierarchy::HierarchyNode;
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages};

use super::alpha_test::GpuAlphaTests;
use super::gpu_structs;
use super::material::{MaterialDraw, Materials};
use crate::frame::SceneParts;
use crate::frame::shared_scene::{FrameScene, SharedScene};
use crate::wgpu::Wgpu;
use crate::{Gpu, RenderError};

/// Geometry and materials on the GPU.
#[derive(Debug)]
pub(crate) struct GpuScene {
    pub geometry: Geometry,
    /// One draw per material in use. Those without an alpha test come first.
    pub draws: Vec<MaterialDraw>,
    /// Table without tests, which is bound if the scene has none.
    no_tests: GpuAlphaTests,
    /// Group 2 of the fill's pass; see `fill.wgsl`.
    pub fill: BindGroup,
}

/// Layouts of the bind groups of a scene.
#[derive(Debug)]
pub(crate) struct SceneGroupLayouts {
    pub view: BindGroupLayout,
    pub material: BindGroupLayout,
    pub fill: BindGroupLayout,
    pub links: BindGroupLayout,
}

/// Fragments per submission, so that work can yield: for a GPU, and for a software driver, which takes about 25 ms for
/// them.
const FRAGMENTS_AT_ONCE: f64 = 32e6;
const SOFTWARE_FRAGMENTS_AT_ONCE: f64 = 4e6;

impl GpuScene {
    /// Uploads geometry and materials. Also returns their bytes.
    pub fn new(gpu: &Gpu, layouts: &SceneGroupLayouts, parts: &SceneParts) -> Result<(Self, u64), RenderError> {
        let scene = &parts.posed.scene;
        let Materials { draws, texture_bytes } = Materials::new(gpu, &layouts.material, scene, &parts.vertices.draws)?;
        gpu.host.yield_point()?;
        let geometry = Geometry::new(gpu, parts)?;
        let fill = gpu_structs::Fill {
            sky: scene.fill.sky.as_vec3().to_array(),
            ground: scene.fill.ground.as_vec3().to_array(),
            ..gpu_structs::Fill::default()
        };
        let fill_uniform = gpu.uniform_with("fill", &fill);
        let fill = gpu.bind_group("fill", &layouts.fill, &[fill_uniform.as_entire_binding()]);
        let bytes = texture_bytes + geometry.bytes();
        Ok((Self { geometry, draws, no_tests: GpuAlphaTests::none(gpu)?, fill }, bytes))
    }
}

/// Returns group 0 of the passes with a camera; see `view.wgsl`. `view_uniform` has the camera of each picture.
pub(crate) fn view_group(
    gpu: &Gpu,
    layouts: &SceneGroupLayouts,
    view_uniform: &Buffer,
    scene: &SharedScene<Wgpu>,
) -> BindGroup {
    let GpuScene { geometry, no_tests, .. } = &scene.uploaded;
    let Geometry { positions, attributes, indices, planes, hierarchy, hierarchy_triangles } = geometry;
    let tests = scene.alpha_tests.as_ref().map_or(no_tests, |(_, tests)| tests);
    let resources = [view_uniform, planes, positions, indices, attributes]
        .into_iter()
        .chain([hierarchy, hierarchy_triangles, &tests.tests, &tests.texels])
        .map(Buffer::as_entire_binding)
        .collect::<Vec<_>>();
    gpu.bind_group("view", &layouts.view, &resources)
}

/// Returns the number of parts for drawing the scene's triangles onto `pixels`, or for ray tests near those pixels. It
/// is 1 except for scenes with a great depth complexity.
pub(crate) fn part_count(gpu: &Gpu, scene: &FrameScene<Wgpu>, pixels: u64) -> u32 {
    let at_once = if gpu.is_cpu() { SOFTWARE_FRAGMENTS_AT_ONCE } else { FRAGMENTS_AT_ONCE };
    (scene.posed.depth_complexity() * pixels as f64 / at_once).ceil().clamp(1.0, 65_536.0) as u32
}

/// [`crate::frame::geometry::Vertices`] on the GPU. Shaders can read every buffer, for instance to map casters into a light.
#[derive(Debug)]
pub(crate) struct Geometry {
    /// `array<f32>`, three per vertex.
    pub positions: Buffer,
    /// [`crate::frame::geometry::Attributes`] of each vertex.
    pub attributes: Buffer,
    /// Three per triangle.
    pub indices: Buffer,
    /// `array<vec4f>`, one per triangle.
    pub planes: Buffer,
    /// [`HierarchyNode`]s over all triangles.
    pub hierarchy: Buffer,
    /// The triangles in the order of the hierarchy's leaves.
    pub hierarchy_triangles: Buffer,
}

impl Geometry {
    /// Returns the bytes of the buffers.
    fn bytes(&self) -> u64 {
        let geometry = [&self.positions, &self.attributes, &self.indices, &self.planes];
        geometry.into_iter().chain([&self.hierarchy, &self.hierarchy_triangles]).map(Buffer::size).sum()
    }

    fn new(gpu: &Gpu, parts: &SceneParts) -> Result<Self, RenderError> {
        let SceneParts { vertices, hierarchy, hierarchy_triangles, .. } = parts;
        // A binding must not be empty.
        let nodes = if hierarchy.nodes.is_empty() { &[HierarchyNode::NOWHERE] } else { &hierarchy.nodes[..] };
        let storage = BufferUsages::STORAGE;
        let (geometry, indices) = (storage | BufferUsages::VERTEX, storage | BufferUsages::INDEX);
        let order = "the order of the scene's triangles in bytes";
        Ok(Self {
            positions: gpu.upload("the scene's vertex positions in bytes", &vertices.positions, geometry)?,
            attributes: gpu.upload("the scene's vertex attributes in bytes", &vertices.attributes, geometry)?,
            indices: gpu.upload("the scene's triangle indices in bytes", &vertices.indices, indices)?,
            planes: gpu.upload("the scene's triangles in bytes", &vertices.planes, storage)?,
            hierarchy: gpu.upload("the boxes around the scene's triangles in bytes", nodes, storage)?,
            hierarchy_triangles: gpu.upload(order, hierarchy_triangles, storage)?,
        })
    }
}
