//! Boxes along the axes.

use glam::Vec3A;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Its least coordinates.
    pub min: Vec3A,
    /// Its largest.
    pub max: Vec3A,
}

impl Aabb {
    /// What holds nothing: the union of no boxes.
    pub(crate) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub(crate) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half of its surface; 0 where there is none.
    pub(crate) fn half_area(self) -> f32 {
        let side = (self.max - self.min).max(Vec3A::ZERO);
        side.x * side.y + side.y * side.z + side.z * side.x
    }

    /// Twice its middle.
    pub(crate) fn doubled_center(self) -> Vec3A {
        self.min + self.max
    }
}
