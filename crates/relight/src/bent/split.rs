//! Clipping of triangles to slabs, and splitting until their edges are nearly straight in the map, like
//! `bent_map_clip.wgsl` and `bent_map_split.wgsl`. The decision to split an edge depends on that edge alone, so
//! adjacent triangles split it alike and no cracks appear.

use super::casters::{BentCasters, BentMap};
use super::edges::{Edge, INSIDE_OUT, OPEN, edge_error, exceeds_tolerance, faces_away, off_map};
use super::slab::{MapSlab, SlabLanes, TubePosition, lanes_from_points};
use crate::lanes::LANES;
use crate::raster::{AlphaTestedTriangle, RasterTriangle};
use crate::scene::weights_at;
use crate::simd::SimdTask;
use glam::Vec3;

/// Most levels of splitting. Patches of the last level are drawn as they are.
const MAX_LEVELS: usize = 10;
/// Most corners of a clipped triangle: three, and one more for each of the slab's six planes.
const MAX_CORNERS: usize = 9;

/// Triangles that result from clipping and splitting.
#[derive(Debug, Default)]
pub(super) struct SplitTriangles {
    pub opaque: Vec<RasterTriangle>,
    pub alpha_tested: Vec<AlphaTestedTriangle>,
}

/// Triangle, and a slab that it may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct ToClip {
    pub triangle: u32,
    pub slab: u32,
    /// Same as `Patch::caster`.
    pub caster: u32,
}

/// Triangle, or part of one, that lies in one slab of the tube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Corners in tube space.
    pub q: [Vec3; 3],
    /// Tube coordinates of the corners.
    pub mapped: [TubePosition<f32>; 3],
    pub slab: u32,
    /// Index of the triangle among those with an alpha test, or kind of the surface.
    pub caster: u32,
}

/// Middle of a patch's edge, with the decision whether the edge is split there.
#[derive(Clone, Copy, Debug)]
struct Middle {
    needs_split: bool,
    /// Deviation of (V, W, R) from the straight edge, as a length in tube space; 0 if too small to see.
    edge_error: f32,
    q: Vec3,
    mapped: TubePosition<f32>,
}

/// Memory for measuring the edges of one slab's patches, reused for the next slab.
#[derive(Default)]
struct SplitMemory {
    points: Vec<Vec3>,
    mapped: Vec<TubePosition<f32>>,
    /// Index in `points` of the first point of each patch's edges. `None` for an edge that is certainly straight and
    /// needs no points.
    edges: Vec<[Option<usize>; 3]>,
}

/// Task that clips the triangles `to_clip`, and splits the results and `patches`. Both lists are sorted by slab. It
/// adds the resulting triangles to `into`.
pub(super) struct Split<'a> {
    pub map: &'a BentMap<'a>,
    pub slabs: &'a [SlabLanes],
    pub casters: &'a BentCasters<'a>,
    pub to_clip: &'a [ToClip],
    pub patches: &'a [Patch],
    pub into: &'a mut SplitTriangles,
}

impl SimdTask for Split<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { map, slabs, casters, to_clip, patches, into } = self;
        let mut memory = SplitMemory::default();
        let mut level_patches = patches.to_vec();
        for of_slab in to_clip.chunk_by(|a, b| a.slab == b.slab) {
            clip(map, &slabs[of_slab[0].slab as usize], casters, of_slab, &mut memory, &mut level_patches);
        }
        for level in 0..=MAX_LEVELS {
            let mut next = Vec::new();
            for of_slab in level_patches.chunk_by(|a, b| a.slab == b.slab) {
                let slab = &slabs[of_slab[0].slab as usize];
                measure(map, slab, of_slab, &mut memory);
                for (patch, edges) in of_slab.iter().zip(&memory.edges) {
                    let middles = middles_of(map, patch, edges, &memory);
                    divide(map, casters, patch, &middles, level == MAX_LEVELS, &mut next, into);
                }
            }
            if next.is_empty() {
                return;
            }
            level_patches = next;
        }
    }
}

/// Computes the tube coordinates of points in one slab, sixteen at a time.
#[inline(always)]
fn map_points(map: &BentMap, slab: &SlabLanes, points: &[Vec3], mapped: &mut Vec<TubePosition<f32>>) {
    mapped.clear();
    for points in points.chunks(LANES) {
        let lanes = slab.to_tube_position(&map.space, lanes_from_points(points));
        for i in 0..points.len() {
            mapped.push(lanes.lane(i));
        }
    }
}

