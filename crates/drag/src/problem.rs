//! A drag as equations, a metric and bounds, evaluated and linearized at a light.

use light::{CheckedLight, LightRays};

use crate::bound::{Bound, MIN_PATH_SPACING, cross_error, direction_error_about, distance_behind, hard_bound};
use crate::goal::{STEPS_OF_COPY, STEPS_OF_POINT, TakenFeature};
use crate::matrix::Matrix;
use crate::moves::{MAX_R_KAPPA, Unknowns};
use crate::penalized::{Slopes, StepValues};
use crate::picture_metric::{EDGE_SLOPE, PictureMetric, within_edge};
use crate::pins::PinState;
use crate::point_in_light::{PointInLight, SceneLight};
use crate::quadratic::Hold;
use crate::request::{DragLimit, Feature, RadiusMode};
use crate::work::WorkBudget;

/// Change of an unknown between two evaluations for a finite difference.
const DIFFERENCE: f64 = 1e-6;

/// Least share of the brightness at the feature, where it was taken, that remains at the cursor.
const LEAST_BRIGHTNESS_SHARE: f64 = 0.5;

/// Brightness below which a feature cannot be seen, as a share of the brightest point's.
const UNSEEN: f64 = 0.02;

/// Least cosine between the normal under the cursor and the direction to the light.
const LEAST_COSINE: f64 = 0.05;

/// Room of the feature, in widths or as a cosine, on its way through the air between two surfaces. It shrinks to 0 at
/// the cursor.
const ROOM_ON_PATH: f64 = 3.0;

/// Drag of a feature.
pub(crate) struct Problem<'a> {
    pub start: &'a CheckedLight,
    pub unknowns: &'a Unknowns,
    /// Light at the start of the drag, in scene space.
    pub scene_light: SceneLight<'a>,
    pub taken: &'a TakenFeature,
    pub metric: &'a PictureMetric,
    pub pins: &'a [PinState],
    /// Largest `R kappa` of each segment at the start of the drag.
    pub folds: Vec<f64>,
}

/// Values of `t` that are tracked while the light moves.
#[derive(Clone, Debug)]
pub(crate) struct Tracked {
    /// Values of the feature and of its caster.
    pub feature: [f64; 2],
    /// Values of each pin and its caster.
    pub pins: Vec<[f64; 2]>,
    /// Values of the points of the metric.
    pub points: Vec<f64>,
}

/// Values of a drag at a light.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    /// Must be 0: the feature's error, in radii or radians, then those of hard pins.
    pub equations: Vec<f64>,
    /// Weighted changes of the picture, then the errors of soft pins.
    pub rows: Vec<f64>,
    pub bounds: Vec<Bound>,
    pub tracked: Tracked,
}

impl Evaluated {
    pub fn values(&self) -> StepValues<'_> {
        StepValues { equations: &self.equations, rows: &self.rows, bounds: &self.bounds }
    }

    /// Returns the size of the errors of the equations.
    pub fn error(&self) -> f64 {
        self.equations.iter().fold(0.0, |most, error| f64::max(most, error.abs()))
    }

    /// Returns the bound that is violated most, if any is by more than `tolerance`.
    pub fn violated(&self, tolerance: f64) -> Option<DragLimit> {
        let worst =
            self.bounds.iter().filter(|bound| bound.compliance == 0.0).min_by(|a, b| a.value.total_cmp(&b.value));
        worst.filter(|bound| bound.value < -tolerance).map(|bound| bound.limit)
    }
}

impl<'a> Problem<'a> {
    /// Returns the values of `t` at the start of the drag, with those of the feature and its caster.
    pub fn tracked_at_start(&self, feature: [f64; 2]) -> Tracked {
        Tracked { feature, pins: self.pins.iter().map(PinState::start_t).collect(), points: self.metric.start_t() }
    }

    /// Evaluates the light that the unknowns `x` give, with the feature's target at a share of its way. `None` if the
    /// light cannot be evaluated, or if the budget is spent.
    pub fn evaluate(&self, x: &[f64], share: f64, near: &Tracked) -> Option<Evaluated> {
        let rays = self.rays(x)?;
        let placed = self.scene_light.with(&rays);
        let mut bounds = self.shape_bounds(&rays, x);
        let (error, feature) = self.feature_error(&placed, share, near.feature, &mut bounds)?;
        let (mut equations, mut rows) = (error.to_vec(), Vec::new());
        let points = self.metric.add_rows(&placed, &near.points, &mut rows);
        let mut pins = Vec::with_capacity(near.pins.len());
        for (pin, near) in self.pins.iter().zip(&near.pins) {
            let mut errors = Vec::new();
            let (tracked, _) = pin.add_residual(&placed, *near, &mut errors, &mut bounds)?;
            for (error, hold) in errors.into_iter().zip(pin.row_holds()) {
                match hold {
                    Hold::Soft(compliance) => rows.push(error / compliance.sqrt()),
                    _ => equations.push(error),
                }
            }
            pins.push(tracked);
        }
        let all = equations.iter().chain(&rows).chain(bounds.iter().map(|bound| &bound.value));
        let is_finite = all.copied().all(f64::is_finite);
        is_finite.then_some(Evaluated { equations, rows, bounds, tracked: Tracked { feature, pins, points } })
    }

