//! Goal of a drag: two equations that are fulfilled where the feature lies under the cursor, and limits whose values
//! must stay 0 or more.

use std::rc::Rc;

use glam::{DVec2, DVec3};
use light::{CheckedLight, LightRays, r_kappa_max_of_segments};
use raycast::SeenPoint;

use crate::bound::{Bound, EDGE_MARGIN, bounds_at, cross_error, direction_error_about, distance_behind, hard_bound};
use crate::matrix::Matrix;
use crate::moves::{MAX_R_KAPPA, Unknowns};
use crate::pins::{OcclusionTangent, PinState};
use crate::point_in_light::{PointInLight, SceneLight};
use crate::quadratic::{Hold, Linearization, Multipliers, RowSelection, Values};
use crate::request::{DragLimit, Feature, RadiusMode};
use crate::work::WorkBudget;

/// Distance outside the light that the feature may have at the start of its path, so that it can cross the air between
/// two surfaces. It shrinks to 0 at the cursor.
const EDGE_SLACK_ON_PATH: f64 = 3.0;

/// Change of an unknown between two evaluations for a finite difference.
pub(crate) const DIFFERENCE: f64 = 1e-6;

/// Number of pins above which finite differences are one-sided, if their step is below `ONE_SIDED`.
const MANY_PINS: usize = 16;
const ONE_SIDED: f64 = 1e-5;

/// Costs per control point, in steps of the work budget. This one is for rebuilding a tube. The next ones are the
/// additional cost of radii that follow, and the cost of only moving a tube.
pub(crate) const STEPS_OF_POINT: u64 = 400;
const STEPS_OF_FOLLOWING: u64 = 400;
pub(crate) const STEPS_OF_COPY: u64 = 40;

/// Objective, unknowns and constraints of a drag.
#[derive(Clone, Debug)]
pub(crate) struct Goal<'a> {
    pub objective: Objective,
    /// Light at the start of the drag.
    pub start: &'a CheckedLight,
    pub unknowns: Unknowns,
    /// Light at the start of the drag, in scene space. Later lights of the drag have the same origin, chart and budget.
    pub scene_light: SceneLight<'a>,
    /// Largest `R kappa` of each segment at the start of the drag. A segment that was above the limit for drags may
    /// keep this value.
    pub folds: Vec<f64>,
    pub pins: Vec<PinState>,
    /// Priority of each residual: of the objective, of the pins and of the joint.
    pub rows: Rc<[Hold]>,
    /// Tangents of shadow edges and surfaces that pins and the source may not cross.
    pub tangents: Vec<OcclusionTangent>,
    /// Tracked point that must stay at a joint of the tube (0 for the feature's, 1 for its pivot's), and the joint's
    /// `t`.
    joint: Option<(usize, f64)>,
    /// Softness of the limits that keep the point under the cursor inside the light. While the drag can still converge
    /// it is 0, which makes them hard limits.
    edge_compliance: f64,
}

#[derive(Clone, Debug)]
pub(crate) enum Objective {
    /// Moves a feature under the cursor.
    Feature(Box<TakenFeature>),
    /// Moves a control point to a position in light-local space.
    Position { point: usize, to: DVec3 },
}

/// Dragged feature, with the path of its target from the start of the drag to the cursor.
#[derive(Clone, Debug)]
pub(crate) struct TakenFeature {
    pub feature: Feature,
    /// Surface point at the start of the drag.
    pub from: SeenPoint,
    /// Surface point under the cursor.
    pub to: SeenPoint,
    /// Caster point of a dragged shadow, in scene space.
    pub pivot: Option<DVec3>,
    /// Light coordinates of `from` at the start of the drag.
    pub start_coords: PointInLight,
    /// Unit directions to the light: at `from` at the start of the drag, and at `to` at its end. Only highlights and
    /// lit sides use them.
    pub directions: [DVec3; 2],
}

/// Values of `t` that the solver tracks while the light moves. The first entry is for the feature and its pivot, the
/// others are for each pin and its pivot.
pub(crate) type TrackedPoints = Vec<[f64; 2]>;

