//! Straight to where the feature should be, from several lights: for drags whose way there is closed.

use crate::goal::{DIFFERENCE, Goal, TrackedPoints};
use crate::matrix::length;
use crate::moves::Unknowns;
use crate::pins::PinState;
use crate::quadratic::{RowSelection, Values, smallest_step};
use crate::request::RadiusMode;
use crate::scene_visibility::SceneVisibility;
use crate::solve::solve;
use crate::start::rigid_start;
use crate::step::{Iterate, Solution, objective_trace};

/// Lights that are started from beside the one that the drag began with, and how far they are from it, in the units of what moves.
const RESTART_DISTANCES: [f64; 6] = [0.03, 0.1, 0.2, 0.4, 0.1, 0.3];

/// Steps from each, the longest, and by which share what is off has to become less in how many.
const MAX_NEWTON_STEPS: usize = 32;
const MAX_STEP: f64 = 0.2;
const REQUIRED_REDUCTION: f64 = 0.5;
const REDUCTION_STEPS: usize = 6;

/// Halvings of a step that makes nothing better.
const HALVINGS: usize = 5;

/// Rounds in which edges turn up that what is pinned crosses.
const MAX_TANGENT_ROUNDS: usize = 4;

/// Lights with the feature where it should be and all that has to hold, as they are found, and the steps that it took.
///
/// First by the way that is found when soft pins do not count; then from the light that the drag began with, from those that
/// are `known` with the feature there or near to it, and from some beside.
pub(crate) fn other_solutions<'a>(
    goal: &'a Goal,
    near: &'a TrackedPoints,
    sight: &'a SceneVisibility,
    known: [&'a [f64]; 2],
) -> impl Iterator<Item = Solution> + 'a {
    // Where nothing can be said of soft pins in that light they do not count.
    let firmly = move || {
        let has_soft = goal.pins.iter().any(|pin| !pin.is_hard);
        let found = if has_soft { solve_with_pins(goal, near, sight, |pin| pin.is_hard) } else { None };
        let softly = found.as_ref().and_then(|found| solve_from(goal, near, sight, found.iterate.x.clone()));
        softly.into_iter().chain(found)
    };
    let unmoved = vec![0.0; goal.unknowns.count()];
    let placed = rigid_start(goal, near).map(|(x, _)| x);
    let known = known.into_iter().map(<[f64]>::to_vec);
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let away = RESTART_DISTANCES.iter().map(move |size| {
        (0..goal.unknowns.count())
            .map(|k| size * random.next() * goal.unknowns.random_scale(k))
            .collect::<Vec<f64>>()
    });
    let starts = std::iter::once(unmoved).chain(placed).chain(known).chain(away);
    std::iter::once_with(firmly).flatten().chain(starts.filter_map(move |x| solve_from(goal, near, sight, x)))
}

/// What is found with some of the pins alone.
pub(crate) fn solve_with_pins(
    goal: &Goal,
    near: &TrackedPoints,
    sight: &SceneVisibility,
    is_kept: fn(&PinState) -> bool,
) -> Option<Solution> {
    let (mut goal, near) = goal.with_pins(near, is_kept);
    solve(&mut goal, &near, sight)
}

/// The light that is found from one.
fn solve_from(goal: &Goal, near: &TrackedPoints, sight: &SceneVisibility, x: Vec<f64>) -> Option<Solution> {
    let mut goal = goal.clone();
    goal.tangents.clear();
    let near = goal.tracked_at_end(&x, near);
    let evaluation = goal.evaluate(&x, 1.0, &near)?;
    let mut found = Solution { iterate: Iterate { x, evaluation }, strongest_limit: None, iterations: 0 };
    for _ in 0..MAX_TANGENT_ROUNDS {
        found.descend(&goal)?;
        found.shrink(&goal);
        let cuts = sight.violated_tangents(&goal, &found.iterate.x, false);
        if cuts.is_empty() {
            return sight.violated_limit(&goal, &found.iterate.x).is_none().then_some(found);
        }
        goal.tangents.extend(cuts);
        found.iterate.evaluation = goal.evaluate(&found.iterate.x, 1.0, &found.iterate.evaluation.tracked)?;
    }
    None
}

impl Solution {
    /// Newton's method with steps that make what is off less; `None` where that leads nowhere.
    fn descend(&mut self, goal: &Goal) -> Option<()> {
        let nowhere = vec![0.0; self.iterate.x.len()];
        let mut before = Vec::new();
        for _ in 0..MAX_NEWTON_STEPS {
            if self.iterate.is_converged() {
                return Some(());
            }
            let off = self.iterate.merit();
            if before.len() >= REDUCTION_STEPS
                && off > REQUIRED_REDUCTION * before[before.len() - REDUCTION_STEPS]
            {
                return None;
            }
            before.push(off);
            self.iterations += 1;
            let linear = goal.linearize(&self.iterate.x, 1.0, &self.iterate.evaluation, DIFFERENCE);
            let limits: Vec<f64> =
                self.iterate.evaluation.bounds.iter().map(|bound| bound.value - 1e-12).collect();
            let residual = &self.iterate.evaluation.residual;
            let values = Values { residual, limits: &limits, counting: RowSelection::Firm };
            let (step, _) = smallest_step(&nowhere, &linear, values, 1e-15 * objective_trace(&linear));
            let mut factor = (MAX_STEP / length(&step)).min(1.0);
            let better = (0..HALVINGS).find_map(|_| {
                let x: Vec<f64> =
                    self.iterate.x.iter().zip(&step).map(|(x, step)| x + factor * step).collect();
                factor *= 0.5;
                let evaluation = goal.evaluate(&x, 1.0, &self.iterate.evaluation.tracked)?;
                let at = Iterate { x, evaluation };
                (at.merit() < off || at.is_converged()).then_some(at)
            });
            self.iterate = better?;
        }
        self.iterate.is_converged().then_some(())
    }
}

impl Unknowns {
    /// How far an unknown goes where a light is changed at random: turns farther than ways, radii less.
    fn random_scale(&self, unknown: usize) -> f64 {
        match self {
            Self::Rigid { .. } if unknown >= 3 => 2.0,
            Self::Points { points, radii: RadiusMode::Solve, .. } if unknown >= 3 * points.len() => 0.1,
            _ => 1.0,
        }
    }
}

/// A linear congruential generator (Knuth's MMIX), the same numbers for each drag.
struct Random(u64);

impl Random {
    /// Between -1 and 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
