//! A drag as equations, rows of least squares and bounds, evaluated and linearized at a light.

use glam::DVec3;
use light::{CheckedLight, LightRays, TubeOverlap, r_kappa_max_of_segments};

use crate::bound::{Bound, MIN_PATH_SPACING, cross_error, direction_error_about, distance_behind, hard_bound};
use crate::convex_step::Slopes;
use crate::matrix::Matrix;
use crate::moves::{MAX_R_KAPPA, Unknowns};
use crate::overlap::OverlapRule;
use crate::picture_metric::{EDGE_SLOPE, PictureMetric, within_edge};
use crate::pin_state::{LimitTangent, PinRow, PinState};
use crate::pins::Pins;
use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::{DragLimit, Feature, RadiusMode};
use crate::taken_feature::TakenFeature;
use crate::work::WorkBudget;

/// Change of an unknown between two evaluations for a finite difference.
const DIFFERENCE: f64 = 1e-6;

/// Least share of the brightness at the feature, where it was taken, that remains at the cursor.
const LEAST_BRIGHTNESS_SHARE: f64 = 0.5;

/// Brightness below which a feature cannot be seen, as a share of the brightest point's.
const UNSEEN: f64 = 0.02;

/// Least cosine between the normal under the cursor and the direction to the light.
const LEAST_COSINE: f64 = 0.05;

/// Least share of its start that a radius keeps if it follows the control points.
const LEAST_RADIUS_SHARE: f64 = 0.8;

/// Room of the feature, in widths or as a cosine, on its way through the air between two surfaces. It shrinks to 0 at
/// the cursor.
const ROOM_ON_PATH: f64 = 3.0;

/// Costs per control point, in steps of the work budget. This one is for rebuilding a tube. The next ones are the
/// additional cost of radii that follow, and the cost of only moving a tube.
const STEPS_OF_POINT: u64 = 400;
const STEPS_OF_FOLLOWING: u64 = 400;
const STEPS_OF_COPY: u64 = 40;

/// Wish of a drag.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Objective<'a> {
    /// Moves a feature under the cursor.
    Feature(&'a TakenFeature),
    /// Moves a control point towards a position in light-local space, as near as the bounds allow.
    Position { point: usize, to: DVec3 },
    /// Changes the unknowns, those of a placement, by this much, or as nearly as the bounds allow.
    Placement(&'a [f64]),
}

/// Objective, unknowns and constraints of a drag.
pub(crate) struct Problem<'a> {
    pub objective: Objective<'a>,
    /// Light at the start of the drag.
    pub start: &'a CheckedLight,
    pub unknowns: &'a Unknowns,
    /// Light at the start of the drag, in scene space. Later lights have the same origin, chart and budget.
    pub scene_light: SceneLight<'a>,
    pub metric: &'a PictureMetric,
    /// Factor of the weights of the metric.
    pub picture_weight: f64,
    pub pins: &'a Pins,
    /// Tangents of limits without a slope that the light may not cross.
    pub tangents: Vec<LimitTangent>,
    /// Largest `R kappa` of each segment at the start of the drag. A segment that was above the limit may keep it.
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
    /// Number of equations of the feature.
    pub of_feature: usize,
    /// Weighted changes of the picture, then the errors of soft pins or the distance of the control point.
    pub rows: Vec<f64>,
    pub bounds: Vec<Bound>,
    pub tracked: Tracked,
}

impl Evaluated {
    /// Returns the hard bound that is violated most, if any is by more than `tolerance`.
    pub fn violated(&self, tolerance: f64) -> Option<DragLimit> {
        let hard = self.bounds.iter().filter(|bound| bound.compliance == 0.0);
        let worst = hard.min_by(|a, b| a.value.total_cmp(&b.value));
        worst.filter(|bound| bound.value < -tolerance).map(|bound| bound.limit)
    }
}

impl<'a> Problem<'a> {
    /// Makes the problem of a drag without tangents.
    pub fn new(
        objective: Objective<'a>,
        start: &'a CheckedLight,
        unknowns: &'a Unknowns,
        scene_light: SceneLight<'a>,
        metric: &'a PictureMetric,
        pins: &'a Pins,
    ) -> Self {
        let folds = start.tube().map_or_else(Vec::new, light::Tube::r_kappa_max);
        Self { objective, start, unknowns, scene_light, metric, picture_weight: 1.0, pins, tangents: Vec::new(), folds }
    }

    /// Returns the unknowns at the start of the drag.
    pub fn unmoved(&self) -> Vec<f64> {
        vec![0.0; self.unknowns.count()]
    }

    /// Returns the values of `t` at the start of the drag, with those of the feature and its caster.
    pub fn tracked_at_start(&self, feature: [f64; 2]) -> Tracked {
        Tracked {
            feature,
            pins: self.pins.states.iter().map(PinState::start_t).collect(),
            points: self.metric.start_t(),
        }
    }

