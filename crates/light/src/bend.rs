//! A spotlight as a BendyLight.

use glam::DVec3;

use crate::build::{MAX_SEGMENTS, check_values};
use crate::parameters::{COLOR, CONE_ANGLE, END_MODE, INTENSITY, RANGE, SCALE};
use crate::{ControlPoint, EndMode, Light, LightError, Setting, Shape};

/// The BendyLight equal to the spotlight `spot`, with `segments` quadratic segments to bend.
///
/// Control points and radii are linear in the Greville abscissae `0, 1/2, 3/2, ..., n - 1/2, n`, at which a clamped
/// quadratic B-spline reproduces linear functions exactly (light model, section 1): the tube is the cone, parametrised
/// evenly. It ends at the spotlight's `range`; without one, its control points span one local unit and it is extended
/// without end. Parameters that both shapes have keep their values.
pub fn bend(spot: &Light, segments: usize) -> Result<Light, LightError> {
    check_values(spot)?;
    if *spot.shape() != Shape::Spot {
        return Err(LightError::NotASpot);
    }
    if !(1..=MAX_SEGMENTS).contains(&segments) {
        return Err(LightError::SegmentCount { count: segments, limit: MAX_SEGMENTS });
    }
    let range = spot.get(RANGE);
    let length = range.map_or(1.0, |range| range / spot.get(SCALE));
    let slope = libm::tan(spot.get(CONE_ANGLE).to_radians());
    let point = |g: f64| {
        let along = g / segments as f64 * length;
        ControlPoint {
            // Subtracted rather than negated: the source is at 0, not at -0.
            position: DVec3::new(0.0, 0.0, 0.0 - along),
            radius: along * slope,
            color: spot.get(COLOR),
            intensity: spot.get(INTENSITY),
        }
    };
    let mut bent = Light::new(Shape::Bendy(greville(segments).into_iter().map(point).collect()));
    for (parameter, value) in spot.values() {
        bent.set(Setting { parameter, value: value.clone() });
    }
    Ok(bent.with(END_MODE, if range.is_some() { EndMode::Cut } else { EndMode::Extend }))
}

/// The Greville abscissae of a clamped uniform quadratic B-spline with `n` segments: `0, 1/2, 3/2, ..., n -
/// 1/2, n`.
pub fn greville(n: usize) -> Vec<f64> {
    let inner = (0..n).map(|i| i as f64 + 0.5);
    std::iter::once(0.0).chain(inner).chain(std::iter::once(n as f64)).collect()
}
