//! Sorting of every triangle near a bent light, once. A triangle is dropped, drawn as it is, kept as a patch if it lies
//! in one slab and may be bent, or else listed with each slab that it may touch. Like `bent_map_triangles.wgsl`.

use glam::Vec3;
use light::{Lanes, Mask};

use super::casters::{BentCasters, BentMap};
use super::edges::{Edge, INSIDE_OUT, OPEN, faces_away, off_map};
use super::slab::{SlabLanes, TubePosition};
use super::split::{Patch, ToClip};
use crate::lanes::{F32s, LANES, Masks, U32s, Vec3s};
use crate::raster::RasterTriangle;
use crate::simd::SimdTask;

/// Vertex of a caster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// In tube space.
    pub q: Vec3,
    /// First slab that holds the vertex.
    pub slab: u32,
    /// Tube coordinates in that slab.
    pub mapped: TubePosition<f32>,
}

/// Triangles of a chunk of leaves, sorted by what has to be done before they can be drawn.
#[derive(Debug, Default)]
pub(super) struct SortedTriangles {
    /// Triangles that can be drawn without clipping or splitting.
    pub unsplit: Vec<RasterTriangle>,
    pub patches: Vec<Patch>,
    pub to_clip: Vec<ToClip>,
}

/// Task that sorts the triangles of `leaves` into the lists of `listed`, and discards their former contents.
pub(super) struct SortTriangles<'a> {
    pub map: &'a BentMap<'a>,
    pub slabs: &'a [SlabLanes],
    pub casters: &'a BentCasters<'a>,
    pub vertices: &'a [Vertex],
    pub leaves: &'a [[u32; 2]],
    pub listed: &'a mut SortedTriangles,
}

impl SimdTask for SortTriangles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.listed.unsplit.clear();
        self.listed.patches.clear();
        self.listed.to_clip.clear();
        for &[first, count_and_kind] in self.leaves {
            let (end, kind) = (first + (count_and_kind & 0xffff), count_and_kind >> 16);
            for first in (first..end).step_by(LANES) {
                let count = (end - first).min(LANES as u32) as usize;
                self.sort_sixteen(LeafTriangles { first, count, kind });
            }
        }
    }
}

/// At most sixteen triangles of a leaf.
#[derive(Clone, Copy)]
struct LeafTriangles {
    first: u32,
    count: usize,
    /// Kind of the leaf's surface.
    kind: u32,
}

/// Corners of sixteen triangles: positions in tube space, tube coordinates, and the slab that holds each corner.
struct Corners {
    q: [Vec3s; 3],
    mapped: [TubePosition<F32s>; 3],
    slab: [U32s; 3],
    /// Bounds for straight edges in the slab of the first corner.
    bounds: [F32s; 4],
}

