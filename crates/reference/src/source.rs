//! Lights at a point, without shadows.

use glam::{DVec2, DVec3};
use light::{CheckedLight, Cone, LightCoords, LightProfile, LightRays, Omni, Parallel, Tube};

/// Light that is ready for sampling.
#[derive(Clone, Debug)]
pub enum ReferenceLight {
    Bendy(Tube<f64>),
    Spot(Cone),
    Directional(Parallel),
    Omni(Omni),
}

/// Sample of a light at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Light coordinates of the surface.
    pub coords: LightCoords,
    /// Unit vector in world space from the surface back along the light path, which visibility follows. It
    /// differs from `coords.direction` by the terms that a light's `direction` parameter leaves out.
    pub along_path: DVec3,
    /// Unshadowed irradiance on a surface perpendicular to the light, linear RGB.
    pub irradiance: DVec3,
    /// True if no occluder lies on the light path.
    pub is_visible: bool,
}

impl ReferenceLight {
    /// Returns the falloff, lobes and shadow of the light.
    pub fn light_profile(&self) -> &LightProfile {
        match self {
            Self::Bendy(tube) => &tube.light_profile,
            Self::Spot(cone) => &cone.light_profile,
            Self::Omni(omni) => &omni.light_profile,
            Self::Directional(parallel) => &parallel.light_profile,
        }
    }

    /// Prepares a light for sampling.
    pub fn new(light: &CheckedLight) -> Self {
        match light.rays() {
            LightRays::Bent(tube) => Self::Bendy(tube.clone()),
            LightRays::Cone(cone) => Self::Spot(cone.clone()),
            LightRays::Parallel(parallel) => Self::Directional(parallel.clone()),
            LightRays::Omni(omni) => Self::Omni(omni.clone()),
        }
    }

    /// Returns the world position of the source, or of the window's centre for a directional light.
    pub(crate) fn position(&self) -> DVec3 {
        match self {
            Self::Bendy(tube) => tube.placement.translation,
            Self::Spot(cone) => cone.translation,
            Self::Omni(omni) => omni.translation,
            Self::Directional(parallel) => parallel.translation,
        }
    }

    /// Samples the light at a point, without its shadow. `source` is the position of the light, with the same origin as
    /// `point`. Returns `None` outside the light.
    pub(crate) fn sample(&self, source: DVec3, point: DVec3) -> Option<LightSample> {
        let straight = |coords: LightCoords, irradiance: DVec3| (coords, coords.direction, irradiance);
        let (coords, along_path, irradiance) = match self {
            Self::Bendy(tube) => {
                // Like `Placement::tube_from_world`, but relative to a near origin.
                let in_tube = tube.placement.rotation.transpose() * (point - source) / tube.placement.world_per_tube;
                let root = tube.nearest_root(in_tube)?;
                let along_path = tube.placement.rotation * tube.path_direction_at(&root);
                (tube.coords_at(&root), along_path, tube.irradiance(&root))
            }
            Self::Spot(cone) => {
                let coords = cone.locate(point - source)?;
                straight(coords, cone.irradiance(&coords))
            }
            Self::Omni(omni) => {
                let coords = omni.locate(point - source)?;
                straight(coords, omni.irradiance(&coords))
            }
            Self::Directional(parallel) => {
                let coords = Parallel { translation: source, ..parallel.clone() }.locate(point)?;
                straight(coords, parallel.irradiance(&coords))
            }
        };
        Some(LightSample { coords, along_path, irradiance, is_visible: true })
    }
}

/// Returns the coordinates of `point`, which lies near the point of `sample`, inside the tube or beyond its
/// rim: `t`, and (v, w) in radii.
///
/// Newton's method on `(q - P) . P'` starts at the sample's `t`. Each step squares the error, which starts as
/// the curvature over the distance.
pub(crate) fn coords_near(tube: &Tube<f64>, source: DVec3, sample: &LightSample, point: DVec3) -> (f64, DVec2) {
    const STEPS: usize = 8;
    let q = tube.placement.rotation.transpose() * (point - source) / tube.placement.world_per_tube;
    let last = tube.segments.len() - 1;
    // The extension past the last segment is infinite.
    let end = if last == tube.n { f64::INFINITY } else { tube.n as f64 };
    let piece = |t: f64| {
        let index = (t as usize).min(last);
        (&tube.segments[index].curve, t - index as f64)
    };
    let mut t = sample.coords.t;
    for _ in 0..STEPS {
        let (curve, u) = piece(t);
        let (r, d) = (curve.offset(q, u), curve.d(u));
        let slope = 2.0 * d.length_squared() - r.dot(curve.a);
        if slope <= 0.0 {
            break;
        }
        t = (t + r.dot(d) / slope).clamp(0.0, end);
    }
    let (curve, u) = piece(t);
    let (v_hat, w_hat) = tube.cross_section(curve, curve.u_hat(u));
    let (r, radius) = (curve.offset(q, u), curve.radius(u));
    let radii = if radius > 0.0 { radius } else { 1.0 };
    (t, DVec2::new(r.dot(v_hat), r.dot(w_hat)) / radii)
}
