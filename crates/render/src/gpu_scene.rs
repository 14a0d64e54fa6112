//! A scene on the GPU.

use std::ops::Deref;
use std::sync::Arc;

use relight::SurfaceMaterials;
use scene::PosedScene;
use wgpu::{BindGroup, BindGroupLayout, Buffer};

use crate::alpha_test::GpuAlphaTests;
use crate::casters::{CasterSet, Casters};
use crate::geometry::{DrawRun, Geometry, Vertices};
use crate::material::{MaterialDraw, Materials};
use crate::memory::{MemoryKind, Reservation};
use crate::{Gpu, RenderError, gpu_structs};

/// Scene on the device, which any number of renderers can use. Clones share it.
#[derive(Clone, Debug)]
pub struct SceneOnDevice(Arc<UploadedScene>);

/// Data of a scene that is uploaded once and shared by renderers.
#[derive(Debug)]
pub(crate) struct UploadedScene {
    pub posed: Arc<PosedScene>,
    pub geometry: Geometry,
    pub triangle_count: u32,
    /// Number of leading indices whose triangles have no alpha test.
    pub opaque_indices: u32,
    pub draws: Vec<MaterialDraw>,
    /// Triangle ranges of each node.
    pub runs: Vec<DrawRun>,
    /// Alpha tests of `draws`; `None` if no draw has one.
    pub alpha_tests: Option<GpuAlphaTests>,
    /// Table without tests, which is bound in place of `alpha_tests` if there are none.
    no_tests: Option<GpuAlphaTests>,
    /// Group 2 of the fill's pass; see `fill.wgsl`.
    pub fill: BindGroup,
    /// Materials in CPU memory, for surfaces on the native backend; `None` on the wgpu backend.
    pub host_materials: Option<HostMaterials>,
    /// Largest distance of the shadow casters from the surface in world units, and the casters.
    casters: (f64, Arc<Casters>),
    /// Counts the memory of buffers, textures and copies in CPU memory.
    _memory: Reservation,
}

/// Materials of a scene in CPU memory.
#[derive(Debug)]
pub(crate) struct HostMaterials {
    pub materials: SurfaceMaterials,
    /// One bit per triangle, in words of 32 triangles: set if the triangle is seen from both sides.
    pub both_sides: Vec<u32>,
}

impl HostMaterials {
    fn new(materials: SurfaceMaterials, draws: &[MaterialDraw], triangle_count: u32) -> Self {
        let mut both_sides = vec![0; triangle_count.div_ceil(32) as usize];
        for draw in draws.iter().filter(|draw| draw.double_sided) {
            for triangle in draw.indices.start / 3..draw.indices.end / 3 {
                both_sides[triangle as usize / 32] |= 1 << (triangle % 32);
            }
        }
        Self { materials, both_sides }
    }

    fn bytes(&self) -> u64 {
        self.materials.bytes() + size_of_val(&self.both_sides[..]) as u64
    }
}

/// Scene as one renderer uses it: shared uploaded data, and the renderer's own bind group.
#[derive(Debug)]
pub(crate) struct GpuScene {
    /// Number that the renderer gives to each scene it is set to. Cached data of another number is invalid.
    pub revision: u64,
    pub casters: Arc<Casters>,
    /// Group 0 of the passes with a camera, with the camera of this renderer; see `view.wgsl`.
    pub view: BindGroup,
    uploaded: SceneOnDevice,
}

/// Layouts of the bind groups of a scene.
#[derive(Debug)]
pub(crate) struct SceneGroupLayouts {
    pub view: BindGroupLayout,
    pub material: BindGroupLayout,
    pub fill: BindGroupLayout,
    pub links: BindGroupLayout,
}

impl Deref for GpuScene {
    type Target = UploadedScene;

    fn deref(&self) -> &UploadedScene {
        &self.uploaded.0
    }
}

/// Fragments per submission, so that work can yield: for a GPU, and for a software driver, which takes about 25 ms for
/// them.
const FRAGMENTS_AT_ONCE: f64 = 32e6;
const SOFTWARE_FRAGMENTS_AT_ONCE: f64 = 4e6;

impl GpuScene {
    /// Returns the number of parts for drawing the triangles onto `pixels`, or for ray tests near those pixels. It is 1
    /// except for scenes with a great depth complexity.
    pub fn part_count(&self, gpu: &Gpu, pixels: u64) -> u32 {
        let at_once = if gpu.is_cpu() { SOFTWARE_FRAGMENTS_AT_ONCE } else { FRAGMENTS_AT_ONCE };
        (self.posed.depth_complexity() * pixels as f64 / at_once).ceil().clamp(1.0, 65_536.0) as u32
    }

