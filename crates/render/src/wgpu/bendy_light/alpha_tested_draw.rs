//! Draws alpha-tested triangles into a bent shadow map (see `bent_masked.wgsl`).

use std::mem::offset_of;

use wgpu::{Buffer, BufferBinding, RenderPass, RenderPipeline};

use super::gpu_structs::BentCounts;
use super::shadow_buffers::{Buffers, mapped_vertices};
use crate::Gpu;
use crate::wgpu::alpha_test::GpuAlphaTests;
use crate::wgpu::gpu_structs::Mat4;
use crate::wgpu::pipeline::{DrawPipeline, least_depth_test};
use crate::wgpu::scene::Geometry;
use crate::wgpu::shaders;

#[cfg(test)]
mod tests;

/// Pipeline that draws mapped alpha-tested triangles onto a bent shadow map. All scenes and lights share it.
#[derive(Debug)]
pub(super) struct AlphaTestedDraw(RenderPipeline);

impl AlphaTestedDraw {
    pub fn new(gpu: &Gpu) -> Self {
        let module = gpu.shader_module("bent masked", shaders::BENT_MASKED);
        let mapped = wgpu::vertex_attr_array![0 => Float32x4];
        let in_triangle = wgpu::vertex_attr_array![1 => Float32x3, 2 => Uint32];
        Self(gpu.draw_pipeline(DrawPipeline {
            vertex_buffers: &[Some(mapped_vertices(&mapped)), Some(mapped_vertices(&in_triangle))],
            depth_stencil: Some(least_depth_test()),
            ..DrawPipeline::new("bent masked", &module, "vs_bent_masked", Some("fs_bent_masked"))
        }))
    }

    /// Draws the mapped alpha-tested triangles of `geometry` onto the face that a uniform names.
    pub fn draw(
        &self,
        gpu: &Gpu,
        pass: &mut RenderPass,
        (geometry, tests): (&Geometry, &GpuAlphaTests),
        (mapped, face): (&Buffers, &Buffer),
    ) {
        // The uniform begins with the matrix.
        let tube_from_scene = BufferBinding {
            buffer: &mapped.uniform,
            offset: 0,
            size: std::num::NonZeroU64::new(size_of::<Mat4>() as u64),
        };
        let triangles = [
            face.as_entire_binding(),
            wgpu::BindingResource::Buffer(tube_from_scene),
            geometry.positions.as_entire_binding(),
            geometry.attributes.as_entire_binding(),
            geometry.indices.as_entire_binding(),
        ];
        let tests = [tests.tests.as_entire_binding(), tests.texels.as_entire_binding()];
        let group =
            |index, bindings: &[_]| gpu.bind_group("bent masked", &self.0.get_bind_group_layout(index), bindings);
        pass.set_pipeline(&self.0);
        pass.set_bind_group(0, &group(0, &triangles), &[]);
        pass.set_bind_group(1, &group(1, &tests), &[]);
        pass.set_vertex_buffer(0, mapped.masked_vertices.slice(..));
        pass.set_vertex_buffer(1, mapped.masked_places.slice(..));
        pass.draw_indirect(&mapped.counts, offset_of!(BentCounts, masked_vertex_count) as u64);
    }
}
