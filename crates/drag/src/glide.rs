//! Control points that are dragged themselves: as near to the cursor as the tube may follow.

use glam::DVec3;
use light::CheckedLight;

use crate::goal::{Asked, Goal};
use crate::moves::Moves;
use crate::place::Placed;
use crate::request::{Limit, Radii};
use crate::solve::solve_position;

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
    let placed = Placed::new(light.rays(), DVec3::ZERO, DVec3::ZERO);
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