/// Clips triangles to their slab in the scene, and adds the results as fans of patches.
#[inline(always)]
fn clip(
    map: &BentMap,
    slab: &SlabLanes,
    casters: &BentCasters,
    items: &[ToClip],
    memory: &mut SplitMemory,
    patches: &mut Vec<Patch>,
) {
    memory.points.clear();
    let mut counts = Vec::with_capacity(items.len());
    for item in items {
        let planes = &map.slabs[item.slab as usize].planes;
        let first = 3 * item.triangle as usize;
        let corner = |k: usize| map.space.position(casters.positions[casters.indices[first + k] as usize]);
        let (polygon, count) = clipped(planes, [corner(0), corner(1), corner(2)]);
        let count = if count < 3 { 0 } else { count };
        memory.points.extend(&polygon[..count]);
        counts.push(count);
    }
    map_points(map, slab, &memory.points, &mut memory.mapped);
    let mut first = 0;
    for (item, count) in items.iter().zip(counts) {
        let corners = &memory.points[first..first + count];
        let mapped = &memory.mapped[first..first + count];
        for k in 2..count {
            patches.push(Patch {
                q: [corners[0], corners[k - 1], corners[k]],
                mapped: [mapped[0], mapped[k - 1], mapped[k]],
                slab: item.slab,
                caster: item.caster,
            });
        }
        first += count;
    }
}

/// Clips a triangle by six planes. Returns its corners and their number.
#[inline(always)]
fn clipped(planes: &[[f32; 4]; 6], triangle: [Vec3; 3]) -> ([Vec3; MAX_CORNERS], usize) {
    let mut polygon = [Vec3::ZERO; MAX_CORNERS];
    polygon[..3].copy_from_slice(&triangle);
    let mut count = 3;
    for &[x, y, z, w] in planes {
        if count < 3 {
            break;
        }
        let normal = Vec3::new(x, y, z);
        let (mut kept, mut kept_count) = ([Vec3::ZERO; MAX_CORNERS], 0);
        let mut before = polygon[count - 1];
        let mut before_distance = normal.dot(before) + w;
        for &here in &polygon[..count] {
            let distance = normal.dot(here) + w;
            // Interpolates from the outer end always, so the triangles on both sides of the edge agree bit for bit.
            let crossing = if before_distance < 0.0 && distance >= 0.0 {
                Some(before + (here - before) * (before_distance / (before_distance - distance)))
            } else if before_distance >= 0.0 && distance < 0.0 {
                Some(here + (before - here) * (distance / (distance - before_distance)))
            } else {
                None
            };
            let inside = (distance >= 0.0).then_some(here);
            for corner in [crossing, inside].into_iter().flatten() {
                if kept_count < MAX_CORNERS {
                    kept[kept_count] = corner;
                    kept_count += 1;
                }
            }
            (before, before_distance) = (here, distance);
        }
        (polygon, count) = (kept, kept_count);
    }
    (polygon, count)
}

/// Computes the tube coordinates of points on the edges of `patches`, all of one slab. From these points follows if an
/// edge is straight.
#[inline(always)]
fn measure(map: &BentMap, slab: &SlabLanes, patches: &[Patch], memory: &mut SplitMemory) {
    memory.points.clear();
    memory.edges.clear();
    let bounds = map.slabs[patches[0].slab as usize].edge_bounds;
    for patch in patches {
        let mut edges = [None; 3];
        for (k, edge) in edges.iter_mut().enumerate() {
            let ends = patch.edge(k);
            if !ends.is_safe(bounds) {
                *edge = Some(memory.points.len());
                let middle = (ends.qa + ends.qb) * 0.5;
                // The formula is symmetric in both ends, so the edge's other triangle computes the same bits.
                memory.points.extend([middle, (ends.qa + middle) * 0.5, (ends.qb + middle) * 0.5]);
            }
        }
        memory.edges.push(edges);
    }
    map_points(map, slab, &memory.points, &mut memory.mapped);
}

impl Patch {
    /// Returns the edge from a corner to the next.
    #[inline(always)]
    fn edge(&self, k: usize) -> Edge<f32> {
        let next = (k + 1) % 3;
        Edge { qa: self.q[k], a: self.mapped[k], qb: self.q[next], b: self.mapped[next] }
    }
}

