//! Visibility buffer of a picture: the triangle that each pixel shows, and its depth.

use glam::Mat4;
use pulp::Arch;
use rayon::prelude::*;

use super::alpha_tested::AlphaTestedPiece;
use super::project::Projection;
use super::rule::PictureDepthTest;
use super::setup::{OpaquePiece, SetUp, Triangles, has_both_sides};
use super::{AlphaTestedTriangle, BandWork, DrawBand, SetUpTriangles, TRIANGLES_PER_PIECE};
use crate::depth_map::stride;
use crate::pixel_block::{BLOCK_SIDE, CameraRays};
use crate::{Cancelled, CasterScene, Workers};

/// Number of rows of a picture that one thread draws at once. Those of a picture 2048 pixels wide take a quarter of a
/// megabyte.
const ROWS_PER_BAND: usize = 16;
/// Number of vertices that a thread projects at once.
const VERTICES_PER_CHUNK: usize = 4096;

/// Triangles of a scene for pictures.
#[derive(Clone, Copy, Debug)]
pub struct VisibleTriangles<'a> {
    pub scene: &'a CasterScene<'a>,
    /// One bit per triangle, in words of 32 triangles: set if the triangle is seen from both sides, not only from its
    /// front.
    pub both_sides: &'a [u32],
}

/// Part of a picture that is drawn. It has the bits of the whole.
#[derive(Clone, Copy, Debug)]
pub struct PicturePart {
    /// Transform from scene space to clip coordinates with reversed depth: z / w is 1 at the near plane and 0 at the far
    /// one. |x| <= w and |y| <= w are in the whole picture, and y is up.
    pub clip_from_scene: Mat4,
    /// Distance of the near plane, which is the least w, of a perspective camera; `None` for an orthographic one.
    pub near: Option<f32>,
    /// Rays of the part's pixels.
    pub camera: CameraRays,
    /// Width and height of the whole picture in pixels.
    pub whole: [usize; 2],
    /// First column and row of the part.
    pub first: [usize; 2],
    /// Width and height of the part in pixels.
    pub size: [usize; 2],
}

/// Triangle and depth of each pixel, rows from the top.
#[derive(Debug, Default)]
pub struct VisibilityBuffer {
    size: [usize; 2],
    /// Reversed depths z / w; 0 without a triangle.
    z: Vec<f32>,
    /// Index of the triangle + 1; 0 without one.
    triangles: Vec<u32>,
}

/// Work memory for drawing, reused from one picture to the next.
#[derive(Debug, Default)]
pub struct VisibilityBuilder {
    /// (x, y, w, z) of each vertex in clip coordinates.
    clip_positions: Vec<[f32; 4]>,
    opaque: Vec<OpaquePiece>,
    alpha_tested: Vec<AlphaTestedPiece>,
}

impl VisibilityBuffer {
    /// Returns the width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the triangle + 1 and the depth of a pixel; (0, 0) without a triangle.
    #[inline(always)]
    pub(crate) fn at(&self, column: usize, row: usize) -> (u32, f32) {
        let index = row * stride(self.size[0]) + column;
        (self.triangles[index], self.z[index])
    }

    /// True if a pixel of the block with that top left corner shows a triangle.
    pub(crate) fn is_block_seen(&self, corner: [u16; 2]) -> bool {
        let ([width, height], [left, top]) = (self.size, corner.map(usize::from));
        let right = width.min(left + BLOCK_SIDE);
        let rows = (top..height.min(top + BLOCK_SIDE)).map(|row| row * stride(width));
        rows.flat_map(|start| &self.triangles[start + left..start + right]).any(|triangle| *triangle != 0)
    }
}