    pub fn alpha_tested_draws(&self) -> &[MaterialDraw] {
        &self.draws[self.draws.partition_point(|draw| !draw.is_alpha_tested)..]
    }

    /// Returns the shadow casters of lights without links.
    pub fn all_casters(&self) -> CasterSet<'_> {
        CasterSet {
            casters: &self.casters,
            alpha_tested: self.alpha_tested_draws(),
            alpha_tests: self.alpha_tests.as_ref(),
        }
    }

    /// Returns the casters within `mesh_error` of the surface, in world units.
    pub fn casters_within(&self, gpu: &Gpu, mesh_error: f64) -> Result<Casters, RenderError> {
        Casters::new(gpu, (&Vertices::new(&self.posed)?, self.opaque_indices as usize), mesh_error)
    }

    /// Binds a scene on the device for a renderer, whose `view_uniform` will hold the camera of each picture. Casters
    /// are within `mesh_error` of the surface, in world units.
    pub fn new(
        gpu: &Gpu,
        group_layouts: &SceneGroupLayouts,
        view_uniform: &Buffer,
        uploaded: SceneOnDevice,
        revision: u64,
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let UploadedScene { geometry, alpha_tests, no_tests, .. } = &*uploaded.0;
        let Geometry { positions, attributes, indices, planes, hierarchy, hierarchy_triangles, .. } = geometry;
        let tests = alpha_tests.as_ref().or(no_tests.as_ref()).expect("one of them is there");
        let view_resources = [view_uniform, planes, positions, indices, attributes]
            .into_iter()
            .chain([hierarchy, hierarchy_triangles, &tests.tests, &tests.texels])
            .map(Buffer::as_entire_binding)
            .collect::<Vec<_>>();
        let view = gpu.bind_group("view", &group_layouts.view, &view_resources);
        let casters = Arc::clone(&uploaded.0.casters.1);
        let mut scene = Self { revision, casters, view, uploaded };
        if scene.uploaded.0.casters.0 != mesh_error {
            scene.casters = scene.casters_within(gpu, mesh_error)?.into();
        }
        Ok(scene)
    }

    /// Returns the part that other renderers can share.
    pub fn on_device(&self) -> &SceneOnDevice {
        &self.uploaded
    }
}

impl SceneOnDevice {
    /// Uploads a scene. Casters are within `mesh_error` of the surface, in world units.
    pub(crate) fn upload(
        gpu: &Gpu,
        group_layouts: &SceneGroupLayouts,
        posed: &Arc<PosedScene>,
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let (scene, mut vertices) = (&posed.scene, gpu.run_in_background(|| Vertices::new(posed))??);
        let opaque = vertices.draws.iter().rfind(|draw| scene.materials[draw.material].alpha_cutoff.is_none());
        let opaque_indices = opaque.map_or(0, |draw| draw.indices.end);
        let Materials { draws, alpha_tests, host, texture_bytes } =
            Materials::new(gpu, &group_layouts.material, scene, &vertices.draws)?;
        gpu.yield_point()?;
        let no_tests = if alpha_tests.is_none() { Some(GpuAlphaTests::none(gpu)?) } else { None };
        let casters = Casters::new(gpu, (&vertices, opaque_indices as usize), mesh_error)?;
        gpu.yield_point()?;
        let (triangle_count, runs) = (vertices.planes.len() as u32, std::mem::take(&mut vertices.runs));
        let geometry = Geometry::new(gpu, posed, vertices, &runs)?;
        gpu.yield_point()?;
        let host_materials = host.map(|materials| HostMaterials::new(materials, &draws, triangle_count));
        let fill = gpu_structs::Fill {
            sky: scene.fill.sky.as_vec3().to_array(),
            ground: scene.fill.ground.as_vec3().to_array(),
            ..gpu_structs::Fill::default()
        };
        let fill_uniform = gpu.uniform_with("fill", &fill);
        let bytes = texture_bytes
            + geometry.bytes()
            + casters.bytes()
            + alpha_tests.as_ref().map_or(0, GpuAlphaTests::bytes)
            + host_materials.as_ref().map_or(0, HostMaterials::bytes);
        Ok(Self(Arc::new(UploadedScene {
            posed: Arc::clone(posed),
            geometry,
            triangle_count,
            opaque_indices,
            draws,
            runs,
            alpha_tests,
            no_tests,
            host_materials,
            fill: gpu.bind_group("fill", &group_layouts.fill, &[fill_uniform.as_entire_binding()]),
            casters: (mesh_error, casters.into()),
            _memory: gpu.memory.reserve(MemoryKind::Scenes, bytes),
        })))
    }
}
