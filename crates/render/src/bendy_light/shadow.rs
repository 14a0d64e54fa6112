//! The bent shadow map: what casts shadows mapped into tube space by compute passes, then drawn (see
//! `bent_map.wgsl`).
//!
//! Every triangle is looked at once. Most lie in one slab and are straight in the map: they are drawn from
//! the vertices that were mapped once. The others are clipped to slabs and split until their edges are
//! straight. Buffers for those start small and grow when a scene needs more: the counts are read back after
//! each map, and a map that did not fit is made again.

use std::sync::OnceLock;

use glam::DVec3;
use light::{Frame, Tube};
use wgpu::{BindGroup, Buffer, BufferUsages, CommandEncoder, ComputePipeline, RenderPipeline};

use super::faces::MOST_FACES;
use super::layout::{BentCounts, BentMap, BentShadow, Patch, STAGES, Slab};
use super::map_shape::MapShape;
use super::masked::MaskedDraw;
use super::slab::{self, SLABS_A_TURN};
use super::tube_from_scene;
use super::wireframe::Drawing;
use crate::ledger::{Kept, MemoryKind};
use crate::pipeline::{DEPTH_FORMAT, MapTarget};
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowSettings, readback, shaders};

/// Threads of a workgroup, as in the shaders.
const WORKGROUP: u32 = 64;
/// Most workgroups in one dimension that every device can run.
const MAX_GROUPS: u32 = 65_535;

/// The pipelines, which outlive scenes and lights.
#[derive(Debug)]
pub(crate) struct BentShadowPass {
    vertices: ComputePipeline,
    triangles: ComputePipeline,
    clip: ComputePipeline,
    split: ComputePipeline,
    next: ComputePipeline,
    draw: RenderPipeline,
    /// Compiled when first wanted: by a scene with an alpha test.
    masked: OnceLock<MaskedDraw>,
}

/// What the maps of one scene are made in, one after another.
#[derive(Debug)]
pub(crate) struct BentWork {
    pub room: Room,
    buffers: Option<Kept<Buffers>>,
}

/// How many items fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Room {
    /// (triangle, slab) pairs.
    pub work: u32,
    /// Patches of one level.
    pub patches: u32,
    /// Vertices of what was clipped and split.
    pub split_vertices: u32,
    /// The same of triangles with an alpha test.
    pub masked_vertices: u32,
}

/// A map to be drawn: of what, and where.
pub(crate) struct MapRequest<'a> {
    pub scene: &'a StagedScene,
    pub tube: &'a Tube<f64>,
    pub map: &'a MapShape,
    pub onto: Onto<'a>,
    pub shadows: &'a ShadowSettings,
}

