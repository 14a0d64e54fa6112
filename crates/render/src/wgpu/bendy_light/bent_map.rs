//! Bent shadow maps. Compute passes map the casters into tube space, then a render pass draws them (see
//! `bent_map.wgsl`).
//!
//! Every triangle is processed once. Most lie in one slab and are straight in the map: these are drawn from vertices
//! that were mapped once. The others are clipped to slabs and split until their edges are straight. The buffers for
//! those start small and grow if a scene needs more. The counts are read back after each map, or together with the
//! picture, and a map that did not fit is drawn again.

use std::sync::OnceLock;

use glam::DVec3;
use light::{FrameMode, Tube};
use shadow::{BoxedSlab, CastersNearSlabs, Culling, MapShape, PlacedBent, slab_bounds, slabs_of_map, tube_from_scene};
use wgpu::{BindGroup, BindingResource, Buffer, CommandEncoder, ComputePipeline, RenderPipeline};

use super::alpha_tested_draw::AlphaTestedDraw;
use super::gpu_structs::{self, BentCounts, BentMap, LEVELS};
use super::shadow_buffers::{BentMapBuffers, Buffers, Capacity, LEAVES_PER_WINDOW, MapCounts, mapped_vertices};
use super::slab::{self, SLABS_PER_UNIFORM};
use super::wireframe::WireframeTarget;
use crate::frame::MapSource;
use crate::frame::casters::{CasterSet, Casters};
use crate::frame::memory::{Evictable, MemoryKind};
use crate::frame::shared_scene::FrameScene;
use crate::frame::stages::FrameStage;
use crate::wgpu::Wgpu;
use crate::wgpu::pipeline::{DrawPipeline, END_OF_LIGHT, MapTarget, depth_attachment, entire, least_depth_test};
use crate::wgpu::readback;
use crate::wgpu::shaders;
use crate::{Gpu, RenderError};

/// Most workgroups that a dispatch may have in one dimension on every device.
const MAX_GROUPS: u32 = 65_535;

/// Pipelines that map casters into a tube and draw them onto its shadow map. All scenes and lights share them.
#[derive(Debug)]
pub(crate) struct BentMapPass {
    vertices: ComputePipeline,
    triangles: ComputePipeline,
    clip: ComputePipeline,
    split: ComputePipeline,
    next: ComputePipeline,
    draw: RenderPipeline,
    /// Pipeline for alpha-tested triangles, compiled when a scene has some.
    alpha_tested: OnceLock<AlphaTestedDraw>,
}

/// A map to draw: casters, light and target.
pub(crate) struct MapRequest<'a> {
    pub source: &'a MapSource<'a, Wgpu>,
    pub placed: &'a PlacedBent,
    pub shape: &'a MapShape,
    pub onto: DrawTarget<'a>,
}

impl MapRequest<'_> {
    fn tube(&self) -> &Tube<f64> {
        &self.placed.part.tube
    }

    fn scene_origin(&self) -> DVec3 {
        self.source.scene.posed.origin_in_world
    }
}

