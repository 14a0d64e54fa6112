//! Passes from the G-buffer to values: the fill, AOVs of the surface, and one additive pass or one layer per light.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use wgpu::{
    BindGroup, BindGroupLayout, BlendComponent, BlendFactor, BlendOperation, BlendState, PipelineLayout,
    RenderPass, RenderPipeline, ShaderModule, TextureFormat,
};

use crate::{Aov, Gpu, shaders};

/// Format of radiance and every AOV: raw values, added up in f32.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Format of a layer; see `terms.wgsl`.
pub(crate) const LAYER_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;

const ADD: BlendState = {
    let sum = BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: sum, alpha: sum }
};

/// Compiled passes of one shader module, by their constants and by whether lights have links. Each pass is compiled at
/// first use.
#[derive(Debug)]
pub(crate) struct PassVariants<K>(Mutex<Vec<Variant<K>>>);

#[derive(Debug)]
struct Variant<K> {
    constants: K,
    linked: bool,
    pass: Arc<LightingPass>,
}

impl<K: Copy + PartialEq> PassVariants<K> {
    pub fn new() -> Self {
        Self(Mutex::default())
    }

    /// Returns the pass for a set of compiled-in constants, for lights with links if `linked`. Calls `make` to compile
    /// the pass if it does not exist yet.
    pub fn get(&self, constants: K, linked: bool, make: impl FnOnce() -> LightingPass) -> Arc<LightingPass> {
        let mut made = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |known: &&Variant<K>| (known.constants, known.linked) == (constants, linked);
        if let Some(known) = made.iter().find(is_it) {
            return Arc::clone(&known.pass);
        }
        let pass = Arc::new(make());
        made.push(Variant { constants, linked, pass: Arc::clone(&pass) });
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

    /// Makes a pass of a light. `groups` are the layouts of the view, the surface, the light and links. Without
    /// `linked`, all triangles count, which is compiled in.
    pub fn of_light(gpu: &Gpu, label: &str, wgsl: &str, linked: bool, groups: [&BindGroupLayout; 4]) -> Self {
        let count = if linked { 4 } else { 3 };
        Self::new(gpu, label, &shaders::lighting_pass(wgsl, linked, gpu.has_subgroups()), &groups[..count])
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
        let pipeline = self.layer.get_or_init(|| {
            gpu.fullscreen_pipeline(&self.layout, &self.module, "fs_layer", &[LAYER_FORMAT], None)
        });
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