/// Residuals and limits of a light.
#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    /// Error of the objective, then of each pin, in radii of the light or in radians.
    pub residual: Vec<f64>,
    /// Priority of each residual.
    pub rows: Rc<[Hold]>,
    pub bounds: Vec<Bound>,
    pub tracked: TrackedPoints,
}

impl Evaluation {
    /// Returns the values for a step that fulfils the selected residuals.
    pub fn values(&self, counting: RowSelection) -> Values<'_> {
        let limits = self.bounds.iter().map(|bound| bound.value - 1e-12).collect();
        Values { residual: &self.residual, limits, counting }
    }
}

impl TakenFeature {
    /// Returns the target of the feature at a share of the path: its position, and the direction to the light there.
    pub fn target(&self, share: f64) -> (DVec3, DVec3) {
        let [from, to] = self.directions;
        (self.from.position.lerp(self.to.position, share), slerp(from, to, share))
    }

    /// Computes the feature's error at a share of the path, and adds the limits of the feature and of its pivot to
    /// `bounds`. Also returns the tracked `t` of both.
    fn feature_residual(
        &self,
        placed: &SceneLight,
        share: f64,
        near: [f64; 2],
        bounds: &mut Vec<Bound>,
        compliance: f64,
    ) -> Option<(DVec2, [f64; 2])> {
        let (point, direction) = self.target(share);
        let coords = placed.locate(point, Some(near[0]))?;
        let room = EDGE_SLACK_ON_PATH * (1.0 - share);
        bounds_at(placed, &coords, [DragLimit::Fold, DragLimit::TubeEdge], compliance, room, bounds);
        let mut pivot_t = near[1];
        let error = match (self.feature, self.pivot) {
            (Feature::Shadow, Some(pivot)) => {
                let pivot = placed.locate(pivot, Some(near[1]))?;
                pivot_t = pivot.t;
                // The caster must be in the light too.
                let values = [
                    distance_behind(&coords, &pivot, &self.start_coords),
                    pivot.distance_to_ends.min(1.0) - EDGE_MARGIN,
                ];
                let limit = DragLimit::TubeEdge;
                bounds.extend(values.map(|value| Bound { value: value + room, limit, compliance }));
                cross_error(pivot.cross_coords, &coords, &self.start_coords)
            }
            (Feature::Shadow | Feature::Hotspot, _) => {
                -cross_error(self.start_coords.cross_coords, &coords, &self.start_coords)
            }
            (Feature::Highlight | Feature::Diffuse, _) => {
                direction_error_about(coords.to_light, direction, self.axis())?
            }
        };
        Some((error, [coords.t, pivot_t]))
    }

    /// Returns a unit vector orthogonal to the target direction at every share of the path.
    pub fn axis(&self) -> DVec3 {
        let [from, to] = self.directions;
        from.cross(to).try_normalize().unwrap_or_else(|| from.any_orthonormal_vector())
    }

    /// Returns the length of the path of the feature's target, in radii of the light or in radians.
    fn path_length(&self) -> f64 {
        let [from, to] = self.directions;
        let across = self.from.position.distance(self.to.position) / self.start_coords.width;
        match self.feature {
            Feature::Shadow | Feature::Hotspot => across,
            Feature::Highlight | Feature::Diffuse => libm::atan2(from.cross(to).length(), from.dot(to)).max(across),
        }
    }
}

impl<'a> Goal<'a> {
    pub fn new(
        objective: Objective,
        start: &'a CheckedLight,
        unknowns: Unknowns,
        scene_light: SceneLight<'a>,
        pins: Vec<PinState>,
    ) -> Self {
        let folds = start.tube().map_or_else(Vec::new, light::Tube::r_kappa_max);
        let rows = row_holds(&objective, &pins);
        Self {
            objective,
            start,
            unknowns,
            scene_light,
            folds,
            pins,
            rows,
            tangents: Vec::new(),
            joint: None,
            edge_compliance: 0.0,
        }
    }

    /// Copies the goal, and adds the equation that a tracked point stays at a joint of the tube.
    pub fn at_joint(&self, which: usize, t: f64) -> Self {
        let rows = self.rows.iter().copied().chain([Hold::Fixed]).collect();
        Self { joint: Some((which, t)), rows, ..self.clone() }
    }

