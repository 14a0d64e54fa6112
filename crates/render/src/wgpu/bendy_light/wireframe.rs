//! Draws the triangles of a bent shadow map (see `wireframe.wgsl`), to show their density and position.

use std::mem::offset_of;

use shadow::MapShape;
use wgpu::{Buffer, CommandEncoder, RenderPipeline, TextureView};

use super::gpu_structs::{BentCounts, Wireframe};
use super::shadow_buffers::Buffers;
use crate::Gpu;
use crate::wgpu::lighting;
use crate::wgpu::pipeline::{DrawPipeline, END_OF_LIGHT, color_attachment, depth_attachment, depth_test, entire};
use crate::wgpu::shaders;

/// Pipelines that draw a bent shadow map's triangles as a wireframe. All scenes and lights share them.
#[derive(Debug)]
pub(crate) struct WireframePass {
    whole: RenderPipeline,
    split: RenderPipeline,
}

/// Target of a wireframe: a picture of any aspect ratio.
pub(crate) struct WireframeTarget<'a> {
    pub pass: &'a WireframePass,
    pub color: &'a TextureView,
    pub depth: &'a TextureView,
    /// In pixels.
    pub size: [u32; 2],
    /// Value of the light's own t where the drawn part begins, and change of the light's t per t of the part.
    pub t_of_light: [f64; 2],
}

impl WireframePass {
    pub fn new(gpu: &Gpu) -> Self {
        let module = gpu.shader_module("wireframe", shaders::WIREFRAME);
        let pipeline = |vertex| {
            gpu.draw_pipeline(DrawPipeline {
                // Casters at the very end of the light are drawn, too.
                depth_stencil: Some(depth_test(wgpu::CompareFunction::LessEqual)),
                targets: &[Some(lighting::FORMAT.into())],
                ..DrawPipeline::new(vertex, &module, vertex, Some("fs_wireframe"))
            })
        };
        Self { whole: pipeline("vs_whole"), split: pipeline("vs_split") }
    }
}

impl WireframeTarget<'_> {
    /// Draws the mapped triangles, into a cleared picture or over those of earlier slabs.
    pub(super) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        mapped: &Buffers,
        shape: &MapShape,
        clear: bool,
    ) {
        let [width, height] = self.size.map(|side| side as f32);
        let shorter = width.min(height);
        let uniform = Wireframe {
            clip_per_vw: [shorter / width, shorter / height],
            t_start: self.t_of_light[0] as f32,
            t_span: self.t_of_light[1] as f32,
            map_t_base: shape.t_base() as f32,
            map_t_span: shape.t_span() as f32,
        };
        let uniform = gpu.uniform_with("wireframe", &uniform);
        let group = |pipeline: &RenderPipeline, buffers: &[&Buffer]| {
            gpu.bind_group("wireframe", &pipeline.get_bind_group_layout(0), &entire(buffers))
        };
        let whole = group(&self.pass.whole, &[&uniform, &mapped.mapped, &mapped.whole_indices]);
        let [split, masked] = [&mapped.split_vertices, &mapped.masked_vertices]
            .map(|vertices| group(&self.pass.split, &[&uniform, vertices]));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("wireframe"),
            color_attachments: &[Some(color_attachment(self.color, clear))],
            depth_stencil_attachment: Some(depth_attachment(self.depth, clear.then_some(END_OF_LIGHT))),
            ..Default::default()
        });
        pass.set_pipeline(&self.pass.whole);
        pass.set_bind_group(0, &whole, &[]);
        // The arguments are those of an indexed draw: one vertex per index, and zeros after the instance count.
        pass.draw_indirect(&mapped.counts, 0);
        pass.set_pipeline(&self.pass.split);
        pass.set_bind_group(0, &split, &[]);
        pass.draw_indirect(&mapped.counts, offset_of!(BentCounts, split_vertex_count) as u64);
        // Alpha tests are ignored: a wireframe shows triangles.
        pass.set_bind_group(0, &masked, &[]);
        pass.draw_indirect(&mapped.counts, offset_of!(BentCounts, masked_vertex_count) as u64);
    }
}
