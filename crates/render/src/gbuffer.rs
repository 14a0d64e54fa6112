//! What each pixel sees: the one pass over the scene's triangles that a picture needs.

use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPipeline, TextureFormat, TextureView,
    TextureViewDescriptor,
};

use crate::gpu_scene::GpuScene;
use crate::pipeline::{
    DEPTH_FORMAT, RAW_TEXTURE, UINT_TEXTURE, cleared_depth, color_attachment, nearer_wins, vertex_buffers,
};
use crate::tile::Tile;
use crate::{Gpu, shaders};

const FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
const OFFSET_FORMAT: TextureFormat = TextureFormat::R32Float;

/// The pipelines, which outlive scenes and pictures.
#[derive(Debug)]
pub(crate) struct GbufferPass {
    one_sided: RenderPipeline,
    double_sided: RenderPipeline,
    /// Group 1 of the lighting passes; see `surface.wgsl`.
    pub surface_layout: BindGroupLayout,
}

/// The textures of one picture size.
#[derive(Debug)]
pub(crate) struct Gbuffer {
    packed: TextureView,
    /// How far in front of each surface its shadow is looked for.
    offset: TextureView,
    depth: TextureView,
    /// Group 1 of the lighting passes.
    pub surface: BindGroup,
}

impl GbufferPass {
    pub fn new(gpu: &Gpu, view_layout: &BindGroupLayout, material_layout: &BindGroupLayout) -> Self {
        let layout = gpu.pipeline_layout("gbuffer", &[view_layout, material_layout]);
        let module = gpu.module("gbuffer", shaders::GBUFFER);
        let pipeline = |cull_mode| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("gbuffer"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vs_gbuffer"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &vertex_buffers(),
                },
                primitive: wgpu::PrimitiveState { cull_mode, ..Default::default() },
                depth_stencil: Some(nearer_wins()),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fs_gbuffer"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(FORMAT.into()), Some(OFFSET_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            one_sided: pipeline(Some(wgpu::Face::Back)),
            double_sided: pipeline(None),
            surface_layout: gpu.layout("surface", &[UINT_TEXTURE, RAW_TEXTURE, RAW_TEXTURE]),
        }
    }

    pub fn targets(&self, gpu: &Gpu, width: u32, height: u32) -> Gbuffer {
        let view = |format| {
            gpu.target("gbuffer", width, height, format).create_view(&TextureViewDescriptor::default())
        };
        let (packed, offset, depth) = (view(FORMAT), view(OFFSET_FORMAT), view(DEPTH_FORMAT));
        let resources = [&packed, &depth, &offset].map(BindingResource::TextureView);
        let surface = gpu.group("surface", &self.surface_layout, &resources);
        Gbuffer { packed, offset, depth, surface }
    }

    /// Draws what the pixels of `tile` see of a picture of `size`. All of the picture is mapped as it would be
    /// without tiles, and what lies outside of this one is cut off: so tiles hold the same.
    pub fn draw(
        &self,
        encoder: &mut CommandEncoder,
        into: &Gbuffer,
        (size, tile): ([u32; 2], Tile),
        scene: &GpuScene,
    ) {
        let GpuScene { view, geometry, draws, .. } = scene;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("gbuffer"),
            color_attachments: &[&into.packed, &into.offset]
                .map(|target| Some(color_attachment(target, true))),
            depth_stencil_attachment: Some(cleared_depth(&into.depth)),
            ..Default::default()
        });
        let [left, top, width, height] =
            [-f64::from(tile.x), -f64::from(tile.y), size[0].into(), size[1].into()].map(|x| x as f32);
        pass.set_viewport(left, top, width, height, 0.0, 1.0);
        pass.set_bind_group(0, view, &[]);
        pass.set_vertex_buffer(0, geometry.positions.slice(..));
        pass.set_vertex_buffer(1, geometry.attributes.slice(..));
        pass.set_index_buffer(geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
        for draw in draws {
            pass.set_pipeline(if draw.double_sided { &self.double_sided } else { &self.one_sided });
            pass.set_bind_group(1, &draw.material, &[]);
            pass.draw_indexed(draw.indices.clone(), 0, 0..1);
        }
    }
}
