//! As near to the cursor as limits let the light: where a feature cannot lie under it, and control points that are dragged
//! themselves.

use glam::DVec3;
use light::CheckedLight;

use crate::goal::{Asked, DIFFERENCE, Goal, Near};
use crate::matrix::length;
use crate::moves::Moves;
use crate::place::Placed;
use crate::quadratic::{Counting, Hold};
use crate::reach::{APART, PLACES};
use crate::request::{Limit, Radii};
use crate::step::{At, Solution, back, length_between, trace_of};
use crate::work::Work;

/// Halvings between the last place on a straight way that can be had and the wall.
const TO_THE_WALL: usize = 20;

/// Steps where nothing lands: on the way, and at its end until they are [`STILL`], so many at most.
const GLIDING: usize = 24;
const SETTLING: usize = 40;

/// A step this small is none, in the units of what moves.
const STILL: f64 = 1e-7;

/// The longest step.
const LONGEST: f64 = 0.03;

/// How softly the feature pulls there, as a share of the trace of `J J^T`: what helps little is not done.
const GIVE_WAY: f64 = 1e-2;

/// Quarterings of a step that makes nothing better.
const QUARTERINGS: usize = 4;

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Glided {
    /// The light, which can be evaluated.
    pub light: CheckedLight,
    /// What keeps the control point from where it was to go; `None` where it is there.
    pub limit: Option<Limit>,
    /// How far it is from there, in light-local units.
    pub short_by: f64,
}

/// `light` with a control point at `to` in light-local space, or as near to that as no fold lets it; with [`Radii::Follow`] radii
/// that would make the tube fold shrink, and nothing is in the way. It depends on the light and on `to` alone.
///
/// `None` where the light has no such control point, or it is the source; and for [`Radii::Solve`], since radii do nothing
/// for a position.
pub fn glide(light: &CheckedLight, point: usize, to: DVec3, radii: Radii) -> Option<Glided> {
    let points = light.light().points();
    if !(1..points.len()).contains(&point) || radii == Radii::Solve || !to.is_finite() {
        return None;
    }
    light.tube()?;
    let unit = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    let moves = Moves::Points { points: vec![point], radii, unit };
    let asked = Asked::Position { point, to };
    let work = Work::new(&|_| true);
    let placed = Placed::new(light.rays(), DVec3::ZERO, DVec3::ZERO, &work);
    let goal = Goal::new(asked, (light, moves), placed, Vec::new());
    let near = vec![[0.0; 2]];
    // Where nothing is in the way it is there, to the last bit.
    let all_of_it = ((to - points[point].position) / unit).to_array();
    let reaches = goal
        .evaluate(&all_of_it, 1.0, &near)
        .is_some_and(|at| at.bounds.iter().all(|bound| bound.value >= 0.0));
    if reaches {
        let mut moved = points.to_vec();
        moved[point].position = to;
        goal.moves.settle(light.light(), &mut moved);
        let moved = light.light().clone().with_points(|index, point| *point = moved[index]);
        if let Ok(light) = CheckedLight::new(moved) {
            return Some(Glided { light, limit: None, short_by: 0.0 });
        }
    }
    let found = solve_position(&goal, &near, &all_of_it)?;
    let moved = CheckedLight::new(goal.moves.light(light.light(), &found.at.x));
    // What the solver passes is no fold, and so can be evaluated; the light as it was can be in any case.
    let light = moved.unwrap_or_else(|_| light.clone());
    let short_by = light.light().points()[point].position.distance(to);
    Some(Glided { light, limit: Some(found.held_by.unwrap_or(Limit::NoDescent)), short_by })
}

/// Straight to where the control point first meets a limit, which of each share of the way is one place to look at, and on along that.
fn solve_position(goal: &Goal, near: &Near, way: &[f64]) -> Option<Solution> {
    let mut found = Solution::begin(goal, near)?;
    let at = |share: f64| {
        let x: Vec<f64> = way.iter().map(|way| way * share).collect();
        let at = At { evaluation: goal.evaluate(&x, share, near)?, x };
        at.is_there().then_some(at)
    };
    let places = goal.places(APART, PLACES);
    let mut share = 0.0;
    let mut step = 1.0 / places;
    for _ in 0..places as usize + TO_THE_WALL {
        match at(share + step).filter(|_| share + step <= 1.0) {
            Some(next) => (found.at, share) = (next, share + step),
            None => step *= 0.5,
        }
    }
    found.glide(goal, share);
    Some(found)
}

