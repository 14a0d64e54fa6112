//! Drawing of bent shadow maps: maps casters into tube space, clips and splits them until their edges are straight
//! there, and rasterizes them.
//!
//! `docs/decisions/29-bent-shadow-maps.md` has the reasons. `bent_map.wgsl` and its passes do the same on a GPU. The
//! caller runs the stages one by one, so that each can be measured: [`BentMapBuilder::map_vertices`],
//! [`BentMapBuilder::map_triangles`], [`BentMapBuilder::split`], [`BentMapBuilder::draw`].

use glam::Vec3;
use light::{Lanes, Mask};
use rayon::prelude::*;

use super::casters::{BentCasters, BentMap};
use super::slab::{SlabLanes, TubePosition};
use super::split::{Patch, Split, SplitTriangles, ToClip};
use super::triangles::{SortTriangles, SortedTriangles, Vertex};
use crate::depth_map::DepthMap;
use crate::lanes::{LANES, U32s, Vec3s};
use crate::raster::{AlphaTestedTriangles, DepthRule, MapFace, RasterMemory, RasterTriangle, draw_face};
use crate::simd::{self, SimdTask};
use crate::{Cancelled, Workers};

/// Vertices of a block of casters.
const VERTICES_PER_BLOCK: usize = 64;
/// Leaves of casters that a worker sorts at once.
const LEAVES_PER_CHUNK: usize = 32;
/// Triangles that a worker clips and splits at once.
const SPLITS_PER_CHUNK: usize = 64;
/// Slab index of a vertex that is in no slab.
const NO_SLAB: u32 = u32::MAX;
/// Slab index of a vertex that is in several slabs of distant parts of the tube.
const SEVERAL_SLABS: u32 = u32::MAX - 1;

/// Work memory for drawing bent maps, reused from one map to the next.
#[derive(Debug, Default)]
pub struct BentMapBuilder {
    slabs: Vec<SlabLanes>,
    vertices: Vec<Vertex>,
    listed: Vec<SortedTriangles>,
    split: Vec<SplitTriangles>,
    scratch: RasterMemory,
}

impl BentMapBuilder {
    /// Computes the tube coordinates of each vertex near the light, once.
    pub fn map_vertices(&mut self, workers: &Workers, map: &BentMap, casters: &BentCasters) {
        let Self { slabs, vertices, .. } = self;
        slabs.clear();
        slabs.extend(map.slabs.iter().map(SlabLanes::new));
        let nowhere = TubePosition { v: 0.0, w: 0.0, r: 0.0, t: 0.0 };
        let unmapped = Vertex { q: Vec3::ZERO, slab: NO_SLAB, mapped: nowhere };
        vertices.resize(casters.positions.len(), unmapped);
        let mut is_near = vec![false; casters.positions.len().div_ceil(VERTICES_PER_BLOCK)];
        for &block in casters.blocks {
            is_near[block as usize] = true;
        }
        workers.run(|| {
            let blocks =
                vertices.par_chunks_mut(VERTICES_PER_BLOCK).zip(casters.positions.par_chunks(VERTICES_PER_BLOCK));
            blocks.zip(&is_near).filter(|(_, is_near)| **is_near).for_each(|((vertices, positions), _)| {
                simd::run(MapVertices { map, slabs, positions, vertices });
            });
        });
    }

    /// Sorts the triangles near the light: those to drop, those to draw without splitting, those to clip and those to
    /// split.
    pub fn map_triangles(&mut self, workers: &Workers, map: &BentMap, casters: &BentCasters) {
        let Self { slabs, vertices, listed, .. } = self;
        let chunks = casters.leaves.len().div_ceil(LEAVES_PER_CHUNK);
        listed.resize_with(chunks, SortedTriangles::default);
        workers.run(|| {
            listed.par_iter_mut().zip(casters.leaves.par_chunks(LEAVES_PER_CHUNK)).for_each(|(listed, leaves)| {
                simd::run(SortTriangles { map, slabs, casters, vertices, leaves, listed });
            });
        });
    }

    /// Clips triangles that are in several slabs, and splits triangles whose edges are not straight in the map. Returns
    /// the number of its inputs: pairs of a triangle and a slab, and patches.
    pub fn split(&mut self, workers: &Workers, map: &BentMap, casters: &BentCasters) -> Result<u64, Cancelled> {
        let mut to_clip: Vec<ToClip> = self.listed.iter().flat_map(|listed| &listed.to_clip).copied().collect();
        let mut patches: Vec<Patch> = self.listed.iter().flat_map(|listed| &listed.patches).copied().collect();
        // Sixteen points of one slab are mapped at once.
        to_clip.sort_unstable_by_key(|item| (item.slab, item.triangle));
        patches.sort_by_key(|patch| patch.slab);
        let count = to_clip.len() + patches.len();
        let Self { slabs, split: into, .. } = self;
        let clipped = to_clip.chunks(SPLITS_PER_CHUNK).map(|to_clip| (to_clip, &[][..]));
        let split_only = patches.chunks(SPLITS_PER_CHUNK).map(|patches| (&[][..], patches));
        let chunks: Vec<(&[ToClip], &[Patch])> = clipped.chain(split_only).collect();
        into.resize_with(chunks.len(), SplitTriangles::default);
        workers.each(into.iter_mut().zip(chunks), |(into, (to_clip, patches))| {
            into.opaque.clear();
            into.alpha_tested.clear();
            simd::run(Split { map, slabs, casters, to_clip, patches, into });
            true
        })?;
        Ok(count as u64)
    }

