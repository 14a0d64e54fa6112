//! Encoding and decoding of the vectors and materials of surfaces, as in `encoding.wgsl`.

use light::Lanes;

use crate::lanes::{F32s, LANES, U32s, Vec3s};

/// Encodes unit vectors octahedrally in 2 x 16 bits.
#[inline(always)]
pub(crate) fn unit_to_bits(n: Vec3s) -> U32s {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let per_length = one / (n.x.abs() + n.y.abs() + n.z.abs());
    let (x, y) = (n.x * per_length, n.y * per_length);
    let sign = |v: F32s| F32s::select(v.lt(zero), F32s::splat(-1.0), one);
    let below = n.z.lt(zero);
    let folded_x = F32s::select(below, (one - y.abs()) * sign(x), x);
    let folded_y = F32s::select(below, (one - x.abs()) * sign(y), y);
    let mut bits = U32s::ZERO;
    for i in 0..LANES {
        let snorm = |v: f32| (v.clamp(-1.0, 1.0) * 32767.0).round_ties_even() as i32 as u32 & 0xffff;
        bits.0[i] = snorm(folded_x.0[i]) | snorm(folded_y.0[i]) << 16;
    }
    bits
}

/// Encodes a linear base color, metallic factor and roughness, each from 0 to 1, in 64 bits.
#[inline(always)]
pub(crate) fn material_to_bits(base_color: [F32s; 3], metallic: F32s, roughness: F32s) -> [U32s; 2] {
    let step = |share: F32s, steps: f32| (share * F32s::splat(steps)).to_u32();
    let [r, g, b] = base_color.map(|color| step(color.sqrt(), 8191.0));
    let (metallic, roughness) = (step(metallic, 4090.0), step(roughness, 8190.0));
    let (mut low, mut high) = (U32s::ZERO, U32s::ZERO);
    for i in 0..LANES {
        low.0[i] = r.0[i] | g.0[i] << 13 | b.0[i] << 26;
        high.0[i] = b.0[i] >> 6 | metallic.0[i] << 7 | roughness.0[i] << 19;
    }
    [low, high]
}

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
