//! What a drag may change of a light, as numbers that are 0 where it begins and alike in size.

use glam::{DMat3, DQuat, DVec3};
use light::parameters::{ROTATION, TRANSLATION};
use light::{CheckedLight, ControlPoint, Light, LightRays, r_kappa_max_of_segments};

use crate::request::RadiusMode;

/// The largest `R kappa` that a drag makes; at 1 a tube folds.
pub(crate) const MAX_R_KAPPA: f64 = 0.97;

/// Where radii begin to shrink for a bend, `R kappa`.
const SHRINK_FROM_R_KAPPA: f64 = 0.8;

/// What may change.
#[derive(Clone, Debug)]
pub(crate) enum Unknowns {
    /// The placement: three numbers are a way in `unit` world units, three a rotation in radians about the source.
    Rigid { unit: f64 },
    /// The rotation alone, of a light that comes from everywhere.
    Turn,
    /// Control points: three numbers each are an offset in `unit` light-local units, and with [`RadiusMode::Solve`] one more each
    /// is that of its radius.
    Points { points: Vec<usize>, radii: RadiusMode, unit: f64 },
}

impl Unknowns {
    /// How many numbers they are.
    pub fn count(&self) -> usize {
        match self {
            Self::Rigid { .. } => 6,
            Self::Turn => 3,
            Self::Points { points, radii, .. } => {
                points.len() * if *radii == RadiusMode::Solve { 4 } else { 3 }
            }
        }
    }

    /// The light with them; a tube that folds is one too.
    pub fn light(&self, start: &Light, x: &[f64]) -> Light {
        if let Self::Points { .. } = self {
            let moved = self.points(start, x);
            return start.clone().map_points(|index, point| *point = moved[index]);
        }
        let (translation, rotation) = self.placement(start, x);
        let turned = start.clone().with(ROTATION, rotation);
        // A light that is only turned has its other values to the bit.
        if translation == start.get(TRANSLATION) { turned } else { turned.with(TRANSLATION, translation) }
    }

    /// Where the light's source is with them, and how it is turned.
    fn placement(&self, start: &Light, x: &[f64]) -> (DVec3, DQuat) {
        let (translation, rotation) = (start.get(TRANSLATION), start.get(ROTATION));
        let turned =
            |by: &[f64]| (DQuat::from_scaled_axis(DVec3::from_slice(by)) * rotation.normalize()).normalize();
        match self {
            Self::Rigid { unit } => (translation + DVec3::from_slice(&x[..3]) * *unit, turned(&x[3..])),
            Self::Turn => (translation, turned(x)),
            Self::Points { .. } => (translation, rotation),
        }
    }

    /// The light's control points with them.
    pub fn points(&self, start: &Light, x: &[f64]) -> Vec<ControlPoint> {
        let mut all = start.points().to_vec();
        let Self::Points { points, radii, unit } = self else { return all };
        for (k, &index) in points.iter().enumerate() {
            let Some(point) = all.get_mut(index) else { continue };
            point.position += DVec3::from_slice(&x[3 * k..][..3]) * *unit;
            if *radii == RadiusMode::Solve {
                point.radius += x[3 * points.len() + k] * unit;
            }
        }
        self.shrink_radii(start, &mut all);
        all
    }

    /// How points are found in the light with them; `None` where it cannot be evaluated.
    pub fn rays(&self, start: &CheckedLight, x: &[f64]) -> Option<LightRays> {
        if let (Self::Points { .. }, Some(tube)) = (self, start.tube()) {
            return tube.with_points(start.light(), &self.points(start.light(), x)).ok().map(LightRays::Bent);
        }
        let (translation, rotation) = self.placement(start.light(), x);
        let rotation = DMat3::from_quat(rotation);
        let mut rays = start.rays().clone();
        match &mut rays {
            LightRays::Bent(tube) => {
                (tube.placement.translation, tube.placement.rotation) = (translation, rotation);
            }
            LightRays::Cone(cone) => (cone.translation, cone.rotation) = (translation, rotation),
            LightRays::Omni(omni) => (omni.translation, omni.rotation) = (translation, rotation),
            LightRays::Parallel(parallel) => {
                (parallel.translation, parallel.rotation) = (translation, rotation);
            }
        }
        Some(rays)
    }
}

impl Unknowns {
    /// Lets the radii of control points that have moved follow.
    pub fn shrink_radii(&self, start: &Light, moved: &mut [ControlPoint]) {
        if let Self::Points { radii: RadiusMode::Follow, .. } = self {
            shrink_folding_radii(start.points(), moved);
        }
    }

    /// How far a control point is from a share of its way to a light-local position, in units of what moves.
    pub fn position_error(&self, start: &Light, x: &[f64], point: usize, to: DVec3, share: f64) -> DVec3 {
        let Self::Points { points, unit, .. } = self else { return DVec3::ZERO };
        let Some(k) = points.iter().position(|&moving| moving == point) else { return DVec3::ZERO };
        DVec3::from_slice(&x[3 * k..][..3]) - (to - start.points()[point].position) / *unit * share
    }
}

/// Makes those radii smaller that would make the tube of these control points fold: continuous in their positions, and where
/// nothing is nearer to folding than `arrive` was they stay.
///
/// A segment's radius is a mean of those of its three control points, so that a segment whose three shrink by a factor
/// shrinks by that at least.
fn shrink_folding_radii(start: &[ControlPoint], moved: &mut [ControlPoint]) {
    let all = 0..moved.len().saturating_sub(2);
    let (Ok(begun), Ok(folds)) =
        (r_kappa_max_of_segments(start, all.clone()), r_kappa_max_of_segments(moved, all))
    else {
        return;
    };
    let factor = |point: usize| {
        let segments = point.saturating_sub(2)..(point + 1).min(folds.len());
        segments.map(|segment| allowed_radius_share(folds[segment], begun[segment])).fold(1.0, f64::min)
    };
    let factors: Vec<f64> = (0..moved.len()).map(factor).collect();
    for (point, factor) in moved.iter_mut().zip(factors) {
        if factor < 1.0 {
            point.radius *= factor;
        }
    }
}

/// The share of its radius that a segment with that `R kappa` may have, which had `begun`: what was near to folding already
/// may stay so.
fn allowed_radius_share(fold: f64, begun: f64) -> f64 {
    let shrinks_from = begun.clamp(SHRINK_FROM_R_KAPPA, MAX_R_KAPPA);
    if fold <= shrinks_from {
        return 1.0;
    }
    if !fold.is_finite() {
        return 0.0;
    }
    let (room, beyond) = (MAX_R_KAPPA - shrinks_from, fold - shrinks_from);
    // With the slope 1 at first, and never all of the room.
    (shrinks_from + room * beyond / (room + beyond)) / fold
}
