//! Boxes along the world's axes.

use glam::DVec3;

/// A box, between two corners.
#[derive(Clone, Copy, Debug)]
pub struct Aabb64 {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl Aabb64 {
    /// Everywhere.
    pub const INFINITE: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// Length of the diagonal.
    pub(crate) fn size(&self) -> f64 {
        (self.max - self.min).length()
    }
}
