//! A scene on the GPU.

use glam::DVec3;
use light::Reach;
use scene::Scene;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages};

use crate::alpha_test::AlphaTests;
use crate::casters::Casters;
use crate::clusters::Clusters;
use crate::geometry::{Geometry, Posed};
use crate::ledger::{Entry, MemoryKind};
use crate::material::{MaterialDraw, Materials};
use crate::{Gpu, RenderError, layout};

/// What is made once a scene.
#[derive(Debug)]
pub(crate) struct StagedScene {
    /// Which scene of its renderer: whatever was made from another one is stale.
    pub revision: u64,
    /// Where scene space begins, in the world.
    pub origin: DVec3,
    /// The bounds reach from minus to plus this, in scene space.
    pub half_extent: DVec3,
    pub geometry: Geometry,
    /// The scene's own triangles as casters: they share the buffers of `geometry`.
    pub surface: Casters,
    /// What casts shadows.
    pub casters: Casters,
    /// Boxes around the surface.
    pub clusters: Clusters,
    pub draws: Vec<MaterialDraw>,
    /// Those of `draws` that have one; none where no draw has.
    pub alpha_tests: Option<AlphaTests>,
    /// Group 0 of the passes that have a camera; see `view.wgsl`.
    pub view: BindGroup,
    /// Group 2 of the fill's pass; see `fill.wgsl`.
    pub fill: BindGroup,
    /// Counts its buffers and textures.
    _entry: Entry,
}

/// The layouts of the groups that a scene fills.
#[derive(Debug)]
pub(crate) struct SceneLayouts {
    pub view: BindGroupLayout,
    pub material: BindGroupLayout,
    pub fill: BindGroupLayout,
}

impl StagedScene {
    /// What lights are measured against.
    pub fn reach(&self) -> Reach {
        Reach { middle: self.origin, half_extent: self.half_extent }
    }

    /// Poses `scene` and uploads it. `view_uniform` will hold the camera of each picture; casters may stray
    /// from the surface by `mesh_error`, in world units.
    pub fn new(
        gpu: &Gpu,
        layouts: &SceneLayouts,
        view_uniform: &Buffer,
        scene: &Scene,
        revision: u64,
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let posed = Posed::new(scene)?;
        let opaque = posed.draws.iter().rfind(|draw| scene.materials[draw.material].alpha_cutoff.is_none());
        let opaque_indices = opaque.map_or(0, |draw| draw.indices.end);
        let geometry = Geometry::new(gpu, &posed)?;
        let Materials { draws, alpha_tests, texture_bytes } =
            Materials::new(gpu, &layouts.material, scene, &posed)?;
        let no_tests;
        let tests = if let Some(tests) = &alpha_tests {
            tests
        } else {
            no_tests = AlphaTests::none(gpu)?;
            &no_tests
        };
        let Geometry { positions, attributes, indices, planes, hierarchy, hierarchy_triangles } = &geometry;
        let view_resources = [view_uniform, planes, positions, indices, attributes]
            .into_iter()
            .chain([hierarchy, hierarchy_triangles, &tests.tests, &tests.texels])
            .map(Buffer::as_entire_binding)
            .collect::<Vec<_>>();
        let view = gpu.group("view", &layouts.view, &view_resources);
        let fill_uniform = gpu.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("fill"),
            contents: bytemuck::bytes_of(&layout::Fill {
                sky: scene.fill.sky.as_vec3().to_array(),
                ground: scene.fill.ground.as_vec3().to_array(),
                ..layout::Fill::default()
            }),
            usage: BufferUsages::UNIFORM,
        });
        let surface = Casters {
            positions: geometry.positions.clone(),
            indices: geometry.indices.clone(),
            vertex_count: posed.positions.len() as u32,
            triangle_count: posed.planes.len() as u32,
            opaque_indices,
        };
        let casters = surface.simplified(gpu, mesh_error)?;
        let bytes = texture_bytes + geometry.bytes() + alpha_tests.as_ref().map_or(0, AlphaTests::bytes);
        Ok(Self {
            revision,
            origin: posed.scene_origin,
            half_extent: posed.half_extent,
            geometry,
            surface,
            casters,
            clusters: Clusters::new(&posed.positions, &posed.indices),
            draws,
            alpha_tests,
            view,
            fill: gpu.group("fill", &layouts.fill, &[fill_uniform.as_entire_binding()]),
            _entry: gpu.ledger.enter(MemoryKind::Scenes, bytes),
        })
    }
}
