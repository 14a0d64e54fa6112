//! Shadow maps by ordinary rasterisation, for lights whose rays are straight.

use std::ops::Range;

use glam::DVec3;
use wgpu::{BindGroupLayout, Buffer, CommandEncoder, RenderPipeline};

use crate::casters::Casting;
use crate::geometry::Geometry;
use crate::in_view::in_view;
use crate::pipeline::{MapTarget, UNIFORM, cleared_depth, nearer_wins, vertex_buffers};
use crate::shadow_settings::{Culling, MapSize};
use crate::shells::Shell;
use crate::{Gpu, gpu_structs, shaders};

/// The pipelines, which outlive scenes and lights.
#[derive(Debug)]
pub(crate) struct ShadowPass {
    /// By what surfaces are, as [`Shell`] numbers them: of closed ones only the side that faces the light is drawn.
    opaque: [RenderPipeline; 3],
    masked: RenderPipeline,
    layout: BindGroupLayout,
}

/// A light's own map.
#[derive(Debug)]
pub(crate) struct ShadowMap {
    pub target: MapTarget,
    /// One a layer: its view, and the group that binds it.
    views: Vec<(Buffer, wgpu::BindGroup)>,
}

impl ShadowPass {
    pub fn new(gpu: &Gpu, material_layout: &BindGroupLayout) -> Self {
        let layout = gpu.layout("shadow", &[UNIFORM]);
        let buffers = vertex_buffers();
        let pipeline = |wgsl, groups: &[&BindGroupLayout], vertex, fragment, buffers, cull_mode| {
            let module = gpu.module("shadow", wgsl);
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(vertex),
                layout: Some(&gpu.pipeline_layout("shadow", groups)),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers,
                },
                primitive: wgpu::PrimitiveState { cull_mode, ..Default::default() },
                depth_stencil: Some(nearer_wins()),
                multisample: wgpu::MultisampleState::default(),
                fragment: Option::map(fragment, |entry_point| wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        // Both sides of an open surface cast: what light meets does not depend on which side was modelled.
        let opaque = [None, Some(wgpu::Face::Back), Some(wgpu::Face::Front)]
            .map(|culled| pipeline(shaders::SHADOW, &[&layout], "vs_opaque", None, &buffers[..1], culled));
        let masked = pipeline(
            shaders::SHADOW_MASKED,
            &[&layout, material_layout],
            "vs_masked",
            Some("fs_masked"),
            &buffers,
            None,
        );
        Self { opaque, masked, layout }
    }

    pub fn map(&self, gpu: &Gpu, size: MapSize) -> ShadowMap {
        let view = |_| {
            let uniform = gpu.uniform_buffer::<gpu_structs::ShadowView>("shadow view");
            let group = gpu.group("shadow view", &self.layout, &[uniform.as_entire_binding()]);
            (uniform, group)
        };
        ShadowMap { target: gpu.map_target("shadow map", size), views: (0..size.layers).map(view).collect() }
    }

    /// Draws what casts of a scene's geometry into each layer by its view; those without one are empty. Returns how many
    /// opaque triangles were looked at.
    ///
    /// Light begins at `source`, in scene space, or outside of the scene.
    pub fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        into: &ShadowMap,
        (views, source, culling): (&[Option<gpu_structs::ShadowView>], Option<DVec3>, Culling),
        scene: (&Geometry, &Casting),
    ) -> u64 {
        let mut triangles = 0;
        for ((layer, (uniform, group)), view) in into.target.layers.iter().zip(&into.views).zip(views) {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow"),
                depth_stencil_attachment: Some(cleared_depth(layer)),
                ..Default::default()
            });
            if let Some(view) = view {
                gpu.queue.write_buffer(uniform, 0, bytemuck::bytes_of(view));
                pass.set_bind_group(0, group, &[]);
                let seen = in_view(scene.1.casters, &view.clip_from_scene, source, culling);
                triangles += seen.iter().map(|(indices, _)| indices.len() as u64 / 3).sum::<u64>();
                self.draw_casters(&mut pass, scene, &seen);
            }
        }
        triangles
    }

    fn draw_casters(
        &self,
        pass: &mut wgpu::RenderPass,
        (geometry, casting): (&Geometry, &Casting),
        seen: &[(Range<u32>, Shell)],
    ) {
        let Casting { casters, masked, .. } = casting;
        if !seen.is_empty() {
            pass.set_vertex_buffer(0, casters.positions.slice(..));
            pass.set_index_buffer(casters.indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        for shell in Shell::ALL {
            pass.set_pipeline(&self.opaque[shell as usize]);
            for (indices, _) in seen.iter().filter(|(_, own)| *own == shell) {
                pass.draw_indexed(indices.clone(), 0, 0..1);
            }
        }
        if !masked.is_empty() {
            pass.set_pipeline(&self.masked);
            pass.set_vertex_buffer(0, geometry.positions.slice(..));
            pass.set_vertex_buffer(1, geometry.attributes.slice(..));
            pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        for draw in *masked {
            pass.set_bind_group(1, &draw.material, &[]);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
        }
    }
}
