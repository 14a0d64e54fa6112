//! Linear radiance to the bytes of a screen.

use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline, TextureFormat, TextureView,
};

use crate::pipeline::{RAW_TEXTURE, color_attachment};
use crate::{Gpu, shaders};

/// Encoded by the shader: the texture only rounds to the nearest of 256 steps.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

#[derive(Debug)]
pub(crate) struct DisplayPass {
    pipeline: RenderPipeline,
    layout: BindGroupLayout,
}

impl DisplayPass {
    pub fn new(gpu: &Gpu) -> Self {
        let layout = gpu.layout("display", &[RAW_TEXTURE]);
        let module = gpu.module("display", shaders::DISPLAY);
        let pipeline_layout = gpu.pipeline_layout("display", &[&layout]);
        let pipeline = gpu.fullscreen_pipeline(&pipeline_layout, &module, "fs_display", FORMAT, None);
        Self { pipeline, layout }
    }

    /// The group that reads `radiance`.
    pub fn group(&self, gpu: &Gpu, radiance: &TextureView) -> BindGroup {
        gpu.group("display", &self.layout, &[BindingResource::TextureView(radiance)])
    }

    pub fn draw(&self, encoder: &mut CommandEncoder, radiance: &BindGroup, into: &TextureView) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("display"),
            color_attachments: &[Some(color_attachment(into, true))],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, radiance, &[]);
        pass.draw(0..3, 0..1);
    }
}
