//! One drag, from the pick to the result.

use glam::DVec2;
use light::{CheckedLight, LightRays};
use raycast::{Bvh, SeenPoint};
use scene::ViewRay;

use crate::SOLVER;
use crate::direct::{other_solutions, solve_with_pins};
use crate::dragged_feature::DraggedFeature;
use crate::goal::{Goal, Objective, TakenFeature, TrackedPoints};
use crate::moves::Unknowns;
use crate::occlusion::{Occlusion, ShadowCaster};
use crate::pins::PinState;
use crate::point_in_light::{PointInLight, SceneLight};
use crate::request::{
    Drag, DragLimit, DragOutcome, DragRefusal, DragResult, DragStatus, Feature, NumberedPin, Viewport,
};
use crate::scene_visibility::SceneVisibility;
use crate::solve::solve;
use crate::step::{Iterate, Solution};
use crate::work::WorkBudget;

/// Largest residual of a converged drag, in pixels. The lit side of a surface has to reach 0, since its residual is 0
/// wherever the surface faces the light closely enough.
pub(crate) const CONVERGED_PX: f64 = 0.5;

/// Cost of checking a light, in steps per control point.
const CHECK_COST_STEPS: u64 = 1_000;

/// Largest distance at which two points of a light path count as the same point, as a share of their distance from the
/// source or from the point under the cursor.
pub(crate) const SAME_POINT_TOLERANCE: f64 = 1e-6;

/// Drags a feature of `light` from one point of a picture to another. Keeps `pins` if the drag has none of its own.
pub fn drag(bvh: &Bvh, light: &CheckedLight, drag: &Drag, pins: &[NumberedPin]) -> DragResult {
    drag_budgeted(bvh, light, drag, pins, &WorkBudget::new(&|_| true))
}

/// Drags a feature like [`drag`] and counts the steps in `work`. If `work` is cancelled, the result has no meaning.
pub fn drag_budgeted(
    bvh: &Bvh,
    light: &CheckedLight,
    drag: &Drag,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> DragResult {
    let pins = drag.pins.as_deref().unwrap_or(pins);
    let (picked, mut result) = pick(bvh, light, drag, work);
    let occlusion = Occlusion::new(bvh, light, work);
    match build_goal(&occlusion, light, drag, pins, &picked) {
        _ if work.is_exhausted() => limit_unmoved(&mut result, drag),
        Err(refusal) => result.outcome.status = DragStatus::Refused(refusal),
        Ok((goal, taken, near)) => {
            result.outcome.pivot_world = taken.pivot.map(|pivot| pivot + bvh.posed.origin_in_world);
            solve_and_judge(&occlusion, drag, goal, &taken, &near, &mut result);
        }
    }
    result
}

/// Picks the surfaces at the start of the drag and under the cursor. Also returns the result of a drag that is refused.
pub(crate) fn pick(
    bvh: &Bvh,
    light: &CheckedLight,
    drag: &Drag,
    work: &WorkBudget,
) -> ([Option<SeenPoint>; 2], DragResult) {
    let origin = bvh.posed.origin_in_world;
    let picked = [drag.from, drag.to].map(|pixel| seen_at(bvh, &drag.view, pixel, work));
    let [from_world, to_world] = picked.map(|seen| seen.map(|seen| seen.position + origin));
    let (solver, version) = SOLVER;
    let outcome = DragOutcome {
        solver: solver.into(),
        version,
        status: DragStatus::Refused(DragRefusal::NothingAtStart),
        residual_px: f64::INFINITY,
        shadowed_by: None,
        iterations: 0,
        from_world,
        to_world,
        pivot_world: None,
    };
    (picked, DragResult { light: light.light().clone(), outcome })
}

/// Returns the surface that a pixel shows.
pub(crate) fn seen_at(bvh: &Bvh, view: &Viewport, pixel: DVec2, work: &WorkBudget) -> Option<SeenPoint> {
    let ray = ViewRay::new(&view.camera, view.size, pixel, bvh.posed.origin_in_world);
    bvh.visible_point_budgeted(&ray, |boxes| work.spend_on_rays(boxes))
}

/// Start of a drag, the same for all its ends.
pub(crate) struct DragStart<'a> {
    pub placed: SceneLight<'a>,
    pub from: SeenPoint,
    /// Surface under the cursor.
    pub to: SeenPoint,
    /// Light coordinates of `from`.
    pub coords: PointInLight,
    /// First caster before `from`, for a dragged shadow.
    pub caster: Option<ShadowCaster>,
    pub pins: Vec<PinState>,
    pub unknowns: Unknowns,
}

