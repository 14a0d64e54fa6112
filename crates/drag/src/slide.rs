//! Dragged control points, which slide along the limits of their light.

use glam::DVec3;
use light::{CheckedLight, ControlPoint};

use crate::chain::{ChainEnd, ChainRule, follow};
use crate::convex_step::StepWeights;
use crate::moves::Unknowns;
use crate::overlap::OverlapRule;
use crate::picture_metric::PictureMetric;
use crate::pin_state::LimitTangent;
use crate::pins::Pins;
use crate::point_in_light::SceneLight;
use crate::problem::{Objective, Problem, Tracked};
use crate::request::{DragLimit, RadiusMode};
use crate::work::WorkBudget;

/// Chain along the way of a control point. The steps are light, since the way itself is the wish.
pub(crate) const RULE: ChainRule = ChainRule {
    sub_steps: 32,
    end_steps: 16,
    weights: StepWeights { change: 0.0, step: 0.1 },
    max_change: f64::INFINITY,
    max_rows: 0.1,
};

/// Number of times that an interval is halved to find the last place of the straight way before a limit.
pub(crate) const LIMIT_HALVINGS: usize = 20;

/// Number of parts of the way after that place that are tried from the target backwards.
pub(crate) const PARTS: u32 = 8;

/// Most tangents that are added in a slide.
pub(crate) const MAX_TANGENTS: usize = 12;

/// Result of a dragged control point, or of a light that is placed.
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    /// A light that can be evaluated.
    pub light: CheckedLight,
    /// Limit that keeps the control point or the light from its target; `None` if the target is reached.
    pub limit: Option<DragLimit>,
    /// Distance of the control point from its target, in light-local units, or of the placed light's source, in world
    /// units.
    pub distance_left: f64,
}

/// Moves a control point of `light` to `to` in light-local space, or as near as it can without a fold, and without an
/// overlap unless the light allows it.
///
/// With [`RadiusMode::Follow`] radii that would make the tube fold shrink, and no fold keeps the point from its target.
/// The result depends on the light and on `to` alone.
///
/// `None` if the light has no such control point or it is the source, if `to` is not finite, and for
/// [`RadiusMode::Solve`], since radii have no effect on a position.
pub fn slide_point(light: &CheckedLight, point: usize, to: DVec3, radii: RadiusMode) -> Option<Slide> {
    let points = light.light().points();
    if !(1..points.len()).contains(&point) || radii == RadiusMode::Solve || !to.is_finite() {
        return None;
    }
    light.tube()?;
    let unit = polyline_length(points);
    let unknowns = Unknowns::Points { points: vec![point], radii, unit };
    let (work, metric, pins) = (WorkBudget::new(&|_| true), PictureMetric::default(), Pins::default());
    let scene_light = SceneLight::new(light.rays(), DVec3::ZERO, DVec3::ZERO, &work);
    let objective = Objective::Position { point, to };
    let mut problem = Problem::new(objective, light, &unknowns, scene_light, &metric, &pins);
    let near = problem.tracked_at_start([0.0; 2]);
    let overlap = OverlapRule::new(light, &work);
    // Without a limit the point reaches its target to the last bit.
    let whole_change = ((to - points[point].position) / unit).to_array();
    if problem.evaluate(&whole_change, 1.0, &near).is_some_and(|at| at.violated(0.0).is_none()) {
        let mut moved = points.to_vec();
        moved[point].position = to;
        unknowns.shrink_radii(light.light(), &mut moved);
        let moved = light.light().clone().map_points(|index, point| *point = moved[index]);
        if let Ok(light) = CheckedLight::new(moved)
            && overlap.overlap(light.rays(), &work).is_none()
        {
            return Some(Slide { light, limit: None, distance_left: 0.0 });
        }
    }
    let distance_left = |light: &CheckedLight| light.light().points()[point].position.distance(to);
    let checked = |x: &[f64]| {
        let light = CheckedLight::new(unknowns.light(light.light(), x)).ok()?;
        overlap.overlap(light.rays(), &work).is_none().then_some(light)
    };
    // The point goes straight to the first limit, and then slides along it.
    let on_way = |share: f64| whole_change.map(|change| change * share).to_vec();
    let (mut valid, mut limited, mut first_limit) = (0.0, 1.0, DragLimit::Fold);
    for _ in 0..LIMIT_HALVINGS {
        let middle = f64::midpoint(valid, limited);
        let x = on_way(middle);
        let is_unfolded = problem.evaluate(&x, middle, &near).is_some_and(|at| at.violated(0.0).is_none());
        let overlaps = || problem.rays(&x).is_some_and(|rays| overlap.overlap(&rays, &work).is_some());
        if !is_unfolded {
            (limited, first_limit) = (middle, DragLimit::Fold);
        } else if overlaps() {
            (limited, first_limit) = (middle, DragLimit::Overlap);
        } else {
            valid = middle;
        }
    }
    let straight = checked(&on_way(valid)).unwrap_or_else(|| light.clone());
    let slid = (1..=PARTS).rev().find_map(|part| {
        let to = valid + (1.0 - valid) * f64::from(part) / f64::from(PARTS);
        let ChainEnd { x, limit, .. } = without_overlap(&mut problem, overlap, &on_way(valid), &near, [valid, to])?;
        let slid = checked(&x).filter(|slid| distance_left(slid) <= distance_left(&straight))?;
        Some((slid, limit))
    });
    let (light, limit) = slid.unwrap_or((straight, first_limit));
    let distance_left = distance_left(&light);
    Some(Slide { light, limit: Some(limit), distance_left })
}

/// Follows a part of the way. Where two parts of the tube meet on it becomes a further bound, since an overlap has no
/// slope. `None` if the chain does not reach the end.
fn without_overlap(
    problem: &mut Problem,
    overlap: OverlapRule,
    begin: &[f64],
    near: &Tracked,
    part: [f64; 2],
) -> Option<ChainEnd> {
    problem.tangents.clear();
    loop {
        let end = follow(problem, begin.to_vec(), near, part, &RULE).ok()?;
        let met = problem.first_overlap(overlap, &end.x).filter(|_| problem.tangents.len() < MAX_TANGENTS);
        let Some(met) = met else { return Some(end) };
        problem.tangents.push(LimitTangent::Overlap(met));
    }
}

/// Returns the length of the polyline through control points, in light-local units.
pub(crate) fn polyline_length(points: &[ControlPoint]) -> f64 {
    points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
}
