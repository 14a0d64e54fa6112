//! Axis-aligned boxes in f64.

use glam::DVec3;

/// Axis-aligned box between two corners.
#[derive(Clone, Copy, Debug)]
pub struct Aabb64 {
    pub min: DVec3,
    pub max: DVec3,
}

impl Aabb64 {
    /// All of space.
    pub const INFINITE: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    pub(crate) fn size(&self) -> f64 {
        (self.max - self.min).length()
    }
}
