//! A bent map as it is asked for: what casts shadows, and what the map is to show of the light.

use glam::{Mat3, Vec3};

use super::slab::{MapSlab, TubeSpace};
use crate::{AlphaTests, CasterScene};

/// What throws shadows in a light, near it.
#[derive(Clone, Copy, Debug)]
pub struct BentCasters<'a> {
    /// Scene space, in blocks of 64.
    pub positions: &'a [[f32; 3]],
    /// Three a triangle; those without an alpha test come first.
    pub indices: &'a [u32],
    /// How many triangles have none.
    pub opaque_triangles: u32,
    /// Triangles that lie near each other: the first, and how many with what surface they are of above 16 bits: 0 open, 1
    /// closed, 2 closed and inside out.
    pub leaves: &'a [[u32; 2]],
    /// Blocks that leaves have corners in, in ascending order.
    pub blocks: &'a [u32],
    /// The tests of the triangles that have one, counted from the first of those.
    pub alpha_tests: AlphaTests<'a>,
    /// Whose triangles those are.
    pub scene: &'a CasterScene<'a>,
}

/// A map to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct BentMap<'a> {
    /// Where the light lies.
    pub space: TubeSpace,
    /// In ascending t.
    pub slabs: &'a [MapSlab],
    /// Least and greatest corner of a box around all slabs, in tube space.
    pub bounds: [Vec3; 2],
    /// One a face.
    pub faces: &'a [BentFace],
    /// Radius over the depth of the map's cube; `None` for one face.
    pub cube_slope: Option<f32>,
    /// Texels per unit of v and w where they are finest.
    pub texels_per_vw: f32,
    /// Largest distance, in texels, between an edge's image and the straight line drawn for it.
    pub tolerance_texels: f32,
}

/// A face of a bent map.
#[derive(Clone, Copy, Debug)]
pub struct BentFace {
    /// Clip coordinates (x, y, w) from (V, W, R).
    pub clip_from_mapped: Mat3,
    /// y / depth of a row of texels: the first plus the second for each; on the front 1.
    pub row_divisor: [f32; 2],
    /// What is stored of t.
    pub depth_per_t: f32,
    /// Whether anything may cast shadows on it.
    pub has_casters: bool,
}
