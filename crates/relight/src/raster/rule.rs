//! Depth rules: the depth that a texel stores, and the comparison by which one of two wins.

use glam::Vec3;
use light::Lanes;

use super::wide::{F32s, Ints};
use crate::pixel_block::CameraRays;

/// One of [`super::DepthRule`], in the form of the innermost loops.
///
/// They interpolate two numbers that are linear on the face: N, which set-up computes from a corner's value, and D = 1
/// / w.
pub(super) trait DepthTest: Copy + Send + Sync {
    /// Depth of a texel that no triangle covers.
    const CLEARED: f32;

    /// Numbers of a triangle that the rule needs besides N and D.
    type Triangle: Copy;
    /// Numbers of a row of its texels.
    type Row: Copy;

    fn triangle(self, id: u32) -> Self::Triangle;
    fn row(self, triangle: Self::Triangle, row: usize) -> Self::Row;

    /// Computes the new depths of texels that stored `old`, after a triangle that covers the lanes of `covered`. `columns`
    /// are those of the texels.
    fn updated_depths(self, covered: Ints, n: F32s, d: F32s, row: Self::Row, columns: Ints, old: F32s) -> F32s;
}

/// N is value / w. The least N / (D * row divisor) wins.
#[derive(Clone, Copy)]
pub(super) struct BentDepthTest<'a> {
    pub rows: &'a [f32],
}

/// N is near / w. The greatest wins.
#[derive(Clone, Copy)]
pub(super) struct PerspectiveDepthTest;

/// N is the value. The greatest that is at most 1 wins.
#[derive(Clone, Copy)]
pub(super) struct OrthographicDepthTest;

/// N is the reversed depth z / w. The greatest that is at most 1 wins, of depths on the planes of the triangles. Those of
/// coincident surfaces, such as a carpet and its floor, differ by roundings, and the first one wins everywhere.
#[derive(Clone, Copy)]
pub(super) struct PictureDepthTest<'a> {
    /// Planes of the scene's triangles; see [`crate::CasterScene`].
    pub planes: &'a [[f32; 4]],
    pub camera: &'a CameraRays,
}

/// Least ratio of the depths of two surfaces of which the second one is nearer: eight roundings of f32. Planes of
/// coincident surfaces differ by the roundings of their normals.
const NEARER: f32 = 1.0 + 1.0 / 2_097_152.0;

/// Reversed depths on a plane: the first number, plus the others times the column and the row of a pixel of the picture.
pub(super) type PlaneDepths = [f32; 3];

impl PictureDepthTest<'_> {
    /// Returns the depths on the plane of a triangle. Those of a plane that is seen edge on are not finite.
    fn plane_depths(self, id: u32) -> PlaneDepths {
        let [x, y, z, offset] = self.planes[id as usize - 1];
        let normal = Vec3::new(x, y, z);
        let along = |v: [f32; 3]| normal.dot(Vec3::from(v));
        let CameraRays { origin, origin_dx, origin_dy, direction, direction_dx, direction_dy, .. } = *self.camera;
        // A ray meets the plane at the distance height / closing along the view axis.
        let (height, closing) = (offset - along(origin), along(direction));
        // z = (c.x - c.z distance) / (c.w distance - c.y), where c.y is 0 in perspective and c.w in parallel projection.
        let [c_x, c_y, c_z, c_w] = self.camera.depth_from_z;
        if c_w == 0.0 {
            let (per_closing, scale) = (closing.recip(), c_y.recip());
            let [dx, dy] = [along(origin_dx), along(origin_dy)].map(|change| -c_z * change * per_closing * scale);
            return [(c_z * height * per_closing - c_x) * scale, dx, dy];
        }
        let per_height = c_x / (c_w * height);
        [closing * per_height - c_z / c_w, along(direction_dx) * per_height, along(direction_dy) * per_height]
    }
}

impl DepthTest for BentDepthTest<'_> {
    const CLEARED: f32 = 1.0;
    type Triangle = ();
    /// Factor by which D is multiplied.
    type Row = f32;

    #[inline(always)]
    fn triangle(self, _: u32) {}

    #[inline(always)]
    fn row(self, (): (), row: usize) -> f32 {
        self.rows[row]
    }

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: F32s, d: F32s, factor: f32, _: Ints, old: F32s) -> F32s {
        let depth = (n / (d * F32s::splat(factor))).greater(F32s::ZERO);
        covered.select_floats(depth, old).lesser(old)
    }
}

impl DepthTest for PerspectiveDepthTest {
    const CLEARED: f32 = 0.0;
    type Triangle = ();
    type Row = ();

    #[inline(always)]
    fn triangle(self, _: u32) {}

    #[inline(always)]
    fn row(self, (): (), _: usize) {}

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: F32s, _: F32s, (): (), _: Ints, old: F32s) -> F32s {
        // With rounding, near / near may be more than 1.
        covered.select_floats(n.lesser(F32s::splat(1.0)), old).greater(old)
    }
}

impl DepthTest for OrthographicDepthTest {
    const CLEARED: f32 = 0.0;
    type Triangle = ();
    type Row = ();

    #[inline(always)]
    fn triangle(self, _: u32) {}

    #[inline(always)]
    fn row(self, (): (), _: usize) {}

    #[inline(always)]
    fn updated_depths(self, covered: Ints, n: F32s, _: F32s, (): (), _: Ints, old: F32s) -> F32s {
        let covered = covered | n.at_most(F32s::splat(1.0));
        covered.select_floats(n, old).greater(old)
    }
}

impl DepthTest for PictureDepthTest<'_> {
    const CLEARED: f32 = 0.0;
    type Triangle = PlaneDepths;
    /// Depth at column 0, and its change per column.
    type Row = [f32; 2];

    #[inline(always)]
    fn triangle(self, id: u32) -> PlaneDepths {
        self.plane_depths(id)
    }

    #[inline(always)]
    fn row(self, [start, per_column, per_row]: PlaneDepths, row: usize) -> [f32; 2] {
        let row = self.camera.tile_origin[1] + row as f32;
        [row.mul_add(per_row, start), per_column]
    }

    #[inline(always)]
    fn updated_depths(
        self,
        covered: Ints,
        n: F32s,
        _: F32s,
        [start, per_column]: [f32; 2],
        columns: Ints,
        old: F32s,
    ) -> F32s {
        let column = columns.floats() + F32s::splat(self.camera.tile_origin[0]);
        let exact = column.times_plus(F32s::splat(per_column), F32s::splat(start));
        // A plane that is seen edge on has a larger error than the rasterizer. Also for NaN.
        let is_near = (exact - n).abs().at_most(n * F32s::splat(1.0 / 4096.0));
        let depth = is_near.select_floats(exact, n);
        let covered = covered | n.at_most(F32s::splat(1.0));
        let depth = covered.select_floats(depth, old);
        F32s::select((old * F32s::splat(NEARER)).lt(depth), depth, old)
    }
}
