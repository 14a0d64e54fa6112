//! Drawing of straight lights' maps: casters as the light sees them, each vertex mapped once, drawn onto each face by
//! its own matrix.

use glam::{Mat4, Vec3};
use rayon::prelude::*;

use super::alpha_tested;
use super::casters::{AlphaTestedCasters, StraightFace, StraightMap};
use crate::depth_map::DepthMap;
use crate::raster::{
    AlphaTestedTriangle, AlphaTestedTriangles, DepthRule, MapFace, RasterMemory, RasterTriangle,
    draw_face_with_alpha_tests,
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
    /// Draws all faces. `positions` are in scene space, in blocks of 64; `blocks` are those that leaves use. `indices`
    /// are three per triangle.
    pub fn draw(
        &mut self,
        workers: &Workers,
        map: &StraightMap,
        (positions, blocks, indices): (&[[f32; 3]], &[u32], &[u32]),
        alpha_tested: &AlphaTestedCasters,
        into: &mut DepthMap,
    ) -> Result<(), Cancelled> {
        self.map_vertices(workers, map, (positions, blocks));
        let side = into.side();
        let depths = map.near.map_or(DepthRule::Orthographic, |near| DepthRule::Perspective { near });
        for (index, face) in map.faces.iter().enumerate() {
            let texels = into.face_mut(index);
            if !face.has_casters {
                workers.run(|| texels.par_chunks_mut(side).for_each(|some| some.fill(0.0)));
                continue;
            }
            let Self { map_positions: places, listed, alpha_tested: listed_alpha_tested, scratch } = self;
            let snap = snap(face, side);
            let turns = face.leaves.len().div_ceil(LEAVES_PER_CHUNK);
            listed.resize_with(turns, Vec::new);
            workers.run(|| {
                let turns = listed.par_iter_mut().zip(face.leaves.par_chunks(LEAVES_PER_CHUNK));
                turns.for_each(|(listed, leaves)| {
                    listed.clear();
                    simd::run(List { near: map.near, snap, map_positions: places, indices, leaves, listed });
                });
            });
            alpha_tested::list_triangles(workers, (map, face), alpha_tested, listed_alpha_tested);
            let drawn = MapFace { clip_from_map: face.clip_from_map, depths };
            let with_holes = AlphaTestedTriangles { chunks: listed_alpha_tested, tests: alpha_tested.tests };
            draw_face_with_alpha_tests(&drawn, listed, &with_holes, workers, scratch, texels, side)?;
        }
        Ok(())
    }

    /// Maps each vertex near the light.
    fn map_vertices(
        &mut self,
        workers: &Workers,
        map: &StraightMap,
        (positions, blocks): (&[[f32; 3]], &[u32]),
    ) {
        let places = &mut self.map_positions;
        places.resize(positions.len(), [0.0; 4]);
        let mut is_near = vec![false; positions.len().div_ceil(VERTICES_PER_BLOCK)];
        for &block in blocks {
            is_near[block as usize] = true;
        }
        workers.run(|| {
            let blocks =
                places.par_chunks_mut(VERTICES_PER_BLOCK).zip(positions.par_chunks(VERTICES_PER_BLOCK));
            blocks.zip(&is_near).filter(|(_, is_near)| **is_near).for_each(|((places, positions), _)| {
                for (place, position) in places.iter_mut().zip(positions) {
                    *place = map.map_position(*position);
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
    let place_from_clip = face.clip_from_map.inverse();
    let half = place_from_clip.x_axis.length_squared().max(place_from_clip.y_axis.length_squared()).sqrt();
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
        let Self { near, snap, map_positions: places, indices, leaves, listed } = self;
        // Seen along the light, the triangles of a closed surface that face it wind one way about a source, and the
        // other way about the direction of parallel rays.
        let turned = if near.is_some() { 1.0 } else { -1.0 };
        let (slack, rounding) =
            if near.is_some() { (snap.max(POSITION_ROUNDING), 0.0) } else { (snap, POSITION_ROUNDING) };
        for &[first, count_and_shell] in leaves {
            let (count, shell) = ((count_and_shell & 0xffff) as usize, count_and_shell >> 16);
            let corners = &indices[3 * first as usize..][..3 * count];
            let sign = if shell == 2 { -turned } else { turned };
            for corners in corners.as_chunks::<3>().0 {
                let triangle =
                    [places[corners[0] as usize], places[corners[1] as usize], places[corners[2] as usize]];
                if shell == 0 || !faces_away(&triangle, sign, [slack, rounding]) {
                    listed.push(triangle);
                }
            }
        }
    }
}

/// True if light meets the back of a triangle, and does so by more than shifts of the triangle's corners could change.
#[inline(always)]
fn faces_away(triangle: &RasterTriangle, sign: f32, [slack, rounding]: [f32; 2]) -> bool {
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