    /// Copies the goal, and lets the point under the cursor leave the light at a cost. `edge_compliance` is the
    /// softness of its limits.
    pub fn with_edge_compliance(&self, edge_compliance: f64) -> Self {
        Self { edge_compliance, ..self.clone() }
    }

    /// Evaluates the light that the unknowns `x` give, at a share of the path. `None` if the light cannot be evaluated.
    pub fn evaluate(&self, x: &[f64], share: f64, near: &TrackedPoints) -> Option<Evaluation> {
        let taken = match &self.objective {
            Objective::Feature(taken) => taken,
            Objective::Position { point, to } => return self.evaluate_position(x, share, near, *point, *to),
        };
        let rays = self.rays(x)?;
        let placed = self.scene_light.with(&rays);
        let mut bounds = self.shape_bounds(&rays, x);
        let mut tracked = TrackedPoints::with_capacity(near.len());
        let (error, at) = taken.feature_residual(&placed, share, near[0], &mut bounds, self.edge_compliance)?;
        let mut residual = error.to_array().to_vec();
        tracked.push(at);
        for (pin, near) in self.pins.iter().zip(&near[1..]) {
            let (at, coords) = pin.add_residual(&placed, *near, &mut residual, &mut bounds)?;
            tracked.push(at);
            for tangent in self.tangents.iter().filter(|tangent| tangent.pin() == Some(pin.number)) {
                bounds.push(tangent.pin_bound(&placed, &coords, pin)?);
            }
        }
        residual.extend(self.joint.map(|(which, t)| tracked[0][which] - t));
        bounds.extend(self.tangents.iter().filter_map(|tangent| tangent.source_bound(&placed)));
        let is_finite = residual.iter().chain(bounds.iter().map(|bound| &bound.value)).all(|value| value.is_finite());
        is_finite.then(|| Evaluation { residual, rows: Rc::clone(&self.rows), bounds, tracked })
    }

    /// Returns the rays of the light that the unknowns `x` give. `None` if the light cannot be evaluated or the budget
    /// is spent.
    pub fn rays(&self, x: &[f64]) -> Option<LightRays> {
        let points = self.start.light().points().len() as u64;
        let of_a_point = match &self.unknowns {
            Unknowns::Points { radii: RadiusMode::Follow, .. } => STEPS_OF_POINT + STEPS_OF_FOLLOWING,
            Unknowns::Points { .. } => STEPS_OF_POINT,
            Unknowns::Rigid { .. } | Unknowns::Turn => STEPS_OF_COPY,
        };
        self.work().spend(of_a_point * points).then(|| self.unknowns.rays(self.start, x))?
    }

    pub fn work(&self) -> &'a WorkBudget<'a> {
        self.scene_light.work
    }

    /// Evaluates a dragged control point. Checks only the segments of the tube that this point can fold.
    fn evaluate_position(
        &self,
        x: &[f64],
        share: f64,
        near: &TrackedPoints,
        point: usize,
        to: DVec3,
    ) -> Option<Evaluation> {
        let points = self.start.light().points().len() as u64;
        if !self.work().spend(STEPS_OF_FOLLOWING * points) {
            return None;
        }
        let moved = self.unknowns.points(self.start.light(), x);
        let touched = point.saturating_sub(2)..(point + 1).min(self.folds.len());
        let folds = r_kappa_max_of_segments(&moved, touched.clone()).ok()?;
        let bounds: Vec<Bound> = fold_bounds(&folds, &self.folds[touched]).collect();
        let residual = self.unknowns.position_error(self.start.light(), x, point, to, share).to_array().to_vec();
        let is_finite = residual.iter().chain(&folds).all(|value| value.is_finite());
        is_finite.then(|| Evaluation { residual, rows: Rc::clone(&self.rows), bounds, tracked: near.clone() })
    }

