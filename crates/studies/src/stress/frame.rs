//! The frame of the cross-section is orthonormal, and continuous at joints.

use light::{FrameMode, Light, Real, Tube};
use proptest::prelude::*;
use serde::Serialize;

use super::light::{LightLimits, as_file, lights};
use super::place::eps;
use super::runner::{Check, CheckTally};

/// A light and parameters along it.
#[derive(Clone, Debug, Serialize)]
pub struct FrameCase {
    #[serde(serialize_with = "as_file")]
    pub light: Light,
    /// Parameters along the light, as shares of its length.
    pub shares: Vec<f64>,
}

/// Generates cases that include thin lights with arbitrarily sharp turns.
pub fn cases() -> impl Strategy<Value = FrameCase> {
    let lights = lights(LightLimits { segments: 40, fold: 1.0, pinched: true, flipping: true });
    let share = prop_oneof![4 => (0.0..1.0).boxed(), 1 => Just(0.0).boxed(), 1 => Just(1.0).boxed()];
    (lights, prop::collection::vec(share, 1..16)).prop_map(|(light, shares)| FrameCase { light, shares })
}

/// Checks each parameter and joint, in f64 and f32.
pub fn check(case: &FrameCase, tally: &mut CheckTally) -> Check {
    let tube = Tube::new(&case.light).expect("cases are valid");
    orthonormal(&tube, &case.shares, tally)?;
    orthonormal(&Tube::<f32>::from(&tube), &case.shares, tally)?;
    check_transport(&tube, tally)
}

/// Bound of some roundings, for vectors that are differences of others of length `L`: `32 eps (1 + L / |d|)`.
fn orthonormal<F: Real>(tube: &Tube<F>, shares: &[f64], tally: &mut CheckTally) -> Check {
    for share in shares {
        let t = share * tube.n as f64;
        let i = (t as usize).min(tube.n - 1);
        let segment = &tube.segments[i].curve;
        let u = F::of(t - i as f64);
        let u_hat = segment.u_hat(u);
        let (v_hat, w_hat) = tube.cross_section(segment, u_hat);
        let [u_hat, mut v_hat, w_hat, d, d0, d1] =
            [u_hat, v_hat, w_hat, segment.d(u), segment.d0, segment.d1].map(F::vec_f64);
        if tally.is_planted {
            v_hat += u_hat * 1e-2;
        }
        let speed = if d.length() > 0.0 { d.length() } else { d0.length() + d1.length() };
        let bound = 32.0 * eps::<F>() * (1.0 + (d0.length() + d1.length()) / speed);
        let place = format!("at t = {t:?} in f{}", 8 * size_of::<F>());
        tally.within(format_args!("u_hat x v_hat - w_hat {place}"), (u_hat.cross(v_hat) - w_hat).length(), bound)?;
        tally.within(format_args!("u_hat . v_hat {place}"), u_hat.dot(v_hat).abs(), bound)?;
        for (name, vector) in [("u_hat", u_hat), ("v_hat", v_hat), ("w_hat", w_hat)] {
            tally.within(format_args!("the length of {name} {place}"), (vector.length() - 1.0).abs(), bound)?;
        }
    }
    Ok(())
}

/// `v_hat` is the same from both sides of a joint, except at a corner, which it crosses by the smallest rotation.
fn check_transport(tube: &Tube<f64>, tally: &mut CheckTally) -> Check {
    if tube.frame == FrameMode::Up {
        return Ok(());
    }
    for (i, pair) in tube.segments.windows(2).enumerate() {
        let [one, next] = [&pair[0].curve, &pair[1].curve];
        let (before, after) = (one.u_hat(1.0), next.u_hat(0.0));
        let step = (tube.cross_section(one, before).0 - tube.cross_section(next, after).0).length();
        let turn = (before - after).length();
        let error = (step - turn).max(0.0);
        tally.within(format_args!("v_hat over joint {}", i + 1), error, 64.0 * f64::EPSILON)?;
    }
    Ok(())
}
