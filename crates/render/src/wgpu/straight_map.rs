//! Shadow maps of lights with straight rays, by ordinary rasterization.

use std::ops::Range;

use glam::{DVec3, Mat4};
use shadow::{Culling, MapSize, TriangleComponent, visible_runs};
use wgpu::{BindGroup, BindGroupLayout, Buffer, CommandEncoder, RenderPass, RenderPipeline, TextureView};

use super::pipeline::{
    DrawPipeline, INFINITELY_FAR, MapTarget, UNIFORM, cut_into_parts, depth_attachment, reversed_depth_test,
    vertex_buffers,
};
use super::scene::{GpuScene, part_count};
use super::{gpu_structs, shaders};
use crate::frame::casters::CasterSet;
use crate::frame::shared_scene::FrameScene;
use crate::wgpu::Wgpu;
use crate::{Gpu, RenderError};

/// Pipelines that draw shadow maps of straight lights. All scenes and lights share them.
#[derive(Debug)]
pub(crate) struct ShadowPass {
    /// Indexed by [`TriangleComponent`]: for closed components, only the side that faces the light is drawn.
    opaque: [RenderPipeline; 3],
    alpha_tested: RenderPipeline,
    layout: BindGroupLayout,
}

#[derive(Debug)]
pub(crate) struct ShadowMap {
    pub target: MapTarget,
    /// One entry per layer: its uniform, and the bind group with that uniform.
    views: Vec<(Buffer, wgpu::BindGroup)>,
}

/// Views of the faces of a map from its light.
pub(crate) struct ShadowViews<'a> {
    /// One entry per layer; `None` for a face without casters.
    pub clips_from_scene: &'a [Option<Mat4>],
    /// Point in scene space where light begins; `None` means outside the scene.
    pub source: Option<DVec3>,
    pub culling: Culling,
}

impl ShadowPass {
    pub fn new(gpu: &Gpu, material_layout: &BindGroupLayout) -> Self {
        let layout = gpu.bind_group_layout("shadow", &[UNIFORM]);
        let buffers = vertex_buffers();
        let pipeline = |wgsl, groups: &[&BindGroupLayout], vertex, fragment, vertex_buffers, cull_mode| {
            gpu.draw_pipeline(DrawPipeline {
                layout: Some(&gpu.pipeline_layout("shadow", groups)),
                vertex_buffers,
                cull_mode,
                depth_stencil: Some(reversed_depth_test()),
                ..DrawPipeline::new(vertex, &gpu.shader_module("shadow", wgsl), vertex, fragment)
            })
        };
        // Both sides of an open component cast: light hits a surface regardless of its modeled side.
        let opaque = [None, Some(wgpu::Face::Back), Some(wgpu::Face::Front)]
            .map(|culled| pipeline(shaders::SHADOW, &[&layout], "vs_opaque", None, &buffers[..1], culled));
        let alpha_tested = pipeline(
            shaders::SHADOW_MASKED,
            &[&layout, material_layout],
            "vs_masked",
            Some("fs_masked"),
            &buffers,
            None,
        );
        Self { opaque, alpha_tested, layout }
    }

    pub fn new_map(&self, gpu: &Gpu, size: MapSize) -> ShadowMap {
        let view = |_| {
            let uniform = gpu.uniform_buffer::<gpu_structs::ShadowView>("shadow view");
            let group = gpu.bind_group("shadow view", &self.layout, &[uniform.as_entire_binding()]);
            (uniform, group)
        };
        ShadowMap { target: gpu.map_target("shadow map", size), views: (0..size.layers).map(view).collect() }
    }

