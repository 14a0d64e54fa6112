//! Buffers of bent shadow maps. They start small and grow if a scene needs more.

use relight::BentFace;
use shadow::{CastersNearSlabs, MapShape, VERTICES_PER_BLOCK};
use wgpu::{
    BindingResource, Buffer, BufferBinding, BufferUsages, CommandEncoder, VertexAttribute, VertexBufferLayout,
    VertexStepMode,
};

use super::MAX_FACES;
use super::gpu_structs::{self, BentCounts, BentMap, BentShadow, Patch, Slab};
use super::slab::SLABS_PER_UNIFORM;
use crate::frame::casters::Casters;
use crate::frame::memory::Evictable;
use crate::frame::stages::{FrameStage, WorkCounters};
use crate::wgpu::Wgpu;
use crate::wgpu::readback;
use crate::{Gpu, RenderError};

/// Work buffers for drawing bent shadow maps in a scene. Maps are drawn one after another with the same buffers.
#[derive(Debug)]
pub(crate) struct BentMapBuffers {
    pub capacity: Capacity,
    pub(super) buffers: Option<Evictable<Buffers>>,
    /// Counts of batches that are not yet checked for whether they fitted. `None` if checks are not postponed.
    deferred: Option<Vec<MapCounts>>,
}

#[derive(Debug)]
pub(super) struct MapCounts {
    /// Copy of the [`BentCounts`] of a batch of slabs.
    pub counts: Buffer,
    /// Number of triangles that the batch processed.
    pub triangles: u32,
    /// Number of texels of the map if this is its first batch, else 0.
    pub texels: u64,
}

/// Number of items of each kind that fit into the work buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Capacity {
    /// Number of (triangle, slab) pairs to clip.
    pub work: u32,
    /// Number of patches that one level of splitting can read or write.
    pub patches: u32,
    /// Number of vertices of clipped and split triangles without an alpha test. The next field is the number of those
    /// with one.
    pub split_vertices: u32,
    pub masked_vertices: u32,
}

/// Numbers of casters and the capacity, which determine the sizes of the buffers.
#[derive(Clone, Copy, Debug)]
struct Size {
    vertices: u32,
    triangles: u32,
    leaves: u32,
    capacity: Capacity,
}

/// Buffers for drawing one map, which are reused for the next.
#[derive(Debug)]
pub(super) struct Buffers {
    size: Size,
    pub slabs: Buffer,
    pub uniform: Buffer,
    /// Uniforms of the faces, one for each face that a map may have.
    pub faces: [Buffer; MAX_FACES],
    pub mapped: Buffer,
    pub vertex_slab: Buffer,
    /// Blocks of vertices near the slabs. The next buffer has the leaves of triangles; see [`CastersNearSlabs`].
    pub blocks: Buffer,
    pub leaves: Buffer,
    pub whole_indices: Buffer,
    pub work: Buffer,
    pub patches: [Buffer; 2],
    pub split_vertices: Buffer,
    pub masked_vertices: Buffer,
    /// Positions of the vertices in `masked_vertices` within their triangles: `MaskedPlace` of `bent_map_split.wgsl`.
    pub masked_places: Buffer,
    pub counts: Buffer,
    pub workgroups: Buffer,
}

impl BentMapBuffers {
    pub fn new() -> Self {
        let capacity = Capacity { work: 1 << 16, patches: 1 << 16, split_vertices: 3 << 16, masked_vertices: 0 };
        Self { capacity, buffers: None, deferred: None }
    }

    /// Postpones fit checks until [`Self::check_deferred_fits`], so that the CPU does not wait for the GPU before the
    /// picture is submitted.
    pub fn defer_fit_checks(&mut self) {
        self.deferred = Some(Vec::new());
    }

    /// Returns true if all maps since [`Self::defer_fit_checks`] have fitted. If one has not, the capacity has grown.
    /// Waits for the GPU.
    pub fn check_deferred_fits(&mut self, gpu: &Gpu) -> Result<bool, RenderError> {
        let mut fitted = true;
        for made in self.deferred.take().into_iter().flatten() {
            fitted &= self.check_fit(gpu, made)?;
        }
        Ok(fitted)
    }

    /// Makes fit checks immediate again, for later maps.
    pub fn clear_deferred(&mut self) {
        self.deferred = None;
    }

