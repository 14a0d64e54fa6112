//! Powers, logarithms and arc tangents of sixteen numbers.

use light::Lanes;

use crate::lanes::{F32s, LANES, U32s};

/// Raises `x >= 0` to the power of `exponent`, with a relative error of `3e-7 (1 + |exponent log2 x|)`. An infinite
/// exponent makes a step at 1, which stays 1.
#[inline(always)]
pub(crate) fn pow(x: F32s, exponent: f32) -> F32s {
    // An overflowed logarithm times an infinite exponent would not be a number.
    let exponent = exponent.clamp(-1e30, 1e30);
    exp2(log2(x) * F32s::splat(exponent))
}

/// Computes the binary logarithm of `x >= 0`; -10^9 for subnormals and 0. With `x = m 2^e`, m from 0.7 to 1.4, and `s =
/// (m - 1) / (m + 1)`, `log2 m = 2 / ln 2 (s + s^3 / 3 + s^5 / 5 + ...)`. The terms after `s^9` are below 1e-8.
#[inline(always)]
pub(crate) fn log2(x: F32s) -> F32s {
    let bits = x.to_bits();
    let mut exponent = F32s::splat(0.0);
    let mut mantissa = F32s::splat(0.0);
    for i in 0..LANES {
        // 0x3f3504f3 are the bits of the root of one half.
        let from_root = bits.0[i].wrapping_sub(0x3f35_04f3);
        exponent.0[i] = (from_root.cast_signed() >> 23) as f32;
        mantissa.0[i] = f32::from_bits((from_root & 0x007f_ffff) + 0x3f35_04f3);
    }
    let one = F32s::splat(1.0);
    let s = (mantissa - one) / (mantissa + one);
    let s2 = s * s;
    let mut series = F32s::splat(1.0 / 9.0);
    for odd in [1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0] {
        series = series * s2 + F32s::splat(odd);
    }
    let two_over_ln2 = F32s::splat(std::f32::consts::LOG2_E * 2.0);
    let log = exponent + two_over_ln2 * (s + s * s2 * series);
    F32s::select(x.lt(F32s::splat(f32::MIN_POSITIVE)), F32s::splat(-1e9), log)
}

/// Computes two to the power of `x`; 0 below -126, and at most 2^127.
#[inline(always)]
pub(crate) fn exp2(x: F32s) -> F32s {
    let bounded = x.within(F32s::splat(-126.0), F32s::splat(127.0));
    // From 1.5 times 2^23 on, the last bit of a float is 1, for negative numbers too.
    let shifted = bounded + F32s::splat(12_582_912.0);
    let whole = shifted - F32s::splat(12_582_912.0);
    let share = (bounded - whole) * F32s::splat(std::f32::consts::LN_2);
    // e^share, |share| <= ln 2 / 2. The terms after share^7 are below 5e-9.
    let mut series = F32s::splat(1.0 / 5040.0);
    for factor in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        series = series * share + F32s::splat(factor);
    }
    let mut power = U32s::splat(0);
    for i in 0..LANES {
        power.0[i] = shifted.0[i].to_bits().wrapping_sub(0x4b40_0000 - 127) << 23;
    }
    let result = series * power.to_floats();
    F32s::select(x.lt(F32s::splat(-126.0)), F32s::splat(0.0), result)
}

/// Computes the angle of the vector (x, y) from the first axis, from -pi to pi, with an error of 4e-7. The polynomial
/// in `z = (least / most)^2` is the one with the least maximum relative error from 0 to 1, as in profile.wgsl.
#[inline(always)]
pub(crate) fn atan2(y: F32s, x: F32s) -> F32s {
    let (across, along) = (y.abs(), x.abs());
    let ratio = across.least(along) / across.most(along).most(F32s::splat(1e-37));
    let z = ratio * ratio;
    let mut p = F32s::splat(0.002_849_887);
    for factor in
        [-0.016_068_615, 0.042_691_49, -0.075_042_92, 0.106_409_32, -0.142_036_44, 0.199_926_2, -0.333_330_73, 1.0]
    {
        p = p * z + F32s::splat(factor);
    }
    let mut angle = ratio * p;
    let (zero, pi) = (F32s::splat(0.0), F32s::splat(std::f32::consts::PI));
    angle = F32s::select(across.gt(along), F32s::splat(std::f32::consts::FRAC_PI_2) - angle, angle);
    angle = F32s::select(x.lt(zero), pi - angle, angle);
    F32s::select(y.lt(zero), -angle, angle)
}

#[cfg(test)]
mod tests;
