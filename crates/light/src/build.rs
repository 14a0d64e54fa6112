//! From what an artist set to a [`Tube`] that can be evaluated: checks, Bezier extraction and the frame's
//! constants.

use glam::{DMat3, DVec3};

use crate::segment::{Segment, TubeBox};
use crate::{BendyLight, EndMode, LightError, Real, SpotLight, Transform, arc, validity};

/// Most segments of one light: far past what an artist handles, and small enough for any GPU buffer.
pub const MAX_SEGMENTS: usize = 256;

/// Where tube space lies in the world. Tube space is light-local space scaled by a power of two so that the
/// control polygon is about one unit long: f32 then never under- or overflows, and the scaling itself is
/// exact.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// World position of the source.
    pub translation: DVec3,
    /// World axes from tube axes.
    pub rotation: DMat3,
    /// World units per tube unit.
    pub world_per_tube: f64,
}

impl Placement {
    /// Tube-space position of a world position.
    pub fn tube_from_world(&self, world: DVec3) -> DVec3 {
        (self.rotation.transpose() * (world - self.translation)) / self.world_per_tube
    }

    /// World position of a tube-space position.
    pub fn world_from_tube(&self, tube: DVec3) -> DVec3 {
        self.translation + self.rotation * (tube * self.world_per_tube)
    }
}

/// Checks the fields that both kinds of light have.
fn check_common(transform: &Transform, cone_angle: f64, cone_softness: f64) -> Result<(), LightError> {
    if !transform.translation.is_finite() || !transform.rotation.is_finite() || !transform.scale.is_finite() {
        return Err(LightError::NotFinite("transform"));
    }
    let length = transform.rotation.length();
    if !(0.5..=2.0).contains(&length) {
        let domain = "it must be a unit quaternion [x, y, z, w], of length 1";
        return Err(LightError::OutOfDomain { field: "transform.rotation's length", value: length, domain });
    }
    if transform.scale <= 0.0 {
        let domain = "it must be more than 0";
        return Err(LightError::OutOfDomain { field: "transform.scale", value: transform.scale, domain });
    }
    if !(cone_angle > 0.0 && cone_angle < 90.0) {
        let domain = "it must lie between 0 and 90 degrees";
        return Err(LightError::OutOfDomain { field: "coneAngle", value: cone_angle, domain });
    }
    if !(0.0..=1.0).contains(&cone_softness) {
        let domain = "it must lie from 0 to 1";
        return Err(LightError::OutOfDomain { field: "coneSoftness", value: cone_softness, domain });
    }
    Ok(())
}

/// Checks a spotlight: everything finite and in its domain.
pub fn check_spot(light: &SpotLight) -> Result<(), LightError> {
    check_common(&light.transform, light.cone_angle, light.cone_softness)?;
    if !light.color.is_finite() {
        return Err(LightError::NotFinite("color"));
    }
    if !light.intensity.is_finite() {
        return Err(LightError::NotFinite("intensity"));
    }
    match light.range {
        Some(range) if !(range.is_finite() && range > 0.0) => {
            Err(LightError::OutOfDomain { field: "range", value: range, domain: "it must be more than 0" })
        }
        _ => Ok(()),
    }
}

/// Checks lengths, finiteness and domains of a BendyLight's own fields.
fn check_bendy(light: &BendyLight) -> Result<(), LightError> {
    let count = light.points.len();
    if count < 3 {
        return Err(LightError::TooFewPoints(count));
    }
    if count > MAX_SEGMENTS + 2 {
        return Err(LightError::TooManyPoints { count, limit: MAX_SEGMENTS + 2 });
    }
    let lengths = [
        ("radii", light.radii.len()),
        ("colors", light.colors.len()),
        ("intensities", light.intensities.len()),
    ];
    for (field, len) in lengths {
        if len != count {
            return Err(LightError::LengthMismatch { field, count: len, points: count });
        }
    }
    let finite = [
        ("points", light.points.iter().all(|p| p.is_finite())),
        ("radii", light.radii.iter().all(|r| r.is_finite())),
        ("colors", light.colors.iter().all(|c| c.is_finite())),
        ("intensities", light.intensities.iter().all(|i| i.is_finite())),
        ("up", light.up.is_finite()),
    ];
    if let Some((field, _)) = finite.iter().find(|(_, ok)| !ok) {
        return Err(LightError::NotFinite(field));
    }
    // Wider than this, f32 has no digits left for the curve. A light without length is refused for that.
    let length = polygon_length(&light.points);
    let widest = if length > 0.0 { 1e6 * length } else { f64::MAX };
    if let Some((index, &value)) = light.radii.iter().enumerate().find(|(_, r)| !(0.0..=widest).contains(*r))
    {
        return Err(LightError::Radius { index, value });
    }
    if light.up == DVec3::ZERO {
        return Err(LightError::OutOfDomain { field: "up", value: 0.0, domain: "it must have a direction" });
    }
    if light.points[0] != DVec3::ZERO {
        return Err(LightError::SourceNotAtOrigin);
    }
    check_common(&light.transform, light.cone_angle, light.cone_softness)
}