    /// Yields in the middle of a map. Does nothing while fit checks are deferred, because nothing may wait for the GPU
    /// then.
    pub(super) fn yield_point(&self, gpu: &Gpu, encoder: &mut CommandEncoder) -> Result<(), RenderError> {
        if self.deferred.is_none() {
            gpu.submit_and_wait(encoder)?;
            gpu.host.yield_point()?;
        }
        Ok(())
    }

    /// Checks if a batch has fitted, or adds its counts to those to check later. Returns false if the batch is known
    /// not to have fitted; the capacity has then grown.
    pub(super) fn check_fit(&mut self, gpu: &Gpu, made: MapCounts) -> Result<bool, RenderError> {
        if let Some(put_off) = &mut self.deferred {
            put_off.push(made);
            return Ok(true);
        }
        let counts = readback::read_copy::<BentCounts>(gpu, &made.counts)?[0];
        gpu.host.stages.record_stage(FrameStage::Counts);
        gpu.host.stages.count(|counters| made.count(counters, &counts));
        let needed = self.capacity.grown_for(&counts);
        needed.check(gpu)?;
        let fitted = needed == self.capacity;
        self.capacity = needed;
        Ok(fitted)
    }
}

impl MapCounts {
    fn count(&self, counters: &mut WorkCounters, counts: &BentCounts) {
        let corners = [counts.whole_index_count, counts.split_vertex_count, counts.masked_vertex_count];
        counters.triangles_seen += u64::from(self.triangles);
        counters.triangles_split += u64::from(counts.items[0]);
        counters.triangles_drawn += corners.map(|corners| u64::from(corners / 3)).iter().sum::<u64>();
        counters.texels += self.texels;
    }
}

impl Capacity {
    /// Returns a capacity that holds the counted items, in powers of two. Returns the same capacity if they fitted.
    pub(super) fn grown_for(self, counts: &BentCounts) -> Self {
        let grow = |room: u32, count: u32| if count > room { count.next_power_of_two() } else { room };
        let patches = counts.items[1..].iter().copied().max().unwrap_or(0);
        Self {
            work: grow(self.work, counts.items[0]),
            patches: grow(self.patches, patches),
            split_vertices: grow(self.split_vertices, counts.split_vertex_count),
            masked_vertices: grow(self.masked_vertices, counts.masked_vertex_count),
        }
    }

    /// Returns an error if no buffer of this device can hold the items.
    pub(super) fn check(self, gpu: &Gpu) -> Result<(), RenderError> {
        let limit = gpu.device.limits().max_storage_buffer_binding_size;
        let largest = [
            u64::from(self.work) * WORK_BYTES,
            u64::from(self.patches) * PATCH_BYTES,
            u64::from(self.split_vertices) * VERTEX_BYTES,
            u64::from(self.masked_vertices) * VERTEX_BYTES,
        ];
        let size = largest.into_iter().max().unwrap_or(0);
        RenderError::check_size("the bent shadow's geometry in bytes", size, limit)
    }
}

/// Leaves that a uniform holds. `map_triangles` is dispatched once for each such window.
pub(super) const LEAVES_PER_WINDOW: usize = 8192;
const WINDOW_BYTES: u64 = 8 * LEAVES_PER_WINDOW as u64;
/// Bytes of a triangle in a slab: `ToClip` of `bent_map.wgsl`.
const WORK_BYTES: u64 = 12;
const PATCH_BYTES: u64 = size_of::<Patch>() as u64;
/// Bytes of a mapped vertex, and of its position in a triangle.
const VERTEX_BYTES: u64 = 16;

/// Returns the layout of a buffer of mapped vertices, or of their positions in triangles.
pub(super) fn mapped_vertices(attributes: &[VertexAttribute]) -> VertexBufferLayout<'_> {
    VertexBufferLayout { array_stride: VERTEX_BYTES, step_mode: VertexStepMode::Vertex, attributes }
}

