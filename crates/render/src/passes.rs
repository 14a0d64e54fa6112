//! The pipelines and layouts, which outlive scenes and pictures.

use wgpu::BindGroupLayout;

use crate::Gpu;
use crate::bendy_light::BendyPass;
use crate::display::DisplayPass;
use crate::gbuffer::GbufferPass;
use crate::lighting::LightingPass;
use crate::pipeline::{STORAGE, UNIFORM};
use crate::spot::SpotPass;
use crate::staged::SceneLayouts;
use crate::{material, shaders};

/// All of them: renderers on one device share these.
#[derive(Debug)]
pub(crate) struct Passes {
    pub layouts: SceneLayouts,
    pub gbuffer: GbufferPass,
    pub fill: LightingPass,
    pub inspect: LightingPass,
    pub spot: SpotPass,
    pub bendy: BendyPass,
    pub display: DisplayPass,
}

impl Passes {
    pub fn new(gpu: &Gpu) -> Self {
        let layouts = SceneLayouts {
            view: gpu.layout("view", &[&[UNIFORM][..], &[STORAGE; 8]].concat()),
            material: gpu.layout("material", &material::BINDINGS),
            fill: gpu.layout("fill", &[UNIFORM]),
        };
        let gbuffer = GbufferPass::new(gpu, &layouts.view, &layouts.material);
        let camera_groups: [&BindGroupLayout; 2] = [&layouts.view, &gbuffer.surface_layout];
        let [view, surface] = camera_groups;
        Self {
            fill: LightingPass::new(gpu, "fill", shaders::FILL, &[view, surface, &layouts.fill]),
            inspect: LightingPass::new(gpu, "inspect", shaders::INSPECT, &camera_groups),
            spot: SpotPass::new(gpu, camera_groups, &layouts.material),
            bendy: BendyPass::new(gpu, camera_groups),
            display: DisplayPass::new(gpu),
            gbuffer,
            layouts,
        }
    }
}
