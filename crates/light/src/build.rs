//! Construction of a [`Tube`]'s segments from a light's values: checks, Bezier extraction and the frame's constants.

use std::ops::Range;

use glam::{DMat3, DVec3};

use crate::arc::arc_length;
use crate::curve::{Curve, TubeBox};
use crate::frame::{STRAIGHT_SINE, set_frame};
use crate::parameters::{END_MODE, SCALE, UP};
use crate::{ControlPoint, EndMode, Light, LightError, Segment, Transform, validity};

/// Maximum number of segments of a light: far more than an artist handles, and few enough for any GPU buffer.
pub const MAX_SEGMENTS: usize = 256;

/// Position and scale of tube space in the world.
///
/// Tube space is light-local space, scaled by a power of two so that the control polygon is about one unit long. So f32
/// neither overflows nor underflows, and the scaling itself is exact.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// World position of the source.
    pub translation: DVec3,
    /// Rotation from tube axes to world axes.
    pub rotation: DMat3,
    pub world_per_tube: f64,
}

impl Placement {
    pub fn tube_from_world(&self, world: DVec3) -> DVec3 {
        (self.rotation.transpose() * (world - self.translation)) / self.world_per_tube
    }

    pub fn world_from_tube(&self, tube: DVec3) -> DVec3 {
        self.translation + self.rotation * (tube * self.world_per_tube)
    }
}

/// Checks each value against its row of the table.
pub fn check_values(light: &Light) -> Result<(), LightError> {
    light.values().try_for_each(|(row, value)| row.check(value))
}

/// Checks the control points of a BendyLight.
fn check_points(points: &[ControlPoint]) -> Result<(), LightError> {
    let count = points.len();
    if count < 3 {
        return Err(LightError::TooFewPoints(count));
    }
    if count > MAX_SEGMENTS + 2 {
        return Err(LightError::TooManyPoints { count, limit: MAX_SEGMENTS + 2 });
    }
    let finite = [
        ("points", points.iter().all(|point| point.position.is_finite())),
        ("radii", points.iter().all(|point| point.radius.is_finite())),
        ("colors", points.iter().all(|point| point.color.is_finite())),
        ("intensities", points.iter().all(|point| point.intensity.is_finite())),
    ];
    if let Some((field, _)) = finite.iter().find(|(_, ok)| !ok) {
        return Err(LightError::NotFinite(field));
    }
    // A wider tube leaves f32 no digits for the curve. A light without length is refused for its length instead.
    let length = polygon_length(points);
    let widest = if length > 0.0 { 1e6 * length } else { f64::MAX };
    let radii = points.iter().map(|point| point.radius);
    if let Some((index, value)) = radii.enumerate().find(|(_, r)| !(0.0..=widest).contains(r)) {
        return Err(LightError::Radius { index, value });
    }
    if points[0].position != DVec3::ZERO {
        return Err(LightError::SourceNotAtOrigin);
    }
    Ok(())
}

/// Returns the Bezier control values of segment `i` of the clamped uniform quadratic B-spline through `c` (light model,
/// section 1).
pub fn bezier<T>(c: &[T], i: usize) -> [T; 3]
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let n = c.len() - 2;
    let b0 = if i == 0 { c[0] } else { (c[i] + c[i + 1]) * 0.5 };
    let b2 = if i == n - 1 { c[n + 1] } else { (c[i + 1] + c[i + 2]) * 0.5 };
    [b0, c[i + 1], b2]
}

fn polygon_length(points: &[ControlPoint]) -> f64 {
    points.windows(2).map(|p| p[1].position.distance(p[0].position)).sum()
}

/// Returns half the derivatives at both ends. They come from differences of the control points, so that adjacent
/// segments share them bit for bit.
fn half_derivatives<T>(c: &[T], i: usize) -> (T, T)
where
    T: Copy + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let n = c.len() - 2;
    let first = (c[i + 1] - c[i]) * if i == 0 { 1.0 } else { 0.5 };
    let second = (c[i + 2] - c[i + 1]) * if i == n - 1 { 1.0 } else { 0.5 };
    (first, second)
}

/// Computes the largest `R kappa`, radius times curvature, of each of these segments of the BendyLight with these
/// control points. It is 1 or more where the tube folds, which is no error here. A segment without a direction is one.
pub fn r_kappa_max_of_segments(points: &[ControlPoint], segments: Range<usize>) -> Result<Vec<f64>, LightError> {
    let values = ControlValues::of(points, 1.0);
    segments.map(|i| Ok(validity::r_kappa_max(&segment_curve(&values, i)?))).collect()
}

/// Builds the segments of a light in tube space, and the placement of that space, after all checks.
pub fn segments(light: &Light) -> Result<(Vec<Segment<f64>>, Placement), LightError> {
    check_values(light)?;
    if light.get(UP) == DVec3::ZERO {
        return Err(LightError::OutOfDomain { field: UP.path, value: 0.0, domain: "it must have a direction".into() });
    }
    segments_of_points(light.points(), light.transform(), unit_up(light), light.get(END_MODE), false)
}