impl Buffers {
    pub fn new(gpu: &Gpu, casters: &Casters<Wgpu>, room: Capacity) -> Self {
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
        let size = Self::size_for(casters, room);
        let [vertices, triangles, leaves] = [size.vertices, size.triangles, size.leaves].map(u64::from);
        let patches = || storage("patches", u64::from(room.patches) * PATCH_BYTES, none);
        let masked_bytes = u64::from(room.masked_vertices) * VERTEX_BYTES;
        let split_bytes = u64::from(room.split_vertices) * VERTEX_BYTES;
        Self {
            size,
            slabs: buffer("slabs", (size_of::<Slab>() * SLABS_PER_UNIFORM) as u64, uniform),
            uniform: buffer("bent map", size_of::<BentMap>() as u64, uniform),
            faces: std::array::from_fn(|_| buffer("bent shadow", size_of::<BentShadow>() as u64, uniform)),
            mapped: storage("mapped vertices", vertices * VERTEX_BYTES, BufferUsages::VERTEX),
            vertex_slab: storage("slab of each vertex", vertices * 4, none),
            blocks: storage(
                "blocks of vertices",
                vertices.div_ceil(VERTICES_PER_BLOCK as u64) * 4,
                BufferUsages::COPY_DST,
            ),
            leaves: buffer(
                "leaves of triangles",
                leaves.div_ceil(LEAVES_PER_WINDOW as u64).max(1) * WINDOW_BYTES,
                uniform,
            ),
            whole_indices: storage("whole triangles", triangles * 12, BufferUsages::INDEX),
            work: storage("triangles to clip", u64::from(room.work) * WORK_BYTES, none),
            patches: [patches(), patches()],
            split_vertices: storage("split triangles", split_bytes, BufferUsages::VERTEX),
            masked_vertices: storage("masked triangles", masked_bytes, BufferUsages::VERTEX),
            masked_places: storage("masked triangles' places", masked_bytes, BufferUsages::VERTEX),
            counts: storage("bent counts", size_of::<BentCounts>() as u64, counted),
            workgroups: storage("workgroups", 16, BufferUsages::INDIRECT),
        }
    }

    fn size_for(casters: &Casters<Wgpu>, room: Capacity) -> Size {
        let (vertices, triangles) = (casters.vertex_count, casters.triangle_count);
        Size { vertices, triangles, leaves: casters.clusters.leaves.len() as u32, capacity: room }
    }

    /// Returns the leaves of a window, as a uniform.
    pub fn leaves_from(&self, window: usize) -> BindingResource<'_> {
        BindingResource::Buffer(BufferBinding {
            buffer: &self.leaves,
            offset: window as u64 * WINDOW_BYTES,
            size: std::num::NonZeroU64::new(WINDOW_BYTES),
        })
    }

    pub fn bytes(&self) -> u64 {
        let [even, odd] = &self.patches;
        let all =
            [&self.mapped, &self.vertex_slab, &self.blocks, &self.leaves, &self.whole_indices, &self.work, even, odd];
        let lists = [&self.split_vertices, &self.masked_vertices, &self.masked_places];
        all.into_iter().chain(lists).map(Buffer::size).sum()
    }

    /// True if a map of these casters can be drawn with these buffers.
    pub fn fit(&self, casters: &Casters<Wgpu>, room: Capacity) -> bool {
        let (has, needs) = (self.size, Self::size_for(casters, room));
        let enough = has.vertices >= needs.vertices && has.triangles >= needs.triangles && has.leaves >= needs.leaves;
        enough && has.capacity == room
    }

    pub fn write(&self, gpu: &Gpu, slabs: &[Slab], map: &BentMap, near: &CastersNearSlabs, shape: &MapShape) {
        // Level -1: the first `next_level` makes it 0.
        let counts = BentCounts {
            whole_instance_count: 1,
            split_instance_count: 1,
            masked_instance_count: 1,
            level: u32::MAX,
            ..BentCounts::default()
        };
        gpu.queue.write_buffer(&self.slabs, 0, bytemuck::cast_slice(slabs));
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(map));
        gpu.queue.write_buffer(&self.blocks, 0, bytemuck::cast_slice(&near.blocks));
        gpu.queue.write_buffer(&self.leaves, 0, bytemuck::cast_slice(&near.leaves));
        for (face, buffer) in self.faces.iter().enumerate().take(shape.face_count()) {
            let BentFace { clip_from_mapped, row_divisor, depth_per_t, .. } = shape.face(face);
            let clip_from_mapped = gpu_structs::columns(&clip_from_mapped);
            let uniform = BentShadow { clip_from_mapped, row: row_divisor, depth_per_t, pad0: 0.0 };
            gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&uniform));
        }
        gpu.queue.write_buffer(&self.counts, 0, bytemuck::bytes_of(&counts));
    }
}