pub(crate) enum DrawTarget<'a> {
    Map(&'a MapTarget),
    /// Picture that shows the map's triangles as a wireframe.
    Wireframe(WireframeTarget<'a>),
}

impl BentMapPass {
    pub fn new(gpu: &Gpu) -> Self {
        let compute = |wgsl, entry_point| gpu.compute_pipeline(entry_point, wgsl, entry_point);
        Self {
            vertices: compute(shaders::BENT_MAP_VERTICES, "map_vertices"),
            triangles: compute(shaders::BENT_MAP_TRIANGLES, "map_triangles"),
            clip: compute(shaders::BENT_MAP_CLIP, "clip_triangles"),
            split: compute(shaders::BENT_MAP_SPLIT, "split_patches"),
            next: compute(shaders::BENT_MAP_NEXT, "next_level"),
            draw: draw_pipeline(gpu),
            alpha_tested: OnceLock::new(),
        }
    }

    /// Draws a shadow map. Slabs are drawn in batches, each as large as a uniform holds. If a batch did not fit into
    /// the buffers, all batches are drawn again with larger ones.
    pub fn render(&self, gpu: &Gpu, work: &mut BentMapBuffers, request: &MapRequest) -> Result<(), RenderError> {
        let slabs = slabs_of_map(request.tube(), request.shape, request.source.shadows);
        // Without casters, one batch without slabs clears the map.
        let turns = || slabs.chunks(SLABS_PER_UNIFORM).chain(slabs.is_empty().then_some(&slabs[..]));
        // The result of a batch of slabs that did not fit is invalid, so all batches start again.
        'all: loop {
            for (index, turn) in turns().enumerate() {
                if !self.render_slabs(gpu, work, request, turn, index == 0)? {
                    continue 'all;
                }
            }
            return Ok(());
        }
    }

    /// Maps and draws the casters in a batch of slabs. If `first` is true, clears the map before. Returns false if the
    /// casters are known not to have fitted; the capacity has then grown.
    fn render_slabs(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        request: &MapRequest,
        slabs: &[BoxedSlab],
        first: bool,
    ) -> Result<bool, RenderError> {
        let MapSource { scene, casting, shadows, .. } = request.source;
        let (casters, shape) = (casting.casters, request.shape);
        // A wireframe also shows triangles that others hide.
        let culling = match request.onto {
            DrawTarget::Map(_) => shadows.culling,
            DrawTarget::Wireframe(_) => Culling { backs: false, ..shadows.culling },
        };
        let near =
            CastersNearSlabs::new(&casters.clusters, request.tube(), request.scene_origin(), shape, slabs, culling);
        let map = turn_uniforms(work.capacity, request, slabs, &near);
        let kept = work.buffers.take();
        let fitting = kept.as_ref().and_then(Evictable::take).filter(|buffers| buffers.fit(casters, work.capacity));
        let (kept, buffers) = match (kept, fitting) {
            (Some(kept), Some(buffers)) => (Some(kept), buffers),
            _ => (None, Buffers::new(gpu, casters, work.capacity)),
        };
        buffers.write(gpu, &slab::padded(slabs), &map, &near, shape);
        let mut encoder = gpu.encoder();
        if !slabs.is_empty() {
            self.map(gpu, &mut encoder, (casters, &near), &buffers)?;
            work.yield_point(gpu, &mut encoder)?;
        }
        match &request.onto {
            DrawTarget::Map(target) => {
                self.draw(gpu, &mut encoder, (scene, casting), &buffers, (target, shape), first);
            }
            DrawTarget::Wireframe(drawing) => drawing.draw(gpu, &mut encoder, &buffers, shape, first),
        }
        gpu.end_stage(&mut encoder, FrameStage::Draw)?;
        let counts = readback::copy_for_readback(gpu, &mut encoder, &buffers.counts);
        gpu.queue.submit([encoder.finish()]);
        let texels = shape.face_count() as u64 * u64::from(shape.side).pow(2);
        let made = MapCounts { counts, triangles: near.triangles, texels: if first { texels } else { 0 } };
        work.buffers = Some(if let Some(kept) = kept {
            kept.put(buffers);
            kept
        } else {
            gpu.host.memory.keep(MemoryKind::ShadowWork, buffers.bytes(), buffers)
        });
        work.check_fit(gpu, made)
    }

    /// Records the compute passes: vertices, triangles, clipping, and splitting level by level.
    fn map(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (casters, near): (&Casters<Wgpu>, &CastersNearSlabs),
        buffers: &Buffers,
    ) -> Result<(), RenderError> {
        let b = buffers;
        let common = entire(&[&b.uniform, &b.slabs]);
        let group = |pipeline: &ComputePipeline, rest: &[&Buffer]| bind(gpu, pipeline, &common, &entire(rest));
        let vertices = group(&self.vertices, &[&casters.uploaded.positions, &b.mapped, &b.vertex_slab, &b.blocks]);
        let mapped = [&casters.uploaded.positions, &b.mapped, &b.vertex_slab, &casters.uploaded.indices];
        let lists = [&b.whole_indices, &b.work, &b.counts, &b.patches[1]];
        let triangles = |window: &[[u32; 2]], number: usize| {
            let mut rest = entire(&[&mapped[..], &lists[..]].concat());
            rest.push(b.leaves_from(number));
            (bind(gpu, &self.triangles, &common, &rest), window.len())
        };
        let windows = near.leaves.chunks(LEAVES_PER_WINDOW).zip(0..).map(|(window, number)| triangles(window, number));
        let triangles: Vec<_> = windows.collect();
        let next = bind(gpu, &self.next, &common[..1], &entire(&[&b.counts, &b.workgroups]));
        let clip = [&casters.uploaded.positions, &casters.uploaded.indices, &b.work, &b.counts, &b.patches[1]];
        let clip = group(&self.clip, &clip);
        let [even, odd] = [(0, 1), (1, 0)].map(|(from, to)| {
            let lists = [&b.split_vertices, &b.masked_vertices, &b.masked_places];
            group(&self.split, &[&[&b.patches[from], &b.patches[to], &b.counts], &lists[..]].concat())
        });
        let step = |stage, pipeline, group, workgroups| ComputeStep { stage, pipeline, group, workgroups };
        let next = |stage| step(stage, &self.next, &next, Some(1));
        let mut steps = vec![step(FrameStage::Vertices, &self.vertices, &vertices, Some(near.blocks.len()))];
        steps.extend(
            triangles.iter().map(|(group, count)| step(FrameStage::Triangles, &self.triangles, group, Some(*count))),
        );
        steps.extend([next(FrameStage::Clip), step(FrameStage::Clip, &self.clip, &clip, None)]);
        for level in 1..LEVELS {
            let group = if level % 2 == 0 { &even } else { &odd };
            steps.extend([next(FrameStage::Split), step(FrameStage::Split, &self.split, group, None)]);
        }
        // One pass for all steps, unless stages are recorded.
        let apart = gpu.host.stages.is_recording();
        for steps in steps.chunk_by(|one, other| !apart || one.stage == other.stage) {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for step in steps {
                step.run(&mut pass, &b.workgroups);
            }
            drop(pass);
            gpu.end_stage(encoder, steps[0].stage)?;
        }
        Ok(())
    }

    /// Draws the mapped casters onto each face.
    fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        (scene, casting): (&FrameScene<Wgpu>, &CasterSet<Wgpu>),
        buffers: &Buffers,
        (target, map): (&MapTarget, &MapShape),
        clear: bool,
    ) {
        for (index, (layer, face)) in target.layers.iter().zip(&buffers.faces).enumerate() {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("bent shadow"),
                depth_stencil_attachment: Some(depth_attachment(layer, clear.then_some(END_OF_LIGHT))),
                ..Default::default()
            });
            if !map.has_casters(index) {
                continue;
            }
            let group = gpu.bind_group("bent shadow", &self.draw.get_bind_group_layout(0), &[face.as_entire_binding()]);
            pass.set_bind_group(0, &group, &[]);
            self.draw_casters(&mut pass, buffers);
            if let Some(tests) = casting.alpha_tests {
                let masked = self.alpha_tested.get_or_init(|| AlphaTestedDraw::new(gpu));
                masked.draw(gpu, &mut pass, (&scene.uploaded.geometry, tests), (buffers, face));
            }
        }
    }

    fn draw_casters(&self, pass: &mut wgpu::RenderPass, buffers: &Buffers) {
        pass.set_pipeline(&self.draw);
        pass.set_vertex_buffer(0, buffers.mapped.slice(..));
        pass.set_index_buffer(buffers.whole_indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed_indirect(&buffers.counts, 0);
        pass.set_vertex_buffer(0, buffers.split_vertices.slice(..));
        pass.draw_indirect(&buffers.counts, std::mem::offset_of!(BentCounts, split_vertex_count) as u64);
    }
}

