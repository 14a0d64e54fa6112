//! Layers times factors, or sums of some, added up in their order: for a screen, or to samples of pixels.

use rayon::prelude::*;

use crate::depth_map::DepthMap;
use crate::lanes::{F32s, LANES, U32s, Vec3s};
use crate::layer::{Layer, Light, Onto, draw_light};
use crate::screen::{BLACK, BYTES_A_PIXEL, Exposure, shown};
use crate::simd::{self, Work};
use crate::surfaces::{Block, SIDE};
use crate::{Cancelled, Scene, Surfaces, Workers};

/// Blocks that a thread adds up at once.
const BLOCKS_A_TURN: usize = 256;

/// A layer and the factors of what it scatters and mirrors: linear RGB.
#[derive(Clone, Copy, Debug)]
pub struct Term<'a> {
    /// Of the same surfaces as its neighbours.
    pub layer: &'a Layer,
    /// Factor of what is scattered.
    pub diffuse: [f32; 3],
    /// Factor of what is mirrored.
    pub specular: [f32; 3],
}

/// What adds up to a picture, or to a sum, of the same surfaces; nothing where there is none.
#[derive(Clone, Copy, Debug)]
pub enum Terms<'a> {
    /// Layers with their factors.
    Layers(&'a [Term<'a>]),
    /// Sums as they are.
    Sums(&'a [&'a Sum]),
}

/// Linear radiance of each block of surfaces that some lights add up to.
#[derive(Clone, Debug, Default)]
pub struct Sum(Vec<Vec3s>);

impl Sum {
    /// Of how many blocks of surfaces it is.
    pub fn block_count(&self) -> usize {
        self.0.len()
    }

    /// Bytes of the sum of so many blocks of surfaces.
    pub fn bytes(block_count: usize) -> u64 {
        (block_count * size_of::<Vec3s>()) as u64
    }
}

impl Terms<'_> {
    /// What they add up to on one block.
    #[inline(always)]
    fn sum_on(&self, block: usize) -> Vec3s {
        let mut total = Vec3s::splat([0.0; 3]);
        match self {
            Self::Layers(terms) => {
                for term in *terms {
                    let texel = &term.layer.0[block];
                    total = total + texel.weighed([term.diffuse, term.specular]);
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

/// Adds up `terms` of `surfaces`.
pub fn sum(workers: &Workers, surfaces: &Surfaces, terms: Terms, Sum(into): &mut Sum) {
    into.resize(surfaces.block_count(), Vec3s::splat([0.0; 3]));
    workers.run(|| {
        into.par_chunks_mut(BLOCKS_A_TURN).enumerate().for_each(|(turn, into)| {
            simd::run(Added { terms, first: turn * BLOCKS_A_TURN, into });
        });
    });
}

/// Adds what `light` adds to `into` within `pixels`, `[x, y, width, height]`, by factors of what it scatters and of what it
/// mirrors: to the bit as its layer were drawn and added as the last term. `into` is of the same surfaces.
pub fn add_light(
    workers: &Workers,
    surfaces: &Surfaces,
    scene: &Scene,
    light: (&Light, Option<&DepthMap>),
    (pixels, factors): ([u32; 4], [[f32; 3]; 2]),
    Sum(into): &mut Sum,
) -> Result<u64, Cancelled> {
    draw_light(workers, surfaces, scene, light, pixels, Onto::Sum(into, factors))
}

struct Added<'a> {
    terms: Terms<'a>,
    first: usize,
    into: &'a mut [Vec3s],
}

impl Work for Added<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (block, into) in (self.first..).zip(self.into) {
            *into = self.terms.sum_on(block);
        }
    }
}

/// Adds one sample of each pixel to `radiance`, linear RGBA, rows from the top without gaps: `terms` and `fill_factor` times
/// the fill, both times `weight`; to alpha `weight` where there is a surface.
///
/// The sample of weight 1 that is added to zeros is to the bit what [`display`] shows.
pub fn add_sample(
    workers: &Workers,
    surfaces: &Surfaces,
    terms: Terms,
    (fill_factor, weight): (f32, f32),
    radiance: &mut [[f32; 4]],
) {
    let width = surfaces.size()[0] as usize;
    workers.run(|| {
        radiance.par_chunks_mut(SIDE * width).enumerate().for_each(|(row, pixels)| {
            simd::run(Sampled { surfaces, terms, fill_factor, weight, row, width, pixels });
        });
    });
}

struct Sampled<'a> {
    surfaces: &'a Surfaces,
    terms: Terms<'a>,
    fill_factor: f32,
    weight: f32,
    row: usize,
    width: usize,
    pixels: &'a mut [[f32; 4]],
}