impl SortTriangles<'_> {
    #[inline(always)]
    fn sort_sixteen(&mut self, triangles: LeafTriangles) {
        let corners = self.corners(triangles.first, triangles.count);
        let exist = below(LANE_INDICES, triangles.count);
        let [slab_a, slab_b, slab_c] = corners.slab;
        let in_one = exist & slab_a.equals(slab_b) & slab_a.equals(slab_c) & below(slab_a, self.slabs.len());
        if in_one.any() {
            self.sort_in_one_slab(&corners, in_one, triangles);
        }
        let across = exist & !in_one;
        if across.any() {
            self.sort_across_slabs(&corners, across, triangles);
        }
    }

    #[inline(always)]
    fn corners(&self, first: u32, count: usize) -> Corners {
        let (zero, none) = (F32s::splat(0.0), Vec3s::splat([0.0; 3]));
        let nowhere = TubePosition { v: zero, w: zero, r: zero, t: zero };
        let mut corners = Corners { q: [none; 3], mapped: [nowhere; 3], slab: [U32s::splat(0); 3], bounds: [zero; 4] };
        for i in 0..LANES {
            let index = 3 * (first as usize + i.min(count - 1));
            for k in 0..3 {
                let vertex = &self.vertices[self.casters.indices[index + k] as usize];
                let (q, mapped) = (&mut corners.q[k], &mut corners.mapped[k]);
                (q.x.0[i], q.y.0[i], q.z.0[i]) = (vertex.q.x, vertex.q.y, vertex.q.z);
                (mapped.v.0[i], mapped.w.0[i]) = (vertex.mapped.v, vertex.mapped.w);
                (mapped.r.0[i], mapped.t.0[i]) = (vertex.mapped.r, vertex.mapped.t);
                corners.slab[k].0[i] = vertex.slab;
            }
            if let Some(slab) = self.map.slabs.get(corners.slab[0].0[i] as usize) {
                for k in 0..4 {
                    corners.bounds[k].0[i] = slab.edge_bounds[k];
                }
            }
        }
        corners
    }

    /// Returns the index of a triangle among those with an alpha test, or the kind of its surface if it has none.
    #[inline(always)]
    fn caster_of(&self, triangle: u32, kind: u32) -> u32 {
        let opaque = self.casters.opaque_triangles;
        if triangle >= opaque { triangle - opaque } else { OPEN - kind }
    }

    #[inline(always)]
    fn sort_in_one_slab(&mut self, corners: &Corners, here: Masks, triangles: LeafTriangles) {
        let LeafTriangles { first, count, kind } = triangles;
        let [qa, qb, qc] = corners.q;
        let [a, b, c] = &corners.mapped;
        // Nearly all edges are safe. A closer look here would cost nine solves for every triangle.
        let bounds = corners.bounds;
        let safe = Edge { qa, a: *a, qb, b: *b }.is_safe(bounds)
            & Edge { qa: qb, a: *b, qb: qc, b: *c }.is_safe(bounds)
            & Edge { qa: qc, a: *c, qb: qa, b: *a }.is_safe(bounds);
        let mut dropped = off_map(self.map, [a, b, c], F32s::splat(0.0));
        if kind != 0 {
            let turned = if OPEN - kind == INSIDE_OUT { 1.0 } else { -1.0 };
            let opaque = below(U32s::splat(first) + LANE_INDICES, self.casters.opaque_triangles as usize);
            dropped = dropped | (opaque & faces_away(self.map, [a, b, c], F32s::splat(turned)));
        }
        let left = here & !(safe & dropped);
        for i in 0..count {
            if !left.lane(i) {
                continue;
            }
            let caster = self.caster_of(first + i as u32, kind);
            let mapped = [a.lane(i), b.lane(i), c.lane(i)];
            // Patches know their triangle, and so its alpha test.
            if safe.lane(i) && caster >= INSIDE_OUT {
                self.listed.unsplit.push([mapped[0].corner(), mapped[1].corner(), mapped[2].corner()]);
            } else {
                let q = [qa.lane(i), qb.lane(i), qc.lane(i)];
                self.listed.patches.push(Patch { q, mapped, slab: corners.slab[0].0[i], caster });
            }
        }
    }

    #[inline(always)]
    fn sort_across_slabs(&mut self, corners: &Corners, across: Masks, triangles: LeafTriangles) {
        let LeafTriangles { first, count, kind } = triangles;
        let near = across & near_all(self.map.bounds, &corners.q);
        if !near.any() {
            return;
        }
        for (index, slab) in self.slabs.iter().enumerate() {
            let touched = near & may_touch(slab, &corners.q);
            if !touched.any() {
                continue;
            }
            for i in 0..count {
                if touched.lane(i) {
                    let triangle = first + i as u32;
                    let caster = self.caster_of(triangle, kind);
                    self.listed.to_clip.push(ToClip { triangle, slab: index as u32, caster });
                }
            }
        }
    }
}

const LANE_INDICES: U32s = U32s([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]);

/// Returns the lanes whose number is less than a limit.
#[inline(always)]
fn below(numbers: U32s, limit: usize) -> Masks {
    let mut below = Masks::ZERO;
    for i in 0..LANES {
        below.0[i] = if (numbers.0[i] as usize) < limit { u32::MAX } else { 0 };
    }
    below
}

/// Returns the lanes whose triangles have bounding boxes that touch the given box.
#[inline(always)]
fn near_all([low, high]: [Vec3; 2], [a, b, c]: &[Vec3s; 3]) -> Masks {
    let x = axis_near([low.x, high.x], [a.x, b.x, c.x]);
    let y = axis_near([low.y, high.y], [a.y, b.y, c.y]);
    x & y & axis_near([low.z, high.z], [a.z, b.z, c.z])
}

#[inline(always)]
fn axis_near([low, high]: [f32; 2], [a, b, c]: [F32s; 3]) -> Masks {
    a.most(b).most(c).ge(F32s::splat(low)) & a.least(b).least(c).le(F32s::splat(high))
}

/// Returns the lanes whose triangles do not lie completely outside one of the slab's planes.
#[inline(always)]
fn may_touch(slab: &SlabLanes, [a, b, c]: &[Vec3s; 3]) -> Masks {
    let mut may = Masks::of(true);
    for plane in 0..6 {
        let farthest = slab.distance(plane, *a).most(slab.distance(plane, *b)).most(slab.distance(plane, *c));
        may = may & farthest.ge(F32s::splat(0.0));
        if !may.any() {
            break;
        }
    }
    may
}
