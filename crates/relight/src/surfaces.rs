//! Surfaces that pixels show, made from a G-buffer once a camera or scene change: blocks of four by four pixels,
//! without background.

use light::{Lanes, Mask};

use crate::encoding::unit_from_bits;
use crate::lanes::{F32s, LANES, Masks, U32s, Vec3s};
use crate::simd::{self, SimdTask};
use crate::{Cancelled, CasterScene, Workers};

/// Pixels along each side of a block.
pub(crate) const BLOCK_SIDE: usize = 4;

/// Camera rays, as in `view.wgsl`. The sample of pixel (x, y) of the picture lies on a ray with the origin `origin + x
/// origin_dx + y origin_dy` and likewise the direction, which advances one unit along the view axis.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// G-buffer as it was read back, rows from the top.
#[derive(Clone, Copy, Debug)]
pub struct GbufferRows<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Number of texels from one row to the next, at least the width.
    pub row_stride: usize,
    /// Packed texels: the shading normal, the index of the triangle + 1, and the material. `gbuffer.wgsl` has the
    /// format.
    pub packed: &'a [[u32; 4]],
    /// Depth buffer.
    pub z: &'a [f32],
    /// Distance in front of the surface at which its shadow is tested.
    pub terminator_offset: &'a [f32],
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

/// All blocks that show a surface, in rows from the top.
#[derive(Debug)]
pub struct Surfaces {
    size: [u32; 2],
    pub(crate) camera: CameraRays,
    pub(crate) blocks: Vec<PixelBlock>,
    /// Reflected radiance of the whole fill light, for each block.
    pub(crate) fill: Vec<Vec3s>,
    /// Index of the first block in each row of blocks, followed by the number of all blocks.
    pub(crate) row_starts: Vec<usize>,
}

/// Surfaces of sixteen pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceLanes {
    /// Lanes that show a surface. The values of the other lanes have no meaning.
    pub exists: Masks,
    /// Position in scene space.
    pub position: Vec3s,
    pub depth: F32s,
    pub geometric_normal: Vec3s,
    /// Unit shading normal.
    pub normal: Vec3s,
    pub terminator_offset: F32s,
    /// Index of the triangle + 1.
    pub triangle: U32s,
    /// Unit vector towards the viewer.
    pub to_eye: Vec3s,
    /// Linear RGB base color.
    pub base_color: Vec3s,
    pub metallic: F32s,
    /// Perceptual: the GGX alpha is its square.
    pub roughness: F32s,
}

#[cfg(test)]
impl SurfaceLanes {
    /// White and rough surfaces with this normal, seen from straight above, as a base for tests.
    pub fn facing(normal: Vec3s) -> Self {
        Self {
            exists: Masks::of(true),
            position: Vec3s::splat([0.0; 3]),
            depth: F32s::splat(1.0),
            geometric_normal: normal,
            normal,
            terminator_offset: F32s::ZERO,
            triangle: U32s::splat(1),
            to_eye: normal,
            base_color: Vec3s::splat([1.0; 3]),
            metallic: F32s::ZERO,
            roughness: F32s::splat(1.0),
        }
    }
}

impl Surfaces {
    /// Makes the surfaces of a G-buffer of `scene`.
    pub fn new(
        workers: &Workers,
        scene: &CasterScene,
        camera: CameraRays,
        fill: FillColors,
        gbuffer: &GbufferRows,
    ) -> Result<Self, Cancelled> {
        let height_in_blocks = (gbuffer.size[1] as usize).div_ceil(BLOCK_SIDE);
        let mut rows = Vec::new();
        rows.resize_with(height_in_blocks, Default::default);
        workers.each(rows.iter_mut().enumerate(), |(row, into)| {
            **into = simd::run(RowOfBlocks { scene, camera: &camera, fill: &fill, gbuffer, row: *row });
            true
        })?;
        let count = rows.iter().map(|(blocks, _)| blocks.len()).sum();
        let (blocks, fill) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut surfaces = Self { size: gbuffer.size, camera, blocks, fill, row_starts: vec![0] };
        for (blocks, fill) in rows {
            surfaces.blocks.extend(blocks);
            surfaces.fill.extend(fill);
            surfaces.row_starts.push(surfaces.blocks.len());
            // The operating system is slow to provide new memory.
            workers.yielding.yield_point()?;
        }
        Ok(surfaces)
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the number of blocks of sixteen pixels that show a surface.
    pub fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// Returns the size of the contents in bytes.
    pub fn bytes(&self) -> u64 {
        Self::bytes_of(self.block_count())
    }

    /// Returns the largest number of blocks of a picture of this size.
    pub fn max_blocks(size: [u32; 2]) -> usize {
        size.map(|side| (side as usize).div_ceil(BLOCK_SIDE)).iter().product()
    }

    /// Computes the size in bytes for so many blocks.
    pub fn bytes_of(block_count: usize) -> u64 {
        (block_count * (size_of::<PixelBlock>() + size_of::<Vec3s>())) as u64
    }
}

/// Unpacks the surfaces that a block's pixels show.
#[inline(always)]
pub(crate) fn surface_of(camera: &CameraRays, block: &PixelBlock) -> SurfaceLanes {
    let (origin, direction) = rays(camera, block.corner);
    let (base_color, metallic, roughness) = crate::encoding::material_from_bits(block.material);
    let length = F32s::length(direction);
    SurfaceLanes {
        exists: !block.triangle.equals(U32s::splat(0)),
        position: origin + direction * block.depth,
        depth: block.depth,
        geometric_normal: block.geometric_normal,
        normal: unit_from_bits(block.normal),
        terminator_offset: block.terminator_offset,
        triangle: block.triangle,
        to_eye: direction * (F32s::splat(-1.0) / length),
        base_color,
        metallic,
        roughness,
    }
}

/// Fill light from all directions: a hemisphere that goes from `ground` to `sky` with the height of a direction; linear
/// RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FillColors {
    /// Color from above.
    pub sky: [f32; 3],
    /// Color from below.
    pub ground: [f32; 3],
}

