//! Alpha-tested shadow casters of a straight light.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::casters::{AlphaTestedCasters, AlphaTestedRun, StraightFace, StraightMap};
use crate::Workers;
use crate::raster::{AlphaTestedTriangle, RasterTriangle};

/// Triangles that a worker lists at once.
const TRIANGLES_PER_CHUNK: usize = 1024;

/// Lists the triangles that a face may show, and discards the former list.
pub(super) fn list_triangles(
    workers: &Workers,
    map: &StraightMap,
    face: &StraightFace,
    casters: &AlphaTestedCasters,
    into: &mut Vec<Vec<AlphaTestedTriangle>>,
) {
    let chunks: Vec<_> = casters.runs.iter().flat_map(chunks).collect();
    into.resize_with(chunks.len(), Vec::new);
    workers.run(|| {
        into.par_iter_mut().zip(chunks).for_each(|(listed, AlphaTestedRun { triangles, test })| {
            listed.clear();
            for triangle in triangles {
                let corners = casters.scene.corners(triangle).map(|corner| map.map_position(corner.to_array()));
                if !is_outside_face(face, &corners) {
                    let uv_alpha = casters.scene.uv_alpha(triangle).map(|corner| corner.to_array());
                    listed.push(AlphaTestedTriangle { corners, uv_alpha, test });
                }
            }
        });
    });
}

/// Splits a run into chunks.
fn chunks(run: &AlphaTestedRun) -> impl Iterator<Item = AlphaTestedRun> {
    let AlphaTestedRun { triangles: Range { start, end }, test } = run.clone();
    let last = move |first: u32| end.min(first + TRIANGLES_PER_CHUNK as u32);
    (start..end).step_by(TRIANGLES_PER_CHUNK).map(move |first| AlphaTestedRun { triangles: first..last(first), test })
}

/// True if a triangle lies beyond one of the sides of a face.
fn is_outside_face(face: &StraightFace, corners: &RasterTriangle) -> bool {
    let [a, b, c] = corners.map(|[x, y, z, _]| face.clip_from_map * Vec3::new(x, y, z));
    let all = |outside: fn(Vec3) -> bool| outside(a) && outside(b) && outside(c);
    all(|p| p.x > p.z) || all(|p| p.x < -p.z) || all(|p| p.y > p.z) || all(|p| p.y < -p.z)
}
