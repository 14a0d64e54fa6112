//! Converts linear radiance to bytes of a screen.

use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, Buffer, CommandEncoder, RenderPipeline, TextureFormat, TextureView,
};

use crate::Gpu;
use crate::exposure;
use crate::wgpu::composite::{GpuTerms, TermKind};
use crate::wgpu::gpu_structs;
use crate::wgpu::pipeline::{RAW_TEXTURE, UNIFORM, color_attachment};
use crate::wgpu::shaders;

/// The shader encodes sRGB; the texture only rounds to the nearest of 256 steps.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

#[derive(Debug)]
pub(crate) struct DisplayPass {
    pipeline: RenderPipeline,
    /// Pipelines that add layers or sums.
    composites: [RenderPipeline; 2],
    layout: BindGroupLayout,
}

/// Bind group with a picture's radiance and its exposure.
#[derive(Debug)]
pub(crate) struct ExposedRadiance {
    group: BindGroup,
    uniform: Buffer,
}

impl DisplayPass {
    /// Compiles the pipelines. `terms` is the layout of the bind group of layers or sums.
    pub fn new(gpu: &Gpu, terms: &BindGroupLayout) -> Self {
        let layout = gpu.bind_group_layout("display", &[RAW_TEXTURE, UNIFORM]);
        let pipeline = |wgsl: &str, entry_point, groups: &[&BindGroupLayout]| {
            let pipeline_layout = gpu.pipeline_layout("display", groups);
            gpu.fullscreen_pipeline(&pipeline_layout, &gpu.shader_module("display", wgsl), entry_point, &[FORMAT], None)
        };
        Self {
            pipeline: pipeline(shaders::DISPLAY, "fs_display", &[&layout]),
            composites: TermKind::ALL
                .map(|of| pipeline(&of.into_wgsl(shaders::COMPOSITE), "fs_composite", &[&layout, terms])),
            layout,
        }
    }

    /// Binds `radiance` for this pass.
    pub fn bind_radiance(&self, gpu: &Gpu, radiance: &TextureView) -> ExposedRadiance {
        let uniform = gpu.uniform_buffer::<gpu_structs::Exposure>("exposure");
        let resources = [BindingResource::TextureView(radiance), uniform.as_entire_binding()];
        ExposedRadiance { group: gpu.bind_group("display", &self.layout, &resources), uniform }
    }

    /// Draws radiance plus the sum of `terms`, if any, with an exposure in `stops`.
    pub fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        radiance: &ExposedRadiance,
        terms: Option<&GpuTerms>,
        stops: f64,
        into: &TextureView,
    ) {
        let relight::Exposure { factor, brightest } = exposure::from_stops(stops);
        let uniform = gpu_structs::Exposure { factor, brightest };
        gpu.queue.write_buffer(&radiance.uniform, 0, bytemuck::bytes_of(&uniform));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("display"),
            color_attachments: &[Some(color_attachment(into, true))],
            ..Default::default()
        });
        pass.set_pipeline(terms.map_or(&self.pipeline, |terms| &self.composites[terms.kind as usize]));
        pass.set_bind_group(0, &radiance.group, &[]);
        if let Some(terms) = terms {
            pass.set_bind_group(1, &terms.group, &[]);
        }
        pass.draw(0..3, 0..1);
    }
}
