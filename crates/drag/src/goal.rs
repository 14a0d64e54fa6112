//! What a drag is after: two equations that hold where the feature lies under the cursor, and what must stay above 0.

use glam::{DVec2, DVec3};
use light::{CheckedLight, Rays};
use raycast::Seen;

use crate::moves::{LARGEST_FOLD, Moves};
use crate::place::{Place, Placed};
use crate::quadratic::Linear;
use crate::request::{Feature, Limit, Radii};

/// Least of `1 - kappa r.N`: at 0 ways of the light meet, and light comes from nowhere.
const LEAST_SPREAD: f64 = 0.02;

/// How far inside of the light's edge the place under the cursor stays, in radii.
const INSIDE: f64 = 1e-4;

/// How much farther than the pivot a shadowed place lies, along the light.
const BEHIND: f64 = 1e-6;

/// A feature on its way from where it was taken to the cursor.
#[derive(Clone, Debug)]
pub(crate) struct Goal<'a> {
    pub feature: Feature,
    /// The light as the drag began.
    pub start: &'a CheckedLight,
    pub moves: Moves,
    /// Where it was taken.
    pub from: Seen,
    /// Where it goes.
    pub to: Seen,
    /// Of a shadow: what throws it.
    pub pivot: Option<DVec3>,
    /// The light as it was, for what lights are measured by.
    pub placed: Placed<'a>,
    /// Where `from` was in the light.
    pub place: Place,
    /// Directions to the light, as it was at `from` and as it is to be at `to`, where they are what is dragged.
    pub directions: [DVec3; 2],
    /// The largest `R kappa` of each segment as the drag began, and so what it may have.
    pub folds: Vec<f64>,
}

/// Places that are followed while the light moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub t: f64,
    pub pivot_t: f64,
}

/// How a light does.
#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    /// How far the feature lies off, in radii of the light or in radians.
    pub residual: [f64; 2],
    /// What is to stay 0 or more.
    pub limits: Vec<f64>,
    pub near: Near,
}