impl Work for Sampled<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { surfaces, terms, fill_factor, weight, row, width, pixels } = self;
        for index in surfaces.rows[row]..surfaces.rows[row + 1] {
            let radiance = shown_radiance(surfaces, &terms, fill_factor, index) * F32s::splat(weight);
            let block = &surfaces.blocks[index];
            for i in 0..LANES {
                if let Some([r, g, b, alpha]) = place(block, i, width).and_then(|at| pixels.get_mut(at)) {
                    *r += radiance.x.0[i];
                    *g += radiance.y.0[i];
                    *b += radiance.z.0[i];
                    *alpha += weight;
                }
            }
        }
    }
}

/// What comes from no light, and what `terms` add.
#[inline(always)]
fn shown_radiance(surfaces: &Surfaces, terms: &Terms, fill_factor: f32, block: usize) -> Vec3s {
    surfaces.fill[block] * F32s::splat(fill_factor) + terms.sum_on(block)
}

/// Where one of a block's pixels lies in its row of blocks, where it sees something.
#[inline(always)]
fn place(block: &Block, lane: usize, width: usize) -> Option<usize> {
    let x = block.corner[0] as usize + lane % SIDE;
    (block.triangle.0[lane] != 0).then_some(lane / SIDE * width + x)
}

/// What a screen shows of `terms` and `fill_factor` times the fill: exposed, tone-mapped, sRGB, RGBA of 8 bits a channel, rows
/// from the top.
pub fn display(
    workers: &Workers,
    surfaces: &Surfaces,
    terms: Terms,
    (fill_factor, exposure): (f32, Exposure),
) -> Vec<u8> {
    let [width, height] = surfaces.size().map(|side| side as usize);
    let mut bytes = vec![0; BYTES_A_PIXEL * width * height];
    workers.run(|| {
        bytes.par_chunks_mut(BYTES_A_PIXEL * SIDE * width).enumerate().for_each(|(row, bytes)| {
            simd::run(Display { surfaces, terms, fill_factor, exposure, row, width, bytes });
        });
    });
    bytes
}

struct Display<'a> {
    surfaces: &'a Surfaces,
    terms: Terms<'a>,
    fill_factor: f32,
    exposure: Exposure,
    row: usize,
    width: usize,
    bytes: &'a mut [u8],
}

impl Work for Display<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { surfaces, terms, fill_factor, exposure, row, width, bytes } = self;
        let pixels = bytes.as_chunks_mut::<BYTES_A_PIXEL>().0;
        // Where nothing is seen it is black.
        pixels.fill(BLACK.0[0].to_le_bytes());
        for index in surfaces.rows[row]..surfaces.rows[row + 1] {
            let radiance = shown_radiance(surfaces, &terms, fill_factor, index);
            let block = &surfaces.blocks[index];
            let seen = !block.triangle.equals(U32s::splat(0));
            let shown = U32s::select(seen, shown(radiance, exposure), BLACK);
            let x = block.corner[0] as usize;
            let columns = SIDE.min(width - x);
            for (row, shown) in pixels.chunks_mut(width).zip(shown.0.as_chunks::<SIDE>().0) {
                for (pixel, shown) in row[x..x + columns].iter_mut().zip(shown) {
                    *pixel = shown.to_le_bytes();
                }
            }
        }
    }
}
