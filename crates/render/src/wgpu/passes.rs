//! Pipelines and the layouts of their bind groups, shared by all scenes and pictures.

use wgpu::BindGroupLayout;

use super::bendy_light::BendyPass;
use super::composite::CompositePass;
use super::display::DisplayPass;
use super::gbuffer::GbufferPass;
use super::lighting::LightingPass;
use super::pipeline::{STORAGE, UINT_TEXTURE, UNIFORM};
use super::scene::SceneGroupLayouts;
use super::straight::StraightPass;
use super::{material, shaders};
use crate::Gpu;

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

impl Passes {
    pub fn new(gpu: &Gpu) -> Self {
        let group_layouts = SceneGroupLayouts {
            view: gpu.bind_group_layout("view", &[&[UNIFORM][..], &[STORAGE; 8]].concat()),
            material: gpu.bind_group_layout("material", &material::BINDINGS),
            fill: gpu.bind_group_layout("fill", &[UNIFORM]),
            links: gpu.bind_group_layout("links", &[UINT_TEXTURE]),
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
