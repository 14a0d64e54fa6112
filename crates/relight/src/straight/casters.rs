//! Input of a straight light's map: its casters and its faces.

use std::ops::Range;

use glam::{Mat3, Mat4};

use crate::{AlphaTests, CasterScene};

/// Map of a straight light to draw.
#[derive(Clone, Copy, Debug)]
pub struct StraightMap<'a> {
    /// Transform from scene space to map space. For a light with a source, map space is light space with the source at
    /// the origin. For parallel rays it is (x, y, 1, depth), with x and y across the light.
    pub map_from_scene: Mat4,
    /// Near plane in world units, for a light with a source; `None` for parallel rays.
    pub near: Option<f32>,
    pub faces: &'a [StraightFace<'a>],
}

/// Face of a straight light's map.
#[derive(Clone, Copy, Debug)]
pub struct StraightFace<'a> {
    /// Transform from the first three coordinates of map space to clip coordinates (x, y, w).
    pub clip_from_map: Mat3,
    /// Leaves of triangles without an alpha test that the face may show: the first triangle; and their number in the
    /// lower 16 bits, with the kind of their surface above: 0 open, 1 closed, 2 closed and inside out.
    pub leaves: &'a [[u32; 2]],
    /// True if anything casts shadows on the face. The face is empty otherwise.
    pub has_casters: bool,
}

/// Shadow casters without an alpha test, to which the leaves of faces refer.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpaqueCasters<'a> {
    /// Positions of vertices in scene space, in blocks of 64.
    pub positions: &'a [[f32; 3]],
    /// Blocks of positions that leaves use.
    pub blocks: &'a [u32],
    /// Indices of vertices, three per triangle.
    pub indices: &'a [u32],
}

/// Alpha-tested shadow casters.
#[derive(Clone, Copy, Debug)]
pub struct AlphaTestedCasters<'a> {
    /// Scene of the triangles.
    pub scene: &'a CasterScene<'a>,
    pub runs: &'a [AlphaTestedRun],
    /// Tests to which the indices in the runs refer.
    pub tests: AlphaTests<'a>,
}

/// Consecutive triangles with the same alpha test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlphaTestedRun {
    /// Range of the scene's triangles.
    pub triangles: Range<u32>,
    /// Index of the test.
    pub test: u32,
}
