//! Input of a bent map: its casters and its view of the light.

use glam::{Mat3, Vec3};

use super::slab::{MapSlab, TubeSpace};
use crate::{AlphaTests, CasterScene};

/// Shadow casters near a light.
#[derive(Clone, Copy, Debug)]
pub struct BentCasters<'a> {
    /// Positions of vertices in scene space, in blocks of 64.
    pub positions: &'a [[f32; 3]],
    /// Indices of vertices, three per triangle. Triangles without an alpha test come first.
    pub indices: &'a [u32],
    /// Number of triangles without an alpha test.
    pub opaque_triangles: u32,
    /// Groups of neighbouring triangles: the first triangle; and their number in the lower 16 bits, with the kind of
    /// their surface above: 0 open, 1 closed, 2 closed and inside out.
    pub leaves: &'a [[u32; 2]],
    /// Blocks of positions that leaves use, in ascending order.
    pub blocks: &'a [u32],
    /// Tests of the triangles that have one. Triangles count from the first of those.
    pub alpha_tests: AlphaTests<'a>,
    /// Scene of the triangles with an alpha test.
    pub scene: &'a CasterScene<'a>,
}

/// Bent map to draw.
#[derive(Clone, Copy, Debug)]
pub struct BentMap<'a> {
    /// Tube space of the light.
    pub space: TubeSpace,
    /// Slabs of the light's tube, in ascending t.
    pub slabs: &'a [MapSlab],
    /// Least and greatest corner of a box around all slabs, in tube space.
    pub bounds: [Vec3; 2],
    pub faces: &'a [BentFace],
    /// Radius of the tube divided by the depth of the map's cube; `None` for a map with one face.
    pub cube_slope: Option<f32>,
    /// Largest number of texels per unit of v and w.
    pub texels_per_vw: f32,
    /// Largest distance, in texels, between an edge's image and the straight line drawn for it.
    pub tolerance_texels: f32,
}

/// Face of a bent map.
#[derive(Clone, Copy, Debug)]
pub struct BentFace {
    /// Matrix to clip coordinates (x, y, w) from (V, W, R).
    pub clip_from_mapped: Mat3,
    /// Quotient y / depth at a row of texels: the first number, plus the second for each row. 1 on the front face.
    pub row_divisor: [f32; 2],
    /// Stored depth per unit of t.
    pub depth_per_t: f32,
    /// True if anything may cast shadows on the face.
    pub has_casters: bool,
}
