//! A straight light's map as it is asked for: what casts shadows, and how its faces look at that.

use std::ops::Range;

use glam::{Mat3, Mat4};

use crate::{AlphaTests, CasterScene};

/// A map to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct StraightMap<'a> {
    /// From positions in scene space to places and their values: to light space about the source, where light goes out
    /// from one; else to (x, y, 1) across the light, and the depth.
    pub map_from_scene: Mat4,
    /// The near plane, in world units, where light goes out from a source; `None` where rays are parallel.
    pub near: Option<f32>,
    /// One a face.
    pub faces: &'a [StraightFace<'a>],
}

/// A face of a straight light's map.
#[derive(Clone, Copy, Debug)]
pub struct StraightFace<'a> {
    /// From places to clip coordinates (x, y, w).
    pub clip_from_map: Mat3,
    /// Triangles without an alpha test that it may show, by leaves: the first, and how many with what surface they are
    /// of above 16 bits: 0 open, 1 closed, 2 closed and inside out.
    pub leaves: &'a [[u32; 2]],
    /// Whether anything casts shadows on it; it is empty where nothing does.
    pub has_casters: bool,
}

/// Triangles with alpha tests.
#[derive(Clone, Copy, Debug)]
pub struct AlphaTestedCasters<'a> {
    /// Where they are.
    pub scene: &'a CasterScene<'a>,
    /// Which of its triangles.
    pub runs: &'a [AlphaTestedRun],
    /// The tests that runs name.
    pub tests: AlphaTests<'a>,
}

/// Triangles with one alpha test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlphaTestedRun {
    /// Of the scene.
    pub triangles: Range<u32>,
    /// Which of the tests.
    pub test: u32,
}