    /// Draws the casters into each layer by its view; layers without a view are cleared. Returns the number of
    /// processed opaque triangles. A scene with a great depth complexity is drawn in parts, with a yield after each.
    pub fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        into: &ShadowMap,
        ShadowViews { clips_from_scene, source, culling }: ShadowViews,
        scene: &FrameScene<Wgpu>,
        casting: &CasterSet<Wgpu>,
    ) -> Result<u64, RenderError> {
        let mut triangles = 0;
        let parts = part_count(gpu, scene, u64::from(into.target.size.side).pow(2));
        for ((layer, (uniform, group)), view) in into.target.layers.iter().zip(&into.views).zip(clips_from_scene) {
            let Some(clip_from_scene) = view else {
                drop(begin(encoder, layer, group, true));
                continue;
            };
            let view = gpu_structs::ShadowView { clip_from_scene: clip_from_scene.to_cols_array_2d() };
            gpu.queue.write_buffer(uniform, 0, bytemuck::bytes_of(&view));
            let seen = visible_runs(&casting.casters.clusters, clip_from_scene, source, culling);
            triangles += seen.iter().map(|(indices, _)| indices.len() as u64 / 3).sum::<u64>();
            let runs = self.runs(&scene.uploaded, casting, &seen);
            let mut pass = begin(encoder, layer, group, true);
            let mut bound: Option<&ShadowRun> = None;
            for (run, indices, ends_part) in cut_into_parts(runs.iter().map(|run| (run, run.indices.clone())), parts) {
                if bound.is_none_or(|bound| run.binds_other_than(bound)) {
                    run.bind(&mut pass);
                }
                bound = Some(run);
                pass.draw_indexed(indices, 0, 0..1);
                if ends_part {
                    drop(pass);
                    gpu.submit_and_wait(encoder)?;
                    gpu.host.yield_point()?;
                    pass = begin(encoder, layer, group, false);
                    bound = None;
                }
            }
        }
        Ok(triangles)
    }

    /// Lists the draws of the casters, in order.
    fn runs<'a>(
        &'a self,
        scene: &'a GpuScene,
        casting: &CasterSet<'a, Wgpu>,
        seen: &[(Range<u32>, TriangleComponent)],
    ) -> Vec<ShadowRun<'a>> {
        let CasterSet { casters, alpha_tested, .. } = *casting;
        let opaque = TriangleComponent::ALL.into_iter().flat_map(|component| {
            let of_component = seen.iter().filter(move |(_, own)| *own == component);
            of_component.map(move |(indices, _)| ShadowRun {
                pipeline: &self.opaque[component as usize],
                material: None,
                vertices: [Some(&casters.uploaded.positions), None],
                index_buffer: &casters.uploaded.indices,
                indices: indices.clone(),
            })
        });
        let alpha_tested = alpha_tested.iter().map(|draw| ShadowRun {
            pipeline: &self.alpha_tested,
            material: Some(&scene.draws[draw.draw].material),
            vertices: [Some(&scene.geometry.positions), Some(&scene.geometry.attributes)],
            index_buffer: &scene.geometry.indices,
            indices: draw.indices.clone(),
        });
        opaque.chain(alpha_tested).collect()
    }
}

/// Triangles with the same pipeline and buffers.
struct ShadowRun<'a> {
    pipeline: &'a RenderPipeline,
    /// Bind group of the material, for alpha-tested triangles.
    material: Option<&'a BindGroup>,
    vertices: [Option<&'a Buffer>; 2],
    index_buffer: &'a Buffer,
    indices: Range<u32>,
}

impl ShadowRun<'_> {
    fn binds_other_than(&self, other: &Self) -> bool {
        self.material.is_some() || !std::ptr::eq(self.pipeline, other.pipeline)
    }

    fn bind(&self, pass: &mut RenderPass) {
        pass.set_pipeline(self.pipeline);
        for (slot, buffer) in (0..).zip(self.vertices.iter().flatten()) {
            pass.set_vertex_buffer(slot, buffer.slice(..));
        }
        pass.set_index_buffer(self.index_buffer.slice(..), wgpu::IndexFormat::Uint32);
        if let Some(material) = self.material {
            pass.set_bind_group(1, material, &[]);
        }
    }
}

/// Begins a render pass on a layer, which is cleared if `clears`.
fn begin<'e>(encoder: &'e mut CommandEncoder, layer: &TextureView, group: &BindGroup, clears: bool) -> RenderPass<'e> {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("shadow"),
        depth_stencil_attachment: Some(depth_attachment(layer, clears.then_some(INFINITELY_FAR))),
        ..Default::default()
    });
    pass.set_bind_group(0, group, &[]);
    pass
}