struct ComputeStep<'a> {
    stage: FrameStage,
    pipeline: &'a ComputePipeline,
    group: &'a BindGroup,
    /// Number of workgroups. `None` if an earlier pass counts them on the GPU.
    workgroups: Option<usize>,
}

impl ComputeStep<'_> {
    fn run(&self, pass: &mut wgpu::ComputePass, counted_workgroups: &Buffer) {
        pass.set_pipeline(self.pipeline);
        pass.set_bind_group(0, self.group, &[]);
        match self.workgroups {
            Some(groups) => {
                let groups = groups as u32;
                let x = groups.clamp(1, MAX_GROUPS);
                pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
            }
            None => pass.dispatch_workgroups_indirect(counted_workgroups, 0),
        }
    }
}

fn turn_uniforms(room: Capacity, request: &MapRequest, slabs: &[BoxedSlab], near: &CastersNearSlabs) -> BentMap {
    let &MapRequest { source: MapSource { casting: CasterSet { casters, .. }, shadows, .. }, shape, .. } = request;
    BentMap {
        face_count: shape.face_count() as u32,
        texels_per_vw: shape.texels_per_vw() as f32,
        cube_slope: request.placed.map.slope.unwrap_or(0.0),
        faces: std::array::from_fn(|face| {
            if face < shape.face_count() { gpu_structs::columns(&shape.clip_from_mapped(face)) } else { [[0.0; 4]; 3] }
        }),
        vertex_count: casters.vertex_count,
        block_count: near.blocks.len() as u32,
        work_capacity: room.work,
        patch_capacity: room.patches,
        split_capacity: room.split_vertices,
        opaque_triangles: casters.clusters.opaque_triangles,
        masked_capacity: room.masked_vertices,
        tolerance_texels: shadows.split_above_texels(),
        ..bent_map_uniforms(request.tube(), request.scene_origin(), slabs)
    }
}

