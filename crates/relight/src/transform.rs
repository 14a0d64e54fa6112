//! Transforms of sixteen vectors.

use glam::Mat4;
use light::Lanes;

use crate::lanes::{F32s, Vec3s};

/// Affine transform, with each of its numbers in all lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Affine3s {
    columns: [Vec3s; 3],
    translation: Vec3s,
}

impl Affine3s {
    pub fn splat(matrix: Mat4) -> Self {
        let [a, b, c, translation] = matrix.to_cols_array_2d().map(|[x, y, z, _]| Vec3s::splat([x, y, z]));
        Self { columns: [a, b, c], translation }
    }

    #[inline(always)]
    pub fn position(&self, p: Vec3s) -> Vec3s {
        self.vector(p) + self.translation
    }

    #[inline(always)]
    pub fn vector(&self, v: Vec3s) -> Vec3s {
        self.columns[0] * v.x + self.columns[1] * v.y + self.columns[2] * v.z
    }

    /// Transforms a vector by the transposed matrix, the inverse of a rotation.
    #[inline(always)]
    pub fn transposed_vector(&self, v: Vec3s) -> Vec3s {
        Vec3s { x: F32s::dot(self.columns[0], v), y: F32s::dot(self.columns[1], v), z: F32s::dot(self.columns[2], v) }
    }
}
