//! Axis-aligned boxes around points.

use glam::Vec3;

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