impl VisibilityBuilder {
    /// Draws the triangles of a scene onto a part of a picture.
    pub fn draw(
        &mut self,
        workers: &Workers,
        triangles: &VisibleTriangles,
        part: &PicturePart,
        into: &mut VisibilityBuffer,
    ) -> Result<(), Cancelled> {
        let scene = triangles.scene;
        let mut projection = Projection::part_of(part.whole, part.first, part.size, ROWS_PER_BAND);
        projection.least_w = part.near.unwrap_or(projection.least_w);
        self.project(workers, scene.positions, &part.clip_from_scene);
        let (opaque, alpha_tested) = scene.indices.split_at(3 * scene.opaque_triangles as usize);
        let Self { clip_positions, opaque: pieces, alpha_tested: alpha_tested_pieces } = self;
        pieces.resize_with((opaque.len() / 3).div_ceil(TRIANGLES_PER_PIECE), OpaquePiece::default);
        alpha_tested_pieces
            .resize_with((alpha_tested.len() / 3).div_ceil(TRIANGLES_PER_PIECE), AlphaTestedPiece::default);
        workers.run(|| {
            let slices = opaque.par_chunks(3 * TRIANGLES_PER_PIECE);
            pieces.par_iter_mut().zip(slices).enumerate().for_each(|(index, (piece, indices))| {
                let first = index * TRIANGLES_PER_PIECE;
                let both_sides = triangles.both_sides;
                let triangles = Triangles::Indexed { clip_positions, indices, first, both_sides };
                Arch::new().dispatch(SetUp { piece, triangles, projection: &projection });
            });
            let slices = alpha_tested.par_chunks(3 * TRIANGLES_PER_PIECE);
            alpha_tested_pieces.par_iter_mut().zip(slices).enumerate().for_each(|(index, (piece, indices))| {
                let first = scene.opaque_triangles as usize + index * TRIANGLES_PER_PIECE;
                set_up_alpha_tested(piece, triangles, clip_positions, (indices, first as u32), &projection);
            });
        });
        let seen = SetUpTriangles { pieces, alpha_tested: alpha_tested_pieces, tests: scene.alpha_tests };
        into.size = part.size;
        let length = part.size[1] * stride(part.size[0]);
        workers.resize(&mut into.z, length, 0.0)?;
        workers.resize(&mut into.triangles, length, 0)?;
        let length = (projection.rows_per_band * stride(projection.size[0])).max(1);
        let bands = into.z.chunks_mut(length).zip(into.triangles.chunks_mut(length)).enumerate();
        let bands = bands.map(|(index, (texels, ids))| BandWork { index, texels, ids, next: None });
        let rule = PictureDepthTest { planes: scene.planes, camera: &part.camera };
        let projection = &projection;
        workers.each(bands, |work| Arch::new().dispatch(DrawBand { rule, seen, projection, work, workers }))
    }

    fn project(&mut self, workers: &Workers, positions: &[[f32; 3]], clip_from_scene: &Mat4) {
        self.clip_positions.resize(positions.len(), [0.0; 4]);
        workers.run(|| {
            let chunks = self.clip_positions.par_chunks_mut(VERTICES_PER_CHUNK);
            chunks.zip(positions.par_chunks(VERTICES_PER_CHUNK)).for_each(|(projected, positions)| {
                let Mat4 { x_axis, y_axis, z_axis, w_axis } = *clip_from_scene;
                for (projected, [x, y, z]) in projected.iter_mut().zip(positions) {
                    let clip = x_axis * *x + y_axis * *y + z_axis * *z + w_axis;
                    *projected = [clip.x, clip.y, clip.w, clip.z];
                }
            });
        });
    }
}

/// Sets up alpha-tested triangles, the first of which has the index `first`.
fn set_up_alpha_tested(
    piece: &mut AlphaTestedPiece,
    triangles: &VisibleTriangles,
    clip_positions: &[[f32; 4]],
    (indices, first): (&[u32], u32),
    projection: &Projection,
) {
    let scene = triangles.scene;
    piece.clear(projection);
    for (triangle, corners) in (first..).zip(indices.as_chunks::<3>().0) {
        let seen = AlphaTestedTriangle {
            corners: corners.map(|corner| clip_positions[corner as usize]),
            uv_alpha: scene.uv_alpha(triangle).map(|corner| corner.to_array()),
            test: scene.alpha_tests.test_of(triangle - scene.opaque_triangles) as u32,
        };
        piece.add(&seen, triangle + 1, has_both_sides(triangles.both_sides, triangle as usize), projection);
    }
}
