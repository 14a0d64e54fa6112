//! Conversion of straight lights into BendyLights and back.

use glam::{DMat3, DQuat, DVec3};

use crate::build::{MAX_SEGMENTS, check_values};
use crate::parameters::{
    COLOR, CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, DECAY, END_MODE, FAR_EDGE, HEIGHT, INTENSITY, RANGE,
    ROTATION, SCALE, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH, TRANSLATION, UP, WIDTH,
};
use crate::{ControlPoint, CrossSection, Decay, EndMode, Light, LightError, LightShape, Tube, Value};

/// Makes the BendyLight equal to the spotlight `spot`, with `segments` quadratic segments to bend.
///
/// Control points and radii are linear in the Greville abscissae `0, 1/2, 3/2, ..., n - 1/2, n`, at which a clamped
/// quadratic B-spline reproduces linear functions exactly (light model, section 1). So the tube is the cone,
/// parametrised evenly. It ends at the spotlight's `range`. Without a range its control points span one local unit, and
/// the light is extended without end. Parameters that both shapes have keep their values.
///
/// ```
/// use light::parameters::RANGE;
/// use light::{Light, Tube, bend};
///
/// let bent = bend(&Light::spot().with(RANGE, Some(6.0)), 3)?;
/// assert_eq!(bent.points().len(), 5);
/// assert_eq!(bent.points()[4].position.z, -6.0);
/// assert_eq!(Tube::new(&bent)?.n, 3);
/// # Ok::<(), light::LightError>(())
/// ```
pub fn bend(spot: &Light, segments: usize) -> Result<Light, LightError> {
    bend_with_length(spot, segments, spot.get(SCALE))
}

/// Does the same as `bend`, but control points of a spotlight without a range span `reach` world units along the axis.
pub fn bend_with_length(spot: &Light, segments: usize, reach: f64) -> Result<Light, LightError> {
    check_values(spot)?;
    if *spot.shape() != LightShape::Spot {
        return Err(LightError::NotASpot);
    }
    if !(1..=MAX_SEGMENTS).contains(&segments) {
        return Err(LightError::SegmentCount { count: segments, limit: MAX_SEGMENTS });
    }
    RANGE.check(&Value::Number(reach))?;
    let range = spot.get(RANGE);
    let length = range.unwrap_or(reach) / spot.get(SCALE);
    let slope = libm::tan(spot.get(CONE_ANGLE).to_radians());
    let point = |g: f64| {
        let along = g / segments as f64 * length;
        // Subtracted instead of negated: the source is at 0, not at -0.
        ControlPoint::new(DVec3::new(0.0, 0.0, 0.0 - along), along * slope)
    };
    let points = greville_abscissae(segments).into_iter().map(point).collect();
    let bent = Light::new(LightShape::Bendy(points)).with_values_of(spot);
    Ok(bent.with(END_MODE, if range.is_some() { EndMode::Cut } else { EndMode::Extend }))
}

/// Makes a spotlight from a light without a cone, before it is bent: the part of the light within `cone_angle` degrees
/// of its axis. A spotlight or a BendyLight is returned unchanged.
///
/// - An omni light is turned to shine at `toward`, in world space. Its range, a sphere, becomes a cut-off, which is a
///   sphere too; a spotlight's range is a plane. A cut-off that fades past the range is an error.
/// - A directional light keeps its direction and shines from `reach` world units before `toward`, the length of the
///   control points. If it has a window, it shines along the window's axis, and the window is the outline there.
/// - Without `toward` both shine along their own -Z from their own position.
///
/// Parameters that both shapes have keep their values. Within the cone light does not fall off.
pub fn as_spotlight(light: &Light, cone_angle: f64, toward: Option<DVec3>, reach: f64) -> Result<Light, LightError> {
    if !matches!(light.shape(), LightShape::Omni | LightShape::Directional) {
        return Ok(light.clone());
    }
    let mut spot = Light::spot().with(DECAY, Decay::None).with_values_of(light);
    if *light.shape() == LightShape::Omni
        && let Some(range) = light.get(RANGE)
    {
        spot = with_spherical_end(&spot, range)?;
    }
    let spot = spot.with(CONE_ANGLE, cone_angle).with(CONE_SOFTNESS, 0.0);
    let Some(toward) = toward else { return Ok(spot) };
    if *light.shape() == LightShape::Directional {
        return Ok(through_window(spot, light, toward, reach));
    }
    let offset = toward - light.get(TRANSLATION);
    // Divided by the largest component first, so that no length overflows.
    let Some(direction) = (offset / offset.abs().max_element()).try_normalize() else { return Ok(spot) };
    Ok(spot.with(ROTATION, DQuat::from_mat3(&looking_along(direction, DVec3::Y))))
}

