//! Layers: the contribution of one light to each pixel.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::brdf::evaluate_brdf;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, LANES, Masks, Vec3s};
use crate::pixel_block::{BLOCK_SIDE, PixelBlock};
use crate::shape::{LightSampleLanes, RelitShape};
use crate::simd::{self, SimdTask};
use crate::surfaces::{SurfaceLanes, surface_of};
use crate::{Cancelled, CasterScene, RelitBent, RelitDirectional, RelitOmni, RelitSpot, Surfaces, Workers};
use light::{Lanes, LightProfile, Mask};

/// Number of blocks that a worker draws at once. They take about a quarter of a millisecond.
const BLOCKS_PER_CHUNK: usize = 64;
/// Number of blocks that a worker adds to a sum at once: 12 KiB of the sum, which stay in the nearest cache.
const SUM_BLOCKS_PER_CHUNK: usize = 32;

/// Light as it is drawn, by shape.
#[derive(Debug)]
pub enum RelitLight {
    /// BendyLight.
    Bent(Box<RelitBent>),
    Spot(Box<RelitSpot>),
    Omni(Box<RelitOmni>),
    Directional(Box<RelitDirectional>),
}

/// Light to draw.
#[derive(Clone, Copy, Debug)]
pub struct DrawnLight<'a> {
    pub light: &'a RelitLight,
    /// Shadow map of the light, `None` for a light without shadows.
    pub map: Option<&'a DepthMap>,
    /// Pixels that are drawn, `[x, y, width, height]`.
    pub pixels: [u32; 4],
}

/// Diffuse and specular radiance of one light, for each block of surfaces. It is linear, and is not yet multiplied by
/// the factors that apply to the whole layer.
#[derive(Clone, Debug, Default)]
pub struct LightLayer(pub(crate) Vec<LayerBlock>);

/// Diffuse and specular radiance of sixteen pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerBlock {
    pub diffuse: Vec3s,
    pub specular: Vec3s,
}

impl LayerBlock {
    pub const NOTHING: Self = {
        let zero = F32s([0.0; LANES]);
        let nothing = Vec3s { x: zero, y: zero, z: zero };
        Self { diffuse: nothing, specular: nothing }
    };

    /// Computes the radiance towards the viewer, with linear RGB factors of the diffuse and the specular part.
    #[inline(always)]
    pub fn weighted_sum(&self, [diffuse, specular]: [[f32; 3]; 2]) -> Vec3s {
        Vec3s::splat(diffuse) * self.diffuse + Vec3s::splat(specular) * self.specular
    }
}

/// Destination of a light's contribution, with an entry for each block of the surfaces.
pub(crate) enum LayerTarget<'a> {
    /// Stores the contribution.
    Layer(&'a mut [LayerBlock]),
    /// Adds the contribution to a sum, with factors of the diffuse and the specular part.
    Sum(&'a mut [Vec3s], [[f32; 3]; 2]),
    /// Stores the visibility of the light in place of the diffuse part, and 1 within the light in place of the specular
    /// part.
    Visibility(&'a mut [LayerBlock]),
}

impl LightLayer {
    /// Computes the size in bytes of a layer of so many blocks of surfaces.
    pub fn bytes(block_count: usize) -> u64 {
        (block_count * size_of::<LayerBlock>()) as u64
    }
}

/// Draws the layer of `light` within its pixels, and clears it elsewhere. Returns the number of pixels that it
/// examined.
pub fn draw_layer(
    workers: &Workers,
    surfaces: &Surfaces,
    scene: &CasterScene,
    light: DrawnLight,
    LightLayer(texels): &mut LightLayer,
) -> Result<u64, Cancelled> {
    workers.resize(texels, surfaces.blocks.len(), LayerBlock::NOTHING)?;
    draw_light(workers, surfaces, scene, light, LayerTarget::Layer(texels))
}

/// Work on a light of any shape.
pub(crate) trait LightVisitor {
    type Output;
    fn visit<S: RelitShape>(self, shape: &S) -> Self::Output;
}

impl RelitLight {
    /// Does work on the light's shape.
    pub(crate) fn visit<V: LightVisitor>(&self, visitor: V) -> V::Output {
        match self {
            Self::Bent(bent) => visitor.visit(&**bent),
            Self::Spot(spot) => visitor.visit(&**spot),
            Self::Omni(omni) => visitor.visit(&**omni),
            Self::Directional(sun) => visitor.visit(&**sun),
        }
    }
}

/// Draws `light` as [`draw_layer`] does. `onto` has an entry for each block of the surfaces.
pub(crate) fn draw_light(
    workers: &Workers,
    surfaces: &Surfaces,
    scene: &CasterScene,
    drawn: DrawnLight,
    onto: LayerTarget,
) -> Result<u64, Cancelled> {
    drawn.light.visit(DrawLight { workers, surfaces, scene, drawn, onto })
}

struct DrawLight<'a> {
    workers: &'a Workers,
    surfaces: &'a Surfaces,
    scene: &'a CasterScene<'a>,
    drawn: DrawnLight<'a>,
    onto: LayerTarget<'a>,
}

impl LightVisitor for DrawLight<'_> {
    type Output = Result<u64, Cancelled>;

    fn visit<S: RelitShape>(self, shape: &S) -> Result<u64, Cancelled> {
        let Self { workers, surfaces, scene, drawn, onto } = self;
        draw(workers, surfaces, scene, shape, drawn, onto)
    }
}

