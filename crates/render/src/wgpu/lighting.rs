//! Passes from the G-buffer to values: the fill, AOVs of the surface, and one additive pass or one layer per light.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, BindingType, BlendComponent, BlendFactor, BlendOperation, BlendState,
    Buffer, PipelineLayout, RenderPass, RenderPipeline, Sampler, ShaderModule, TextureFormat,
};

use crate::wgpu::pipeline::{MapTarget, entire};
use crate::wgpu::shaders;
use crate::{Aov, Gpu};

/// Format of radiance and every AOV: raw values, added up in f32.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Format of a layer; see `terms.wgsl`.
pub(crate) const LAYER_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;

const ADD: BlendState = {
    let sum =
        BlendComponent { src_factor: BlendFactor::One, dst_factor: BlendFactor::One, operation: BlendOperation::Add };
    BlendState { color: sum, alpha: sum }
};

/// Lighting passes of lights whose bind groups have one layout, by their constants and by whether lights have links.
/// Each pass is compiled at first use.
#[derive(Debug)]
pub(crate) struct LightPasses<K> {
    label: &'static str,
    compiled: Mutex<Vec<Variant<K>>>,
    /// Layouts of the view, the surface, the light and the links.
    group_layouts: [BindGroupLayout; 4],
    sampler: Sampler,
}

/// Values of a light that are compiled into its lighting pass.
pub(crate) trait LightConstants: Copy + PartialEq {
    /// Returns a label, and WGSL with the constants in it.
    fn wgsl(self) -> (&'static str, String);
}

#[derive(Debug)]
struct Variant<K> {
    constants: K,
    linked: bool,
    pass: Arc<LightingPass>,
}

impl<K: LightConstants> LightPasses<K> {
    /// Makes passes of lights with these bindings: buffers, the shadow map and its sampler. `camera_groups` are the
    /// layouts of the view and the surface.
    pub fn new(
        gpu: &Gpu,
        label: &'static str,
        bindings: &[BindingType],
        camera_groups: [&BindGroupLayout; 2],
        links: &BindGroupLayout,
    ) -> Self {
        let ([view, surface], own) = (camera_groups, gpu.bind_group_layout(label, bindings));
        let sampler = wgpu::SamplerDescriptor { label: Some(label), ..Default::default() };
        Self {
            label,
            compiled: Mutex::default(),
            group_layouts: [view.clone(), surface.clone(), own, links.clone()],
            sampler: gpu.device.create_sampler(&sampler),
        }
    }

    /// Returns the group of a light's own bindings.
    pub fn light_group(&self, gpu: &Gpu, buffers: &[&Buffer], map: &MapTarget) -> BindGroup {
        let mut resources = entire(buffers);
        resources.extend([BindingResource::TextureView(&map.all), BindingResource::Sampler(&self.sampler)]);
        gpu.bind_group(self.label, &self.group_layouts[2], &resources)
    }

    /// Returns the pass for a set of compiled-in constants, for lights with links if `linked`. Without `linked`, all
    /// triangles count, which is compiled in.
    pub fn get(&self, gpu: &Gpu, constants: K, linked: bool) -> Arc<LightingPass> {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |known: &&Variant<K>| (known.constants, known.linked) == (constants, linked);
        if let Some(known) = compiled.iter().find(is_it) {
            return Arc::clone(&known.pass);
        }
        let (label, wgsl) = constants.wgsl();
        let wgsl = shaders::lighting_pass(&wgsl, linked, gpu.has_subgroups());
        let groups = self.group_layouts.each_ref();
        let pass = Arc::new(LightingPass::new(gpu, label, &wgsl, &groups[..if linked { 4 } else { 3 }]));
        compiled.push(Variant { constants, linked, pass: Arc::clone(&pass) });
        pass
    }
}

/// Pipelines of a shader module that draw over the whole picture and add to it. Each AOV has an entry point of its own,
/// named `fs_` and the AOV's name. A pipeline is compiled at first use.
#[derive(Debug)]
pub(crate) struct LightingPass {
    layout: PipelineLayout,
    module: ShaderModule,
    pipelines: [OnceLock<RenderPipeline>; Aov::NAMES.len()],
    layer: OnceLock<RenderPipeline>,
}

impl LightingPass {
    /// Compiles the module. `groups` are the layouts of its bind groups; the first are those of the view and the
    /// surface.
    pub fn new(gpu: &Gpu, label: &str, wgsl: &str, groups: &[&BindGroupLayout]) -> Self {
        Self {
            layout: gpu.pipeline_layout(label, groups),
            module: gpu.shader_module(label, wgsl),
            pipelines: std::array::from_fn(|_| OnceLock::new()),
            layer: OnceLock::new(),
        }
    }

    /// Adds `aov` within `pixels`, `[x, y, width, height]`. `groups` follow those of the view and the surface.
    pub fn draw(&self, gpu: &Gpu, pass: &mut RenderPass, aov: Aov, groups: &[&BindGroup], pixels: [u32; 4]) {
        let pipeline = self.pipelines[aov as usize].get_or_init(|| {
            let entry_point = format!("fs_{}", aov.name());
            gpu.fullscreen_pipeline(&self.layout, &self.module, &entry_point, &[FORMAT], Some(ADD))
        });
        draw_within(pass, pipeline, groups, pixels);
    }

    /// Draws a light's scattered and mirrored radiance within `pixels`, before factors of the whole light.
    pub fn draw_layer(&self, gpu: &Gpu, pass: &mut RenderPass, groups: &[&BindGroup], pixels: [u32; 4]) {
        let pipeline = self
            .layer
            .get_or_init(|| gpu.fullscreen_pipeline(&self.layout, &self.module, "fs_layer", &[LAYER_FORMAT], None));
        draw_within(pass, pipeline, groups, pixels);
    }
}

fn draw_within(pass: &mut RenderPass, pipeline: &RenderPipeline, groups: &[&BindGroup], pixels: [u32; 4]) {
    let [x, y, width, height] = pixels;
    if width > 0 && height > 0 {
        pass.set_pipeline(pipeline);
        for (index, &group) in (2..).zip(groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.set_scissor_rect(x, y, width, height);
        pass.draw(0..3, 0..1);
    }
}
