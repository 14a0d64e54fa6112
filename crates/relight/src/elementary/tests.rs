//! Powers and angles against double precision.

use super::*;
use crate::simd::{self, SimdTask};

struct Both(F32s, f32, F32s);

impl SimdTask for Both {
    type Output = (F32s, F32s);

    #[inline(always)]
    fn run(self) -> (F32s, F32s) {
        (pow(self.0, self.1), atan2(self.0, self.2))
    }
}

fn both(x: f32, exponent: f32, y: f32) -> (f64, f64) {
    let (power, angle) = simd::run(Both(F32s::splat(x), exponent, F32s::splat(y)));
    (f64::from(power.0[3]), f64::from(angle.0[3]))
}

#[test]
fn powers_are_as_near_as_they_say() {
    let mut worst: f64 = 0.0;
    for k in 1..4000 {
        let x = k as f32 / 1000.0;
        for exponent in [1.0 / 2.4, 0.5, 1.0, 2.0, 3.7, -1.5, 12.0] {
            let exact = libm::pow(f64::from(x), f64::from(exponent));
            let off = (both(x, exponent, 1.0).0 / exact - 1.0).abs();
            let scale = 1.0 + (f64::from(exponent) * libm::log2(f64::from(x))).abs();
            worst = worst.max(off / scale);
        }
    }
    assert!(worst < 3e-7, "{worst:e}");
}

#[test]
fn an_infinite_power_is_a_step_at_one() {
    let power = |x| both(x, f32::INFINITY, 1.0).0;
    assert_eq!((power(0.0), power(0.999), power(1.0)), (0.0, 0.0, 1.0));
    assert_eq!((both(0.0, 2.0, 1.0).0, both(0.0, 0.5, 1.0).0), (0.0, 0.0));
}

#[test]
fn angles_are_as_near_as_they_say() {
    let mut worst: f64 = 0.0;
    for k in 0..3600 {
        let (sin, cos) = libm::sincosf(k as f32 * std::f32::consts::TAU / 3600.0);
        let exact = libm::atan2(f64::from(sin), f64::from(cos));
        let found = both(sin, 1.0, cos).1;
        // Both ends of the seam are the same angle.
        worst = worst.max((found - exact).abs().min((found - exact + std::f64::consts::TAU).abs()));
    }
    assert!(worst < 4e-7, "{worst:e}");
}
