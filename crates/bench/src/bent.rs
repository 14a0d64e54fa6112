//! A bent light of a straight one, the same in every bench.

use light::parameters::{RANGE, TRANSLATION};
use light::{
    CheckedLight, Light, LightError, ParameterOwner, SceneBounds, as_spotlight, bend_with_length, straighten,
};

/// Segments of the bent light, where the scene brings none: those of the design's frame.
const SEGMENTS: usize = 3;
/// Half angle in degrees of the cone that is bent of a light without one.
const CONE_ANGLE: f64 = 30.0;
/// How far the middle of a straight light is moved aside, as a share of its length; the first that does not fold is
/// taken.
const MIDDLE_OFFSETS: [f64; 4] = [0.25, 0.12, 0.06, 0.03];

/// The bent light that is measured in a scene whose box is `reach`, and a spotlight from the same place in the same
/// direction. A straight `light` is bent into three segments that reach to the middle of the box, or half its half
/// diagonal where that is farther; one that is bent is straightened, to have both.
pub(crate) fn bent_and_spot(light: &Light, reach: SceneBounds) -> Result<(Light, Light), LightError> {
    if light.owner() == ParameterOwner::Bendy {
        return Ok((light.clone(), straighten(light)?));
    }
    let length = light.get(TRANSLATION).distance(reach.center).max(0.5 * reach.half_extent.length());
    let spot = as_spotlight(light, CONE_ANGLE, Some(reach.center), length)?;
    Ok((bent(&spot, SEGMENTS, length)?, spot))
}

/// The spotlight `spot` without its range, of so many segments over `length` world units, bowed aside as evenly as they
/// can.
pub(crate) fn bent(spot: &Light, segments: usize, length: f64) -> Result<Light, LightError> {
    let straight = bend_with_length(&spot.clone().with(RANGE, None), segments, length)?;
    let end = straight.points().last().map_or(1.0, |point| point.position.z);
    let bowed = |aside: f64| {
        straight.clone().map_points(|_, point| {
            let share = point.position.z / end;
            point.position.x = aside * end.abs() * 4.0 * share * (1.0 - share);
        })
    };
    let mut refused = None;
    for light in MIDDLE_OFFSETS.map(bowed) {
        match CheckedLight::new(light.clone()) {
            Ok(_) => return Ok(light),
            Err(why) => refused = Some(why),
        }
    }
    refused.map_or(Ok(straight), Err)
}
