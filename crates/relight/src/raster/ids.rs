//! Triangles that texels show, beside their depths.

use super::wide::{F32s, LANES};

/// Memory for the triangle of each texel, or nothing for a map, which stores depths alone.
pub(super) trait TriangleIds: Send {
    /// Forgets all triangles.
    fn clear(&mut self);

    /// Notes a triangle at the sixteen texels from `at` on whose depth has changed.
    fn note(&mut self, at: usize, before: F32s, after: F32s, id: u32);
}

/// A map.
impl TriangleIds for () {
    #[inline(always)]
    fn clear(&mut self) {}

    #[inline(always)]
    fn note(&mut self, _: usize, _: F32s, _: F32s, _: u32) {}
}

impl TriangleIds for &mut [u32] {
    #[inline(always)]
    fn clear(&mut self) {
        self.fill(0);
    }

    #[inline(always)]
    fn note(&mut self, at: usize, before: F32s, after: F32s, id: u32) {
        let Some(ids) = self[at..].first_chunk_mut::<LANES>() else { return };
        let mut noted = [0; LANES];
        for lane in 0..LANES {
            noted[lane] = if after.0[lane] == before.0[lane] { ids[lane] } else { id };
        }
        *ids = noted;
    }
}