    /// Evaluates the light that the unknowns `x` give, with the objective at a share of its way. `None` if the light
    /// cannot be evaluated, or if the budget is spent.
    pub fn evaluate(&self, x: &[f64], share: f64, near: &Tracked) -> Option<Evaluated> {
        let (mut equations, mut rows, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
        let mut tracked = Tracked { pins: Vec::with_capacity(near.pins.len()), ..near.clone() };
        let mut of_feature = 0;
        match self.objective {
            Objective::Feature(_) => {}
            Objective::Position { point, to } => {
                rows.extend(self.unknowns.position_error(self.start.light(), x, point, to, share).to_array());
                bounds = self.bounds_of_segments(x, point)?;
            }
            Objective::Placement(whole) => rows.extend(x.iter().zip(whole).map(|(x, whole)| x - whole * share)),
        }
        // A control point needs no tube if nothing else limits it.
        let is_of_feature = matches!(self.objective, Objective::Feature(_));
        if is_of_feature || !self.pins.states.is_empty() || !self.tangents.is_empty() {
            let rays = self.rays(x)?;
            let placed = self.scene_light.with(&rays);
            if let Objective::Feature(taken) = self.objective {
                bounds = self.shape_bounds(&rays, x);
                let (error, at) = self.feature_error(taken, &placed, share, near.feature, &mut bounds)?;
                equations.extend(error);
                (of_feature, tracked.feature) = (error.len(), at);
                let metric = self.metric.add_rows(&placed, &near.points, self.picture_weight, &mut rows);
                // An end of the light that the picture does not show stays out of it.
                bounds.extend(metric.room_before_ends.map(|room| hard_bound(room, DragLimit::TubeEdge)));
                tracked.points = metric.t;
            }
            for (pin, near) in self.pins.states.iter().zip(&near.pins) {
                let (at, coords) = pin.add_rows(&placed, *near, &mut bounds, |row| match row {
                    PinRow::Equation(error) => equations.push(error),
                    // Soft errors of a hard pin weigh against the picture, not against a place that is asked for.
                    PinRow::Soft(error) if is_of_feature || pin.is_of_node => rows.push(error),
                    PinRow::Soft(_) => {}
                })?;
                tracked.pins.push(at);
                for tangent in self.tangents.iter().filter(|tangent| tangent.pin() == Some(pin.number)) {
                    bounds.push(tangent.pin_bound(&placed, &coords, pin)?);
                }
            }
            bounds.extend(self.tangents.iter().filter_map(|tangent| tangent.light_bound(&placed)));
        }
        let all = equations.iter().chain(&rows).chain(bounds.iter().map(|bound| &bound.value));
        let is_finite = all.copied().all(f64::is_finite);
        is_finite.then_some(Evaluated { equations, of_feature, rows, bounds, tracked })
    }

    /// Computes the slopes about `x` by differences to one side. Their error is about 1e-6, which Newton's method
    /// corrects.
    pub fn slopes(&self, x: &[f64], share: f64, at: &Evaluated) -> Slopes {
        let n = x.len();
        let mut slopes = Slopes {
            equations: Matrix::zero(at.equations.len(), n),
            rows: Matrix::zero(at.rows.len(), n),
            bounds: Matrix::zero(at.bounds.len(), n),
        };
        let mut beside = x.to_vec();
        for k in 0..n {
            // At the edge of the domain only one side can be evaluated.
            let found = [DIFFERENCE, -DIFFERENCE].into_iter().find_map(|change| {
                beside[k] = x[k] + change;
                Some((self.evaluate(&beside, share, &at.tracked)?, change))
            });
            beside[k] = x[k];
            let Some((there, change)) = found else { continue };
            fill(&mut slopes.equations, k, &there.equations, &at.equations, change);
            fill(&mut slopes.rows, k, &there.rows, &at.rows, change);
            for (row, (there, here)) in there.bounds.iter().zip(&at.bounds).enumerate() {
                *slopes.bounds.at(row, k) = (there.value - here.value) / change;
            }
        }
        slopes
    }

    /// True if changes of the unknowns do not move the feature at the start of the drag.
    pub fn has_no_effect(&self, near: &Tracked) -> bool {
        let x = self.unmoved();
        let Some(at) = self.evaluate(&x, 0.0, near) else { return false };
        let slopes = self.slopes(&x, 0.0, &at).equations;
        (0..at.of_feature).all(|row| slopes.row(row).iter().all(|slope| slope.abs() < 1e-9))
    }

    /// Returns the rays of the light that the unknowns `x` give. `None` if the light cannot be evaluated or the budget
    /// is spent.
    pub fn rays(&self, x: &[f64]) -> Option<LightRays> {
        let points = self.start.light().points().len() as u64;
        let of_a_point = match &self.unknowns {
            Unknowns::Points { radii: RadiusMode::Follow, .. } => STEPS_OF_POINT + STEPS_OF_FOLLOWING,
            Unknowns::Points { .. } => STEPS_OF_POINT,
            Unknowns::Rigid { .. } | Unknowns::Turn | Unknowns::Move { .. } => STEPS_OF_COPY,
        };
        self.work().spend(of_a_point * points).then(|| self.unknowns.rays(self.start, x))?
    }

    /// Returns where the light first overlaps if the unknowns change in a straight line from the start to `x`. `None` if it
    /// does not at `x`.
    pub fn first_overlap(&self, rule: OverlapRule, x: &[f64]) -> Option<TubeOverlap> {
        let rays_at = |share: f64| self.rays(&x.iter().map(|x| x * share).collect::<Vec<_>>());
        rule.first_overlap(rays_at, self.work())
    }

    pub fn work(&self) -> &'a WorkBudget<'a> {
        self.scene_light.work
    }

    /// Computes the bounds of the light's own shape: no segment folds, no radius is negative, and one that follows
    /// keeps most of its length.
    fn shape_bounds(&self, rays: &LightRays, x: &[f64]) -> Vec<Bound> {
        let (Unknowns::Points { points, radii, unit }, LightRays::Bent(tube)) = (self.unknowns, rays) else {
            return Vec::new();
        };
        let mut bounds: Vec<Bound> = fold_bounds(&tube.r_kappa_max(), &self.folds).collect();
        let start = self.start.light();
        match radii {
            RadiusMode::Keep => {}
            RadiusMode::Solve => {
                let radius =
                    |(k, point): (usize, &usize)| x[3 * points.len() + k] + start.points()[*point].radius / unit;
                bounds.extend(points.iter().enumerate().map(|of| hard_bound(radius(of), DragLimit::Radius)));
            }
            RadiusMode::Follow => {
                let now = self.unknowns.points(start, x);
                let shares = start.points().iter().zip(&now).filter(|(was, _)| was.radius > 0.0);
                let rooms = shares.map(|(was, now)| now.radius / was.radius - LEAST_RADIUS_SHARE);
                bounds.extend(rooms.map(|room| hard_bound(room, DragLimit::Fold)));
            }
        }
        bounds
    }

    /// Computes the bounds of the segments that a dragged control point can fold.
    fn bounds_of_segments(&self, x: &[f64], point: usize) -> Option<Vec<Bound>> {
        let start = self.start.light();
        if !self.work().spend(STEPS_OF_FOLLOWING * start.points().len() as u64) {
            return None;
        }
        let moved = self.unknowns.points(start, x);
        let touched = point.saturating_sub(2)..(point + 1).min(self.folds.len());
        let folds = r_kappa_max_of_segments(&moved, touched.clone()).ok()?;
        Some(fold_bounds(&folds, &self.folds[touched]).collect())
    }

    /// Computes the error of the feature with its target at a share of its way, and the bounds by which it can be seen
    /// there. Also returns the tracked `t` of the feature and its caster.
    fn feature_error(
        &self,
        taken: &TakenFeature,
        placed: &SceneLight,
        share: f64,
        near: [f64; 2],
        bounds: &mut Vec<Bound>,
    ) -> Option<([f64; 2], [f64; 2])> {
        let (target, direction) = taken.target(share);
        let coords = placed.locate(target, Some(near[0]))?;
        let room = ROOM_ON_PATH * (1.0 - share);
        let edge = |value: f64| hard_bound(value + room, DragLimit::TubeEdge);
        bounds.push(hard_bound(coords.path_spacing - MIN_PATH_SPACING, DragLimit::Fold));
        bounds.push(edge(self.brightness_bound(taken, placed, &coords)));
        bounds.push(edge(coords.distance_to_ends.min(1.0)));
        bounds.push(edge(taken.to.normal.dot(coords.to_light) - LEAST_COSINE));
        let mut caster_t = near[1];
        let error = match (taken.feature, taken.pivot) {
            (Feature::Shadow, Some(pivot)) => {
                let caster = placed.locate(pivot, Some(near[1]))?;
                caster_t = caster.t;
                bounds.push(edge(distance_behind(&coords, &caster, &taken.start_coords)));
                bounds.push(edge(caster.distance_to_ends.min(1.0)));
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
    fn brightness_bound(&self, taken: &TakenFeature, placed: &SceneLight, coords: &PointInLight) -> f64 {
        let rho = placed.rho2(coords).sqrt();
        let now = placed.edge_profile(coords) * within_edge(rho - 1.0) + UNSEEN;
        let least = LEAST_BRIGHTNESS_SHARE * self.scene_light.edge_profile(&taken.start_coords) + UNSEEN;
        libm::log(now / least) - EDGE_SLOPE * (rho - 1.0).clamp(0.0, 1.0)
    }
}

/// Makes bounds that keep the segments from folding, in the logarithm of `R kappa`. A segment that was folded more than
/// a drag allows at the start may stay as it is.
fn fold_bounds<'a>(folds: &'a [f64], start_folds: &'a [f64]) -> impl Iterator<Item = Bound> + 'a {
    let room = |(fold, most): (&f64, &f64)| libm::log(most.max(MAX_R_KAPPA) / fold.clamp(0.1, 1e3));
    folds.iter().zip(start_folds).map(move |fold| hard_bound(room(fold), DragLimit::Fold))
}

fn fill(slopes: &mut Matrix, column: usize, there: &[f64], here: &[f64], change: f64) {
    for (row, (there, here)) in there.iter().zip(here).enumerate() {
        *slopes.at(row, column) = (there - here) / change;
    }
}
