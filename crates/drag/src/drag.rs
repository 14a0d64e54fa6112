//! One drag, from the pick to the landing.

use glam::DVec2;
use light::{CheckedLight, Rays};
use raycast::{Bvh, Seen};
use scene::ViewRay;

use crate::direct::{others, solve_with};
use crate::goal::{Asked, Goal, Near, Taken};
use crate::lies::Lies;
use crate::moves::Moves;
use crate::occlusion::Occlusion;
use crate::pins::Pinned;
use crate::place::{Place, Placed};
use crate::request::{Drag, Feature, Landing, Limit, Refusal, Status, Viewport};
use crate::sight::Sight;
use crate::solve::solve;
use crate::step::{At, Solution};
use crate::work::Work;

/// Pixels within which a feature lies under the cursor. A surface is turned to the light or is not: where it is they are 0.
const UNDER_THE_CURSOR_PX: f64 = 0.5;

/// Steps of a control point of a light that is checked.
const STEPS_OF_CHECK: u64 = 1_000;

/// How near two places on a way lie that are the same, as a share of their distance from the source or the cursor.
const SAME_PLACE: f64 = 1e-6;

/// Drags a feature of `light` from one point of a picture to another.
pub fn drag(bvh: &Bvh, view: &Viewport, light: &CheckedLight, drag: &Drag) -> Landing {
    drag_within(bvh, view, light, drag, &Work::new(&|_| true))
}

/// The same with its steps counted by `work`. Where it is given up the landing means nothing.
pub fn drag_within(bvh: &Bvh, view: &Viewport, light: &CheckedLight, drag: &Drag, work: &Work) -> Landing {
    let origin = bvh.posed.origin_in_world;
    let spend = |boxes| work.spend_on_rays(boxes);
    let seen = |pixel: DVec2| bvh.seen_counted(&ViewRay::new(&view.camera, view.size, pixel, origin), spend);
    let (from, to) = (seen(drag.from), seen(drag.to));
    let mut landing = Landing {
        status: Status::Refused(Refusal::NothingAtStart),
        light: light.light().clone(),
        residual_px: f64::INFINITY,
        shadowed_by: None,
        iterations: 0,
        from_world: from.map(|seen| seen.position + origin),
        to_world: to.map(|seen| seen.position + origin),
        pivot_world: None,
    };
    let occlusion = Occlusion::new(bvh, light, work);
    match begin(&occlusion, bvh, light, drag, from, to) {
        _ if work.is_over() => end_unmoved(&mut landing, drag),
        Err(refusal) => landing.status = Status::Refused(refusal),
        Ok((goal, taken, near)) => {
            landing.pivot_world = taken.pivot.map(|pivot| pivot + origin);
            land(bvh, &occlusion, (view, drag), (goal, &taken), &near, &mut landing);
        }
    }
    landing
}

/// What is asked for, or why it cannot be.
fn begin<'a>(
    occlusion: &Occlusion<'a>,
    bvh: &Bvh,
    light: &'a CheckedLight,
    drag: &Drag,
    from: Option<Seen>,
    to: Option<Seen>,
) -> Result<(Goal<'a>, Taken, Near), Refusal> {
    if drag.points.is_some() && light.tube().is_none() {
        return Err(Refusal::NotBendy);
    }
    let from = from.ok_or(Refusal::NothingAtStart)?;
    let to = to.ok_or(Refusal::NothingAtEnd)?;
    let placed = Placed::new(light.rays(), bvh.posed.origin_in_world, from.position, occlusion.work);
    let place = placed.locate(from.position, None).ok_or(Refusal::OutsideTheLight)?;
    if placed.out2(&place) > 1.0 || place.from_ends < 0.0 || !occlusion.lights(from.node) {
        return Err(Refusal::OutsideTheLight);
    }
    if !occlusion.lights(to.node) {
        return Err(Refusal::NothingAtEnd);
    }
    let caster = match drag.feature {
        Feature::Shadow => Some(occlusion.first(&placed, &place, &from).ok_or(Refusal::NoShadow)?),
        _ => None,
    };
    let end = match drag.feature {
        Feature::Highlight => to.mirrored(),
        _ => to.normal,
    };
    let pins = drag.pins.iter().enumerate();
    let pins = pins.map(|pin| Pinned::new(occlusion, bvh, &placed, pin));
    let pins: Vec<Pinned> = pins.filter_map(Result::transpose).collect::<Result<_, _>>()?;
    let mut near = vec![[place.t, caster.map_or(0.0, |caster| caster.t)]];
    near.extend(pins.iter().map(Pinned::near));
    let taken = Taken {
        feature: drag.feature,
        from,
        to,
        pivot: caster.map(|caster| caster.position),
        place,
        directions: [place.to_light, end],
    };
    let moves = moves(light, drag, from.position.distance(placed.source()))?;
    let goal = Goal::new(Asked::Feature(Box::new(taken.clone())), (light, moves), placed, pins);
    Ok((goal, taken, near))
}

