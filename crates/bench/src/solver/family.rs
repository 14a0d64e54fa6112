//! Families of inputs on which the solvers are compared: curves that a light can have, and points around them.

use fastrand::Rng;
use glam::DVec3;
use light::{Curve, TubeBox};
use serde::Serialize;

use super::width::FloatWidth;

/// Family of segments and points. The same case number gives the same case on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Family {
    /// Bends of up to 60 degrees, the point inside the tube or around it.
    Ordinary,
    /// Bends of 10^-1 to 10^-10: the cubic's leading coefficients vanish in rounding.
    NearlyStraight,
    /// No bend, with constant and with changing speed.
    Straight,
    /// One end tangent 10 to 10^4 times as long as the other.
    Uneven,
    /// The curve turns back on itself.
    Hairpin,
    /// One end tangent 10^-2 to 10^-7 of the other: P' almost vanishes at that end.
    Cusp,
    /// Two control points coincide: P' is zero at an end.
    Coincident,
    /// Segment and point together 10^3 to 10^6 away from the origin.
    FarOffset,
    /// Everything 10^-4 to 10^4 times as large.
    Scaled,
    /// The point on the curve itself.
    OnCurve,
    /// The point on the surface of the widest tube that the bend allows.
    Boundary,
    /// The point 10 to 10^4 lengths away.
    FarPoint,
    /// The point near the evolute, `1 - kappa r.N` of 10^-1 to 10^-7: two roots almost meet.
    NearEvolute,
    /// The point on the plane across one end, or within rounding of it.
    AtEnd,
    /// Control points and point anywhere in a box.
    Anywhere,
}

/// All families, in the order of reports.
pub const FAMILIES: [Family; 15] = [
    Family::Ordinary,
    Family::NearlyStraight,
    Family::Straight,
    Family::Uneven,
    Family::Hairpin,
    Family::Cusp,
    Family::Coincident,
    Family::FarOffset,
    Family::Scaled,
    Family::OnCurve,
    Family::Boundary,
    Family::FarPoint,
    Family::NearEvolute,
    Family::AtEnd,
    Family::Anywhere,
];

/// Input of a solver: a curve and a point `q`, for the parameters at which `q - P(u)` is perpendicular to the curve.
#[derive(Clone, Debug)]
pub struct SolverCase<F: FloatWidth> {
    /// Only positions and derivatives matter.
    pub curve: Curve<F>,
    pub q: F::Vec3,
}

impl SolverCase<f64> {
    /// Rounds every number to `F`, as the light model does for a light.
    pub fn rounded<F: FloatWidth>(&self) -> SolverCase<F> {
        SolverCase { curve: F::curve(&self.curve), q: F::vec(self.q) }
    }
}

impl Family {
    /// True if `P'` almost vanishes somewhere on the curves of this family.
    pub fn has_vanishing_derivative(self) -> bool {
        matches!(self, Self::Hairpin | Self::Cusp | Self::Coincident)
    }

