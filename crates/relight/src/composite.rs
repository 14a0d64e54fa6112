//! Weighted sums of light layers, added in order, for a screen or into the samples of pixels.

use rayon::prelude::*;

use crate::lanes::{F32s, LANES, U32s, Vec3s};
use crate::layer::{DrawnLight, LayerTarget, LightLayer, draw_light};
use crate::pixel_block::BLOCK_SIDE;
use crate::screen::{BLACK, BYTES_PER_PIXEL, Exposure, tone_mapped_rgba8};
use crate::simd::{self, SimdTask};
use crate::{Cancelled, CasterScene, Surfaces, Workers};

/// Number of blocks that a worker adds up at once.
const BLOCKS_PER_CHUNK: usize = 256;

/// Layer with the linear RGB factors of its diffuse and specular part.
#[derive(Clone, Copy, Debug)]
pub struct LayerTerm<'a> {
    /// Layer of the same surfaces as the other terms.
    pub layer: &'a LightLayer,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
}

/// Layers or sums to add up, all of the same surfaces. Without any the sum is black.
#[derive(Clone, Copy, Debug)]
pub enum LayerTerms<'a> {
    Layers(&'a [LayerTerm<'a>]),
    /// Sums, each with factor 1.
    Sums(&'a [&'a LayerSum]),
}

/// Linear radiance of each block of surfaces under some lights together.
#[derive(Clone, Debug, Default)]
pub struct LayerSum(Vec<Vec3s>);

impl LayerSum {
    /// Returns the number of blocks of surfaces.
    pub fn block_count(&self) -> usize {
        self.0.len()
    }

    /// Computes the size in bytes of a sum over so many blocks of surfaces.
    pub fn bytes(block_count: usize) -> u64 {
        (block_count * size_of::<Vec3s>()) as u64
    }
}

impl LayerTerms<'_> {
    /// Adds the terms on one block.
    #[inline(always)]
    fn sum_on(&self, block: usize) -> Vec3s {
        let mut total = Vec3s::splat([0.0; 3]);
        match self {
            Self::Layers(terms) => {
                for term in *terms {
                    let texel = &term.layer.0[block];
                    total = total + texel.weighted_sum([term.diffuse, term.specular]);
                }
            }
            Self::Sums(sums) => {
                for sum in *sums {
                    total = total + sum.0[block];
                }
            }
        }
        total
    }
}

/// Adds up `terms`, whose layers or sums are of `surfaces`, and stores the result in `into`.
pub fn sum(workers: &Workers, surfaces: &Surfaces, terms: LayerTerms, LayerSum(into): &mut LayerSum) {
    into.resize(surfaces.block_count(), Vec3s::splat([0.0; 3]));
    workers.run(|| {
        into.par_chunks_mut(BLOCKS_PER_CHUNK).enumerate().for_each(|(chunk, into)| {
            simd::run(AddTerms { terms, first: chunk * BLOCKS_PER_CHUNK, into });
        });
    });
}

/// Adds the contribution of `light` to `into`, with factors of its diffuse and specular part. The result is
/// bit-identical to drawing its layer and adding that as the last term. `into` is of the same surfaces.
pub fn add_light(
    workers: &Workers,
    surfaces: &Surfaces,
    scene: &CasterScene,
    light: DrawnLight,
    factors: [[f32; 3]; 2],
    LayerSum(into): &mut LayerSum,
) -> Result<u64, Cancelled> {
    draw_light(workers, surfaces, scene, light, LayerTarget::Sum(into, factors))
}

struct AddTerms<'a> {
    terms: LayerTerms<'a>,
    first: usize,
    into: &'a mut [Vec3s],
}

impl SimdTask for AddTerms<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (block, into) in (self.first..).zip(self.into) {
            *into = self.terms.sum_on(block);
        }
    }
}