/// What is least where a light glides to.
struct Cost<'a> {
    /// Where it could go no further with the feature where it should be.
    wall: &'a [f64],
    /// What a change from there costs beside what is off.
    give: f64,
}

impl Cost<'_> {
    /// How far the feature stays off, squared, and what the light's change and all that is soft cost beside that.
    fn of(&self, at: &At) -> f64 {
        let rows = at.evaluation.residual.iter().zip(at.evaluation.rows.iter());
        let of_rows = rows.map(|(off, row)| if let Hold::Soft(give) = row { off * off / give } else { 0.0 });
        let springs = at.evaluation.bounds.iter().filter(|bound| bound.give > 0.0);
        let of_springs = springs.map(|bound| {
            let broken = bound.value.min(0.0);
            broken * broken / bound.give
        });
        let soft: f64 = of_rows.chain(of_springs).sum();
        let (off, gone) = (at.off(), length_between(&at.x, self.wall));
        off * off + self.give * (gone * gone + soft)
    }
}

impl Solution {
    /// Goes on where nothing more has the feature where it should be, to where it is off the least: weighed against how far the light
    /// goes for that, so that it neither jumps nor runs away for little. Where the feature should be need not be in the light there.
    pub fn glide(&mut self, to_land: &Goal, from: f64) {
        let wall = self.at.x.clone();
        let Some(evaluation) = to_land.evaluate(&wall, from, &self.at.evaluation.near) else { return };
        let pull = trace_of(&to_land.linear(&wall, from, &evaluation, DIFFERENCE));
        let cost = Cost { wall: &wall, give: GIVE_WAY * pull };
        let goal = to_land.gliding(cost.give);
        for step in 1..=GLIDING {
            let share = from + (1.0 - from) * step as f64 / GLIDING as f64;
            self.nearer(&goal, share, &cost, LONGEST);
        }
        let mut longest = LONGEST;
        for _ in 0..SETTLING {
            match self.nearer(&goal, 1.0, &cost, longest) {
                Some(moved) if moved > STILL => longest = (2.0 * moved).min(LONGEST),
                _ => break,
            }
        }
        if let (Asked::Feature(_), Some(at)) = (&to_land.asked, self.reach(to_land, 1.0, Counting::Firm)) {
            self.at = at;
        }
    }

    /// A step that costs less, or back to where limits hold, and how long it is; `None` where there is none.
    fn nearer(&mut self, goal: &Goal, share: f64, cost: &Cost, longest: f64) -> Option<f64> {
        self.iterations += 1;
        self.at.evaluation = goal.evaluate(&self.at.x, share, &self.at.evaluation.near)?;
        let at = self.at.clone();
        let linear = goal.linear(&at.x, share, &at.evaluation, DIFFERENCE);
        let x = self.wanted(goal, cost.wall, &at, &linear, (cost.give, Counting::All));
        let way: Vec<f64> = x.iter().zip(&at.x).map(|(wanted, x)| wanted - x).collect();
        let (before, was_allowed) = (cost.of(&at), at.is_allowed());
        let mut factor = (longest / length(&way)).min(1.0);
        for _ in 0..QUARTERINGS {
            let x: Vec<f64> = at.x.iter().zip(&way).map(|(x, way)| x + factor * way).collect();
            let next = goal.evaluate(&x, share, &at.evaluation.near).map(|evaluation| At { x, evaluation });
            if let Some(next) = next {
                let next = back(goal, share, &linear, &next, Counting::Fixed).unwrap_or(next);
                if next.is_allowed() && (cost.of(&next) < before || !was_allowed) {
                    let moved = length_between(&next.x, &at.x);
                    self.at = next;
                    return Some(moved);
                }
            }
            factor *= 0.25;
        }
        None
    }
}