impl<'a> DragStart<'a> {
    /// Finds the start of a drag between the surfaces of `picked`, or returns the reason to refuse the drag.
    pub fn new(
        occlusion: &Occlusion<'a>,
        light: &'a CheckedLight,
        drag: &Drag,
        pins: &[NumberedPin],
        picked: &[Option<SeenPoint>; 2],
    ) -> Result<Self, DragRefusal> {
        if drag.points.is_some() && light.tube().is_none() {
            return Err(DragRefusal::NotBendy);
        }
        let [from, to] = *picked;
        let from = from.ok_or(DragRefusal::NothingAtStart)?;
        let to = to.ok_or(DragRefusal::NothingAtEnd)?;
        let placed = SceneLight::new(light.rays(), occlusion.bvh.posed.origin_in_world, from.position, occlusion.work);
        let coords = placed.locate(from.position, None).ok_or(DragRefusal::OutsideTheLight)?;
        if !placed.contains(&coords) || !occlusion.is_node_lit(from.node) {
            return Err(DragRefusal::OutsideTheLight);
        }
        if !occlusion.is_node_lit(to.node) {
            return Err(DragRefusal::NothingAtEnd);
        }
        let caster = match drag.feature {
            Feature::Shadow => Some(occlusion.first_caster(&placed, &coords, &from).ok_or(DragRefusal::NoShadow)?),
            _ => None,
        };
        let pins = pins.iter().map(|pin| PinState::new(occlusion, &placed, pin));
        let pins: Vec<PinState> = pins.filter_map(Result::transpose).collect::<Result<_, _>>()?;
        let unknowns = choose_unknowns(light, drag, from.position.distance(placed.source()))?;
        Ok(Self { placed, from, to, coords, caster, pins, unknowns })
    }

    /// Returns the feature with its way to the surface `to`.
    pub fn taken(&self, feature: Feature, to: SeenPoint) -> TakenFeature {
        TakenFeature {
            feature,
            from: self.from,
            to,
            pivot: self.caster.map(|caster| caster.position),
            start_coords: self.coords,
            directions: [self.coords.to_light, feature.target_direction(&to)],
        }
    }

    /// Returns the values of `t` of the feature and its caster.
    pub fn feature_t(&self) -> [f64; 2] {
        [self.coords.t, self.caster.map_or(0.0, |caster| caster.t)]
    }
}

/// Builds the goal of the drag and the values of `t` to track, or returns the reason to refuse the drag.
fn build_goal<'a>(
    occlusion: &Occlusion<'a>,
    light: &'a CheckedLight,
    drag: &Drag,
    pins: &[NumberedPin],
    picked: &[Option<SeenPoint>; 2],
) -> Result<(Goal<'a>, TakenFeature, TrackedPoints), DragRefusal> {
    let start = DragStart::new(occlusion, light, drag, pins, picked)?;
    let mut near = vec![start.feature_t()];
    near.extend(start.pins.iter().map(PinState::start_t));
    let taken = start.taken(drag.feature, start.to);
    let DragStart { placed, pins, unknowns, .. } = start;
    let goal = Goal::new(Objective::Feature(Box::new(taken.clone())), light, unknowns, placed, pins);
    Ok((goal, taken, near))
}