    /// Copies the goal without the pins for which `is_kept` is false. Also returns the tracked points without those
    /// pins.
    pub fn with_pins(&self, near: &TrackedPoints, is_kept: impl Fn(&PinState) -> bool) -> (Self, TrackedPoints) {
        let kept = self.pins.iter().zip(&near[1..]).filter(|(pin, _)| is_kept(pin));
        let (pins, of_pins): (Vec<PinState>, TrackedPoints) = kept.map(|(pin, near)| (pin.clone(), *near)).unzip();
        let goal = Self { rows: row_holds(&self.objective, &pins), pins, tangents: Vec::new(), ..self.clone() };
        (goal, [vec![near[0]], of_pins].concat())
    }

    /// Finds the values of `t` to track in the light that the unknowns `x` give, with the feature at the end of its
    /// path. A point outside the light keeps its value of `near`.
    pub fn tracked_at_end(&self, x: &[f64], near: &TrackedPoints) -> TrackedPoints {
        let Some(rays) = self.rays(x) else { return near.clone() };
        let placed = self.scene_light.with(&rays);
        let t = |point: Option<DVec3>, was: f64| {
            point.and_then(|point| placed.locate(point, None)).map_or(was, |coords| coords.t)
        };
        let feature = match &self.objective {
            Objective::Feature(taken) => [Some(taken.to.position), taken.pivot],
            Objective::Position { .. } => [None; 2],
        };
        let pins = self.pins.iter().map(|pin| [Some(pin.point), pin.pivot.map(|(pivot, _)| pivot)]);
        let points = std::iter::once(feature).chain(pins).zip(near);
        points.map(|([point, pivot], was)| [t(point, was[0]), t(pivot, was[1])]).collect()
    }

    /// True if a pin is soft, or if a hard pin has a soft residual, as that of the irradiance is.
    pub fn has_soft_pins(&self) -> bool {
        self.pins.iter().any(|pin| !pin.is_hard) || self.rows.iter().any(|row| matches!(row, Hold::Soft(_)))
    }

