//! What a drag is after: two equations that hold where the feature lies under the cursor, and what must stay above 0.

use std::rc::Rc;

use glam::{DVec2, DVec3};
use light::{CheckedLight, LightRays, r_kappa_max_of_segments};
use raycast::SeenPoint;

use crate::bound::{
    Bound, EDGE_MARGIN, bounds_at, cross_error, direction_error_about, distance_behind, hard_bound,
};
use crate::matrix::Matrix;
use crate::moves::{MAX_R_KAPPA, Unknowns};
use crate::pins::{OcclusionTangent, PinState};
use crate::point_in_light::{PointInLight, SceneLight};
use crate::quadratic::{Hold, Linearization, Multipliers};
use crate::request::{DragLimit, Feature, RadiusMode};
use crate::work::WorkBudget;

/// How far out of the light the feature may be where it sets out, so that it may go through the air between two surfaces.
const EDGE_SLACK_ON_PATH: f64 = 3.0;

/// Over how far slopes are taken.
pub(crate) const DIFFERENCE: f64 = 1e-6;

/// Pins with which differences are taken to one side, and below which step.
const MANY_PINS: usize = 16;
const ONE_SIDED: f64 = 1e-5;

/// Steps of a control point: of a tube that is made anew, where radii follow besides, and of a tube that is only placed anew.
const STEPS_OF_POINT: u64 = 400;
const STEPS_OF_FOLLOWING: u64 = 400;
const STEPS_OF_COPY: u64 = 40;

/// A drag: what is asked of a light, and what must stay.
#[derive(Clone, Debug)]
pub(crate) struct Goal<'a> {
    pub objective: Objective,
    /// The light as the drag began.
    pub start: &'a CheckedLight,
    pub unknowns: Unknowns,
    /// The light as it was, for what lights are measured by.
    pub scene_light: SceneLight<'a>,
    /// The largest `R kappa` of each segment as the drag began, and so what it may have.
    pub folds: Vec<f64>,
    pub pins: Vec<PinState>,
    /// How firmly each residual is held.
    pub rows: Rc<[Hold]>,
    /// Edges of shadows, and surfaces, that what is pinned may not cross.
    pub tangents: Vec<OcclusionTangent>,
    /// Where two segments of a tube meet, and which of the followed places is to stay there: the feature's or its pivot's.
    joint: Option<(usize, f64)>,
    /// How softly the place under the cursor keeps within the light; 0 where a drag is to land, and not at all softly then.
    edge_compliance: f64,
}

/// What is asked.
#[derive(Clone, Debug)]
pub(crate) enum Objective {
    /// That a feature lies under the cursor.
    Feature(Box<TakenFeature>),
    /// That a control point is at a position in light-local space.
    Position { point: usize, to: DVec3 },
}

/// A feature on its way from where it was taken to the cursor.
#[derive(Clone, Debug)]
pub(crate) struct TakenFeature {
    pub feature: Feature,
    /// Where it was taken.
    pub from: SeenPoint,
    /// Where it goes.
    pub to: SeenPoint,
    /// Of a shadow: what throws it.
    pub pivot: Option<DVec3>,
    /// Where `from` was in the light.
    pub start_coords: PointInLight,
    /// Directions to the light, as it was at `from` and as it is to be at `to`, where they are what is dragged.
    pub directions: [DVec3; 2],
}

/// Places that are followed while the light moves, along the light: the feature's and its pivot's, then those of each pin.
pub(crate) type TrackedPoints = Vec<[f64; 2]>;

/// How a light does.
#[derive(Clone, Debug)]
pub(crate) struct Evaluation {
    /// How far the feature lies off, and then how far each pin does, in radii of the light or in radians.
    pub residual: Vec<f64>,
    /// How firmly each of these is held.
    pub rows: Rc<[Hold]>,
    pub bounds: Vec<Bound>,
    pub tracked: TrackedPoints,
}

impl TakenFeature {
    /// Where the feature is to lie at a share of its way, and from where light is to come there.
    fn target(&self, share: f64) -> (DVec3, DVec3) {
        let [from, to] = self.directions;
        (self.from.position.lerp(self.to.position, share), slerp(from, to, share))
    }

