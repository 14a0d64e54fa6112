//! Axis-aligned bounding boxes.

use glam::Vec3A;

/// Axis-aligned bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Aabb {
    /// Union of no boxes. It contains nothing.
    pub(crate) const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    pub(crate) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns half of the surface area; 0 for an empty box.
    pub(crate) fn half_area(self) -> f32 {
        let side = (self.max - self.min).max(Vec3A::ZERO);
        side.x * side.y + side.y * side.z + side.z * side.x
    }

    /// Returns the sum of the two corners, which is twice the centre.
    pub(crate) fn doubled_center(self) -> Vec3A {
        self.min + self.max
    }
}
