//! Tests of exposure: `2^exposure` times the light, for every shape.

use glam::DVec3;
use light::Light;
use light::parameters::{CONE_SOFTNESS, DECAY, EXPOSURE, RANGE};
use render::Aov;
use scene::{Material, Scene};

use crate::support::{EPS, floor, picture, scene_of, spot, view};

fn table() -> Scene {
    scene_of([floor(3.0, 0.0)], vec![Material::default()])
}

/// Returns a spotlight, soft up to its axis, and a BendyLight bent from it.
fn lights() -> [Light; 2] {
    let spot = spot(DVec3::new(0.5, 3.0, 0.2), DVec3::ZERO).with(CONE_SOFTNESS, 1.0).with(RANGE, Some(6.0));
    let bent = light::bend(&spot, 3).expect("a light");
    [spot, bent]
}

/// Pictures that should differ only by the factor run the same code, so only these round differently: `exp2`, for which
/// WGSL permits an error of `3 + 2 |x|` ulp (of 2 EPS), and the factor's five products.
#[test]
fn a_stop_is_twice_the_light() {
    let view = view(DVec3::new(0.0, 4.0, 3.0), DVec3::ZERO, [48, 32], Aov::Beauty);
    for light in lights() {
        let base = picture(&table(), &view, std::slice::from_ref(&light));
        let lit = base.pixels.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(lit > 100, "{lit} pixels are lit");
        for exposure in [-7.25, -1.0, 0.5, 1.0, 3.3, 12.0_f64] {
            let exposed = picture(&table(), &view, &[light.clone().with(EXPOSURE, exposure)]);
            let apart = |factor: f64| {
                let pairs = base.pixels.iter().flatten().zip(exposed.pixels.iter().flatten());
                let lit = pairs.enumerate().filter(|(k, (was, _))| k % 4 < 3 && **was > 0.0);
                let off = |was: &f32, is: &f32| (f64::from(*is) / (f64::from(*was) * factor) - 1.0).abs();
                lit.map(|(_, (was, is))| off(was, is)).fold(0.0, f64::max)
            };
            let tolerance = (3.0 + 2.0 * exposure.abs()) * 2.0 * EPS + 10.0 * EPS;
            let off = apart(exposure.exp2());
            assert!(off <= tolerance, "{exposure} stops: off by {off:e}, {tolerance:e} allowed");
            // Deliberate faults that the check must detect: a doubling of the added light per stop, and decibels.
            assert!(apart(1.0 + exposure) > tolerance || exposure == 1.0);
            assert!(apart(10_f64.powf(exposure / 10.0)) > tolerance);
        }
    }
}

/// Covers the range of the slider's row in both directions, also at the source itself.
#[test]
fn no_exposure_is_too_much_for_single_precision() {
    let view = view(DVec3::new(0.0, 4.0, 3.0), DVec3::ZERO, [24, 16], Aov::Beauty);
    for light in lights() {
        for exposure in [-100.0, 100.0] {
            let light = light.clone().with(EXPOSURE, exposure).with(DECAY, light::Decay::InverseSquare);
            // `picture` asserts finite values.
            let brightest = picture(&table(), &view, &[light]).pixels.iter().flatten().copied().fold(0.0, f32::max);
            assert!(brightest > 0.0, "{exposure} stops");
        }
    }
}