/// Bezier control values of segment `i` of the clamped uniform quadratic B-spline through `c` (light model,
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

/// Length of the control polygon.
fn polygon_length(points: &[DVec3]) -> f64 {
    points.windows(2).map(|p| p[1].distance(p[0])).sum()
}

/// Half the derivatives at both ends, from the control points' differences so that neighbours share them bit
/// for bit.
fn half_derivatives<T>(c: &[T], i: usize) -> (T, T)
where
    T: Copy + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let n = c.len() - 2;
    let first = (c[i + 1] - c[i]) * if i == 0 { 1.0 } else { 0.5 };
    let second = (c[i + 2] - c[i + 1]) * if i == n - 1 { 1.0 } else { 0.5 };
    (first, second)
}

/// The segments of a checked light, in tube space, and the placement of that space.
pub fn segments(light: &BendyLight) -> Result<(Vec<Segment<f64>>, Placement), LightError> {
    check_bendy(light)?;
    let polygon = polygon_length(&light.points);
    if polygon == 0.0 {
        return Err(LightError::Degenerate {
            segment: 0,
            why: "has all its control points in one place",
            point: 1,
        });
    }
    if !(polygon * light.transform.scale).is_finite() || polygon < f64::MIN_POSITIVE * 1e20 {
        let domain = "the light's size must be a number that can be worked with";
        return Err(LightError::OutOfDomain { field: "points", value: polygon, domain });
    }
    let unit = libm::exp2(libm::floor(libm::log2(polygon)));
    let points: Vec<DVec3> = light.points.iter().map(|&p| p / unit).collect();
    let radii: Vec<f64> = light.radii.iter().map(|&r| r / unit).collect();

    let mut out: Vec<Segment<f64>> = Vec::with_capacity(points.len() - 1);
    let mut arc_start = 0.0;
    let mut carried = None;
    let up = unit_up(light);
    for i in 0..points.len() - 2 {
        let mut segment = shape(light, &points, &radii, i)?;
        segment.arc_start = arc_start;
        carried = Some(orient(&mut segment, carried, up));
        segment.bounds = segment.tube_box();
        arc_start += arc::length(&segment, 1.0);
        let r_kappa = validity::r_kappa_max(&segment);
        if r_kappa >= 1.0 {
            return Err(LightError::Fold { segment: i, r_kappa, point: i + 1 });
        }
        out.push(segment);
    }
    if light.end_mode == EndMode::Extend {
        out.extend(extension(&out[out.len() - 1], arc_start));
    }
    let transform = light.transform;
    let rotation = DMat3::from_quat(transform.rotation.normalize());
    Ok((
        out,
        Placement { translation: transform.translation, rotation, world_per_tube: transform.scale * unit },
    ))
}

/// Position, radius, colour and intensity of segment `i`, without its frame; refuses one that has no direction.
fn shape(light: &BendyLight, points: &[DVec3], radii: &[f64], i: usize) -> Result<Segment<f64>, LightError> {
    let [b0, _, b2] = bezier(points, i);
    let (d0, d1) = half_derivatives(points, i);
    let (e0, e1) = half_derivatives(radii, i);
    let straight = d0.cross(d1).length() <= STRAIGHT * d0.length() * d1.length();
    if d0 == DVec3::ZERO && d1 == DVec3::ZERO {
        let why = "has its three control points in one place";
        return Err(LightError::Degenerate { segment: i, why, point: i + 1 });
    }
    if straight && d0.dot(d1) < 0.0 {
        let why = "doubles back over itself";
        return Err(LightError::Degenerate { segment: i, why, point: i + 2 });
    }
    Ok(Segment {
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
        color: bezier(&light.colors, i),
        intensity: bezier(&light.intensities, i),
        arc_start: 0.0,
        bounds: TubeBox { center: DVec3::ZERO, axes: [DVec3::ZERO; 3], half: [0.0; 3] },
    })
}

/// Below this sine of the angle between the end tangents a segment's plane is rounding noise.
const STRAIGHT: f64 = 1e-13;