/// Compares the image of each edge's middle with the middle of the images, and likewise at the quarters, since an S
/// crosses its chord in the middle.
///
/// The rasterizer draws the middle of the homogeneous (V, W, R). On a straight cone both agree.
#[inline(always)]
fn middles_of(map: &BentMap, patch: &Patch, edges: &[Option<usize>; 3], memory: &SplitMemory) -> [Middle; 3] {
    let mut middles = [Middle { needs_split: false, edge_error: 0.0, q: Vec3::ZERO, mapped: patch.mapped[0] }; 3];
    let MapSlab { curve, t_span, .. } = &map.slabs[patch.slab as usize];
    for k in 0..3 {
        let Some(first) = edges[k] else { continue };
        let ends = patch.edge(k);
        let straight = halfway(&ends.a, &ends.b);
        let there = [straight, halfway(&ends.a, &straight), halfway(&ends.b, &straight)];
        let middle = &mut middles[k];
        (middle.q, middle.mapped) = (memory.points[first], memory.mapped[first]);
        for (i, straight) in there.iter().enumerate() {
            let (q, mapped) = (memory.points[first + i], &memory.mapped[first + i]);
            middle.needs_split |= exceeds_tolerance(map, curve, *t_span, q, mapped, straight);
            middle.edge_error = middle.edge_error.max(edge_error(mapped, straight));
        }
    }
    middles
}

#[inline(always)]
fn halfway(a: &TubePosition<f32>, b: &TubePosition<f32>) -> TubePosition<f32> {
    TubePosition { v: (a.v + b.v) * 0.5, w: (a.w + b.w) * 0.5, r: (a.r + b.r) * 0.5, t: (a.t + b.t) * 0.5 }
}

/// Makes a drawable triangle of a patch with an alpha test. A vertex that clipping or splitting made has no uv. Its
/// position in the original triangle gives it, since both are flat in the scene.
fn alpha_tested_triangle(map: &BentMap, casters: &BentCasters, patch: &Patch) -> AlphaTestedTriangle {
    let (scene, tests) = (casters.scene, &casters.alpha_tests);
    let triangle = tests.scene_triangle(patch.caster);
    let [a, b, c] = scene.corners(triangle).map(|corner| map.space.position(corner.to_array()));
    let [at_a, at_b, at_c] = scene.uv_alpha(triangle);
    let uv_alpha = patch.q.map(|q| {
        let weights = weights_at([a, b, c], q);
        (at_a + weights.y * (at_b - at_a) + weights.z * (at_c - at_a)).to_array()
    });
    let corners = patch.mapped.map(TubePosition::corner);
    AlphaTestedTriangle { corners, uv_alpha, test: tests.test_of(patch.caster) as u32 }
}

/// Drops a patch that lies off the map, draws a patch that is straight or of the last level, and splits any other patch
/// at the middles of its bent edges.
#[inline(always)]
fn divide(
    map: &BentMap,
    casters: &BentCasters,
    patch: &Patch,
    middles: &[Middle; 3],
    is_last: bool,
    next: &mut Vec<Patch>,
    into: &mut SplitTriangles,
) {
    let [a, b, c] = &patch.mapped;
    let bow = middles[0].edge_error.max(middles[1].edge_error).max(middles[2].edge_error);
    if off_map(map, [a, b, c], bow) {
        return;
    }
    let splits = middles.iter().filter(|middle| middle.needs_split).count();
    if splits == 0 || is_last {
        if patch.caster < INSIDE_OUT {
            into.alpha_tested.push(alpha_tested_triangle(map, casters, patch));
            return;
        }
        let turned = if patch.caster == INSIDE_OUT { 1.0 } else { -1.0 };
        if patch.caster == OPEN || !faces_away(map, [a, b, c], turned) {
            into.opaque.push([a.corner(), b.corner(), c.corner()]);
        }
        return;
    }
    let corner = |k: usize| (patch.q[k % 3], patch.mapped[k % 3]);
    let middle = |k: usize| (middles[k % 3].q, middles[k % 3].mapped);
    let mut pass_on = |corners: [(Vec3, TubePosition<f32>); 3]| {
        let [(qa, a), (qb, b), (qc, c)] = corners;
        next.push(Patch { q: [qa, qb, qc], mapped: [a, b, c], ..*patch });
    };
    if splits == 3 {
        for k in 0..3 {
            pass_on([corner(k), middle(k), middle(k + 2)]);
        }
        pass_on([middle(0), middle(1), middle(2)]);
        return;
    }
    // Starts at a split edge that follows an unsplit one; with two split edges the second follows it.
    let first = (0..3).find(|&k| middles[k].needs_split && !middles[(k + 2) % 3].needs_split).unwrap_or(0);
    if splits == 1 {
        pass_on([corner(first), middle(first), corner(first + 2)]);
        pass_on([middle(first), corner(first + 1), corner(first + 2)]);
    } else {
        pass_on([middle(first), corner(first + 1), middle(first + 1)]);
        pass_on([corner(first), middle(first), middle(first + 1)]);
        pass_on([corner(first), middle(first + 1), corner(first + 2)]);
    }
}
