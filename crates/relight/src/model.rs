//! Light model on sixteen lanes: the operations that `light` requires.

use glam::DVec3;
use light::{Lanes, Mask};

use crate::elementary;
use crate::lanes::{F32s, LANES, Masks, Vec3s, lanewise};

impl Mask for Masks {
    #[inline(always)]
    fn of(answer: bool) -> Self {
        Self([if answer { u32::MAX } else { 0 }; LANES])
    }
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = 0;
        for i in 0..LANES {
            any |= self.0[i];
        }
        any != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        let mut all = u32::MAX;
        for i in 0..LANES {
            all &= self.0[i];
        }
        all == u32::MAX
    }
    #[inline(always)]
    fn decided(self) -> Option<bool> {
        None
    }
}

impl Lanes for F32s {
    type Vec3 = Vec3s;
    type Mask = Masks;
    const NEWTON_STEPS: usize = <f32 as Lanes>::NEWTON_STEPS;
    const DIRECTION_FLOOR: Self = Self([<f32 as Lanes>::DIRECTION_FLOOR; LANES]);

    lanewise! {
        fn lt(x, other: Self) -> Masks = if x < other { u32::MAX } else { 0 };
        fn le(x, other: Self) -> Masks = if x <= other { u32::MAX } else { 0 };
        fn equals(x, other: Self) -> Masks = if x == other { u32::MAX } else { 0 };
        fn sqrt(x) -> Self = x.sqrt();
        fn abs(x) -> Self = x.abs();
        fn cbrt_above(x) -> Self = x.cbrt_above();
    }

    #[inline(always)]
    fn of(x: f64) -> Self {
        Self::splat(x as f32)
    }
    #[inline(always)]
    fn vec(v: DVec3) -> Vec3s {
        Vec3s::splat(v.as_vec3().to_array())
    }
    #[inline(always)]
    fn vec3([x, y, z]: [Self; 3]) -> Vec3s {
        Vec3s { x, y, z }
    }
    #[inline(always)]
    fn coordinates(v: Vec3s) -> [Self; 3] {
        [v.x, v.y, v.z]
    }
    #[inline(always)]
    fn dot(a: Vec3s, b: Vec3s) -> Self {
        a.x * b.x + a.y * b.y + a.z * b.z
    }
    #[inline(always)]
    fn cross(a: Vec3s, b: Vec3s) -> Vec3s {
        Vec3s { x: a.y * b.z - b.y * a.z, y: a.z * b.x - b.z * a.x, z: a.x * b.y - b.x * a.y }
    }
    #[inline(always)]
    fn pow(self, exponent: f64) -> Self {
        elementary::pow(self, exponent as f32)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        elementary::atan2(self, x)
    }
    #[inline(always)]
    fn select(mask: Masks, yes: Self, no: Self) -> Self {
        let mut out = no;
        for i in 0..LANES {
            out.0[i] = if mask.0[i] != 0 { yes.0[i] } else { no.0[i] };
        }
        out
    }
    #[inline(always)]
    fn select_vec(mask: Masks, yes: Vec3s, no: Vec3s) -> Vec3s {
        Vec3s {
            x: Self::select(mask, yes.x, no.x),
            y: Self::select(mask, yes.y, no.y),
            z: Self::select(mask, yes.z, no.z),
        }
    }
}

#[cfg(test)]
mod tests;