/// Makes the light of the spotlight `spot` end at the distance `range` from its source, instead of at a plane.
fn with_spherical_end(spot: &Light, range: f64) -> Result<Light, LightError> {
    let spot = spot.clone().with(RANGE, None);
    let Some(cut_off) = spot.get(CUT_OFF).filter(|cut_off| *cut_off < range) else {
        return Ok(spot.with(CUT_OFF, Some(range)).with(FAR_EDGE, 0.0));
    };
    // No light is left at the range.
    if cut_off + spot.get(FAR_EDGE) <= range {
        return Ok(spot);
    }
    Err(LightError::RangeInFarEdge { range, cut_off })
}

/// Places the spotlight `spot` instead of the directional `light`, `reach` world units before `toward`. If the light
/// has a window, the source is on the window's axis, and the cross-section is a rectangle of the window's size as far
/// as the cone contains it.
fn through_window(spot: Light, light: &Light, toward: DVec3, reach: f64) -> Light {
    let back = light.get(ROTATION).normalize() * DVec3::Z;
    let sides = [light.get(WIDTH), light.get(HEIGHT)];
    if sides == [None; 2] {
        return spot.with(TRANSLATION, toward + back * reach);
    }
    let middle = light.get(TRANSLATION);
    let before = middle + back * ((toward - middle).dot(back) + reach);
    let radius = reach * libm::tan(spot.get(CONE_ANGLE).to_radians());
    let half = sides.map(|side| side.map(|side| (side / 2.0 / radius).min(1.0)));
    // An unbounded side reaches as far as the circle does.
    let rest = |other: Option<f64>| other.map_or(1.0, |half| (1.0 - half * half).max(0.0).sqrt().max(1e-3));
    spot.with(TRANSLATION, before)
        .with(CROSS_SECTION, CrossSection::Superellipse)
        .with(SECTION_ROUNDNESS, 0.0)
        .with(SECTION_WIDTH, half[0].unwrap_or_else(|| rest(half[1])))
        .with(SECTION_HEIGHT, half[1].unwrap_or_else(|| rest(half[0])))
}

/// Maximum difference in degrees between the angle of a straight tube and `coneAngle`, for roundings of its radii.
const ANGLE_TOLERANCE_DEGREES: f64 = 1e-9;

/// Maximum distance of control points from a cone, as shares of their distance and radius, for roundings.
const CONE_TOLERANCE: f64 = 1e-9;

/// Makes the spotlight from a BendyLight's source to its last control point, with the colour and intensity of that
/// point. A BendyLight that was made from a spotlight and is still straight gives that spotlight.
///
/// The cone has the tube's last radius at the last control point. It ends there unless the BendyLight is extended. `up`
/// stays up. Parameters that both shapes have keep their values.
///
/// ```
/// use light::parameters::CONE_ANGLE;
/// use light::{Light, bend, straighten};
///
/// let spot = Light::spot().with(CONE_ANGLE, 20.0);
/// assert_eq!(straighten(&bend(&spot, 3)?)?, spot);
/// # Ok::<(), light::LightError>(())
/// ```
pub fn straighten(bent: &Light) -> Result<Light, LightError> {
    if bent.points().is_empty() {
        return Err(LightError::NotBent);
    }
    Tube::new(bent)?;
    straighten_checked(bent)
}