fn draw<S: RelitShape>(
    workers: &Workers,
    surfaces: &Surfaces,
    scene: &CasterScene,
    shape: &S,
    DrawnLight { map, pixels, .. }: DrawnLight,
    onto: LayerTarget,
) -> Result<u64, Cancelled> {
    let shows_visibility = matches!(onto, LayerTarget::Visibility(_));
    let examined = AtomicU64::new(0);
    let draw_chunk = |blocks: &[PixelBlock], texels: &mut [LayerBlock]| {
        let pixels = simd::run(DrawChunk { shape, surfaces, scene, map, pixels, shows_visibility, blocks, texels });
        examined.fetch_add(pixels, Ordering::Relaxed);
    };
    // Some chunks cost twenty times as much as others.
    match onto {
        LayerTarget::Layer(texels) | LayerTarget::Visibility(texels) => {
            let chunks = texels.chunks_mut(BLOCKS_PER_CHUNK).zip(surfaces.blocks.chunks(BLOCKS_PER_CHUNK));
            workers.each(chunks, |(texels, blocks)| {
                draw_chunk(blocks, texels);
                true
            })?;
        }
        LayerTarget::Sum(sums, factors) => {
            let chunks = sums.chunks_mut(SUM_BLOCKS_PER_CHUNK).zip(surfaces.blocks.chunks(SUM_BLOCKS_PER_CHUNK));
            workers.each(chunks, |(sums, blocks)| {
                let mut texels = [LayerBlock::NOTHING; SUM_BLOCKS_PER_CHUNK];
                let texels = &mut texels[..blocks.len()];
                draw_chunk(blocks, texels);
                simd::run(AddBlocks { texels, factors, sums });
                true
            })?;
        }
    }
    Ok(examined.into_inner())
}

struct AddBlocks<'a> {
    texels: &'a [LayerBlock],
    factors: [[f32; 3]; 2],
    sums: &'a mut [Vec3s],
}

impl SimdTask for AddBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (texel, sum) in self.texels.iter().zip(self.sums) {
            *sum = *sum + texel.weighted_sum(self.factors);
        }
    }
}

struct DrawChunk<'a, S> {
    shape: &'a S,
    surfaces: &'a Surfaces,
    scene: &'a CasterScene<'a>,
    map: Option<&'a DepthMap>,
    pixels: [u32; 4],
    shows_visibility: bool,
    blocks: &'a [PixelBlock],
    texels: &'a mut [LayerBlock],
}

impl<S: RelitShape> SimdTask for DrawChunk<'_, S> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let Self { shape, surfaces, scene, map, pixels, shows_visibility, blocks, texels } = self;
        let mut examined = 0;
        for (block, texel) in blocks.iter().zip(texels) {
            *texel = LayerBlock::NOTHING;
            if !touches(block.corner, pixels) {
                continue;
            }
            examined += LANES as u64;
            let surface = surface_of(&surfaces.camera, block);
            let sample = shape.sample(scene, map, &surface, is_lit(scene, &surface));
            if sample.inside.any() {
                *texel = if shows_visibility {
                    visibility(&sample)
                } else {
                    reflection(shape.light_profile(), &surface, &sample)
                };
            }
        }
        examined
    }
}

/// True if a block contains any of `pixels`.
#[inline(always)]
pub(crate) fn touches(corner: [u16; 2], [x, y, width, height]: [u32; 4]) -> bool {
    let [left, top] = corner.map(u32::from);
    left + BLOCK_SIDE as u32 > x && left < x + width && top + BLOCK_SIDE as u32 > y && top < y + height
}

/// Returns the lanes whose surfaces exist and which the light's links let it illuminate.
#[inline(always)]
pub(crate) fn is_lit(scene: &CasterScene, surface: &SurfaceLanes) -> Masks {
    if scene.links.bits.is_none() {
        return surface.exists;
    }
    let mut lit = Masks::ZERO;
    for i in 0..LANES {
        let triangle = surface.triangle.0[i];
        if triangle != 0 && scene.links.is_light_linked(triangle - 1) {
            lit.0[i] = u32::MAX;
        }
    }
    lit
}

#[inline(always)]
fn visibility(sample: &LightSampleLanes) -> LayerBlock {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let visible = F32s::select(sample.inside, sample.visibility, zero);
    let inside = F32s::select(sample.inside, one, zero);
    LayerBlock { diffuse: F32s::vec3([visible, visible, visible]), specular: F32s::vec3([inside, inside, inside]) }
}

#[inline(always)]
fn reflection(profile: &LightProfile, surface: &SurfaceLanes, sample: &LightSampleLanes) -> LayerBlock {
    let shadow = Vec3s::splat(profile.shadow_color.min(glam::DVec3::splat(1e30)).as_vec3().to_array());
    let white = Vec3s::splat([1.0; 3]);
    let arriving = sample.irradiance * (shadow * (F32s::splat(1.0) - sample.visibility) + white * sample.visibility);
    let lobes = evaluate_brdf(surface, sample.direction);
    let nothing = Vec3s::splat([0.0; 3]);
    LayerBlock {
        diffuse: F32s::select_vec(sample.inside, lobes.diffuse * arriving, nothing),
        specular: F32s::select_vec(sample.inside, lobes.specular * arriving, nothing),
    }
}
