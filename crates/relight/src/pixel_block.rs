//! Blocks of four by four pixels, and the rays through them.

use crate::lanes::{F32s, LANES, U32s, Vec3s};

/// Pixels along each side of a block.
pub(crate) const BLOCK_SIDE: usize = 4;

/// Camera rays, as in `view.wgsl`. The sample of pixel (x, y) of the picture lies on a ray with the origin `origin + x
/// origin_dx + y origin_dy` and likewise the direction, which advances one unit along the view axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraRays {
    /// Origin of the first pixel's ray.
    pub origin: [f32; 3],
    /// Change of the origin to the next pixel to the right.
    pub origin_dx: [f32; 3],
    /// Change of the origin to the next pixel below.
    pub origin_dy: [f32; 3],
    /// Direction of the first pixel's ray.
    pub direction: [f32; 3],
    /// Change of the direction to the next pixel to the right.
    pub direction_dx: [f32; 3],
    /// Change of the direction to the next pixel below.
    pub direction_dy: [f32; 3],
    /// Coefficients c of the distance along the view axis, `(c.x + c.y z) / (c.z + c.w z)`, for the z of the depth
    /// buffer.
    pub depth_from_z: [f32; 4],
    /// Position in the picture of the G-buffer's first pixel, in whole pixels. If both are multiples of 4, the blocks
    /// of a tile are those of the picture, and the tile is bit-identical to the picture.
    pub tile_origin: [f32; 2],
}

/// Sixteen adjacent pixels, 4 by 4.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelBlock {
    /// Distance along the view axis.
    pub depth: F32s,
    /// Shading normal, encoded as in the G-buffer.
    pub normal: U32s,
    /// Normal of the triangle, towards the viewer.
    pub geometric_normal: Vec3s,
    /// Packed as in the G-buffer.
    pub material: [U32s; 2],
    pub terminator_offset: F32s,
    /// Index of the triangle + 1; 0 without a surface.
    pub triangle: U32s,
    /// Coordinates of the block's top left pixel.
    pub corner: [u16; 2],
}

impl PixelBlock {
    pub const NOTHING: Self = {
        let (zero, none) = (F32s([0.0; LANES]), U32s([0; LANES]));
        let nowhere = Vec3s { x: zero, y: zero, z: zero };
        Self {
            depth: zero,
            normal: none,
            geometric_normal: nowhere,
            material: [none; 2],
            terminator_offset: zero,
            triangle: none,
            corner: [0; 2],
        }
    };
}

/// Computes the origins and directions of the rays of a block's pixels, or of points `step` pixels to the right and down
/// of them.
#[inline(always)]
pub(crate) fn rays(camera: &CameraRays, [left, top]: [u16; 2], step: [f32; 2]) -> (Vec3s, Vec3s) {
    let (mut x, mut y) = (F32s::splat(0.0), F32s::splat(0.0));
    // Whole numbers, and exact.
    let (left, top) =
        (camera.tile_origin[0] + f32::from(left) + step[0], camera.tile_origin[1] + f32::from(top) + step[1]);
    for i in 0..LANES {
        x.0[i] = left + (i % BLOCK_SIDE) as f32;
        y.0[i] = top + (i / BLOCK_SIDE) as f32;
    }
    (
        along(camera.origin, camera.origin_dx, x, camera.origin_dy, y),
        along(camera.direction, camera.direction_dx, x, camera.direction_dy, y),
    )
}

#[inline(always)]
fn along(base: [f32; 3], dx: [f32; 3], x: F32s, dy: [f32; 3], y: F32s) -> Vec3s {
    Vec3s::splat(base) + Vec3s::splat(dx) * x + Vec3s::splat(dy) * y
}
