//! A spotlight as a BendyLight.

use glam::DVec3;

use crate::build::{MAX_SEGMENTS, check_spot};
use crate::{BendyLight, EndMode, LightError, SpotLight};

/// The BendyLight equal to `spot`, with `segments` quadratic segments to bend.
///
/// Control points and radii are linear in the Greville abscissae `0, 1/2, 3/2, ..., n - 1/2, n`, at which a
/// clamped quadratic B-spline reproduces linear functions exactly (light model, section 1): the tube is the
/// cone, parametrised evenly. It ends at the spotlight's `range`; without one, its control points span one
/// local unit and it is extended without end.
pub fn bend(spot: &SpotLight, segments: usize) -> Result<BendyLight, LightError> {
    check_spot(spot)?;
    if !(1..=MAX_SEGMENTS).contains(&segments) {
        return Err(LightError::SegmentCount(segments));
    }
    let length = spot.range.map_or(1.0, |range| range / spot.transform.scale);
    let slope = libm::tan(spot.cone_angle.to_radians());
    let share = greville(segments).into_iter().map(|g| g / segments as f64);
    let axis: Vec<f64> = share.map(|s| s * length).collect();
    let count = axis.len();
    Ok(BendyLight {
        transform: spot.transform,
        // Subtracted rather than negated: the source is at 0, not at -0.
        points: axis.iter().map(|&z| DVec3::new(0.0, 0.0, 0.0 - z)).collect(),
        radii: axis.iter().map(|z| z * slope).collect(),
        colors: vec![spot.color; count],
        intensities: vec![spot.intensity; count],
        cone_angle: spot.cone_angle,
        cone_softness: spot.cone_softness,
        end_mode: if spot.range.is_some() { EndMode::Cut } else { EndMode::Extend },
        decay: spot.decay,
        ..BendyLight::new(vec![], vec![])
    })
}

/// The Greville abscissae of a clamped uniform quadratic B-spline with `n` segments: `0, 1/2, 3/2, ..., n -
/// 1/2, n`.
pub fn greville(n: usize) -> Vec<f64> {
    let inner = (0..n).map(|i| i as f64 + 0.5);
    std::iter::once(0.0).chain(inner).chain(std::iter::once(n as f64)).collect()
}
