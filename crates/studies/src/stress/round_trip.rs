//! Conversion from (t, v, w) to a point and back.

use light::{Light, Real, Tube};
use proptest::prelude::*;
use serde::Serialize;

use super::light::{LightLimits, as_file, lights};
use super::place::{bounds, eps, point_at, root_at, split};
use super::runner::{Check, CheckTally};

/// A light and coordinates in it.
#[derive(Clone, Debug, Serialize)]
pub struct RoundTripCase {
    #[serde(serialize_with = "as_file")]
    pub light: Light,
    /// (t, v, w) of each point.
    pub places: Vec<[f64; 3]>,
}

/// Generates lights of every kind, and points inside them.
pub fn cases() -> impl Strategy<Value = RoundTripCase> {
    let lights = lights(LightLimits { segments: 12, fold: 1.0, pinched: true, flipping: true });
    let place = (0.0..1.0, 0.0..0.999, 0.0..std::f64::consts::TAU);
    (lights, prop::collection::vec(place, 1..16)).prop_map(|(light, places)| {
        let n = (light.points().len() - 2) as f64;
        let places = places.into_iter().map(|(share, rho, angle)| [share * n, rho * angle.cos(), rho * angle.sin()]);
        RoundTripCase { places: places.collect(), light }
    })
}

/// Checks each point, in f64 and f32.
pub fn check(case: &RoundTripCase, tally: &mut CheckTally) -> Check {
    let tube = Tube::new(&case.light).expect("cases are valid");
    let single = Tube::<f32>::from(&tube);
    for &place in &case.places {
        comes_back(&tube, &tube, place, tally)?;
        comes_back(&tube, &single, place, tally)?;
    }
    Ok(())
}

fn comes_back<F: Real>(exact: &Tube<f64>, tube: &Tube<F>, [t, v, w]: [f64; 3], tally: &mut CheckTally) -> Check {
    let q = point_at(exact, t, v, w);
    let (segment, u) = split(exact, t);
    let root = root_at(exact, segment, u, q);
    let Some(bound) = bounds(exact, &root, q, eps::<F>(), 0.0) else { return Ok(()) };
    let gap = (1.0 - v.hypot(w)) * root.radius;
    // Rounding can put a point at the rim or at an end outside.
    if gap < 4.0 * (bound.across + bound.radius) || t < bound.t || exact.n as f64 - t < bound.t {
        return Ok(());
    }
    let mut found = None;
    tube.for_each_root(F::vec(q), |root| {
        let off = (root.segment as f64 + root.u.f64() - t).abs();
        if found.is_none_or(|(best, _)| off < best) {
            found = Some((off, [root.v_len, root.w_len, root.radius].map(F::f64)));
        }
    });
    let place = format!("(t, v, w) = ({t:?}, {v:?}, {w:?}) in f{}", 8 * size_of::<F>());
    let Some((off, [v_len, mut w_len, radius])) = found else {
        return tally.holds(false, || format!("{place} is not found again"));
    };
    if tally.is_planted {
        w_len = -w_len;
    }
    let expected_radius = root.radius;
    tally.within(format_args!("t of {place}"), off, bound.t)?;
    tally.within(format_args!("V of {place}"), (v_len - v * expected_radius).abs(), bound.across + bound.radius)?;
    tally.within(format_args!("W of {place}"), (w_len - w * expected_radius).abs(), bound.across + bound.radius)?;
    tally.within(format_args!("R of {place}"), (radius - expected_radius).abs(), bound.radius)
}