    /// Makes case `index` of this family.
    pub fn case(self, index: u64) -> SolverCase<f64> {
        let rng = &mut Rng::with_seed((self as u64 + 1) << 48 | index);
        let strength = (index % 10) as f64;
        if let Self::FarOffset | Self::Scaled = self {
            let SolverCase { curve, q } = Self::Ordinary.case(index);
            if self == Self::FarOffset {
                let offset = direction(rng) * magnitude(rng, 3.0, 6.0);
                return SolverCase { curve: curve_of(curve.b0 + offset, curve.d0, curve.d1), q: q + offset };
            }
            let scale = magnitude(rng, -4.0, 4.0);
            let [b0, d0, d1] = [curve.b0, curve.d0, curve.d1].map(|vector| vector * scale);
            return SolverCase { curve: curve_of(b0, d0, d1), q: q * scale };
        }
        let curve = match self {
            Self::NearlyStraight => bent(rng, libm::exp10(-1.0 - strength)),
            Self::Straight => {
                let (b0, d0) = (cube(rng), direction(rng));
                let speed = if rng.bool() { 1.0 } else { uniform(rng, 0.2, 5.0) };
                curve_of(b0, d0, d0 * speed)
            }
            Self::Uneven | Self::Cusp | Self::Coincident => {
                let curve = bent(rng, 1.0);
                let ratio = match self {
                    Self::Uneven => magnitude(rng, -4.0, -1.0),
                    Self::Cusp => libm::exp10(-2.0 - strength % 6.0),
                    _ => 0.0,
                };
                with_end_speed(rng, &curve, ratio)
            }
            Self::Hairpin => {
                let (b0, d0) = (cube(rng), direction(rng));
                let width = magnitude(rng, -3.0, -0.5);
                curve_of(b0, d0, d0 * -uniform(rng, 0.5, 2.0) + direction(rng) * width)
            }
            Self::Anywhere => {
                let (c0, c1, c2) = (cube(rng), cube(rng), cube(rng));
                curve_of(c0, c1 - c0, c2 - c1)
            }
            _ => bent(rng, 1.0),
        };
        let q = match self {
            Self::NearlyStraight => in_tube(rng, &curve, 0.9),
            Self::Uneven => around(rng, &curve, 1.0),
            Self::Hairpin | Self::Cusp | Self::Coincident => near_slowest(rng, &curve),
            Self::OnCurve => curve.position(rng.f64()),
            Self::Boundary => {
                let u = rng.f64();
                curve.position(u) + across(rng, &curve, u) * (0.9 * narrowest(&curve))
            }
            Self::FarPoint => curve.b0 + direction(rng) * magnitude(rng, 1.0, 4.0),
            Self::NearEvolute => {
                let u = rng.f64();
                let (d, a) = (curve.d(u), curve.a);
                // P'' across P' points to the center of curvature, |d|^2 / (2 a_across) away, with |P'|^2 = 4 |d|^2.
                let a_across = a - d * (a.dot(d) / d.length_squared());
                let sign = if rng.bool() { 1.0 } else { -1.0 };
                let short = 1.0 - sign * magnitude(rng, -7.0, -1.0);
                let to_center = a_across * (2.0 * d.length_squared() / a_across.length_squared());
                curve.position(u) + to_center * short + d.cross(a).normalize_or_zero() * uniform(rng, -1.0, 1.0)
            }
            Self::AtEnd => {
                let u = f64::from(rng.bool());
                let q = curve.position(u) + across(rng, &curve, u) * (rng.f64() * narrowest(&curve));
                let past = if rng.bool() { 0.0 } else { uniform(rng, -1.0, 1.0) * magnitude(rng, -9.0, -5.0) };
                q + curve.d(u) * past
            }
            Self::Anywhere => cube(rng) * 2.0,
            Self::Ordinary | Self::Straight | Self::FarOffset | Self::Scaled => {
                if rng.bool() {
                    in_tube(rng, &curve, 0.9)
                } else {
                    around(rng, &curve, 1.0)
                }
            }
        };
        SolverCase { curve, q }
    }
}

/// Makes one end tangent of a curve `ratio` times as long.
fn with_end_speed(rng: &mut Rng, curve: &Curve<f64>, ratio: f64) -> Curve<f64> {
    let [start, end] = if rng.bool() { [ratio, 1.0] } else { [1.0, ratio] };
    curve_of(curve.b0, curve.d0 * start, curve.d1 * end)
}

/// Returns a random number from `10^low` to `10^high`, log-uniform.
fn magnitude(rng: &mut Rng, low: f64, high: f64) -> f64 {
    libm::exp10(uniform(rng, low, high))
}