/// Returns the spotlight equal to a checked BendyLight whose tube is a cone. The control points lie on one ray from the
/// source in ascending order, have one colour and intensity, and radii proportional to their distances, at the angle
/// that its profile uses. `None` if the light is bent, however little.
pub fn spotlight_if_straight(bent: &Light) -> Option<Light> {
    let points = bent.points();
    let last = points.last()?;
    let length = last.position.length();
    let (axis, slope) = (last.position / length, last.radius / length);
    let along = |point: &ControlPoint| point.position.dot(axis);
    let is_on_cone = |point: &ControlPoint| {
        let aside = (point.position - axis * along(point)).length();
        aside <= CONE_TOLERANCE * along(point)
            && (point.radius - slope * along(point)).abs() <= CONE_TOLERANCE * point.radius
            && (point.color, point.intensity) == (last.color, last.intensity)
    };
    // If `up` is along the axis, each shape chooses its own direction across it.
    let up = bent.get(UP);
    let is_cone = points.iter().all(is_on_cone)
        && points.windows(2).all(|pair| along(&pair[0]) < along(&pair[1]))
        && (cone_angle(last) - bent.get(CONE_ANGLE)).abs() <= ANGLE_TOLERANCE_DEGREES
        && cone_angle(last) > ANGLE_TOLERANCE_DEGREES
        && up.cross(axis).length() > 1e-6 * up.length();
    if is_cone { straighten_checked(bent).ok() } else { None }
}

/// Does the work of `straighten` for a checked BendyLight.
fn straighten_checked(bent: &Light) -> Result<Light, LightError> {
    let Some(last) = bent.points().last() else { return Err(LightError::NotBent) };
    let length = last.position.length();
    if length == 0.0 {
        return Err(LightError::NoDirection);
    }
    let cone_angle = cone_angle(last);
    let mut spot = Light::spot().with_values_of(bent);
    if (cone_angle - bent.get(CONE_ANGLE)).abs() > ANGLE_TOLERANCE_DEGREES {
        spot.set(CONE_ANGLE.to(cone_angle.max(ANGLE_TOLERANCE_DEGREES)));
    }
    let turn = looking_along(last.position / length, bent.get(UP));
    if turn != DMat3::IDENTITY {
        spot.set(ROTATION.to((bent.get(ROTATION).normalize() * DQuat::from_mat3(&turn)).normalize()));
    }
    let range = (bent.get(END_MODE) == EndMode::Cut).then(|| length * bent.get(SCALE));
    let (color, intensity) = (bent.get(COLOR) * last.color, bent.get(INTENSITY) * last.intensity);
    let spot = spot.with(RANGE, range).with(COLOR, color).with(INTENSITY, intensity);
    check_values(&spot)?;
    Ok(spot)
}

/// Returns the half angle in degrees of the cone from the source that is as wide as the tube at a control point.
fn cone_angle(point: &ControlPoint) -> f64 {
    libm::atan2(point.radius, point.position.length()).to_degrees()
}

/// Returns the rotation that takes -Z to the unit vector `direction` and +Y to the side of `up`. If `up` is along
/// `direction`, the rotation about it is arbitrary.
fn looking_along(direction: DVec3, up: DVec3) -> DMat3 {
    let back = -direction;
    let across = up.cross(back);
    let right = if across.length() > 1e-9 * up.length() { across.normalize() } else { back.any_orthonormal_vector() };
    DMat3::from_cols(right, back.cross(right), back)
}

/// Returns the Greville abscissae of a clamped uniform quadratic B-spline with `n` segments:
/// `0, 1/2, 3/2, ..., n - 1/2, n`.
pub fn greville_abscissae(n: usize) -> Vec<f64> {
    let inner = (0..n).map(|i| i as f64 + 0.5);
    std::iter::once(0.0).chain(inner).chain(std::iter::once(n as f64)).collect()
}