/// Makes the part of a batch's uniform that depends on the light and on its slabs.
pub(crate) fn bent_map_uniforms(tube: &Tube<f64>, scene_origin: DVec3, slabs: &[BoxedSlab]) -> BentMap {
    let [box_min, box_max] = slab_bounds(slabs).map(|corner| corner.to_array());
    BentMap {
        tube_from_scene: tube_from_scene(tube, scene_origin).to_cols_array_2d(),
        up: tube.up.as_vec3().to_array(),
        frame_up: u32::from(tube.frame == FrameMode::Up),
        box_min,
        slab_count: slabs.len() as u32,
        box_max,
        ..BentMap::default()
    }
}

/// Makes group 0 of a compute pass: resources that all passes use from binding 0 on, and those of this pass from
/// binding 2 on.
fn bind(gpu: &Gpu, pipeline: &ComputePipeline, common: &[BindingResource], rest: &[BindingResource]) -> BindGroup {
    let entries: Vec<_> = (0..)
        .zip(common)
        .chain((2..).zip(rest))
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("bent map"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

fn draw_pipeline(gpu: &Gpu) -> RenderPipeline {
    let module = gpu.shader_module("bent shadow", shaders::BENT_SHADOW);
    gpu.draw_pipeline(DrawPipeline {
        vertex_buffers: &[Some(mapped_vertices(&wgpu::vertex_attr_array![0 => Float32x4]))],
        // Both sides cast shadows: light hits a surface regardless of its modeled side.
        cull_mode: None,
        depth_stencil: Some(least_depth_test()),
        ..DrawPipeline::new("bent shadow", &module, "vs_bent_shadow", Some("fs_bent_shadow"))
    })
}
