//! AOVs: quantities of surfaces, and of one light there, in place of radiance.

use light::Lanes;

use crate::lanes::{F32s, LANES, Masks, Vec3s};
use crate::layer::{LayerBlock, LayerTarget, LightVisitor, draw_light, is_lit, touches};
use crate::pixel_block::{BLOCK_SIDE, PixelBlock};
use crate::shape::RelitShape;
use crate::simd::{self, SimdTask};
use crate::surfaces::surface_of;
use crate::{Cancelled, CasterScene, DrawnLight, Surfaces, Workers};

/// Number of blocks that a worker evaluates at once.
const BLOCKS_PER_CHUNK: usize = 64;

/// Quantity of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceAov {
    /// Distance along the view axis.
    Depth,
    /// Unit shading normal in scene axes, towards the viewer.
    Normal,
}

/// Quantity of a light at a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightAov {
    /// Position along the light.
    T,
    /// Position across the light: v in red, w in green.
    Vw,
    /// Unit vector in scene axes from the surface towards the arriving light.
    Direction,
    /// Share of the light that no caster blocks: 1 if lit, 0 in shadow.
    Visibility,
}

/// Adds `weight` times `aov` of `surfaces` to `radiance`, and `weight` to alpha where there is a surface. `radiance` has
/// rows from the top without gaps.
pub fn add_surface_aov(surfaces: &Surfaces, aov: SurfaceAov, weight: f32, radiance: &mut [[f32; 4]]) {
    add_values(surfaces, weight, radiance, |index| {
        let surface = surface_of(&surfaces.camera, &surfaces.blocks[index]);
        let value = match aov {
            SurfaceAov::Depth => Vec3s { x: surface.depth, y: surface.depth, z: surface.depth },
            SurfaceAov::Normal => surface.normal,
        };
        (value, surface.exists)
    });
}

/// Adds `weight` times `aov` of a light to `radiance`, and `weight` to alpha where the light's volume holds the surface.
/// `radiance` has rows from the top without gaps.
pub fn add_light_aov(
    workers: &Workers,
    surfaces: &Surfaces,
    scene: &CasterScene,
    drawn: DrawnLight,
    aov: LightAov,
    weight: f32,
    radiance: &mut [[f32; 4]],
) -> Result<(), Cancelled> {
    let mut texels = vec![LayerBlock::NOTHING; surfaces.blocks.len()];
    if aov == LightAov::Visibility {
        draw_light(workers, surfaces, scene, drawn, LayerTarget::Visibility(&mut texels))?;
    } else {
        drawn.light.visit(DrawCoords { workers, surfaces, scene, drawn, aov, texels: &mut texels })?;
    }
    add_values(surfaces, weight, radiance, |index| {
        let LayerBlock { diffuse, specular } = texels[index];
        (diffuse, specular.x.gt(F32s::ZERO))
    });
    Ok(())
}

/// Adds `weight` times the values that `of_block` returns to the pixels of its mask.
fn add_values(surfaces: &Surfaces, weight: f32, radiance: &mut [[f32; 4]], of_block: impl Fn(usize) -> (Vec3s, Masks)) {
    let width = surfaces.size()[0] as usize;
    for (index, block) in surfaces.blocks.iter().enumerate() {
        let (value, inside) = of_block(index);
        for i in (0..LANES).filter(|i| inside.lane(*i)) {
            let [x, y] = [i % BLOCK_SIDE, i / BLOCK_SIDE];
            let at = (usize::from(block.corner[1]) + y) * width + usize::from(block.corner[0]) + x;
            let [r, g, b, alpha] = &mut radiance[at];
            *r += weight * value.x.0[i];
            *g += weight * value.y.0[i];
            *b += weight * value.z.0[i];
            *alpha += weight;
        }
    }
}

struct DrawCoords<'a> {
    workers: &'a Workers,
    surfaces: &'a Surfaces,
    scene: &'a CasterScene<'a>,
    drawn: DrawnLight<'a>,
    aov: LightAov,
    texels: &'a mut [LayerBlock],
}

impl LightVisitor for DrawCoords<'_> {
    type Output = Result<(), Cancelled>;

    fn visit<S: RelitShape>(self, shape: &S) -> Result<(), Cancelled> {
        let Self { workers, surfaces, scene, drawn, aov, texels } = self;
        let chunks = texels.chunks_mut(BLOCKS_PER_CHUNK).zip(surfaces.blocks.chunks(BLOCKS_PER_CHUNK));
        workers.each(chunks, |(texels, blocks)| {
            simd::run(CoordsChunk { shape, surfaces, scene, pixels: drawn.pixels, aov, blocks, texels });
            true
        })
    }
}

struct CoordsChunk<'a, S> {
    shape: &'a S,
    surfaces: &'a Surfaces,
    scene: &'a CasterScene<'a>,
    pixels: [u32; 4],
    aov: LightAov,
    blocks: &'a [PixelBlock],
    texels: &'a mut [LayerBlock],
}

impl<S: RelitShape> SimdTask for CoordsChunk<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { shape, surfaces, scene, pixels, aov, blocks, texels } = self;
        let (zero, one) = (F32s::ZERO, F32s::splat(1.0));
        for (block, texel) in blocks.iter().zip(texels) {
            if !touches(block.corner, pixels) {
                continue;
            }
            let surface = surface_of(&surfaces.camera, block);
            let coords = shape.coords(&surface, is_lit(scene, &surface));
            let value = match aov {
                LightAov::T | LightAov::Visibility => Vec3s { x: coords.t, y: coords.t, z: coords.t },
                LightAov::Vw => Vec3s { x: coords.v, y: coords.w, z: zero },
                LightAov::Direction => coords.direction,
            };
            let inside = F32s::select(coords.inside, one, zero);
            *texel = LayerBlock { diffuse: value, specular: Vec3s { x: inside, y: inside, z: inside } };
        }
    }
}