impl FillColors {
    #[inline(always)]
    fn hemisphere_at(&self, height: F32s) -> Vec3s {
        let share = height * F32s::splat(0.5) + F32s::splat(0.5);
        Vec3s::splat(self.ground) * (F32s::splat(1.0) - share) + Vec3s::splat(self.sky) * share
    }

    /// Computes the reflection of the fill light. Dielectrics scatter light from directions around the normal. Metals
    /// mirror light from directions around the reflected ray. Both have the base color as albedo, so a white surface
    /// reflects all of the light.
    #[inline(always)]
    fn reflected_by(&self, surface: &SurfaceLanes) -> Vec3s {
        let (one, two) = (F32s::splat(1.0), F32s::splat(2.0));
        let normal = surface.normal;
        let mirrored = two * F32s::dot(normal, surface.to_eye) * normal.y - surface.to_eye.y;
        let rough = surface.roughness;
        let diffuse = self.hemisphere_at(normal.y);
        let specular = self.hemisphere_at(mirrored * (one - rough) + normal.y * rough);
        let arriving = diffuse * (one - surface.metallic) + specular * surface.metallic;
        F32s::select_vec(surface.exists, surface.base_color * arriving, Vec3s::splat([0.0; 3]))
    }
}

/// Computes the origins and directions of the rays of a block's pixels.
#[inline(always)]
fn rays(camera: &CameraRays, [left, top]: [u16; 2]) -> (Vec3s, Vec3s) {
    let (mut x, mut y) = (F32s::splat(0.0), F32s::splat(0.0));
    // Whole numbers, and exact.
    let (left, top) = (camera.tile_origin[0] + f32::from(left), camera.tile_origin[1] + f32::from(top));
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

struct RowOfBlocks<'a> {
    scene: &'a CasterScene<'a>,
    camera: &'a CameraRays,
    fill: &'a FillColors,
    gbuffer: &'a GbufferRows<'a>,
    row: usize,
}

impl SimdTask for RowOfBlocks<'_> {
    type Output = (Vec<PixelBlock>, Vec<Vec3s>);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { scene, camera, fill, gbuffer, row } = self;
        let width = gbuffer.size[0] as usize;
        let mut blocks = Vec::with_capacity(width.div_ceil(BLOCK_SIDE));
        let mut filled = Vec::with_capacity(width.div_ceil(BLOCK_SIDE));
        for column in 0..width.div_ceil(BLOCK_SIDE) {
            let corner = [(BLOCK_SIDE * column) as u16, (BLOCK_SIDE * row) as u16];
            if let Some(block) = load_block(scene, camera, gbuffer, corner) {
                filled.push(fill.reflected_by(&surface_of(camera, &block)));
                blocks.push(block);
            }
        }
        (blocks, filled)
    }
}

/// Loads a block; `None` if it shows no surface. Finds its depths by intersection with the planes of its triangles, as
/// in `depth_on` of `view.wgsl`, and turns its geometric normals towards the viewer.
#[inline(always)]
fn load_block(scene: &CasterScene, camera: &CameraRays, gbuffer: &GbufferRows, corner: [u16; 2]) -> Option<PixelBlock> {
    let [width, height] = gbuffer.size.map(|side| side as usize);
    let (zero, none) = (F32s::splat(0.0), U32s::splat(0));
    let mut block = PixelBlock {
        depth: zero,
        normal: none,
        geometric_normal: Vec3s::splat([0.0; 3]),
        material: [none; 2],
        terminator_offset: zero,
        triangle: none,
        corner,
    };
    let (mut z, mut offset) = (zero, zero);
    for i in 0..LANES {
        let (x, y) = (corner[0] as usize + i % BLOCK_SIDE, corner[1] as usize + i / BLOCK_SIDE);
        if x >= width || y >= height {
            continue;
        }
        let pixel = y * gbuffer.row_stride + x;
        let [normal, triangle, low, high] = gbuffer.packed[pixel];
        if triangle == 0 {
            continue;
        }
        let [nx, ny, nz, plane_offset] = scene.planes[triangle as usize - 1];
        (block.geometric_normal.x.0[i], block.geometric_normal.y.0[i], block.geometric_normal.z.0[i]) = (nx, ny, nz);
        offset.0[i] = plane_offset;
        block.normal.0[i] = normal;
        block.triangle.0[i] = triangle;
        (block.material[0].0[i], block.material[1].0[i]) = (low, high);
        block.terminator_offset.0[i] = gbuffer.terminator_offset[pixel];
        z.0[i] = gbuffer.z[pixel];
    }
    if block.triangle.equals(none).all() {
        return None;
    }
    let (origin, direction) = rays(camera, corner);
    let normal = block.geometric_normal;
    let [a, b, c, d] = camera.depth_from_z;
    let [a, b, c, d] = [F32s::splat(a), F32s::splat(b), F32s::splat(c), F32s::splat(d)];
    let rough = (a + b * z) / (c + d * z);
    let closing = F32s::dot(normal, direction);
    let edge_on = closing.equals(zero);
    let exact = (offset - F32s::dot(normal, origin)) / F32s::select(edge_on, F32s::splat(1.0), closing);
    let held = exact.within(F32s::splat(0.5) * rough, F32s::splat(2.0) * rough);
    block.depth = F32s::select(edge_on, rough, held);
    block.geometric_normal = F32s::select_vec(closing.gt(zero), -normal, normal);
    Some(block)
}
