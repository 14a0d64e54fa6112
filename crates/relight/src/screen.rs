//! Display of linear radiance on a screen: exposed, tone-mapped, sRGB, RGBA of 8 bits a channel.

use light::{Lanes, Mask};
use rayon::prelude::*;

use crate::Workers;
use crate::elementary::pow;
use crate::lanes::{F32s, LANES, U32s, Vec3s};
use crate::simd::{self, SimdTask};

/// Bytes of a pixel on a screen: RGBA.
pub(crate) const BYTES_PER_PIXEL: usize = 4;
/// Pixels that a worker converts at once.
const PIXELS_PER_CHUNK: usize = 4096;

/// Factor and bound by which radiance is exposed for a screen.
#[derive(Clone, Copy, Debug)]
pub struct Exposure {
    /// Factor by which radiance is multiplied.
    pub factor: f32,
    /// Upper bound of radiance, so that its product with the factor stays finite.
    pub brightest: f32,
}

/// Converts `radiance`, linear RGBA, for a screen. It ignores alpha, which is only the share of a pixel that shows a
/// surface; the rest is black.
pub fn display_radiance(workers: &Workers, radiance: &[[f32; 4]], exposure: Exposure) -> Vec<u8> {
    let mut bytes = vec![0; BYTES_PER_PIXEL * radiance.len()];
    workers.run(|| {
        let chunks = bytes.par_chunks_mut(BYTES_PER_PIXEL * PIXELS_PER_CHUNK);
        let chunks = chunks.zip(radiance.par_chunks(PIXELS_PER_CHUNK));
        chunks.for_each(|(bytes, radiance)| simd::run(DisplayPixels { radiance, exposure, bytes }));
    });
    bytes
}

struct DisplayPixels<'a> {
    radiance: &'a [[f32; 4]],
    exposure: Exposure,
    bytes: &'a mut [u8],
}

impl SimdTask for DisplayPixels<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { radiance, exposure, bytes } = self;
        let pixels = bytes.as_chunks_mut::<BYTES_PER_PIXEL>().0;
        for (radiance, pixels) in radiance.chunks(LANES).zip(pixels.chunks_mut(LANES)) {
            let mut linear = Vec3s::splat([0.0; 3]);
            for (i, [r, g, b, _]) in radiance.iter().enumerate() {
                (linear.x.0[i], linear.y.0[i], linear.z.0[i]) = (*r, *g, *b);
            }
            let shown = tone_mapped_rgba8(linear, exposure);
            for (pixel, shown) in pixels.iter_mut().zip(shown.0) {
                *pixel = shown.to_le_bytes();
            }
        }
    }
}

/// Value up to which hue and color stay unchanged. Higher peaks are compressed to at most 1 and desaturated.
const START: f32 = 0.8 - 0.04;
const DESATURATION: f32 = 0.15;

/// Applies Khronos PBR Neutral, as in `display.wgsl`.
#[inline(always)]
fn pbr_neutral(linear: Vec3s) -> Vec3s {
    let one = F32s::splat(1.0);
    // Removes the reflection of 4 % that a dielectric adds to its base color.
    let low = linear.x.least(linear.y.least(linear.z));
    let dark = low - F32s::splat(6.25) * low * low;
    let off = F32s::select(low.lt(F32s::splat(0.08)), dark, F32s::splat(0.04));
    let color = linear - Vec3s { x: off, y: off, z: off };
    let peak = color.x.most(color.y.most(color.z));
    let bright = peak.ge(F32s::splat(START));
    if !bright.any() {
        return color;
    }
    let room = F32s::splat(1.0 - START);
    let new_peak = one - room * room / (peak + room - F32s::splat(START));
    let white = one - one / (F32s::splat(DESATURATION) * (peak - new_peak) + one);
    let scaled = color * (new_peak / peak);
    let peaks = Vec3s { x: new_peak, y: new_peak, z: new_peak };
    F32s::select_vec(bright, scaled * (one - white) + peaks * white, color)
}

/// Black, and opaque.
pub(crate) const BLACK: U32s = U32s([0xff00_0000; LANES]);

/// Exposes and tone-maps radiance, and returns the bytes of the four channels, red in the lowest.
#[inline(always)]
pub(crate) fn tone_mapped_rgba8(linear: Vec3s, exposure: Exposure) -> U32s {
    let (brightest, factor) = (F32s::splat(exposure.brightest), F32s::splat(exposure.factor));
    let [r, g, b] = F32s::coordinates(linear);
    let exposed = F32s::vec3([r.least(brightest), g.least(brightest), b.least(brightest)]) * factor;
    let [r, g, b] = F32s::coordinates(pbr_neutral(exposed));
    let (green, blue) = (srgb_byte(g) * U32s::splat(0x100), srgb_byte(b) * U32s::splat(0x1_0000));
    srgb_byte(r) | green | blue | BLACK
}

/// Applies the sRGB transfer function (IEC 61966-2-1), to the nearest of 256 steps.
#[inline(always)]
fn srgb_byte(linear: F32s) -> U32s {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let c = linear.within(zero, one);
    let curved = F32s::splat(1.055) * pow(c, 1.0 / 2.4) - F32s::splat(0.055);
    let encoded = F32s::select(c.le(F32s::splat(0.003_130_8)), F32s::splat(12.92) * c, curved);
    (encoded * F32s::splat(255.0)).to_u32()
}