/// What may change; `unit` is what a whole light moves by.
fn moves(light: &CheckedLight, drag: &Drag, unit: f64) -> Result<Moves, Refusal> {
    let Some(points) = &drag.points else {
        let comes_from_everywhere = matches!(light.rays(), Rays::Parallel(_));
        return Ok(if comes_from_everywhere { Moves::Turn } else { Moves::Rigid { unit } });
    };
    let all = light.light().points();
    if all.is_empty() {
        return Err(Refusal::NotBendy);
    }
    let mut points = points.clone();
    points.sort_unstable();
    points.dedup();
    if points.iter().any(|point| !(1..all.len()).contains(point)) {
        return Err(Refusal::NoSuchPoint);
    }
    let unit = all.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    Ok(Moves::Points { points, radii: drag.radii, unit })
}

/// Solves, and says what came of it.
fn land(
    bvh: &Bvh,
    occlusion: &Occlusion,
    (view, drag): (&Viewport, &Drag),
    (mut goal, taken): (Goal, &Taken),
    near: &Near,
    landing: &mut Landing,
) {
    let work = occlusion.work;
    let sight = Sight { occlusion, source_outside: drag.source_outside };
    let end = End { bvh, view, drag, occlusion, taken };
    let has_no_weight = goal.has_no_weight(near);
    let first = if has_no_weight { None } else { solve(&mut goal, near, &sight) };
    let unjudged = landing.clone();
    match &first {
        _ if work.is_over() => {}
        _ if has_no_weight => landing.status = Status::Refused(Refusal::NoWeight),
        None => landing.status = Status::Refused(Refusal::OutsideTheLight),
        Some(first) => end.judge(&goal, first, landing),
    }
    if work.is_over() {
        *landing = end.cut_short(&goal, first.as_ref(), &sight, unjudged);
        return;
    }
    let Some(first) = first else { return };
    if !matches!(landing.status, Status::Limited(_)) || goal.pins.is_empty() {
        return;
    }
    let first_landing = landing.clone();
    elsewhere(&goal, &first, near, &sight, &end, landing);
    if work.is_over() {
        // What was found first holds.
        *landing = Landing { status: Status::Limited(Limit::TooMuchWork), ..first_landing };
    }
}

/// Another light that lands, where pins close the way to the cursor; or which pin keeps the light from it.
fn elsewhere(goal: &Goal, first: &Solution, near: &Near, sight: &Sight, end: &End, landing: &mut Landing) {
    let lands = |found: &Solution| {
        let mut landing = landing.clone();
        end.judge(goal, found, &mut landing);
        (landing.status == Status::Landed).then_some(landing)
    };
    let Some(free) = solve_with(goal, near, sight, |_| false).filter(|free| lands(free).is_some()) else {
        return;
    };
    let found = others(goal, near, sight, [&first.at.x, &free.at.x]).find_map(|other| lands(&other));
    if let Some(found) = found {
        *landing = found;
    } else if !matches!(landing.status, Status::Limited(Limit::Pin(_)))
        && let Some(limit) = sight.unheld(goal, &free.at.x)
    {
        landing.status = Status::Limited(limit);
    }
}