impl Goal<'_> {
    /// Where the feature is to lie at a share of its way, and from where light is to come there.
    fn target(&self, share: f64) -> (DVec3, DVec3) {
        let [from, to] = self.directions;
        (self.from.position.lerp(self.to.position, share), between(from, to, share))
    }

    /// How the light with `x` does at a share of the way; `None` where it cannot be evaluated.
    pub fn evaluate(&self, x: &[f64], share: f64, near: Near) -> Option<Evaluation> {
        let rays = self.moves.rays(self.start, x)?;
        let placed = self.placed.with(&rays);
        let (point, direction) = self.target(share);
        let place = placed.locate(point, Some(near.t))?;
        let mut limits = self.shape_limits(&rays, x);
        limits.push(place.spread - LEAST_SPREAD);
        limits.push(1.0 - INSIDE - placed.out2(&place));
        limits.push(place.from_ends.min(1.0));
        let mut pivot_t = near.pivot_t;
        let residual = match (self.feature, self.pivot) {
            (Feature::Shadow, Some(pivot)) => {
                let pivot = placed.locate(pivot, Some(near.pivot_t))?;
                pivot_t = pivot.t;
                limits.push((place.t - pivot.t) / self.place.t.max(f64::MIN_POSITIVE) - BEHIND);
                (pivot.across - place.across) * (place.width / self.place.width)
            }
            (Feature::Shadow | Feature::Hotspot, _) => {
                (place.across - self.place.across) * (place.width / self.place.width)
            }
            (Feature::Highlight | Feature::Diffuse, _) => {
                let ahead = place.to_light.dot(direction);
                if ahead <= 0.0 {
                    return None;
                }
                let (right, up) = direction.any_orthonormal_pair();
                DVec2::new(place.to_light.dot(right), place.to_light.dot(up))
            }
        };
        let near = Near { t: place.t, pivot_t };
        (residual.is_finite() && limits.iter().all(|limit| limit.is_finite())).then(|| Evaluation {
            residual: residual.to_array(),
            limits,
            near,
        })
    }

    /// How far the feature goes, in radii of the light or in radians.
    pub fn way(&self) -> f64 {
        let [from, to] = self.directions;
        match self.feature {
            Feature::Shadow | Feature::Hotspot => {
                self.from.position.distance(self.to.position) / self.place.width
            }
            Feature::Highlight | Feature::Diffuse => {
                let across = self.from.position.distance(self.to.position) / self.place.width;
                libm::atan2(from.cross(to).length(), from.dot(to)).max(across)
            }
        }
    }

    /// Whether nothing that may change does anything to the feature where it is.
    pub fn has_no_weight(&self, near: Near) -> bool {
        let x = vec![0.0; self.moves.count()];
        let Some(at) = self.evaluate(&x, 0.0, near) else { return false };
        let jacobian = self.linear(&x, 0.0, &at).jacobian;
        (0..2).all(|row| jacobian.row(row).iter().all(|slope| slope.abs() < 1e-9))
    }

    /// What keeps the light's own shape: no fold, no radius below nothing.
    fn shape_limits(&self, rays: &Rays, x: &[f64]) -> Vec<f64> {
        let (Moves::Points { points, radii, unit }, Rays::Bent(tube)) = (&self.moves, rays) else {
            return Vec::new();
        };
        let folds = tube.r_kappa_max();
        let mut limits: Vec<f64> = folds
            .iter()
            .zip(&self.folds)
            .map(|(fold, most)| (most.max(LARGEST_FOLD) - fold) / LARGEST_FOLD)
            .collect();
        if *radii == Radii::Solve {
            let all = self.start.light().points();
            limits.extend(
                points
                    .iter()
                    .enumerate()
                    .map(|(k, &point)| x[3 * points.len() + k] + all[point].radius / unit),
            );
        }
        limits
    }

    /// Which limit the one of that index is.
    pub fn limit(&self, index: usize) -> Limit {
        let (folds, radii) = match &self.moves {
            Moves::Points { points, radii: Radii::Solve, .. } => (self.folds.len(), points.len()),
            Moves::Points { .. } => (self.folds.len(), 0),
            _ => (0, 0),
        };
        match index {
            index if index < folds => Limit::Fold,
            index if index < folds + radii => Limit::Radius,
            index if index == folds + radii => Limit::Fold,
            index if index < folds + radii + 3 => Limit::TubeEdge,
            _ => Limit::NoDescent,
        }
    }

    /// What is linear about `x`, by central differences: to some 1e-10 of what it is, which Newton's method makes up for.
    pub fn linear(&self, x: &[f64], share: f64, at: &Evaluation) -> Linear {
        const STEP: f64 = 1e-6;
        let (count, limits) = (x.len(), at.limits.len());
        let mut linear = Linear {
            residual: at.residual.to_vec(),
            jacobian: crate::quadratic::Matrix::zero(2, count),
            limits: at.limits.clone(),
            slopes: crate::quadratic::Matrix::zero(limits, count),
        };
        let mut beside = x.to_vec();
        for k in 0..count {
            let mut side = |step: f64| {
                beside[k] = x[k] + step;
                let found = self.evaluate(&beside, share, at.near);
                beside[k] = x[k];
                found
            };
            let (ahead, behind) = (side(STEP), side(-STEP));
            // At the very edge of what can be evaluated one side is all there is.
            let (ahead, behind, length) = match (&ahead, &behind) {
                (Some(ahead), Some(behind)) => (ahead, behind, 2.0 * STEP),
                (Some(ahead), None) => (ahead, at, STEP),
                (None, Some(behind)) => (at, behind, STEP),
                (None, None) => continue,
            };
            for row in 0..2 {
                *linear.jacobian.at(row, k) = (ahead.residual[row] - behind.residual[row]) / length;
            }
            for row in 0..limits {
                *linear.slopes.at(row, k) = (ahead.limits[row] - behind.limits[row]) / length;
            }
        }
        linear
    }
}

/// The unit vector at a share of the shortest turn from one to another.
fn between(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    let cos = from.dot(to);
    let across = (to - from * cos).normalize_or_zero();
    let angle = libm::atan2(from.cross(to).length(), cos) * share;
    from * libm::cos(angle) + across * libm::sin(angle)
}