/// Adds one sample of each pixel to `radiance`, linear RGBA, rows from the top without gaps. It adds `terms` and
/// `fill_factor` times the fill, both times `weight`, and `weight` to alpha where there is a surface.
///
/// A sample of weight 1 added to zeros is bit-identical to the radiance that [`display`] shows.
pub fn add_sample(
    workers: &Workers,
    surfaces: &Surfaces,
    terms: LayerTerms,
    fill_factor: f32,
    weight: f32,
    radiance: &mut [[f32; 4]],
) {
    let width = surfaces.size()[0] as usize;
    workers.run(|| {
        radiance.par_chunks_mut(BLOCK_SIDE * width).enumerate().for_each(|(row, pixels)| {
            simd::run(AddSample { surfaces, terms, fill_factor, weight, row, width, pixels });
        });
    });
}

struct AddSample<'a> {
    surfaces: &'a Surfaces,
    terms: LayerTerms<'a>,
    fill_factor: f32,
    weight: f32,
    row: usize,
    width: usize,
    pixels: &'a mut [[f32; 4]],
}

impl SimdTask for AddSample<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { surfaces, terms, fill_factor, weight, row, width, pixels } = self;
        for index in surfaces.row_starts[row]..surfaces.row_starts[row + 1] {
            let radiance = total_radiance(surfaces, &terms, fill_factor, index) * F32s::splat(weight);
            let block = &surfaces.blocks[index];
            for i in 0..LANES {
                let at = i / BLOCK_SIDE * width + block.corner[0] as usize + i % BLOCK_SIDE;
                if block.triangle.0[i] != 0
                    && let Some([r, g, b, alpha]) = pixels.get_mut(at)
                {
                    *r += radiance.x.0[i];
                    *g += radiance.y.0[i];
                    *b += radiance.z.0[i];
                    *alpha += weight;
                }
            }
        }
    }
}

/// Computes the sum of the fill light and `terms` on one block.
#[inline(always)]
fn total_radiance(surfaces: &Surfaces, terms: &LayerTerms, fill_factor: f32, block: usize) -> Vec3s {
    surfaces.fill[block] * F32s::splat(fill_factor) + terms.sum_on(block)
}

/// Renders `terms` and `fill_factor` times the fill for a screen: exposed, tone-mapped, sRGB, RGBA of 8 bits a channel,
/// rows from the top.
pub fn display(
    workers: &Workers,
    surfaces: &Surfaces,
    terms: LayerTerms,
    fill_factor: f32,
    exposure: Exposure,
) -> Vec<u8> {
    let [width, height] = surfaces.size().map(|side| side as usize);
    let mut bytes = vec![0; BYTES_PER_PIXEL * width * height];
    workers.run(|| {
        bytes.par_chunks_mut(BYTES_PER_PIXEL * BLOCK_SIDE * width).enumerate().for_each(|(row, bytes)| {
            simd::run(Display { surfaces, terms, fill_factor, exposure, row, width, bytes });
        });
    });
    bytes
}

struct Display<'a> {
    surfaces: &'a Surfaces,
    terms: LayerTerms<'a>,
    fill_factor: f32,
    exposure: Exposure,
    row: usize,
    width: usize,
    bytes: &'a mut [u8],
}

impl SimdTask for Display<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { surfaces, terms, fill_factor, exposure, row, width, bytes } = self;
        let pixels = bytes.as_chunks_mut::<BYTES_PER_PIXEL>().0;
        // The background is black.
        pixels.fill(BLACK.0[0].to_le_bytes());
        for index in surfaces.row_starts[row]..surfaces.row_starts[row + 1] {
            let radiance = total_radiance(surfaces, &terms, fill_factor, index);
            let block = &surfaces.blocks[index];
            let seen = !block.triangle.equals(U32s::splat(0));
            let shown = U32s::select(seen, tone_mapped_rgba8(radiance, exposure), BLACK);
            let x = block.corner[0] as usize;
            let columns = BLOCK_SIDE.min(width - x);
            for (row, shown) in pixels.chunks_mut(width).zip(shown.0.as_chunks::<BLOCK_SIDE>().0) {
                for (pixel, shown) in row[x..x + columns].iter_mut().zip(shown) {
                    *pixel = shown.to_le_bytes();
                }
            }
        }
    }
}
