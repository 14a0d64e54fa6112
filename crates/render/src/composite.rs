//! Layers times factors, added up.

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, BufferUsages, CommandEncoder, RenderPipeline, TextureView,
};

use crate::gpu_structs::TERMS;
use crate::pipeline::{UINT_TEXTURE, UNIFORM, color_attachment};
use crate::{Gpu, gpu_structs, lighting, shaders};

/// A layer, or a sum of some, and the factors of what it scatters and mirrors: linear RGB.
#[derive(Clone, Debug)]
pub(crate) struct Term {
    pub texture: TextureView,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
}

/// Sums as layers; as a screen shows them, [`crate::display`] has them.
#[derive(Debug)]
pub(crate) struct CompositePass {
    sum: RenderPipeline,
    pub layout: BindGroupLayout,
}

impl CompositePass {
    pub fn new(gpu: &Gpu) -> Self {
        let layout = gpu.layout("terms", &[&[UNIFORM][..], &[UINT_TEXTURE; TERMS]].concat());
        let module = gpu.module("sum", shaders::SUM);
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("sum"),
            // Where pictures for screens have their radiance there is none.
            bind_group_layouts: &[None, Some(&layout)],
            immediate_size: 0,
        });
        let sum =
            gpu.fullscreen_pipeline(&pipeline_layout, &module, "fs_sum", &[lighting::LAYER_FORMAT], None);
        Self { sum, layout }
    }

    /// What adds up to a sum: at least one and at most [`TERMS`].
    pub fn terms(&self, gpu: &Gpu, terms: &[Term]) -> BindGroup {
        let mut uniform = gpu_structs::Terms { count: terms.len() as u32, ..Default::default() };
        let padded = |[r, g, b]: [f32; 3]| [r, g, b, 0.0];
        for (index, term) in terms.iter().enumerate() {
            uniform.diffuse[index] = padded(term.diffuse);
            uniform.specular[index] = padded(term.specular);
        }
        let uniform = gpu.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("terms"),
            contents: bytemuck::bytes_of(&uniform),
            usage: BufferUsages::UNIFORM,
        });
        // What is not counted is bound all the same.
        let textures = terms.iter().chain(std::iter::repeat(&terms[0])).take(TERMS);
        let textures = textures.map(|term| BindingResource::TextureView(&term.texture));
        let resources: Vec<_> = [uniform.as_entire_binding()].into_iter().chain(textures).collect();
        gpu.group("terms", &self.layout, &resources)
    }

    /// Writes a sum.
    pub fn draw_sum(&self, encoder: &mut CommandEncoder, terms: &BindGroup, into: &TextureView) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("sum"),
            color_attachments: &[Some(color_attachment(into, true))],
            ..Default::default()
        });
        pass.set_pipeline(&self.sum);
        pass.set_bind_group(1, terms, &[]);
        pass.draw(0..3, 0..1);
    }
}
