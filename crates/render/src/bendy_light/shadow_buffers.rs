//! What bent shadow maps are made in: buffers that start small and grow when a scene needs more.

use wgpu::{Buffer, BufferUsages};

use super::faces::MOST_FACES;
use super::gpu_structs::{BentCounts, BentMap, BentShadow, Patch, Slab};
use super::map_shape::MapShape;
use super::slab::SLABS_A_TURN;
use crate::memory::Evictable;
use crate::{Gpu, RenderError};

/// What the maps of one scene are made in, one after another.
#[derive(Debug)]
pub(crate) struct BentWork {
    pub room: Room,
    pub(super) buffers: Option<Evictable<Buffers>>,
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

/// The buffers of one map, kept for the next.
#[derive(Debug)]
pub(super) struct Buffers {
    /// For how many vertices, triangles, and what room.
    size: (u32, u32, Room),
    pub slabs: Buffer,
    pub uniform: Buffer,
    /// One a face of any map.
    pub faces: [Buffer; MOST_FACES],
    pub mapped: Buffer,
    pub vertex_slab: Buffer,
    pub whole_indices: Buffer,
    pub work: Buffer,
    pub patches: [Buffer; 2],
    pub split_vertices: Buffer,
    pub masked_vertices: Buffer,
    /// Where those lie in their triangles: `MaskedPlace` of `bent_map_split.wgsl`.
    pub masked_places: Buffer,
    pub counts: Buffer,
    pub workgroups: Buffer,
}

impl BentWork {
    pub fn new() -> Self {
        let room = Room { work: 1 << 16, patches: 1 << 16, split_vertices: 3 << 16, masked_vertices: 0 };
        Self { room, buffers: None }
    }
}

impl Room {
    /// Enough for what was counted, in powers of two; the same room where that fitted.
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

    /// Refuses what no buffer of this device can hold.
    pub(super) fn check(self, gpu: &Gpu) -> Result<(), RenderError> {
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
    pub fn new(gpu: &Gpu, map: &BentMap) -> Self {
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

    pub fn bytes(&self) -> u64 {
        let [even, odd] = &self.patches;
        let all = [&self.mapped, &self.vertex_slab, &self.whole_indices, &self.work, even, odd];
        let lists = [&self.split_vertices, &self.masked_vertices, &self.masked_places];
        all.into_iter().chain(lists).map(Buffer::size).sum()
    }

    /// Whether a map can be made in these: of the same scene, of which a light's links may leave a part.
    pub fn fits(&self, map: &BentMap) -> bool {
        let (vertices, triangles, room) = Self::size_for(map);
        (self.size.0, self.size.2) == (vertices, room) && triangles <= self.size.1
    }

    pub fn write(&self, gpu: &Gpu, slabs: &[Slab], map: &BentMap, shape: &MapShape) {
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
        for (face, buffer) in self.faces.iter().enumerate().take(shape.face_count()) {
            gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(&shape.shadow(face)));
        }
        gpu.queue.write_buffer(&self.counts, 0, bytemuck::bytes_of(&counts));
    }
}