/// Selects the unknowns of the drag. `unit` is the unit of length of a rigid motion, in world units.
fn choose_unknowns(light: &CheckedLight, drag: &Drag, unit: f64) -> Result<Unknowns, DragRefusal> {
    let Some(points) = &drag.points else {
        let is_directional = matches!(light.rays(), LightRays::Parallel(_));
        return Ok(if is_directional { Unknowns::Turn } else { Unknowns::Rigid { unit } });
    };
    let all = light.light().points();
    if all.is_empty() {
        return Err(DragRefusal::NotBendy);
    }
    let mut points = points.clone();
    points.sort_unstable();
    points.dedup();
    if points.iter().any(|point| !(1..all.len()).contains(point)) {
        return Err(DragRefusal::NoSuchPoint);
    }
    let unit = all.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    Ok(Unknowns::Points { points, radii: drag.radii, unit })
}

/// Solves the drag and writes the result to `result`.
fn solve_and_judge(
    occlusion: &Occlusion,
    drag: &Drag,
    mut goal: Goal,
    taken: &TakenFeature,
    near: &TrackedPoints,
    result: &mut DragResult,
) {
    let work = occlusion.work;
    let visibility = SceneVisibility { occlusion, source_outside: drag.source_outside };
    let judge = ResultJudge { drag, occlusion, taken };
    let has_no_effect = goal.has_no_effect(near);
    let first = if has_no_effect { None } else { solve(&mut goal, near, &visibility) };
    let unjudged = result.clone();
    match &first {
        _ if work.is_exhausted() => {}
        _ if has_no_effect => result.outcome.status = DragStatus::Refused(DragRefusal::NoWeight),
        None => result.outcome.status = DragStatus::Refused(DragRefusal::OutsideTheLight),
        Some(first) => judge.judge(&goal, first, result),
    }
    if work.is_exhausted() {
        *result = judge.judge_unfinished(&goal, first.as_ref(), &visibility, unjudged);
        return;
    }
    let Some(first) = first else { return };
    if !matches!(result.outcome.status, DragStatus::Limited(_)) || goal.pins.is_empty() {
        return;
    }
    let first_landing = result.clone();
    try_other_solutions(&goal, &first, near, &visibility, &judge, result);
    if work.is_exhausted() {
        // The first result holds.
        *result = first_landing;
        result.outcome.status = DragStatus::Limited(DragLimit::TooMuchWork);
    }
}

/// Searches for another light that has the feature under the cursor, if pins keep the solver from getting there. If
/// there is none, names the pin that keeps the light from the cursor.
fn try_other_solutions(
    goal: &Goal,
    first: &Solution,
    near: &TrackedPoints,
    visibility: &SceneVisibility,
    judge: &ResultJudge,
    result: &mut DragResult,
) {
    let lands = |found: &Solution| {
        let mut result = result.clone();
        judge.judge(goal, found, &mut result);
        (result.outcome.status == DragStatus::Landed).then_some(result)
    };
    let Some(free) = solve_with_pins(goal, near, visibility, |_| false).filter(|free| lands(free).is_some()) else {
        return;
    };
    let found =
        other_solutions(goal, near, visibility, [&first.iterate.x, &free.iterate.x]).find_map(|other| lands(&other));
    if let Some(found) = found {
        *result = found;
    } else if !matches!(result.outcome.status, DragStatus::Limited(DragLimit::Pin(_)))
        && let Some(limit) = visibility.violated_limit(goal, &free.iterate.x)
    {
        result.outcome.status = DragStatus::Limited(limit);
    }
}

/// Writes the result of a drag that spent its budget and leaves the light as it was at the start.
pub(crate) fn limit_unmoved(result: &mut DragResult, drag: &Drag) {
    result.outcome.status = DragStatus::Limited(DragLimit::TooMuchWork);
    result.outcome.residual_px = drag.from.distance(drag.to);
}

/// Judge of a light that the solver found. It checks the light with rays of its own and uses none of the solver's
/// numbers.
struct ResultJudge<'a> {
    drag: &'a Drag,
    occlusion: &'a Occlusion<'a>,
    taken: &'a TakenFeature,
}