/// `(u_hat, v_hat)` at the end of a segment, for the next one to go on from.
type Carried = (DVec3, DVec3);

/// Sets the frame's constants (light model, section 2) and returns what the next segment starts from.
fn orient(segment: &mut Segment<f64>, carried: Option<Carried>, up: DVec3) -> Carried {
    let u_hat = segment.u_hat(0.0);
    let v_hat = match carried {
        None => perpendicular_up::<f64>(up, u_hat).cross(u_hat),
        Some((u_before, v_before)) => minimal_rotation(u_before, u_hat, v_before),
    };
    let v_hat = (v_hat - u_hat * v_hat.dot(u_hat)).normalize();
    let normal = segment.d0.cross(segment.d1);
    let bent = normal.length() > STRAIGHT * segment.d0.length() * segment.d1.length();
    let n = if bent { normal.normalize() } else { u_hat.cross(v_hat) };
    segment.n_hat = (n - u_hat * n.dot(u_hat)).normalize();
    let (alpha, beta) = (v_hat.dot(segment.n_hat), v_hat.dot(segment.n_hat.cross(u_hat)));
    let length = alpha.hypot(beta);
    (segment.alpha, segment.beta) = (alpha / length, beta / length);
    let u_end = segment.u_hat(1.0);
    (u_end, segment.rotation_minimizing(u_end).0)
}

/// `w_hat` from the unit vector `up`: its part across `u_hat`, or the least-aligned axis's where they are
/// parallel.
pub fn perpendicular_up<F: Real>(up: F::Vec3, u_hat: F::Vec3) -> F::Vec3 {
    let across = |v: F::Vec3| v - u_hat * F::dot(v, u_hat);
    let perp = across(up);
    if F::dot(perp, perp) >= F::of(1e-12) {
        // Once more: what rounding left along `u_hat` is large against a small `perp`.
        let perp = across(F::unit(perp).unwrap_or(perp));
        return F::unit(perp).unwrap_or(perp);
    }
    let axis = across(F::vec(least_aligned_axis(F::vec_f64(u_hat))));
    F::unit(axis).unwrap_or(axis)
}

/// The light's `up` as a unit vector, whatever its size.
pub fn unit_up(light: &BendyLight) -> DVec3 {
    (light.up / light.up.abs().max_element()).normalize()
}

/// The coordinate axis that leans least towards `v`.
fn least_aligned_axis(v: DVec3) -> DVec3 {
    let magnitude = v.abs();
    if magnitude.x <= magnitude.y && magnitude.x <= magnitude.z {
        DVec3::X
    } else if magnitude.y <= magnitude.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// `v` turned by the smallest rotation that takes the unit vector `from` to `to`: nothing where the curve is
/// C1, and the turn at a corner where two control points coincide.
fn minimal_rotation(from: DVec3, to: DVec3, v: DVec3) -> DVec3 {
    let (cos, axis) = (from.dot(to), from.cross(to));
    if cos <= -1.0 + 1e-12 {
        return v;
    }
    v * cos + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cos))
}

/// The light past its last control point: straight on, with linear radius, colour and intensity; `None` where
/// it ends without a direction to go on in.
fn extension(last: &Segment<f64>, arc_start: f64) -> Option<Segment<f64>> {
    let grow = |b: [f64; 3]| 2.0 * (b[2] - b[1]);
    let grow3 = |b: [DVec3; 3]| (b[2] - b[1]) * 2.0;
    if last.d1 == DVec3::ZERO {
        return None;
    }
    let u_hat = last.u_hat(1.0);
    let (v_hat, w_hat) = last.rotation_minimizing(u_hat);
    let (i2, c2) = (last.intensity[2], last.color[2]);
    let mut segment = Segment {
        b0: last.b2,
        b2: last.b2 + last.d1 * 2.0,
        d0: last.d1,
        d1: last.d1,
        a: DVec3::ZERO,
        n_hat: w_hat,
        alpha: 0.0,
        // v_hat = beta m with m = n_hat x u_hat = w_hat x u_hat = v_hat.
        beta: w_hat.cross(u_hat).dot(v_hat).signum(),
        r0: last.radius(1.0),
        e0: last.e0 + last.ar,
        ar: 0.0,
        color: [c2, c2 + grow3(last.color) * 0.5, c2 + grow3(last.color)],
        intensity: [i2, i2 + grow(last.intensity) * 0.5, i2 + grow(last.intensity)],
        arc_start,
        bounds: last.bounds,
    };
    segment.bounds = segment.tube_box();
    Some(segment)
}