    /// Returns the sorted, clipped and split triangles, those with alpha tests last.
    pub(super) fn triangles(&self) -> impl Iterator<Item = &RasterTriangle> {
        let whole = self.listed.iter().flat_map(|listed| &listed.unsplit);
        let opaque = self.split.iter().flat_map(|split| &split.opaque);
        let alpha_tested = self.split.iter().flat_map(|split| &split.alpha_tested).map(|triangle| &triangle.corners);
        whole.chain(opaque).chain(alpha_tested)
    }

    /// Draws the sorted, clipped and split triangles onto each face, and returns their number.
    pub fn draw(
        &mut self,
        workers: &Workers,
        map: &BentMap,
        casters: &BentCasters,
        into: &mut DepthMap,
    ) -> Result<u64, Cancelled> {
        let Self { listed, split, scratch, .. } = self;
        let whole = listed.iter().map(|listed| listed.unsplit.as_slice());
        let whole: Vec<_> = whole.chain(split.iter().map(|drawn| drawn.opaque.as_slice())).collect();
        let alpha_tested: Vec<_> = split.iter().map(|drawn| drawn.alpha_tested.as_slice()).collect();
        let side = into.side();
        for (index, face) in map.faces.iter().enumerate() {
            let depths = DepthRule::Bent { row_divisor: face.row_divisor, depth_per_value: face.depth_per_t };
            let drawn = MapFace { clip_from_map: face.clip_from_mapped, depths };
            let (whole, chunks) = if face.has_casters { (&whole[..], &alpha_tested[..]) } else { (&[][..], &[][..]) };
            let alpha_tested = AlphaTestedTriangles { chunks, tests: casters.alpha_tests };
            draw_face(&drawn, whole, &alpha_tested, workers, scratch, into.face_mut(index), side)?;
        }
        let count = |drawn: &SplitTriangles| drawn.opaque.len() + drawn.alpha_tested.len();
        let split = split.iter().map(count).sum::<usize>();
        Ok((listed.iter().map(|listed| listed.unsplit.len()).sum::<usize>() + split) as u64)
    }
}

struct MapVertices<'a> {
    map: &'a BentMap<'a>,
    slabs: &'a [SlabLanes],
    positions: &'a [[f32; 3]],
    vertices: &'a mut [Vertex],
}

impl SimdTask for MapVertices<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { map, slabs, positions, vertices } = self;
        for (positions, vertices) in positions.chunks(LANES).zip(vertices.chunks_mut(LANES)) {
            let mut q = Vec3s::splat([0.0; 3]);
            for i in 0..LANES {
                let at = map.space.position(positions[i.min(positions.len() - 1)]);
                (q.x.0[i], q.y.0[i], q.z.0[i]) = (at.x, at.y, at.z);
            }
            let slab = slabs_of(map, slabs, q);
            for (i, vertex) in vertices.iter_mut().enumerate() {
                (vertex.q, vertex.slab) = (q.lane(i), slab.0[i]);
            }
            for (index, lanes) in slabs.iter().enumerate() {
                let here = slab.equals(U32s::splat(index as u32));
                if here.any() {
                    let mapped = lanes.to_tube_position(&map.space, q);
                    for (i, vertex) in vertices.iter_mut().enumerate() {
                        if here.lane(i) {
                            vertex.mapped = mapped.lane(i);
                        }
                    }
                }
            }
        }
    }
}

/// Returns the index of the first slab that holds each point.
#[inline(always)]
fn slabs_of(map: &BentMap, slabs: &[SlabLanes], q: Vec3s) -> U32s {
    let [low, high] = map.bounds.map(|corner| Vec3s::splat(corner.to_array()));
    let near = q.x.ge(low.x) & q.y.ge(low.y) & q.z.ge(low.z) & q.x.le(high.x) & q.y.le(high.y) & q.z.le(high.z);
    let none = U32s::splat(NO_SLAB);
    let mut found = none;
    if !near.any() {
        return found;
    }
    for (index, slab) in slabs.iter().enumerate() {
        let holds = near & slab.holds(q);
        if !holds.any() {
            continue;
        }
        let is_first = holds & found.equals(none);
        // The next slab shares a margin with this one. A later slab is another part of the tube.
        let is_next = found.equals(U32s::splat((index as u32).wrapping_sub(1))) | is_first;
        found = U32s::select(holds & !is_next, U32s::splat(SEVERAL_SLABS), found);
        found = U32s::select(is_first, U32s::splat(index as u32), found);
    }
    found
}