    /// Computes the slopes about `x` by central differences.
    pub fn slopes(&self, x: &[f64], share: f64, at: &Evaluated) -> Slopes {
        let n = x.len();
        let mut slopes = Slopes {
            equations: Matrix::zero(at.equations.len(), n),
            rows: Matrix::zero(at.rows.len(), n),
            bounds: Matrix::zero(at.bounds.len(), n),
        };
        let mut beside = x.to_vec();
        for k in 0..n {
            let mut evaluate_at = |change: f64| {
                beside[k] = x[k] + change;
                let found = self.evaluate(&beside, share, &at.tracked);
                beside[k] = x[k];
                found
            };
            let (ahead, behind) = (evaluate_at(DIFFERENCE), evaluate_at(-DIFFERENCE));
            // At the edge of the domain only one side can be evaluated.
            let (ahead, behind, length) = match (&ahead, &behind) {
                (Some(ahead), Some(behind)) => (ahead, behind, 2.0 * DIFFERENCE),
                (Some(ahead), None) => (ahead, at, DIFFERENCE),
                (None, Some(behind)) => (at, behind, DIFFERENCE),
                (None, None) => continue,
            };
            fill(&mut slopes.equations, k, &ahead.equations, &behind.equations, length);
            fill(&mut slopes.rows, k, &ahead.rows, &behind.rows, length);
            for (row, (ahead, behind)) in ahead.bounds.iter().zip(&behind.bounds).enumerate() {
                *slopes.bounds.at(row, k) = (ahead.value - behind.value) / length;
            }
        }
        slopes
    }

    /// Returns the rays of the light that the unknowns `x` give. `None` if the light cannot be evaluated or the budget
    /// is spent.
    pub fn rays(&self, x: &[f64]) -> Option<LightRays> {
        let points = self.start.light().points().len() as u64;
        let of_a_point = if matches!(self.unknowns, Unknowns::Points { .. }) { STEPS_OF_POINT } else { STEPS_OF_COPY };
        self.work().spend(of_a_point * points).then(|| self.unknowns.rays_that_may_fold(self.start, x))?
    }

    pub fn work(&self) -> &'a WorkBudget<'a> {
        self.scene_light.work
    }

    /// Computes the limits of the light's own shape: no segment folds, and no radius is negative.
    fn shape_bounds(&self, rays: &LightRays, x: &[f64]) -> Vec<Bound> {
        let (Unknowns::Points { points, radii, unit }, LightRays::Bent(tube)) = (self.unknowns, rays) else {
            return Vec::new();
        };
        let room = |(fold, most): (f64, &f64)| libm::log(most.max(MAX_R_KAPPA) / fold.clamp(0.1, 1e3));
        let folds = tube.r_kappa_max().into_iter().zip(&self.folds);
        let mut bounds: Vec<Bound> = folds.map(|fold| hard_bound(room(fold), DragLimit::Fold)).collect();
        if *radii == RadiusMode::Solve {
            let all = self.start.light().points();
            let radius = |(k, point): (usize, &usize)| x[3 * points.len() + k] + all[*point].radius / unit;
            bounds.extend(points.iter().enumerate().map(|of| hard_bound(radius(of), DragLimit::Radius)));
        }
        bounds
    }

    /// Computes the error of the feature with its target at a share of its way, and the bounds by which it can be seen
    /// there. Also returns the tracked `t` of the feature and its caster.
    fn feature_error(
        &self,
        placed: &SceneLight,
        share: f64,
        near: [f64; 2],
        bounds: &mut Vec<Bound>,
    ) -> Option<([f64; 2], [f64; 2])> {
        let taken = self.taken;
        let (target, direction) = taken.target(share);
        let coords = placed.locate(target, Some(near[0]))?;
        let room = ROOM_ON_PATH * (1.0 - share);
        bounds.push(hard_bound(coords.path_spacing - MIN_PATH_SPACING, DragLimit::Fold));
        bounds.push(hard_bound(self.brightness_bound(placed, &coords) + room, DragLimit::TubeEdge));
        bounds.push(hard_bound(coords.distance_to_ends.min(1.0) + room, DragLimit::TubeEdge));
        let cosine = taken.to.normal.dot(coords.to_light);
        bounds.push(hard_bound(cosine - LEAST_COSINE + room, DragLimit::TubeEdge));
        let mut caster_t = near[1];
        let error = match (taken.feature, taken.pivot) {
            (Feature::Shadow, Some(pivot)) => {
                let caster = placed.locate(pivot, Some(near[1]))?;
                caster_t = caster.t;
                bounds.push(hard_bound(
                    distance_behind(&coords, &caster, &taken.start_coords) + room,
                    DragLimit::TubeEdge,
                ));
                bounds.push(hard_bound(caster.distance_to_ends.min(1.0) + room, DragLimit::TubeEdge));
                cross_error(caster.cross_coords, &coords, &taken.start_coords)
            }
            (Feature::Shadow | Feature::Hotspot, _) => {
                -cross_error(taken.start_coords.cross_coords, &coords, &taken.start_coords)
            }
            (Feature::Highlight | Feature::Diffuse, _) => {
                direction_error_about(coords.to_light, direction, taken.axis())?
            }
        };
        Some((error.to_array(), [coords.t, caster_t]))
    }

    /// Returns the logarithm of the brightness at the feature, as a share of the least one at which it can still be
    /// seen.
    fn brightness_bound(&self, placed: &SceneLight, coords: &PointInLight) -> f64 {
        let rho = placed.rho2(coords).sqrt();
        let now = placed.edge_profile(coords) * within_edge(rho - 1.0) + UNSEEN;
        let least = LEAST_BRIGHTNESS_SHARE * self.scene_light.edge_profile(&self.taken.start_coords) + UNSEEN;
        libm::log(now / least) - EDGE_SLOPE * (rho - 1.0).clamp(0.0, 1.0)
    }
}

fn fill(slopes: &mut Matrix, column: usize, ahead: &[f64], behind: &[f64], length: f64) {
    for (row, (ahead, behind)) in ahead.iter().zip(behind).enumerate() {
        *slopes.at(row, column) = (ahead - behind) / length;
    }
}
