//! Bends a straight light, in the same way for all benchmarks.

use light::parameters::{RANGE, TRANSLATION};
use light::{CheckedLight, Light, LightError, ParameterOwner, SceneBounds, as_spotlight, bend_with_length, straighten};

/// Segments of the bent light if the scene has none; the frame time that the design measured used as many.
const SEGMENTS: usize = 3;
/// Half angle in degrees of the cone that is bent if the light has none.
const CONE_ANGLE: f64 = 30.0;
/// Offsets of the middle of a straight light to one side, as shares of its length. The first that does not fold is
/// used.
const MIDDLE_OFFSETS: [f64; 4] = [0.25, 0.12, 0.06, 0.03];

/// Returns the bent light to measure in a scene with the bounding box `reach`, and a spotlight at the same position in
/// the same direction. A straight `light` is bent into three segments that reach to the middle of the box, or half of
/// its half diagonal if that is farther. A bent `light` is straightened for the spotlight.
pub(crate) fn bent_and_spot(light: &Light, reach: SceneBounds) -> Result<(Light, Light), LightError> {
    if light.owner() == ParameterOwner::Bendy {
        return Ok((light.clone(), straighten(light)?));
    }
    let length = light.get(TRANSLATION).distance(reach.center).max(0.5 * reach.half_extent.length());
    let spot = as_spotlight(light, CONE_ANGLE, Some(reach.center), length)?;
    Ok((bent(&spot, SEGMENTS, length)?, spot))
}

/// Bends `spot`, without its range, into `segments` segments over `length` world units, with the largest of
/// `MIDDLE_OFFSETS` that does not fold.
pub(crate) fn bent(spot: &Light, segments: usize, length: f64) -> Result<Light, LightError> {
    let straight = bend_with_length(&spot.clone().with(RANGE, None), segments, length)?;
    let end = straight.points().last().map_or(1.0, |point| point.position.z);
    let bowed = |aside: f64| {
        straight.clone().map_points(|_, point| {
            let share = point.position.z / end;
            point.position.x = aside * end.abs() * 4.0 * share * (1.0 - share);
        })
    };
    let checked = MIDDLE_OFFSETS.map(|aside| CheckedLight::new(bowed(aside))).into_iter().reduce(Result::or);
    Ok(checked.expect("there are offsets")?.light().clone())
}
