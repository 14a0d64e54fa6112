//! Unknowns of a drag: numbers that are 0 at the start and similar in scale.

use glam::{DMat3, DQuat, DVec3};
use light::parameters::{ROTATION, TRANSLATION};
use light::{CheckedLight, ControlPoint, Light, LightRays, r_kappa_max_of_segments};

use crate::request::RadiusMode;

/// Largest `R kappa` that a drag gives a segment. A tube folds at 1.
pub(crate) const MAX_R_KAPPA: f64 = 0.97;

/// Value of `R kappa` at which radii that follow begin to shrink.
const SHRINK_FROM_R_KAPPA: f64 = 0.8;

#[derive(Clone, Debug)]
pub(crate) enum Unknowns {
    /// Placement: a translation in `unit` world units (three numbers) and a rotation about the source in radians
    /// (three).
    Rigid { unit: f64 },
    /// Rotation alone, for a directional light, or for a light that is placed by its rotation alone.
    Turn,
    /// Translation alone in `unit` world units, for a light that is placed by its translation alone.
    Move { unit: f64 },
    /// Control points: for each an offset in `unit` light-local units (three numbers), and with [`RadiusMode::Solve`]
    /// also the change of its radius (one number).
    Points { points: Vec<usize>, radii: RadiusMode, unit: f64 },
}

impl Unknowns {
    /// Returns the number of unknowns.
    pub fn count(&self) -> usize {
        match self {
            Self::Rigid { .. } => 6,
            Self::Turn | Self::Move { .. } => 3,
            Self::Points { points, radii, .. } => points.len() * if *radii == RadiusMode::Solve { 4 } else { 3 },
        }
    }

    /// Returns the light that the unknowns `x` give. It is not checked: its tube may fold.
    pub fn light(&self, start: &Light, x: &[f64]) -> Light {
        if let Self::Points { .. } = self {
            let moved = self.points(start, x);
            return start.clone().map_points(|index, point| *point = moved[index]);
        }
        let (translation, rotation) = self.placement(start, x);
        let turned = start.clone().with(ROTATION, rotation);
        // A light that only rotates keeps its other values to the bit.
        if translation == start.get(TRANSLATION) { turned } else { turned.with(TRANSLATION, translation) }
    }

    /// Returns the translation and the rotation of the light that the unknowns `x` give.
    fn placement(&self, start: &Light, x: &[f64]) -> (DVec3, DQuat) {
        let (translation, rotation) = (start.get(TRANSLATION), start.get(ROTATION));
        let turned = |by: &[f64]| (DQuat::from_scaled_axis(DVec3::from_slice(by)) * rotation.normalize()).normalize();
        match self {
            Self::Rigid { unit } => (translation + DVec3::from_slice(&x[..3]) * *unit, turned(&x[3..])),
            Self::Turn => (translation, turned(x)),
            Self::Move { unit } => (translation + DVec3::from_slice(x) * *unit, rotation),
            Self::Points { .. } => (translation, rotation),
        }
    }

    /// Returns the control points of the light that the unknowns `x` give.
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

    /// Returns the rays of the light that the unknowns `x` give, also those of a tube that folds. `None` if the light
    /// cannot be evaluated.
    pub fn rays(&self, start: &CheckedLight, x: &[f64]) -> Option<LightRays> {
        if let (Self::Points { .. }, Some(tube)) = (self, start.tube()) {
            let points = self.points(start.light(), x);
            return tube.with_points(start.light(), &points).ok().map(LightRays::Bent);
        }
        Some(self.placed_rays(start, x))
    }

    fn placed_rays(&self, start: &CheckedLight, x: &[f64]) -> LightRays {
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
        rays
    }

    /// Shrinks radii to follow moved control points, with [`RadiusMode::Follow`] only.
    pub fn shrink_radii(&self, start: &Light, moved: &mut [ControlPoint]) {
        if let Self::Points { radii: RadiusMode::Follow, .. } = self {
            shrink_folding_radii(start.points(), moved);
        }
    }

    /// Computes the offset of a control point from the target at a share of its path, in units of the unknowns. `to` is
    /// in light-local space.
    pub fn position_error(&self, start: &Light, x: &[f64], point: usize, to: DVec3, share: f64) -> DVec3 {
        let Self::Points { points, unit, .. } = self else { return DVec3::ZERO };
        let Some(k) = points.iter().position(|&moving| moving == point) else { return DVec3::ZERO };
        DVec3::from_slice(&x[3 * k..][..3]) - (to - start.points()[point].position) / *unit * share
    }
}

/// Shrinks the radii that would make the tube of these control points fold. The result is continuous in the positions.
/// Radii stay where no segment is nearer to folding than it was in `start`.
///
/// A segment's radius is a mean of the radii of its three control points. So if all three shrink by a factor, the
/// segment shrinks by at least that factor.
fn shrink_folding_radii(start: &[ControlPoint], moved: &mut [ControlPoint]) {
    let all = 0..moved.len().saturating_sub(2);
    let (Ok(start_folds), Ok(folds)) =
        (r_kappa_max_of_segments(start, all.clone()), r_kappa_max_of_segments(moved, all))
    else {
        return;
    };
    let factor = |point: usize| {
        let segments = point.saturating_sub(2)..(point + 1).min(folds.len());
        segments.map(|segment| allowed_radius_share(folds[segment], start_folds[segment])).fold(1.0, f64::min)
    };
    let factors: Vec<f64> = (0..moved.len()).map(factor).collect();
    for (point, factor) in moved.iter_mut().zip(factors) {
        if factor < 1.0 {
            point.radius *= factor;
        }
    }
}

/// Computes the factor by which the radius of a segment with `R kappa` of `fold` may be multiplied, if its `R kappa`
/// was `start_fold` at the start. A segment that was nearly folding then may stay so.
fn allowed_radius_share(fold: f64, start_fold: f64) -> f64 {
    let shrinks_from = start_fold.clamp(SHRINK_FROM_R_KAPPA, MAX_R_KAPPA);
    if fold <= shrinks_from {
        return 1.0;
    }
    if !fold.is_finite() {
        return 0.0;
    }
    let (room, beyond) = (MAX_R_KAPPA - shrinks_from, fold - shrinks_from);
    // The slope is 1 at first, and the value never reaches `MAX_R_KAPPA`.
    (shrinks_from + room * beyond / (room + beyond)) / fold
}