    /// What is off at a share of the way, and where the place and the pivot are then.
    fn feature_residual(
        &self,
        placed: &SceneLight,
        share: f64,
        near: [f64; 2],
        (bounds, give): (&mut Vec<Bound>, f64),
    ) -> Option<(DVec2, [f64; 2])> {
        let (point, direction) = self.target(share);
        let place = placed.locate(point, Some(near[0]))?;
        let room = EDGE_SLACK_ON_PATH * (1.0 - share);
        bounds_at(placed, &place, ([DragLimit::Fold, DragLimit::TubeEdge], give), room, bounds);
        let across_off = |across: DVec2| cross_error(across, &place, &self.start_coords);
        let mut pivot_t = near[1];
        let off = match (self.feature, self.pivot) {
            (Feature::Shadow, Some(pivot)) => {
                let pivot = placed.locate(pivot, Some(near[1]))?;
                pivot_t = pivot.t;
                // What throws it is in the light too.
                let values = [
                    distance_behind(&place, &pivot, &self.start_coords),
                    pivot.distance_to_ends.min(1.0) - EDGE_MARGIN,
                ];
                bounds.extend(values.map(|value| Bound {
                    value: value + room,
                    limit: DragLimit::TubeEdge,
                    compliance: give,
                }));
                across_off(pivot.cross_coords)
            }
            (Feature::Shadow | Feature::Hotspot, _) => -across_off(self.start_coords.cross_coords),
            (Feature::Highlight | Feature::Diffuse, _) => {
                direction_error_about(place.to_light, direction, self.axis())?
            }
        };
        Some((off, [place.t, pivot_t]))
    }

    /// Square to the directions at every share of the way.
    fn axis(&self) -> DVec3 {
        let [from, to] = self.directions;
        from.cross(to).try_normalize().unwrap_or_else(|| from.any_orthonormal_vector())
    }

    /// How far the feature goes, in radii of the light or in radians.
    fn path_length(&self) -> f64 {
        let [from, to] = self.directions;
        let across = self.from.position.distance(self.to.position) / self.start_coords.width;
        match self.feature {
            Feature::Shadow | Feature::Hotspot => across,
            Feature::Highlight | Feature::Diffuse => {
                libm::atan2(from.cross(to).length(), from.dot(to)).max(across)
            }
        }
    }
}

