//! Control points and lights that are placed by hand, which slide along their hard pins.

use glam::{DQuat, DVec3};
use light::CheckedLight;
use light::parameters::{ROTATION, TRANSLATION};
use raycast::Bvh;

use crate::chain::follow;
use crate::held_pins::HeldPins;
use crate::matrix::{difference, length};
use crate::moves::Unknowns;
use crate::occlusion::Occlusion;
use crate::overlap::OverlapRule;
use crate::picture_metric::PictureMetric;
use crate::pins::Pins;
use crate::problem::{Objective, Problem, Tracked};
use crate::request::{DragLimit, NumberedPin, RadiusMode};
use crate::slide::{LIMIT_HALVINGS, MAX_TANGENTS, PARTS, RULE, Slide, polyline_length, slide_point};
use crate::visibility::Visibility;
use crate::work::WorkBudget;

/// Greatest length of the way of a placement, in its unit of length. The chain does not shorten steps along such a way.
const MAX_WAY: f64 = 2.0;

/// Way that is left before the first limit of the straight way, in units of the unknowns. At the edge of a shadow itself
/// a picture may show either side.
const ROOM_BEFORE_LIMIT: f64 = 1e-3;

/// Moves a control point as [`slide_point`] does, or as near to `to` as the hard pins allow. Pins that do not hold in
/// `light` are passed over, and soft pins have no effect.
///
/// If `work` is cancelled, the result has no meaning. If it is spent, the light stays.
pub fn slide_point_along_pins(
    bvh: &Bvh,
    light: &CheckedLight,
    point: usize,
    to: DVec3,
    radii: RadiusMode,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> Option<Slide> {
    let free = slide_point(light, point, to, radii)?;
    let occlusion = Occlusion::new(bvh, light, work);
    let held = HeldPins::new(&occlusion, light, pins);
    let Some(broken) = held.first_broken(&free.light) else { return Some(free) };
    let points = light.light().points();
    let unit = polyline_length(points);
    let unknowns = Unknowns::Points { points: vec![point], radii, unit };
    let whole = ((to - points[point].position) / unit).to_array();
    let overlap = OverlapRule::new(light, work);
    let slid = farthest_light(&held, light, &unknowns, Objective::Position { point, to }, &whole, overlap);
    let distance_left = slid.light().points()[point].position.distance(to);
    Some(Slide { light: slid, limit: Some(limit_of(broken, work)), distance_left })
}

/// Places a light at a translation and rotation, or as near to them as the hard pins allow. `None` stays as it is, also
/// where a pin lets the light come nearer by it. Pins count as in [`slide_point_along_pins`].
///
/// `None` if the light cannot be placed there for another reason than its pins.
pub fn place_along_pins(
    bvh: &Bvh,
    light: &CheckedLight,
    translation: Option<DVec3>,
    rotation: Option<DQuat>,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> Option<Slide> {
    let (from, turned_from) = (light.light().get(TRANSLATION), light.light().get(ROTATION));
    let (to, turned_to) = (translation.unwrap_or(from), rotation.unwrap_or(turned_from));
    let placed = light.light().clone().with(TRANSLATION, to).with(ROTATION, turned_to);
    let placed = CheckedLight::new(placed).ok()?;
    let occlusion = Occlusion::new(bvh, light, work);
    let held = HeldPins::new(&occlusion, light, pins);
    let distance_left = |light: &CheckedLight| light.light().get(TRANSLATION).distance(to);
    let Some(broken) = held.first_broken(&placed) else {
        return Some(Slide { light: placed, limit: None, distance_left: 0.0 });
    };
    let nearest_pin = held.nearest_distance(from - bvh.posed.origin_in_world);
    let unit = nearest_pin.max(to.distance(from) / MAX_WAY);
    let turn = (turned_to.normalize() * turned_from.normalize().inverse()).normalize();
    let turn = if turn.w < 0.0 { -turn } else { turn }.to_scaled_axis();
    let (moves, turns) = (to != from, turned_to != turned_from);
    let (unknowns, whole) = match (moves, turns) {
        (true, true) => (Unknowns::Rigid { unit }, [((to - from) / unit).to_array(), turn.to_array()].concat()),
        (true, false) => (Unknowns::Move { unit }, ((to - from) / unit).to_array().to_vec()),
        (false, _) => (Unknowns::Turn, turn.to_array().to_vec()),
    };
    // A light that moves as a whole overlaps as it did.
    let none = OverlapRule::default();
    let slid = farthest_light(&held, light, &unknowns, Objective::Placement(&whole), &whole, none);
    let distance_left = distance_left(&slid);
    Some(Slide { light: slid, limit: Some(limit_of(broken, work)), distance_left })
}

fn limit_of(broken: u64, work: &WorkBudget) -> DragLimit {
    if work.is_exhausted() { DragLimit::TooMuchWork } else { DragLimit::Pin(broken) }
}

/// Returns the light that keeps the pins and is nearest to the change `whole` of the unknowns: straight to the first
/// limit, and then along it. It is the light as it was if no other keeps them.
fn farthest_light(
    held: &HeldPins,
    light: &CheckedLight,
    unknowns: &Unknowns,
    objective: Objective,
    whole: &[f64],
    overlap: OverlapRule,
) -> CheckedLight {
    let Some((scene_light, pins)) = held.together() else { return light.clone() };
    let (metric, none) = (PictureMetric::default(), Pins::default());
    let shape = Problem::new(objective, light, unknowns, scene_light.clone(), &metric, &none);
    let shape_near = shape.tracked_at_start([0.0; 2]);
    // Rays check the pins, and not the bounds by which the solver keeps a margin from them.
    let valid_light = |x: &[f64]| {
        shape.evaluate(x, 1.0, &shape_near).filter(|at| at.violated(0.0).is_none())?;
        let moved = CheckedLight::new(unknowns.light(light.light(), x)).ok()?;
        let overlaps = || overlap.overlap(moved.rays(), held.occlusion.work).is_some();
        (held.first_broken(&moved).is_none() && !overlaps()).then_some(moved)
    };
    let on_way = |share: f64| -> Vec<f64> { whole.iter().map(|whole| whole * share).collect() };
    let left = |x: &[f64]| length(&difference(x, whole));
    let (mut reached, mut limited) = (0.0, 1.0);
    for _ in 0..LIMIT_HALVINGS {
        let middle = f64::midpoint(reached, limited);
        if valid_light(&on_way(middle)).is_some() { reached = middle } else { limited = middle }
    }
    reached = (reached - ROOM_BEFORE_LIMIT / length(whole)).max(0.0);
    let straight = valid_light(&on_way(reached));
    if straight.is_none() {
        reached = 0.0;
    }
    let straight = straight.unwrap_or_else(|| light.clone());
    let begin = on_way(reached);
    let mut problem = Problem::new(objective, light, unknowns, scene_light, &metric, &pins);
    let near = problem.tracked_at_start([0.0; 2]);
    let Some(near) = problem.evaluate(&begin, reached, &near).map(|at| at.tracked) else { return straight };
    let slid = (1..=PARTS).rev().find_map(|part| {
        let to = reached + (1.0 - reached) * f64::from(part) / f64::from(PARTS);
        let x = chain_with_tangents(held, &mut problem, &begin, &near, [reached, to], overlap)?;
        let is_nearer = left(&x) < left(&begin);
        is_nearer.then(|| valid_light(&x)).flatten()
    });
    slid.filter(|_| !held.occlusion.work.is_exhausted()).unwrap_or(straight)
}

/// Follows a part of the way. A limit without a slope that the light has crossed at the end becomes a further
/// bound. `None` if the chain does not reach the end.
fn chain_with_tangents(
    held: &HeldPins,
    problem: &mut Problem,
    begin: &[f64],
    near: &Tracked,
    part: [f64; 2],
    overlap: OverlapRule,
) -> Option<Vec<f64>> {
    let visibility = Visibility { occlusion: held.occlusion, source_outside: false, overlap };
    problem.tangents.clear();
    loop {
        let x = follow(problem, begin.to_vec(), near, part, &RULE).ok()?.x;
        if problem.tangents.len() >= MAX_TANGENTS {
            return Some(x);
        }
        let tangents = visibility.violated_tangents(problem, &x, false);
        if tangents.is_empty() {
            return Some(x);
        }
        problem.tangents.extend(tangents);
    }
}
