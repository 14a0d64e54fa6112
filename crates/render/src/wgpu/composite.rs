//! Sums of layers, each times its factors.

use wgpu::{BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline, TextureFormat, TextureView};

use crate::Gpu;
use crate::frame::{TERMS, Term};
use crate::wgpu::gpu_structs;
use crate::wgpu::pipeline::{UINT_TEXTURE, UNIFORM, color_attachment};
use crate::wgpu::shaders;

pub(crate) const SUM_FORMAT: TextureFormat = TextureFormat::Rg32Uint;

/// Terms of a picture or a sum: at least one and at most [`TERMS`] layers or sums.
#[derive(Debug)]
pub(crate) struct GpuTerms {
    pub group: BindGroup,
    pub kind: TermKind,
}

/// Kind of the terms that a pass adds up. It selects constants of the shader, and the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TermKind {
    Layers,
    Sums,
}

impl TermKind {
    pub const ALL: [Self; 2] = [Self::Layers, Self::Sums];

    /// Prepends the constant of `terms.wgsl` to `wgsl`.
    pub fn into_wgsl(self, wgsl: &str) -> String {
        format!("const OF_SUMS = {};\n{wgsl}", self == Self::Sums)
    }
}

/// Pass that adds up layers, or sums of layers. [`crate::wgpu::display`] shows the result on a screen.
#[derive(Debug)]
pub(crate) struct CompositePass {
    sums: [RenderPipeline; 2],
    pub layout: BindGroupLayout,
}

impl CompositePass {
    pub fn new(gpu: &Gpu) -> Self {
        let layout = gpu.bind_group_layout("terms", &[&[UNIFORM][..], &[UINT_TEXTURE; TERMS]].concat());
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sum"),
            // A sum has no radiance, which pictures for screens bind here.
            bind_group_layouts: &[None, Some(&layout)],
            immediate_size: 0,
        });
        let sums = TermKind::ALL.map(|of| {
            let module = gpu.shader_module("sum", &of.into_wgsl(shaders::SUM));
            gpu.fullscreen_pipeline(&pipeline_layout, &module, "fs_sum", &[SUM_FORMAT], None)
        });
        Self { sums, layout }
    }

    /// Makes the terms of a sum from layers and their factors.
    pub fn layers(&self, gpu: &Gpu, terms: &[Term<TextureView>]) -> GpuTerms {
        let mut uniform = gpu_structs::Terms { count: terms.len() as u32, ..Default::default() };
        let padded = |[r, g, b]: [f32; 3]| [r, g, b, 0.0];
        for (index, term) in terms.iter().enumerate() {
            uniform.diffuse[index] = padded(term.diffuse);
            uniform.specular[index] = padded(term.specular);
        }
        let textures: Vec<_> = terms.iter().map(|term| &term.layer).collect();
        GpuTerms { group: self.group(gpu, &uniform, &textures), kind: TermKind::Layers }
    }

    /// Makes the terms of a sum from sums, each with factor 1.
    pub fn sums(&self, gpu: &Gpu, sums: &[TextureView]) -> GpuTerms {
        let uniform = gpu_structs::Terms { count: sums.len() as u32, ..Default::default() };
        GpuTerms { group: self.group(gpu, &uniform, &sums.iter().collect::<Vec<_>>()), kind: TermKind::Sums }
    }

    fn group(&self, gpu: &Gpu, uniform: &gpu_structs::Terms, textures: &[&TextureView]) -> BindGroup {
        let uniform = gpu.uniform_with("terms", uniform);
        // Unused slots need a binding, too.
        let textures = textures.iter().chain(std::iter::repeat(&textures[0])).take(TERMS);
        let textures = textures.map(|texture| BindingResource::TextureView(texture));
        let resources: Vec<_> = [uniform.as_entire_binding()].into_iter().chain(textures).collect();
        gpu.bind_group("terms", &self.layout, &resources)
    }

    pub fn draw_sum(&self, encoder: &mut CommandEncoder, terms: &GpuTerms, into: &TextureView) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("sum"),
            color_attachments: &[Some(color_attachment(into, true))],
            ..Default::default()
        });
        pass.set_pipeline(&self.sums[terms.kind as usize]);
        pass.set_bind_group(1, &terms.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
