//! Decoding of the vectors and materials of a G-buffer, the inverse of `encoding.wgsl`.

use light::Lanes;

use crate::lanes::{F32s, LANES, U32s, Vec3s};

/// Decodes an octahedral unit vector of 2 x 16 bits.
#[inline(always)]
pub(crate) fn unit_from_bits(bits: U32s) -> Vec3s {
    let (mut x, mut y) = (F32s::splat(0.0), F32s::splat(0.0));
    for i in 0..LANES {
        x.0[i] = (f32::from((bits.0[i] as u16).cast_signed()) * (1.0 / 32767.0)).max(-1.0);
        y.0[i] = (f32::from(((bits.0[i] >> 16) as u16).cast_signed()) * (1.0 / 32767.0)).max(-1.0);
    }
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let z = one - x.abs() - y.abs();
    let below = z.lt(zero);
    let folded_x = F32s::select(x.lt(zero), -(one - y.abs()), one - y.abs());
    let folded_y = F32s::select(y.lt(zero), -(one - x.abs()), one - x.abs());
    let v = Vec3s { x: F32s::select(below, folded_x, x), y: F32s::select(below, folded_y, y), z };
    v * (one / F32s::length(v))
}

/// Decodes linear base color, metallic factor and roughness from 64 bits.
#[inline(always)]
pub(crate) fn material_from_bits([low, high]: [U32s; 2]) -> (Vec3s, F32s, F32s) {
    let (mut roots, mut metallic, mut roughness) = (Vec3s::splat([0.0; 3]), F32s::splat(0.0), F32s::splat(0.0));
    for i in 0..LANES {
        let (low, high) = (low.0[i], high.0[i]);
        roots.x.0[i] = (low & 0x1fff).cast_signed() as f32 * (1.0 / 8191.0);
        roots.y.0[i] = (low >> 13 & 0x1fff).cast_signed() as f32 * (1.0 / 8191.0);
        roots.z.0[i] = (low >> 26 | (high & 0x7f) << 6).cast_signed() as f32 * (1.0 / 8191.0);
        metallic.0[i] = (high >> 7 & 0xfff).cast_signed() as f32 * (1.0 / 4090.0);
        roughness.0[i] = (high >> 19).cast_signed() as f32 * (1.0 / 8190.0);
    }
    (roots * roots, metallic, roughness)
}
