//! Lights, and what they do at a point: everything but their shadows.

use glam::{DMat3, DVec2, DVec3};
use light::LightKind;
use light::{Decay, LightError, SpotLight, Tube, check_spot};

/// A checked light, ready to be asked.
#[derive(Clone, Debug)]
pub enum Source {
    /// Light along a spline.
    Bendy(Tube<f64>),
    /// Light along straight lines.
    Spot(SpotLight),
}

/// What a light does at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Place along the light: 0 to the number of segments, or the share of the range of a spotlight.
    pub t: f64,
    /// Place across the light; 1 is the edge.
    pub vw: DVec2,
    /// Unit vector in world space from the surface towards the arriving light.
    pub to_light: DVec3,
    /// Unit vector in world space from the surface back along the path that the light takes; it is what
    /// visibility follows, and differs from `to_light` by what a light's `direction` leaves out.
    pub along_path: DVec3,
    /// On a surface square to `to_light`, linear RGB, without the shadow.
    pub irradiance: DVec3,
    /// Whether nothing is in the way.
    pub visible: bool,
}

impl Source {
    /// Where its light comes from, in the world.
    pub fn position_in_world(&self) -> DVec3 {
        match self {
            Self::Bendy(tube) => tube.placement.translation,
            Self::Spot(spot) => spot.transform.translation,
        }
    }

    /// Checks a light and prepares it.
    pub fn new(light: &LightKind) -> Result<Self, LightError> {
        Ok(match light {
            LightKind::Bendy(light) => Self::Bendy(Tube::new(light)?),
            LightKind::Spot(light) => {
                check_spot(light)?;
                Self::Spot(light.clone())
            }
        })
    }
}

/// A spotlight with its source at `source`, at `point` (light model, section 6), or `None` outside its cone. Shares nothing with a
/// BendyLight's evaluation, so that each can test the other.
///
/// The profile is a smoothstep in the cosine of the angle off the axis.
pub(crate) fn sample_spot(spot: &SpotLight, source: DVec3, point: DVec3) -> Option<LightSample> {
    let rotation = DMat3::from_quat(spot.transform.rotation.normalize());
    let position = rotation.transpose() * (point - source);
    let (depth, distance) = (-position.z, position.length());
    let slope = position.truncate() / depth;
    let outer = spot.cone_angle.to_radians();
    let tan_outer = libm::tan(outer);
    let in_range = spot.range.is_none_or(|range| depth <= range);
    if !(depth > 0.0 && slope.length() <= tan_outer && in_range) {
        return None;
    }
    let (cos_outer, cos_inner) = (libm::cos(outer), libm::cos(outer * (1.0 - spot.cone_softness)));
    let span = cos_inner - cos_outer;
    let s = if span > 0.0 { ((depth / distance - cos_outer) / span).clamp(0.0, 1.0) } else { 1.0 };
    let decay = match spot.decay {
        Decay::None => 1.0,
        Decay::Linear => 1.0 / distance,
        Decay::InverseSquare => 1.0 / (distance * distance),
    };
    let to_light = rotation * (-position / distance);
    Some(LightSample {
        t: spot.range.map_or(0.0, |range| depth / range),
        // w_hat is up, v_hat = w_hat x u_hat is to the left of +x.
        vw: DVec2::new(-slope.x, slope.y) / tan_outer,
        to_light,
        along_path: to_light,
        // Neither below zero, as in a BendyLight.
        irradiance: spot.color.max(DVec3::ZERO) * (spot.intensity.max(0.0) * s * s * (3.0 - 2.0 * s) * decay),
        visible: true,
    })
}

/// A BendyLight with its source at `source`, at `point`, or `None` outside its tube.
pub(crate) fn sample_tube(tube: &Tube<f64>, source: DVec3, point: DVec3) -> Option<LightSample> {
    // As Placement::tube_from_world, but about a near origin.
    let in_tube = tube.placement.rotation.transpose() * (point - source) / tube.placement.world_per_tube;
    let root = tube.nearest_root(in_tube)?;
    let place = tube.describe(&root);
    Some(LightSample {
        t: place.t,
        vw: DVec2::new(place.v, place.w),
        to_light: place.direction,
        along_path: tube.placement.rotation * tube.path_direction_at(&root),
        irradiance: tube.irradiance(&root),
        visible: true,
    })
}

/// Where `point` lies, a little beside the place of `sample`, inside of the tube or past its rim: `t`, and (v, w) in
/// radii.
///
/// Newton's method on `(q - P) . P'` from that place: a few steps, each squaring an error that starts as the bend of the
/// curve over the distance.
pub(crate) fn place_beside(
    tube: &Tube<f64>,
    source: DVec3,
    sample: &LightSample,
    point: DVec3,
) -> (f64, DVec2) {
    const STEPS: usize = 8;
    let q = tube.placement.rotation.transpose() * (point - source) / tube.placement.world_per_tube;
    let last = tube.segments.len() - 1;
    // The extension past the last segment has no end.
    let end = if last == tube.n { f64::INFINITY } else { tube.n as f64 };
    let piece = |t: f64| {
        let index = (t as usize).min(last);
        (&tube.segments[index], t - index as f64)
    };
    let mut t = sample.t;
    for _ in 0..STEPS {
        let (segment, u) = piece(t);
        let (r, d) = (segment.offset(q, u), segment.d(u));
        let slope = 2.0 * d.length_squared() - r.dot(segment.a);
        if slope <= 0.0 {
            break;
        }
        t = (t + r.dot(d) / slope).clamp(0.0, end);
    }
    let (segment, u) = piece(t);
    let (v_hat, w_hat) = tube.cross_section(segment, segment.u_hat(u));
    let (r, radius) = (segment.offset(q, u), segment.radius(u));
    let radii = if radius > 0.0 { radius } else { 1.0 };
    (t, DVec2::new(r.dot(v_hat), r.dot(w_hat)) / radii)
}