/// Builds the segments as `segments` does, but for other control points. The light's other values must have been
/// checked.
pub fn segments_of_points(
    control: &[ControlPoint],
    transform: Transform,
    up: DVec3,
    end_mode: EndMode,
    may_fold: bool,
) -> Result<(Vec<Segment<f64>>, Placement), LightError> {
    check_points(control)?;
    let polygon = polygon_length(control);
    if polygon == 0.0 {
        return Err(LightError::Degenerate { segment: 0, why: "has all its control points in one place", point: 1 });
    }
    let bad_size = |field, value| {
        let domain = "the light's size must be a number that can be worked with".into();
        Err(LightError::OutOfDomain { field, value, domain })
    };
    if !polygon.is_finite() || polygon < f64::MIN_POSITIVE * 1e20 {
        return bad_size("points", polygon);
    }
    if !(polygon * transform.scale).is_finite() {
        return bad_size(SCALE.path, transform.scale);
    }
    let unit = libm::exp2(libm::floor(libm::log2(polygon)));
    let values = ControlValues::of(control, unit);

    let mut out: Vec<Segment<f64>> = Vec::with_capacity(control.len() - 1);
    let (mut arc_start, mut end_frame) = (0.0, None);
    for i in 0..control.len() - 2 {
        let mut curve = segment_curve(&values, i)?;
        end_frame = Some(set_frame(&mut curve, end_frame, up));
        curve.bounds = curve.tube_box();
        let r_kappa = validity::r_kappa_max(&curve);
        if r_kappa >= 1.0 && !may_fold {
            return Err(LightError::Fold { segment: i, r_kappa, point: i + 1 });
        }
        let (color, intensity) = (bezier(&values.colors, i), bezier(&values.intensities, i));
        out.push(Segment { curve, color, intensity, arc_start });
        arc_start += arc_length(&curve, 1.0);
    }
    if end_mode == EndMode::Extend {
        out.extend(extension_segment(&out[out.len() - 1], arc_start));
    }
    let rotation = transform.world_from_local_axes();
    Ok((out, Placement { translation: transform.translation, rotation, world_per_tube: transform.scale * unit }))
}

/// Values of the control points, one list for each spline.
struct ControlValues {
    positions: Vec<DVec3>,
    radii: Vec<f64>,
    colors: Vec<DVec3>,
    intensities: Vec<f64>,
}

impl ControlValues {
    /// Takes the values apart, with positions and radii in units of `unit`, a power of two.
    fn of(points: &[ControlPoint], unit: f64) -> Self {
        Self {
            positions: points.iter().map(|point| point.position / unit).collect(),
            radii: points.iter().map(|point| point.radius / unit).collect(),
            colors: points.iter().map(|point| point.color).collect(),
            intensities: points.iter().map(|point| point.intensity).collect(),
        }
    }
}

/// Returns position and radius of segment `i`, without its frame. A segment without a direction is an error.
fn segment_curve(values: &ControlValues, i: usize) -> Result<Curve<f64>, LightError> {
    let ControlValues { positions, radii, .. } = values;
    let [b0, _, b2] = bezier(positions, i);
    let (d0, d1) = half_derivatives(positions, i);
    let (e0, e1) = half_derivatives(radii, i);
    let degenerate = |why, point| Err(LightError::Degenerate { segment: i, why, point });
    if d0 == DVec3::ZERO && d1 == DVec3::ZERO {
        return degenerate("has its three control points in one place", i + 1);
    }
    let is_straight = d0.cross(d1).length() <= STRAIGHT_SINE * d0.length() * d1.length();
    if is_straight && d0.dot(d1) < 0.0 {
        return degenerate("doubles back over itself", i + 2);
    }
    Ok(Curve {
        b0,
        b2,
        d0,
        d1,
        a: d1 - d0,
        n_hat: DVec3::ZERO,
        alpha: 0.0,
        beta: 0.0,
        r0: bezier(radii, i)[0],
        e0,
        ar: e1 - e0,
        bounds: TubeBox { center: DVec3::ZERO, axes: [DVec3::ZERO; 3], half: [0.0; 3] },
    })
}

/// Returns the light's `up` as a unit vector, without overflow.
pub fn unit_up(light: &Light) -> DVec3 {
    let up = light.get(UP);
    (up / up.abs().max_element()).normalize()
}

/// Returns the segment past the last control point: straight, with linear radius, colour and intensity. `None` if the
/// curve has no direction at its end.
fn extension_segment(last: &Segment<f64>, arc_start: f64) -> Option<Segment<f64>> {
    let end = &last.curve;
    if end.d1 == DVec3::ZERO {
        return None;
    }
    let u_hat = end.u_hat(1.0);
    let (v_hat, w_hat) = end.rotation_minimizing(u_hat);
    let mut curve = Curve {
        b0: end.b2,
        b2: end.b2 + end.d1 * 2.0,
        d0: end.d1,
        d1: end.d1,
        a: DVec3::ZERO,
        n_hat: w_hat,
        alpha: 0.0,
        // v_hat = beta m with m = n_hat x u_hat = w_hat x u_hat = v_hat.
        beta: w_hat.cross(u_hat).dot(v_hat).signum(),
        r0: end.radius(1.0),
        e0: end.e0 + end.ar,
        ar: 0.0,
        bounds: end.bounds,
    };
    curve.bounds = curve.tube_box();
    let ([_, c1, c2], [_, i1, i2]) = (last.color, last.intensity);
    let (color_growth, intensity_growth) = ((c2 - c1) * 2.0, (i2 - i1) * 2.0);
    let color = [c2, c2 + color_growth * 0.5, c2 + color_growth];
    let intensity = [i2, i2 + intensity_growth * 0.5, i2 + intensity_growth];
    Some(Segment { curve, color, intensity, arc_start })
}