fn uniform(rng: &mut Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

/// Returns a random point, uniform in the cube of half width 1.
fn cube(rng: &mut Rng) -> DVec3 {
    DVec3::new(uniform(rng, -1.0, 1.0), uniform(rng, -1.0, 1.0), uniform(rng, -1.0, 1.0))
}

/// Returns a random unit vector, uniform over the sphere.
fn direction(rng: &mut Rng) -> DVec3 {
    loop {
        let v = cube(rng);
        if (0.01..=1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// Makes a segment whose end tangents differ by up to `bend` times their length.
fn bent(rng: &mut Rng, bend: f64) -> Curve<f64> {
    let (b0, d0) = (cube(rng), direction(rng) * uniform(rng, 0.5, 1.0));
    curve_of(b0, d0, d0 + direction(rng) * (d0.length() * bend * uniform(rng, 0.1, 0.9)))
}

/// Returns the smallest radius of curvature, or the segment's length if that is less.
fn narrowest(curve: &Curve<f64>) -> f64 {
    (1.0 / kappa_max(curve)).min(curve.d0.length() + curve.d1.length())
}

/// Returns the largest curvature over the segment: `kappa = |d0 x d1| / (2 |d|^3)` is greatest where `|d|` is least.
pub fn kappa_max(curve: &Curve<f64>) -> f64 {
    let slowest = slowest(curve);
    curve.d0.cross(curve.d1).length() / (2.0 * slowest * slowest * slowest)
}

/// Returns the smallest `|d|` over the segment.
pub fn slowest(curve: &Curve<f64>) -> f64 {
    curve.d(u_of_slowest(curve)).length()
}

fn u_of_slowest(curve: &Curve<f64>) -> f64 {
    let u = -curve.d0.dot(curve.a) / curve.a.length_squared();
    if u.is_finite() { u.clamp(0.0, 1.0) } else { 0.0 }
}

/// Returns a random unit vector across the curve at `u`.
fn across(rng: &mut Rng, curve: &Curve<f64>, u: f64) -> DVec3 {
    loop {
        let (v, u_hat) = (direction(rng), curve.u_hat(u));
        let across = v - u_hat * v.dot(u_hat);
        if across.length_squared() > 0.01 {
            return across.normalize();
        }
    }
}

/// Returns a random point within `share` of the radius of the widest tube that the curve's bend allows.
fn in_tube(rng: &mut Rng, curve: &Curve<f64>, share: f64) -> DVec3 {
    let u = rng.f64();
    let radius = share * rng.f64() * narrowest(curve);
    curve.position(u) + across(rng, curve, u) * radius
}

/// Returns a random point in a cube around the segment, `reach` lengths wider than the segment.
fn around(rng: &mut Rng, curve: &Curve<f64>, reach: f64) -> DVec3 {
    curve.position(rng.f64()) + cube(rng) * (reach * curve.d0.length().max(curve.d1.length()))
}

/// Returns a random point around the segment, or 10^-5 to 10^-1 lengths from its slowest point: there P' almost
/// vanishes and roots lie close together.
fn near_slowest(rng: &mut Rng, curve: &Curve<f64>) -> DVec3 {
    if rng.bool() {
        return around(rng, curve, 1.0);
    }
    let length = curve.d0.length() + curve.d1.length();
    curve.position(u_of_slowest(curve)) + cube(rng) * (length * magnitude(rng, -5.0, -1.0))
}

/// Makes a curve. Its radius and frame do not matter here and are zero.
fn curve_of(b0: DVec3, d0: DVec3, d1: DVec3) -> Curve<f64> {
    let a = d1 - d0;
    Curve {
        b0,
        b2: b0 + d0 + d1,
        d0,
        d1,
        a,
        n_hat: DVec3::ZERO,
        alpha: 0.0,
        beta: 0.0,
        r0: 0.0,
        e0: 0.0,
        ar: 0.0,
        bounds: TubeBox { center: DVec3::ZERO, axes: [DVec3::ZERO; 3], half: [0.0; 3] },
    }
}