/// What it is drawn onto.
pub(crate) enum Onto<'a> {
    /// The map itself.
    Map(&'a MapTarget),
    /// A picture of its triangles.
    Wireframe(Drawing<'a>),
}

/// The buffers of one map, kept for the next.
#[derive(Debug)]
pub(super) struct Buffers {
    /// For how many vertices, triangles, and what room.
    size: (u32, u32, Room),
    slabs: Buffer,
    pub uniform: Buffer,
    /// One a face of any map.
    faces: [Buffer; MOST_FACES],
    pub mapped: Buffer,
    vertex_slab: Buffer,
    pub whole_indices: Buffer,
    work: Buffer,
    patches: [Buffer; 2],
    pub split_vertices: Buffer,
    pub masked_vertices: Buffer,
    /// Where those lie in their triangles: `MaskedPlace` of `bent_map_split.wgsl`.
    pub masked_places: Buffer,
    pub counts: Buffer,
    workgroups: Buffer,
}

impl BentShadowPass {
    pub fn new(gpu: &Gpu) -> Self {
        let compute = |wgsl: &str, entry_point| {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module: &gpu.module(entry_point, wgsl),
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        Self {
            vertices: compute(shaders::BENT_MAP_VERTICES, "map_vertices"),
            triangles: compute(shaders::BENT_MAP_TRIANGLES, "map_triangles"),
            clip: compute(shaders::BENT_MAP_CLIP, "clip_triangles"),
            split: compute(shaders::BENT_MAP_SPLIT, "split_patches"),
            next: compute(shaders::BENT_MAP_NEXT, "next_stage"),
            draw: draw_pipeline(gpu),
            masked: OnceLock::new(),
        }
    }

    /// Draws a map, in turns of as many slabs as a uniform holds.
    pub fn render(&self, gpu: &Gpu, work: &mut BentWork, request: &MapRequest) -> Result<(), RenderError> {
        let &MapRequest { tube, map, shadows, .. } = request;
        let split_above_texels = f64::from(shadows.split_above_texels());
        // The tube is 2 wide in v and w.
        let resolution = 2.0 * map.texels_per_vw();
        let slabs = |t_range| slab::slabs(tube, (map.t_base(), t_range), resolution, split_above_texels);
        let slabs = map.t_range().map_or_else(Vec::new, slabs);
        // Where nothing casts shadows, one turn of no slabs empties the map.
        let turns = || slabs.chunks(SLABS_A_TURN).chain(slabs.is_empty().then_some(&slabs[..]));
        // What a turn without room has drawn is not to be kept, so all turns start again.
        'all: loop {
            for (index, turn) in turns().enumerate() {
                if !self.render_turn(gpu, work, request, turn, index == 0)? {
                    continue 'all;
                }
            }
            return Ok(());
        }
    }

    /// Maps and draws what lies in some of the slabs, into an emptied map if it is the first. False where it
    /// did not fit; there is more room then.
    fn render_turn(
        &self,
        gpu: &Gpu,
        work: &mut BentWork,
        request: &MapRequest,
        slabs: &[(Slab, [DVec3; 8])],
        first: bool,
    ) -> Result<bool, RenderError> {
        let map = work.map(request, slabs);
        let kept = work.buffers.take();
        let fitting = kept.as_ref().and_then(Kept::take).filter(|buffers| buffers.fits(&map));
        let (kept, buffers) = match (kept, fitting) {
            (Some(kept), Some(buffers)) => (Some(kept), buffers),
            _ => (None, Buffers::new(gpu, &map)),
        };
        let mut table: Vec<Slab> = slabs.iter().map(|slab| slab.0).collect();
        table.resize(SLABS_A_TURN, Slab::default());
        buffers.write(gpu, &table, &map, request.map);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if !slabs.is_empty() {
            self.map(gpu, &mut encoder, request.scene, &buffers, &map);
        }
        match &request.onto {
            Onto::Map(target) => {
                self.draw(gpu, &mut encoder, request.scene, &buffers, (target, request.map), first);
            }
            Onto::Wireframe(drawing) => drawing.draw(gpu, &mut encoder, &buffers, request.map, first),
        }
        gpu.queue.submit([encoder.finish()]);
        let counts = readback::buffer::<BentCounts>(gpu, &buffers.counts)?[0];
        work.buffers = Some(if let Some(kept) = kept {
            kept.put(buffers);
            kept
        } else {
            gpu.ledger.keep(MemoryKind::ShadowWork, buffers.bytes(), buffers)
        });
        let needed = work.room.grown_for(&counts);
        needed.check(gpu)?;
        let fitted = needed == work.room;
        work.room = needed;
        Ok(fitted)
    }

    /// The compute passes: vertices, triangles, clipping, and splitting level by level.
    fn map(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        scene: &StagedScene,
        buffers: &Buffers,
        map: &BentMap,
    ) {
        let b = buffers;
        let casters = &scene.casters;
        let group =
            |pipeline: &ComputePipeline, rest: &[&Buffer]| bind(gpu, pipeline, &[&b.uniform, &b.slabs], rest);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let mut run = |pipeline: &ComputePipeline, group: &BindGroup, threads: Option<u32>| {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            match threads {
                Some(threads) => {
                    let groups = threads.div_ceil(WORKGROUP);
                    let x = groups.clamp(1, MAX_GROUPS);
                    pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
                }
                None => pass.dispatch_workgroups_indirect(&b.workgroups, 0),
            }
        };
        let vertices = group(&self.vertices, &[&casters.positions, &b.mapped, &b.vertex_slab]);
        run(&self.vertices, &vertices, Some(map.vertex_count));
        let mapped = [&casters.positions, &b.mapped, &b.vertex_slab, &casters.indices];
        let triangles = group(
            &self.triangles,
            &[&mapped[..], &[&b.whole_indices, &b.work, &b.counts, &b.patches[1]]].concat(),
        );
        run(&self.triangles, &triangles, Some(map.triangle_count));

        let next = bind(gpu, &self.next, &[&b.uniform], &[&b.counts, &b.workgroups]);
        run(&self.next, &next, Some(1));
        let clip = [&casters.positions, &casters.indices, &b.work, &b.counts, &b.patches[1]];
        run(&self.clip, &group(&self.clip, &clip), None);
        let [even, odd] = [(0, 1), (1, 0)].map(|(from, to)| {
            let lists = [&b.split_vertices, &b.masked_vertices, &b.masked_places];
            group(&self.split, &[&[&b.patches[from], &b.patches[to], &b.counts], &lists[..]].concat())
        });
        for stage in 1..STAGES {
            run(&self.next, &next, Some(1));
            run(&self.split, if stage % 2 == 0 { &even } else { &odd }, None);
        }
    }

    /// Draws what was mapped onto each face.
    fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        scene: &StagedScene,
        buffers: &Buffers,
        (target, map): (&MapTarget, &MapShape),
        clear: bool,
    ) {
        let load = if clear { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
        for (index, (layer, face)) in target.layers.iter().zip(&buffers.faces).enumerate() {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("bent shadow"),
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: layer,
                    depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            if !map.casts(index) {
                continue;
            }
            let group =
                gpu.group("bent shadow", &self.draw.get_bind_group_layout(0), &[face.as_entire_binding()]);
            pass.set_bind_group(0, &group, &[]);
            self.draw_casters(&mut pass, buffers);
            if let Some(tests) = &scene.alpha_tests {
                let masked = self.masked.get_or_init(|| MaskedDraw::new(gpu));
                masked.draw(gpu, &mut pass, (&scene.geometry, tests), (buffers, face));
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

impl BentWork {
    pub fn new() -> Self {
        let room = Room { work: 1 << 16, patches: 1 << 16, split_vertices: 3 << 16, masked_vertices: 0 };
        Self { room, buffers: None }
    }

    /// The uniform of a turn.
    fn map(&self, request: &MapRequest, slabs: &[(Slab, [DVec3; 8])]) -> BentMap {
        let &MapRequest { scene, tube, map, shadows, .. } = request;
        BentMap {
            face_count: map.face_count() as u32,
            texels_per_vw: map.texels_per_vw() as f32,
            cube_slope: if map.is_cube() { map.slope() as f32 } else { 0.0 },
            faces: map.clips_from_mapped(),
            vertex_count: scene.casters.vertex_count,
            triangle_count: scene.casters.triangle_count,
            work_capacity: self.room.work,
            patch_capacity: self.room.patches,
            split_capacity: self.room.split_vertices,
            opaque_triangles: scene.casters.opaque_indices / 3,
            masked_capacity: self.room.masked_vertices,
            tolerance_texels: shadows.split_above_texels(),
            ..bent_map(tube, scene.origin, slabs)
        }
    }
}

/// What a turn's uniform says of the light.
pub(super) fn bent_map(tube: &Tube<f64>, scene_origin: DVec3, slabs: &[(Slab, [DVec3; 8])]) -> BentMap {
    let corners = || slabs.iter().flat_map(|slab| slab.1);
    BentMap {
        tube_from_scene: tube_from_scene(tube, scene_origin),
        up: tube.up.as_vec3().to_array(),
        frame_up: u32::from(tube.frame == Frame::Up),
        box_min: corners().fold(DVec3::INFINITY, DVec3::min).as_vec3().to_array(),
        slab_count: slabs.len() as u32,
        box_max: corners().fold(DVec3::NEG_INFINITY, DVec3::max).as_vec3().to_array(),
        ..BentMap::default()
    }
}

impl Room {
    /// Enough for what was counted, in powers of two; the same room where that fitted.
    fn grown_for(self, counts: &BentCounts) -> Self {
        let grow = |room: u32, count: u32| if count > room { count.next_power_of_two() } else { room };
        let patches = counts.items[1..].iter().copied().max().unwrap_or(0);
        Self {
            work: grow(self.work, counts.items[0]),
            patches: grow(self.patches, patches),
            split_vertices: grow(self.split_vertices, counts.split_vertex_count),
            masked_vertices: grow(self.masked_vertices, counts.masked_vertex_count),
        }
    }

    /// Refuses what no buffer of this device can hold.
    fn check(self, gpu: &Gpu) -> Result<(), RenderError> {
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        let largest = [
            u64::from(self.work) * WORK_BYTES,
            u64::from(self.patches) * PATCH_BYTES,
            u64::from(self.split_vertices) * VERTEX_BYTES,
            u64::from(self.masked_vertices) * VERTEX_BYTES,
        ];
        let size = largest.into_iter().max().unwrap_or(0);
        if size > limit {
            let what = "the bent shadow's geometry in bytes";
            return Err(RenderError::TooLarge { what, size: size as f64, limit: limit as f64 });
        }
        Ok(())
    }
}

/// Bytes of a (triangle, slab) pair.
const WORK_BYTES: u64 = 8;
/// Bytes of a patch.
const PATCH_BYTES: u64 = size_of::<Patch>() as u64;
/// Bytes of a mapped vertex, and of its place in a triangle.
pub(super) const VERTEX_BYTES: u64 = 16;

impl Buffers {
    fn new(gpu: &Gpu, map: &BentMap) -> Self {
        let buffer = |label, size: u64, usage| {
            let size = size.max(16);
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let storage = |label, size, usage| buffer(label, size, BufferUsages::STORAGE | usage);
        let none = BufferUsages::empty();
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let counted = BufferUsages::INDIRECT | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let (vertices, triangles) = (u64::from(map.vertex_count), u64::from(map.triangle_count));
        let patches = || storage("patches", u64::from(map.patch_capacity) * PATCH_BYTES, none);
        let masked_bytes = u64::from(map.masked_capacity) * VERTEX_BYTES;
        let split_bytes = u64::from(map.split_capacity) * VERTEX_BYTES;
        Self {
            size: Self::size_for(map),
            slabs: buffer("slabs", (size_of::<Slab>() * SLABS_A_TURN) as u64, uniform),
            uniform: buffer("bent map", size_of::<BentMap>() as u64, uniform),
            faces: std::array::from_fn(|_| buffer("bent shadow", size_of::<BentShadow>() as u64, uniform)),
            mapped: storage("mapped vertices", vertices * VERTEX_BYTES, BufferUsages::VERTEX),
            vertex_slab: storage("slab of each vertex", vertices * 4, none),
            whole_indices: storage("whole triangles", triangles * 12, BufferUsages::INDEX),
            work: storage("triangles to clip", u64::from(map.work_capacity) * WORK_BYTES, none),
            patches: [patches(), patches()],
            split_vertices: storage("split triangles", split_bytes, BufferUsages::VERTEX),
            masked_vertices: storage("masked triangles", masked_bytes, BufferUsages::VERTEX),
            masked_places: storage("masked triangles' places", masked_bytes, BufferUsages::VERTEX),
            counts: storage("bent counts", size_of::<BentCounts>() as u64, counted),
            workgroups: storage("workgroups", 16, BufferUsages::INDIRECT),
        }
    }

    fn size_for(map: &BentMap) -> (u32, u32, Room) {
        let room = Room {
            work: map.work_capacity,
            patches: map.patch_capacity,
            split_vertices: map.split_capacity,
            masked_vertices: map.masked_capacity,
        };
        (map.vertex_count, map.triangle_count, room)
    }

    fn bytes(&self) -> u64 {
        let [even, odd] = &self.patches;
        let all = [&self.mapped, &self.vertex_slab, &self.whole_indices, &self.work, even, odd];
        let lists = [&self.split_vertices, &self.masked_vertices, &self.masked_places];
        all.into_iter().chain(lists).map(Buffer::size).sum()
    }

    fn fits(&self, map: &BentMap) -> bool {
        self.size == Self::size_for(map)
    }

    fn write(&self, gpu: &Gpu, slabs: &[Slab], map: &BentMap, shape: &MapShape) {
        // Stage -1: the first `next_stage` makes it 0.
        let counts = BentCounts {
            whole_instance_count: 1,
            split_instance_count: 1,
            masked_instance_count: 1,
            stage: u32::MAX,
            ..BentCounts::default()
        };
        gpu.queue.write_buffer(&self.slabs, 0, bytemuck::cast_slice(slabs));
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(map));
        for (face, buffer) in self.faces.iter().enumerate().take(shape.face_count()) {
            gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&shape.shadow(face)));
        }
        gpu.queue.write_buffer(&self.counts, 0, bytemuck::bytes_of(&counts));
    }
}

/// Group 0 of a compute pass: what all share from binding 0, what it works on from binding 2.
fn bind(gpu: &Gpu, pipeline: &ComputePipeline, common: &[&Buffer], rest: &[&Buffer]) -> BindGroup {
    let entries: Vec<_> = (0..)
        .zip(common)
        .chain((2..).zip(rest))
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("bent map"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    })
}

/// Depth grows along the light.
pub(super) fn nearer_wins() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Less),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

fn draw_pipeline(gpu: &Gpu) -> RenderPipeline {
    let module = gpu.module("bent shadow", shaders::BENT_SHADOW);
    let mapped = wgpu::VertexBufferLayout {
        array_stride: VERTEX_BYTES,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x4],
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("bent shadow"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vs_bent_shadow"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(mapped)],
        },
        // Both sides cast: what light meets does not depend on which side was modelled.
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(nearer_wins()),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fs_bent_shadow"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}
