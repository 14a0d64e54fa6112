//! Axis-aligned boxes around points.

use glam::{BVec3, DVec3, Vec3};

#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundsF32 {
    pub min: Vec3,
    pub max: Vec3,
}

impl BoundsF32 {
    pub const NOTHING: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub fn of(points: impl Iterator<Item = Vec3>) -> Self {
        points.fold(Self::NOTHING, |Self { min, max }, p| Self { min: min.min(p), max: max.max(p) })
    }

    pub fn union(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::NOTHING, |a, b| Self { min: a.min.min(b.min), max: a.max.max(b.max) })
    }
}

/// Returns the corners of the box from `low` to `high`.
pub(crate) fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|k| DVec3::select(BVec3::new(k & 1 != 0, k >> 1 & 1 != 0, k >> 2 != 0), high, low))
}