    /// Returns the limit or hard pin with the largest multiplier.
    pub fn strongest_limit(&self, at: &Evaluation, multipliers: &Multipliers) -> Option<DragLimit> {
        let count = at.rows.iter().filter(|row| **row == Hold::Objective).count();
        let (of_objective, of_pins) = multipliers.rows.split_at(count);
        let most = of_objective.iter().fold(0.0, |most: f64, multiplier| most.max(multiplier.abs()));
        // Smaller multipliers come from rounding.
        let least = 1e-6 * most;
        let pins = self.pins.iter().flat_map(|pin| pin.row_holds().map(|hold| (hold, DragLimit::Pin(pin.number))));
        let of_pins = pins
            .zip(of_pins)
            .filter(|((hold, _), multiplier)| *hold == Hold::Fixed && multiplier.abs() > least)
            .map(|((_, limit), multiplier)| (limit, multiplier.abs()));
        let of_limits = at.bounds.iter().zip(&multipliers.limits).filter(|(_, multiplier)| **multiplier > 0.0);
        let all = of_limits.map(|(bound, multiplier)| (bound.limit, *multiplier)).chain(of_pins);
        all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(limit, _)| limit)
    }

    /// Returns the length of the path: for a feature in radii of the light or in radians, for a control point in units
    /// of the unknowns.
    pub fn path_length(&self) -> f64 {
        match &self.objective {
            Objective::Feature(taken) => taken.path_length(),
            Objective::Position { point, to } => {
                let start = self.start.light();
                self.unknowns.position_error(start, &vec![0.0; self.unknowns.count()], *point, *to, 1.0).length()
            }
        }
    }

    /// Returns the number of samples of the path that lie `apart` from each other, clamped to a range.
    pub fn sample_count(&self, apart: f64, [least, most]: [f64; 2]) -> f64 {
        (self.path_length() / apart).clamp(least, most)
    }

    /// True if changes of the unknowns do not move the feature at the start of the drag.
    pub fn has_no_effect(&self, near: &TrackedPoints) -> bool {
        let x = vec![0.0; self.unknowns.count()];
        let Some(at) = self.evaluate(&x, 0.0, near) else { return false };
        let jacobian = self.linearize(&x, 0.0, &at, DIFFERENCE).jacobian;
        let mut objective = (0..at.rows.len()).filter(|row| at.rows[*row] == Hold::Objective);
        objective.all(|row| jacobian.row(row).iter().all(|slope| slope.abs() < 1e-9))
    }

    /// Computes the limits of the light's own shape: no segment folds, and no radius is negative.
    fn shape_bounds(&self, rays: &LightRays, x: &[f64]) -> Vec<Bound> {
        let (Unknowns::Points { points, radii, unit }, LightRays::Bent(tube)) = (&self.unknowns, rays) else {
            return Vec::new();
        };
        let mut bounds: Vec<Bound> = fold_bounds(&tube.r_kappa_max(), &self.folds).collect();
        if *radii == RadiusMode::Solve {
            let all = self.start.light().points();
            let radius = |(k, point): (usize, &usize)| x[3 * points.len() + k] + all[*point].radius / unit;
            bounds.extend(points.iter().enumerate().map(|of| hard_bound(radius(of), DragLimit::Radius)));
        }
        bounds
    }

    /// Linearizes residuals and limits about `x`, by central differences with `step` to both sides.
    ///
    /// With a step of 1e-6 the slopes have a relative error of about 1e-10, which Newton's method corrects. With many
    /// pins the cost of two evaluations per unknown counts, and differences are one-sided, with an error of about 1e-6.
    pub fn linearize(&self, x: &[f64], share: f64, at: &Evaluation, step: f64) -> Linearization<'a> {
        let (count, rows, limits) = (x.len(), at.residual.len(), at.bounds.len());
        let (mut jacobian, mut slopes) = (Matrix::zero(rows, count), Matrix::zero(limits, count));
        let mut beside = x.to_vec();
        for k in 0..count {
            if !self.work().spend((rows + limits) as u64) {
                break;
            }
            let mut evaluate_at = |change: f64| {
                beside[k] = x[k] + change;
                let found = self.evaluate(&beside, share, &at.tracked);
                beside[k] = x[k];
                found
            };
            let ahead = evaluate_at(step);
            let is_enough = ahead.is_some() && self.pins.len() > MANY_PINS && step < ONE_SIDED;
            let behind = if is_enough { None } else { evaluate_at(-step) };
            // At the edge of the domain only one side can be evaluated.
            let (ahead, behind, length) = match (&ahead, &behind) {
                (Some(ahead), Some(behind)) => (ahead, behind, 2.0 * step),
                (Some(ahead), None) => (ahead, at, step),
                (None, Some(behind)) => (at, behind, step),
                (None, None) => continue,
            };
            for row in 0..rows {
                *jacobian.at(row, k) = (ahead.residual[row] - behind.residual[row]) / length;
            }
            for row in 0..limits {
                *slopes.at(row, k) = (ahead.bounds[row].value - behind.bounds[row].value) / length;
            }
        }
        let compliances = at.bounds.iter().map(|bound| bound.compliance).collect();
        Linearization::new((jacobian, slopes), Rc::clone(&at.rows), compliances, self.work())
    }
}

/// Makes limits that keep the segments from folding. A segment that was folded more than a drag allows at the start may
/// stay as it is.
fn fold_bounds<'a>(folds: &'a [f64], start_folds: &'a [f64]) -> impl Iterator<Item = Bound> + 'a {
    let room = |(fold, most): (&f64, &f64)| (most.max(MAX_R_KAPPA) - fold) / MAX_R_KAPPA;
    folds.iter().zip(start_folds).map(move |fold| hard_bound(room(fold), DragLimit::Fold))
}

/// Returns the priorities of the objective's residuals, followed by those of the pins.
fn row_holds(objective: &Objective, pins: &[PinState]) -> Rc<[Hold]> {
    let count = match objective {
        Objective::Feature(_) => 2,
        Objective::Position { .. } => 3,
    };
    std::iter::repeat_n(Hold::Objective, count).chain(pins.iter().flat_map(PinState::row_holds)).collect()
}

/// Interpolates unit vectors along the shortest rotation from one to the other.
fn slerp(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    let cos = from.dot(to);
    let across = (to - from * cos).normalize_or_zero();
    let angle = libm::atan2(from.cross(to).length(), cos) * share;
    from * libm::cos(angle) + across * libm::sin(angle)
}