impl<'a> Goal<'a> {
    pub fn new(
        objective: Objective,
        (start, unknowns): (&'a CheckedLight, Unknowns),
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

    /// The same with a followed place at a joint of the tube.
    pub fn at_joint(&self, joint: (usize, f64)) -> Self {
        let rows = self.rows.iter().copied().chain([Hold::Fixed]).collect();
        Self { joint: Some(joint), rows, ..self.clone() }
    }

    /// The same where the place under the cursor need not be within the light.
    pub fn with_edge_compliance(&self, give: f64) -> Self {
        Self { edge_compliance: give, ..self.clone() }
    }

    /// How the light with `x` does at a share of the way; `None` where it cannot be evaluated.
    pub fn evaluate(&self, x: &[f64], share: f64, near: &TrackedPoints) -> Option<Evaluation> {
        let taken = match &self.objective {
            Objective::Feature(taken) => taken,
            Objective::Position { point, to } => {
                return self.evaluate_position(x, share, near, (*point, *to));
            }
        };
        let rays = self.rays(x)?;
        let placed = self.scene_light.with(&rays);
        let mut bounds = self.shape_bounds(&rays, x);
        let mut followed = TrackedPoints::with_capacity(near.len());
        let (off, at) =
            taken.feature_residual(&placed, share, near[0], (&mut bounds, self.edge_compliance))?;
        let mut residual = off.to_array().to_vec();
        followed.push(at);
        for (pin, near) in self.pins.iter().zip(&near[1..]) {
            let (at, place) = pin.add_residual(&placed, *near, &mut residual, &mut bounds)?;
            followed.push(at);
            for cut in self.tangents.iter().filter(|cut| cut.pin() == Some(pin.index)) {
                bounds.push(cut.pin_bound(&placed, &place, pin)?);
            }
        }
        residual.extend(self.joint.map(|(which, t)| followed[0][which] - t));
        bounds.extend(self.tangents.iter().filter_map(|cut| cut.source_bound(&placed)));
        let is_finite =
            residual.iter().chain(bounds.iter().map(|bound| &bound.value)).all(|value| value.is_finite());
        is_finite.then(|| Evaluation { residual, rows: Rc::clone(&self.rows), bounds, tracked: followed })
    }

    /// How points are found in the light with `x`; `None` where it cannot be evaluated.
    pub fn rays(&self, x: &[f64]) -> Option<LightRays> {
        let points = self.start.light().points().len() as u64;
        let of_a_point = match &self.unknowns {
            Unknowns::Points { radii: RadiusMode::Follow, .. } => STEPS_OF_POINT + STEPS_OF_FOLLOWING,
            Unknowns::Points { .. } => STEPS_OF_POINT,
            Unknowns::Rigid { .. } | Unknowns::Turn => STEPS_OF_COPY,
        };
        self.work().spend(of_a_point * points).then(|| self.unknowns.rays(self.start, x))?
    }

    /// What it costs.
    pub fn work(&self) -> &'a WorkBudget<'a> {
        self.scene_light.work
    }

    /// The same for a control point: no more of the tube is made than what may fold by it.
    fn evaluate_position(
        &self,
        x: &[f64],
        share: f64,
        near: &TrackedPoints,
        (point, to): (usize, DVec3),
    ) -> Option<Evaluation> {
        let points = self.start.light().points().len() as u64;
        if !self.work().spend(STEPS_OF_FOLLOWING * points) {
            return None;
        }
        let moved = self.unknowns.points(self.start.light(), x);
        let touched = point.saturating_sub(2)..(point + 1).min(self.folds.len());
        let folds = r_kappa_max_of_segments(&moved, touched.clone()).ok()?;
        let bounds: Vec<Bound> = fold_bounds(&folds, &self.folds[touched]).collect();
        let residual =
            self.unknowns.position_error(self.start.light(), x, point, to, share).to_array().to_vec();
        let is_finite = residual.iter().chain(&folds).all(|value| value.is_finite());
        is_finite.then(|| Evaluation { residual, rows: Rc::clone(&self.rows), bounds, tracked: near.clone() })
    }

    /// The same with some of its pins alone.
    pub fn with_pins(
        &self,
        near: &TrackedPoints,
        is_kept: impl Fn(&PinState) -> bool,
    ) -> (Self, TrackedPoints) {
        let kept = self.pins.iter().zip(&near[1..]).filter(|(pin, _)| is_kept(pin));
        let (pins, of_pins): (Vec<PinState>, TrackedPoints) =
            kept.map(|(pin, near)| (pin.clone(), *near)).unzip();
        let goal =
            Self { rows: row_holds(&self.objective, &pins), pins, tangents: Vec::new(), ..self.clone() };
        (goal, [vec![near[0]], of_pins].concat())
    }

    /// Where the followed places are in the light with `x`, the feature's at the end of its way: those that count, or where
    /// they were.
    pub fn tracked_at_end(&self, x: &[f64], near: &TrackedPoints) -> TrackedPoints {
        let Some(rays) = self.rays(x) else { return near.clone() };
        let placed = self.scene_light.with(&rays);
        let t = |point: Option<DVec3>, was: f64| {
            point.and_then(|point| placed.locate(point, None)).map_or(was, |place| place.t)
        };
        let feature = match &self.objective {
            Objective::Feature(taken) => [Some(taken.to.position), taken.pivot],
            Objective::Position { .. } => [None; 2],
        };
        let pins = self.pins.iter().map(|pin| [Some(pin.point), pin.pivot.map(|(pivot, _)| pivot)]);
        let points = std::iter::once(feature).chain(pins).zip(near);
        points.map(|([point, pivot], was)| [t(point, was[0]), t(pivot, was[1])]).collect()
    }

    /// Whether something is held softly.
    pub fn has_soft_pins(&self) -> bool {
        self.pins.iter().any(|pin| !pin.is_hard) || self.rows.iter().any(|row| matches!(row, Hold::Soft(_)))
    }

    /// What holds the light back most, by how its limits and pins pull.
    pub fn strongest_limit(&self, at: &Evaluation, pulls: &Multipliers) -> Option<DragLimit> {
        let asked = at.rows.iter().filter(|row| **row == Hold::Objective).count();
        let most = pulls.rows[..asked].iter().fold(0.0, |most: f64, pull| most.max(pull.abs()));
        // Rounding pulls too.
        let least = 1e-6 * most;
        let pins =
            self.pins.iter().flat_map(|pin| pin.row_holds().map(|hold| (hold, DragLimit::Pin(pin.index))));
        let of_pins = pins
            .zip(&pulls.rows[asked..])
            .filter(|((hold, _), pull)| *hold == Hold::Fixed && pull.abs() > least)
            .map(|((_, limit), pull)| (limit, pull.abs()));
        let of_limits = at.bounds.iter().zip(&pulls.limits).filter(|(_, pull)| **pull > 0.0);
        let all = of_limits.map(|(bound, pull)| (bound.limit, *pull)).chain(of_pins);
        all.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(limit, _)| limit)
    }

    /// How far it goes, in steps that one solution is near to the next of.
    pub fn path_length(&self) -> f64 {
        match &self.objective {
            Objective::Feature(taken) => taken.path_length(),
            Objective::Position { point, to } => {
                let start = self.start.light();
                self.unknowns
                    .position_error(start, &vec![0.0; self.unknowns.count()], *point, *to, 1.0)
                    .length()
            }
        }
    }

    /// In how many places that is looked at, so far `apart`, within bounds.
    pub fn sample_count(&self, apart: f64, [least, most]: [f64; 2]) -> f64 {
        (self.path_length() / apart).clamp(least, most)
    }

    /// Whether nothing that may change does anything to the feature where it is.
    pub fn has_no_effect(&self, near: &TrackedPoints) -> bool {
        let x = vec![0.0; self.unknowns.count()];
        let Some(at) = self.evaluate(&x, 0.0, near) else { return false };
        let jacobian = self.linearize(&x, 0.0, &at, DIFFERENCE).jacobian;
        let mut asked = (0..at.rows.len()).filter(|row| at.rows[*row] == Hold::Objective);
        asked.all(|row| jacobian.row(row).iter().all(|slope| slope.abs() < 1e-9))
    }

    /// What keeps the light's own shape: no fold, no radius below nothing.
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

    /// What is linear about `x`, by central differences over `step` each way: with 1e-6 to some 1e-10 of what it is, which
    /// Newton's method makes up for. With many pins, which are what takes long, to the side ahead alone: to some 1e-6.
    pub fn linearize(&self, x: &[f64], share: f64, at: &Evaluation, step: f64) -> Linearization<'a> {
        let (count, rows, limits) = (x.len(), at.residual.len(), at.bounds.len());
        let (mut jacobian, mut slopes) = (Matrix::zero(rows, count), Matrix::zero(limits, count));
        let mut beside = x.to_vec();
        for k in 0..count {
            if !self.work().spend((rows + limits) as u64) {
                break;
            }
            let mut side = |by: f64| {
                beside[k] = x[k] + by;
                let found = self.evaluate(&beside, share, &at.tracked);
                beside[k] = x[k];
                found
            };
            let ahead = side(step);
            let is_enough = ahead.is_some() && self.pins.len() > MANY_PINS && step < ONE_SIDED;
            let behind = if is_enough { None } else { side(-step) };
            // At the very edge of what can be evaluated one side is all there is.
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
        let give = at.bounds.iter().map(|bound| bound.compliance).collect();
        Linearization::new((jacobian, slopes), Rc::clone(&at.rows), give, self.work())
    }
}

/// That no segment folds which did not.
fn fold_bounds<'a>(folds: &'a [f64], begun: &'a [f64]) -> impl Iterator<Item = Bound> + 'a {
    let room = |(fold, most): (&f64, &f64)| (most.max(MAX_R_KAPPA) - fold) / MAX_R_KAPPA;
    folds.iter().zip(begun).map(move |fold| hard_bound(room(fold), DragLimit::Fold))
}

/// How firmly what is asked for and what is pinned is held.
pub(crate) fn row_holds(asked: &Objective, pins: &[PinState]) -> Rc<[Hold]> {
    let count = match asked {
        Objective::Feature(_) => 2,
        Objective::Position { .. } => 3,
    };
    std::iter::repeat_n(Hold::Objective, count).chain(pins.iter().flat_map(PinState::row_holds)).collect()
}

/// The unit vector at a share of the shortest turn from one to another.
fn slerp(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    let cos = from.dot(to);
    let across = (to - from * cos).normalize_or_zero();
    let angle = libm::atan2(from.cross(to).length(), cos) * share;
    from * libm::cos(angle) + across * libm::sin(angle)
}