impl ResultJudge<'_> {
    /// Returns the result of a drag that spent its budget.
    ///
    /// The result has the light found so far if that light keeps all limits and hard pins, and if the feature is nearer
    /// to the cursor than at the start. Otherwise it has the light of the start.
    fn judge_unfinished(
        &self,
        goal: &Goal,
        found: Option<&Solution>,
        visibility: &SceneVisibility,
        unjudged: DragResult,
    ) -> DragResult {
        let work = self.occlusion.work;
        let mut unmoved = unjudged.clone();
        limit_unmoved(&mut unmoved, self.drag);
        work.allow_judging();
        let goal = goal.with_edge_compliance(1.0);
        let holds = |found: &&Solution| {
            let is_feasible = found.iterate.at_share(&goal, 1.0).is_some_and(|at| at.is_feasible());
            is_feasible && visibility.violated_limit(&goal, &found.iterate.x).is_none()
        };
        let Some(found) = found.filter(holds) else { return unmoved };
        let mut moved = unjudged;
        self.judge(&goal, found, &mut moved);
        if work.is_exhausted() || moved.outcome.residual_px >= unmoved.outcome.residual_px {
            return unmoved;
        }
        if moved.outcome.status != DragStatus::Landed {
            moved.outcome.status = DragStatus::Limited(DragLimit::TooMuchWork);
        }
        moved
    }

    /// Judges a light that the solver found, and writes the result to `result`.
    fn judge(&self, goal: &Goal, found: &Solution, result: &mut DragResult) {
        let Self { drag, occlusion, taken } = *self;
        let Solution { iterate: Iterate { x, evaluation }, strongest_limit, iterations } = found;
        goal.work().spend(CHECK_COST_STEPS * goal.start.light().points().len() as u64);
        result.outcome.iterations += iterations;
        let Ok(moved) = CheckedLight::new(goal.unknowns.light(goal.start.light(), x)) else {
            result.outcome.status = DragStatus::Limited(DragLimit::Fold);
            return;
        };
        result.light = moved.light().clone();
        let placed = goal.scene_light.with(moved.rays());
        let near = evaluation.tracked[0];
        result.outcome.residual_px =
            DraggedFeature { bvh: occlusion.bvh, view: &drag.view, taken, placed: &placed }.distance_px(near, drag.to);
        // If paths of a light overlap, the root that counts may differ from the tracked one.
        let counts = placed.locate(taken.to.position, None);
        let is_tracked = |counts: Option<PointInLight>, tracked: f64| {
            counts.is_some_and(|counts| (counts.t - tracked).abs() < SAME_POINT_TOLERANCE * (1.0 + tracked.abs()))
        };
        let is_inside = is_tracked(counts, near[0])
            && taken.pivot.is_none_or(|pivot| is_tracked(placed.locate(pivot, None), near[1]));
        let first = counts.and_then(|coords| occlusion.first_caster(&placed, &coords, &taken.to));
        let is_dark = first.is_some() && counts.is_some_and(|coords| occlusion.is_unlit(&placed, &coords, &taken.to));
        let least_px = if taken.feature == Feature::Diffuse { 0.0 } else { CONVERGED_PX };
        result.outcome.status = if result.outcome.residual_px > least_px {
            DragStatus::Limited(strongest_limit.unwrap_or(DragLimit::NoDescent))
        } else if !is_inside {
            DragStatus::Limited(DragLimit::TubeEdge)
        } else if taken.pivot.is_some() && !is_dark {
            // The light path only grazes the caster.
            DragStatus::Limited(DragLimit::NoDescent)
        } else {
            DragStatus::Landed
        };
        result.outcome.shadowed_by = None;
        let (Some(first), Some(pivot)) = (first, taken.pivot) else { return };
        let is_the_pivot = pivot.distance(first.position) < SAME_POINT_TOLERANCE * pivot.distance(taken.to.position);
        result.outcome.shadowed_by = (!is_the_pivot).then(|| occlusion.bvh.posed.scene.nodes[first.node].name.clone());
    }
}