/// Says of a drag whose work is over that it leaves the light as it was.
fn end_unmoved(landing: &mut Landing, drag: &Drag) {
    landing.status = Status::Limited(Limit::TooMuchWork);
    landing.residual_px = drag.from.distance(drag.to);
}

/// The end of a drag, at which what was found is looked at.
struct End<'a> {
    bvh: &'a Bvh,
    view: &'a Viewport,
    drag: &'a Drag,
    occlusion: &'a Occlusion<'a>,
    taken: &'a Taken,
}

impl End<'_> {
    /// The landing of a drag whose work is over: with the light that was found until then, where that is known to hold and to have
    /// the feature nearer to the cursor than it was; else with the light as it was.
    fn cut_short(&self, goal: &Goal, found: Option<&Solution>, sight: &Sight, unjudged: Landing) -> Landing {
        let work = self.occlusion.work;
        let mut unmoved = unjudged.clone();
        end_unmoved(&mut unmoved, self.drag);
        work.allow_judging();
        let goal = goal.gliding(1.0);
        let holds = |found: &&Solution| {
            let At { x, evaluation } = &found.at;
            let at_end = goal.evaluate(x, 1.0, &evaluation.near);
            let is_allowed = at_end.is_some_and(|evaluation| At { x: x.clone(), evaluation }.is_allowed());
            is_allowed && sight.unheld(&goal, x).is_none()
        };
        let Some(found) = found.filter(holds) else { return unmoved };
        let mut moved = unjudged;
        self.judge(&goal, found, &mut moved);
        if work.is_over() || moved.residual_px >= unmoved.residual_px {
            return unmoved;
        }
        if moved.status != Status::Landed {
            moved.status = Status::Limited(Limit::TooMuchWork);
        }
        moved
    }

    /// Says what came of it.
    fn judge(&self, goal: &Goal, found: &Solution, landing: &mut Landing) {
        let Self { bvh, view, drag, occlusion, taken } = self;
        let Solution { at: At { x, evaluation }, held_by, iterations } = found;
        goal.work().spend(STEPS_OF_CHECK * goal.start.light().points().len() as u64);
        landing.iterations += iterations;
        let Ok(moved) = CheckedLight::new(goal.moves.light(goal.start.light(), x)) else {
            landing.status = Status::Limited(Limit::Fold);
            return;
        };
        landing.light = moved.light().clone();
        let placed = goal.placed.with(moved.rays());
        let near = evaluation.near[0];
        landing.residual_px = Lies { bvh, view, taken, placed: &placed }.distance_px(near, drag.to);
        // Where ways of a light overlap, another place than the one that was followed may count.
        let counts = placed.locate(taken.to.position, None);
        let is_the_one = |counts: Option<Place>, followed: f64| {
            counts.is_some_and(|counts| (counts.t - followed).abs() < SAME_PLACE * (1.0 + followed.abs()))
        };
        let is_inside = is_the_one(counts, near[0])
            && taken.pivot.is_none_or(|pivot| is_the_one(placed.locate(pivot, None), near[1]));
        let first = counts.and_then(|place| occlusion.first(&placed, &place, &taken.to));
        let is_dark =
            first.is_some() && counts.is_some_and(|place| occlusion.is_dark(&placed, &place, &taken.to));
        let least_px = if taken.feature == Feature::Diffuse { 0.0 } else { UNDER_THE_CURSOR_PX };
        landing.status = if landing.residual_px > least_px {
            Status::Limited(held_by.unwrap_or(Limit::NoDescent))
        } else if !is_inside {
            Status::Limited(Limit::TubeEdge)
        } else if taken.pivot.is_some() && !is_dark {
            // The way only touches what throws the shadow.
            Status::Limited(Limit::NoDescent)
        } else {
            Status::Landed
        };
        landing.shadowed_by = None;
        let (Some(first), Some(pivot)) = (first, taken.pivot) else { return };
        let is_the_pivot = pivot.distance(first.position) < SAME_PLACE * pivot.distance(taken.to.position);
        landing.shadowed_by = (!is_the_pivot).then_some(first.node);
    }
}
