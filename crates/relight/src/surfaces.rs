//! Surfaces that pixels show, made once a camera or scene change: blocks of four by four pixels, without background.

use std::ops::Range;

use light::Lanes;
#[cfg(test)]
use light::Mask;

use crate::attributes::{SurfaceScene, block_of};
use crate::encoding::unit_from_bits;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::pixel_block::{BLOCK_SIDE, CameraRays, PixelBlock, rays};
use crate::raster::VisibilityBuffer;
use crate::simd::{self, SimdTask};
use crate::{Cancelled, Workers};

/// All blocks that show a surface, in rows from the top.
#[derive(Debug, Default)]
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
    /// Replaces the surfaces by the triangles of `scene` that pixels show. Reuses their memory. After an error the
    /// surfaces have no meaning.
    pub fn update(
        &mut self,
        workers: &Workers,
        scene: &SurfaceScene,
        camera: CameraRays,
        fill: FillColors,
        visible: &VisibilityBuffer,
    ) -> Result<(), Cancelled> {
        self.size = visible.size().map(|side| side as u32);
        self.camera = camera;
        self.row_starts.clear();
        self.row_starts.resize(visible.size()[1].div_ceil(BLOCK_SIDE) + 1, 0);
        workers.each(self.row_starts[1..].iter_mut().enumerate(), |(row, count)| {
            **count = columns(visible).filter(|column| visible.is_block_seen(corner(*column, *row))).count();
            true
        })?;
        for row in 1..self.row_starts.len() {
            self.row_starts[row] += self.row_starts[row - 1];
        }
        let (most, count) = (Self::max_blocks(self.size), self.row_starts.last().copied().unwrap_or(0));
        // For all cameras at once, or memory would move whenever one shows more than those before.
        self.blocks.reserve_exact(most.saturating_sub(self.blocks.len()));
        self.fill.reserve_exact(most.saturating_sub(self.fill.len()));
        workers.resize(&mut self.blocks, count, PixelBlock::NOTHING)?;
        workers.resize(&mut self.fill, count, Vec3s::splat([0.0; 3]))?;
        let (mut blocks, mut filled, mut rows) = (&mut self.blocks[..], &mut self.fill[..], Vec::new());
        for (row, ends) in self.row_starts.windows(2).enumerate() {
            let ((row_blocks, other_blocks), (row_filled, other_filled)) =
                (blocks.split_at_mut(ends[1] - ends[0]), filled.split_at_mut(ends[1] - ends[0]));
            (blocks, filled) = (other_blocks, other_filled);
            rows.push((row, row_blocks, row_filled));
        }
        workers.each(rows.into_iter(), |(row, blocks, filled)| {
            let seen = columns(visible).filter_map(|column| block_of(scene, &camera, visible, corner(column, *row)));
            for ((block, filled), seen) in blocks.iter_mut().zip(filled.iter_mut()).zip(seen) {
                *block = seen;
                *filled = simd::run(ReflectFill { camera: &camera, fill: &fill, block });
            }
            true
        })
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
    let (origin, direction) = rays(camera, block.corner, [0.0; 2]);
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

/// Returns the columns of blocks of a picture.
fn columns(visible: &VisibilityBuffer) -> Range<usize> {
    0..visible.size()[0].div_ceil(BLOCK_SIDE)
}

/// Returns the coordinates of the top left pixel of a block.
fn corner(column: usize, row: usize) -> [u16; 2] {
    [column, row].map(|index| (BLOCK_SIDE * index) as u16)
}

struct ReflectFill<'a> {
    camera: &'a CameraRays,
    fill: &'a FillColors,
    block: &'a PixelBlock,
}

impl SimdTask for ReflectFill<'_> {
    type Output = Vec3s;

    #[inline(always)]
    fn run(self) -> Vec3s {
        self.fill.reflected_by(&surface_of(self.camera, self.block))
    }
}
