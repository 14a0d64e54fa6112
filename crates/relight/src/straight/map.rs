//! Drawing of straight lights' maps: casters as the light sees them, each vertex mapped once, drawn onto each face by
//! its own matrix.

use glam::{Mat4, Vec3};
use rayon::prelude::*;

use super::alpha_tested;
use super::casters::{AlphaTestedCasters, OpaqueCasters, StraightFace, StraightMap};
use crate::depth_map::DepthMap;
use crate::raster::{
    AlphaTestedTriangle, AlphaTestedTriangles, DepthRule, MapFace, RasterMemory, RasterTriangle, draw_face,
};
use crate::simd::{self, SimdTask};
use crate::{Cancelled, Workers};

/// Vertices of a block of casters.
const VERTICES_PER_BLOCK: usize = 64;
/// Leaves of casters that a worker lists at once: as many triangles as the rasterizer sets up at once.
const LEAVES_PER_CHUNK: usize = 32;
/// Largest shift of a corner by rasterization, in texels.
const SNAP_TEXELS: f32 = 1.0 / 256.0;
/// Rounding error of f32 for a position of size 1 that was rotated and translated.
const POSITION_ROUNDING: f32 = 1.0 / 4_194_304.0;

/// Memory for drawing maps of straight lights, kept from one map to the next.
#[derive(Debug, Default)]
pub struct StraightMapBuilder {
    map_positions: Vec<[f32; 4]>,
    listed: Vec<Vec<RasterTriangle>>,
    alpha_tested: Vec<Vec<AlphaTestedTriangle>>,
    scratch: RasterMemory,
}

impl StraightMapBuilder {
    /// Draws all faces.
    pub fn draw(
        &mut self,
        workers: &Workers,
        map: &StraightMap,
        opaque: &OpaqueCasters,
        alpha_tested: &AlphaTestedCasters,
        into: &mut DepthMap,
    ) -> Result<(), Cancelled> {
        self.map_vertices(workers, map, opaque);
        let side = into.side();
        let depths = map.near.map_or(DepthRule::Orthographic, |near| DepthRule::Perspective { near });
        for (index, face) in map.faces.iter().enumerate() {
            let texels = into.face_mut(index);
            if !face.has_casters {
                workers.run(|| texels.par_chunks_mut(side).for_each(|some| some.fill(0.0)));
                continue;
            }
            let Self { map_positions, listed, alpha_tested: listed_alpha_tested, scratch } = self;
            let (near, indices, snap) = (map.near, opaque.indices, snap(face, side));
            listed.resize_with(face.leaves.len().div_ceil(LEAVES_PER_CHUNK), Vec::new);
            workers.run(|| {
                let chunks = listed.par_iter_mut().zip(face.leaves.par_chunks(LEAVES_PER_CHUNK));
                chunks.for_each(|(listed, leaves)| {
                    listed.clear();
                    simd::run(List { near, snap, map_positions, indices, leaves, listed });
                });
            });
            alpha_tested::list_triangles(workers, map, face, alpha_tested, listed_alpha_tested);
            let drawn = MapFace { clip_from_map: face.clip_from_map, depths };
            let with_holes = AlphaTestedTriangles { chunks: listed_alpha_tested, tests: alpha_tested.tests };
            draw_face(&drawn, listed, &with_holes, workers, scratch, texels, side)?;
        }
        Ok(())
    }

    /// Maps each vertex near the light.
    fn map_vertices(&mut self, workers: &Workers, map: &StraightMap, opaque: &OpaqueCasters) {
        let OpaqueCasters { positions, blocks, .. } = *opaque;
        self.map_positions.resize(positions.len(), [0.0; 4]);
        let mut is_near = vec![false; positions.len().div_ceil(VERTICES_PER_BLOCK)];
        for &block in blocks {
            is_near[block as usize] = true;
        }
        workers.run(|| {
            let mapped = self.map_positions.par_chunks_mut(VERTICES_PER_BLOCK);
            let blocks = mapped.zip(positions.par_chunks(VERTICES_PER_BLOCK)).zip(&is_near);
            blocks.filter(|(_, is_near)| **is_near).for_each(|((mapped, positions), _)| {
                for (mapped, position) in mapped.iter_mut().zip(positions) {
                    *mapped = map.map_position(*position);
                }
            });
        });
    }
}

impl StraightMap<'_> {
    #[inline(always)]
    pub(super) fn map_position(&self, [x, y, z]: [f32; 3]) -> [f32; 4] {
        let Mat4 { x_axis, y_axis, z_axis, w_axis } = self.map_from_scene;
        (x_axis * x + y_axis * y + z_axis * z + w_axis).to_array()
    }
}

/// Returns the largest shift of a corner by rasterization on a face: as a slope, or for parallel rays in world units.
fn snap(face: &StraightFace, side: usize) -> f32 {
    let map_from_clip = face.clip_from_map.inverse();
    let half = map_from_clip.x_axis.length_squared().max(map_from_clip.y_axis.length_squared()).sqrt();
    half * 2.0 / side as f32 * SNAP_TEXELS
}

/// Task that lists the visible triangles in a face's leaves.
struct List<'a> {
    near: Option<f32>,
    snap: f32,
    map_positions: &'a [[f32; 4]],
    indices: &'a [u32],
    leaves: &'a [[u32; 2]],
    listed: &'a mut Vec<RasterTriangle>,
}

impl SimdTask for List<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { near, snap, map_positions, indices, leaves, listed } = self;
        // Seen along the light, the triangles of a closed surface that face it wind one way about a source, and the
        // other way about the direction of parallel rays.
        let turned = if near.is_some() { 1.0 } else { -1.0 };
        let (slack, rounding) =
            if near.is_some() { (snap.max(POSITION_ROUNDING), 0.0) } else { (snap, POSITION_ROUNDING) };
        for &[first, count_and_kind] in leaves {
            let (count, kind) = ((count_and_kind & 0xffff) as usize, count_and_kind >> 16);
            let corners = &indices[3 * first as usize..][..3 * count];
            let sign = if kind == 2 { -turned } else { turned };
            for corners in corners.as_chunks::<3>().0 {
                let triangle = [
                    map_positions[corners[0] as usize],
                    map_positions[corners[1] as usize],
                    map_positions[corners[2] as usize],
                ];
                if kind == 0 || !faces_away(&triangle, sign, slack, rounding) {
                    listed.push(triangle);
                }
            }
        }
    }
}

/// True if light meets the back of a triangle, and does so by more than shifts of the triangle's corners could change.
#[inline(always)]
fn faces_away(triangle: &RasterTriangle, sign: f32, slack: f32, rounding: f32) -> bool {
    let [a, b, c] = [xyz(&triangle[0]), xyz(&triangle[1]), xyz(&triangle[2])];
    let (ab, ac, bc) = (b - a, c - a, c - b);
    // Six times the volume that the triangle makes with the source; for parallel rays twice its area across the light.
    let volume = sign * a.dot(ab.cross(ac));
    let longest = ab.dot(ab).max(ac.dot(ac)).max(bc.dot(bc)).sqrt();
    let farthest2 = a.dot(a).max(b.dot(b)).max(c.dot(c));
    if rounding == 0.0 {
        return volume > 3.0 * slack * farthest2 * longest;
    }
    volume > 3.0 * (slack + rounding * farthest2.sqrt()) * longest
}

#[inline(always)]
fn xyz(corner: &[f32; 4]) -> Vec3 {
    Vec3::new(corner[0], corner[1], corner[2])
}
