//! Pipelines and the layouts of their bind groups, shared by all scenes and pictures.

use glam::DVec2;
use wgpu::BindGroupLayout;

use crate::Gpu;
use crate::bendy_light::BendyPass;
use crate::camera::CameraRaster;
use crate::composite::CompositePass;
use crate::display::DisplayPass;
use crate::gbuffer::{GbufferKey, GbufferPass};
use crate::gpu_scene::{GpuScene, SceneGroupLayouts};
use crate::lighting::LightingPass;
use crate::pipeline::{STORAGE, UNIFORM};
use crate::straight::StraightPass;
use crate::tile::Tile;
use crate::{linked, material, shaders};

/// Pipelines of all passes. Renderers on one device share them.
#[derive(Debug)]
pub(crate) struct Passes {
    pub group_layouts: SceneGroupLayouts,
    pub gbuffer: GbufferPass,
    pub fill: LightingPass,
    pub inspect: LightingPass,
    pub straight: StraightPass,
    pub bendy: BendyPass,
    pub composite: CompositePass,
    pub display: DisplayPass,
}

/// Scene that is drawn with a device's pipelines, as a camera sees it.
#[derive(Clone, Copy)]
pub(crate) struct DrawContext<'a> {
    pub gpu: &'a Gpu,
    pub passes: &'a Passes,
    pub scene: &'a GpuScene,
    pub raster: &'a CameraRaster,
    /// Part of the picture that is drawn.
    pub tile: Tile,
}

impl DrawContext<'_> {
    /// Returns the key of the tile's surfaces, for samples at this offset from the centers of pixels.
    pub fn gbuffer_key(&self, sample_offset: DVec2) -> GbufferKey {
        let Self { scene, raster, tile, .. } = *self;
        GbufferKey {
            revision: scene.revision,
            world_from_camera: raster.world_from_camera,
            projection: raster.projection,
            size: [raster.width, raster.height],
            tile,
            sample_offset,
        }
    }
}

impl Passes {
    pub fn new(gpu: &Gpu) -> Self {
        let group_layouts = SceneGroupLayouts {
            view: gpu.bind_group_layout("view", &[&[UNIFORM][..], &[STORAGE; 8]].concat()),
            material: gpu.bind_group_layout("material", &material::BINDINGS),
            fill: gpu.bind_group_layout("fill", &[UNIFORM]),
            links: gpu.bind_group_layout("links", &linked::BINDINGS),
        };
        let gbuffer = GbufferPass::new(gpu, &group_layouts.view, &group_layouts.material);
        let camera_groups: [&BindGroupLayout; 2] = [&group_layouts.view, &gbuffer.surface_layout];
        let [view, surface] = camera_groups;
        let composite = CompositePass::new(gpu);
        Self {
            fill: LightingPass::new(gpu, "fill", shaders::FILL, &[view, surface, &group_layouts.fill]),
            inspect: LightingPass::new(gpu, "inspect", shaders::INSPECT, &camera_groups),
            straight: StraightPass::new(gpu, camera_groups, &group_layouts),
            bendy: BendyPass::new(gpu, camera_groups, &group_layouts.links),
            display: DisplayPass::new(gpu, &composite.layout),
            composite,
            gbuffer,
            group_layouts,
        }
    }
}
