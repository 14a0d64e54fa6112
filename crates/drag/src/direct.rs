//! Newton's method at the cursor, from several starting lights: for drags whose path to the cursor is closed.

use crate::goal::{DIFFERENCE, Goal, TrackedPoints};
use crate::matrix::{length, scaled_sum};
use crate::moves::Unknowns;
use crate::pins::PinState;
use crate::quadratic::{RowSelection, smallest_step};
use crate::request::RadiusMode;
use crate::scene_visibility::SceneVisibility;
use crate::solve::solve;
use crate::start::rigid_start;
use crate::step::{Iterate, Solution, objective_trace};

/// Distances of the random starting lights from the light at the start of the drag, in units of the unknowns.
const RESTART_DISTANCES: [f64; 6] = [0.03, 0.1, 0.2, 0.4, 0.1, 0.3];

/// Most Newton steps from each starting light. The next constants are the longest step, and the factor by which the
/// squared error must shrink within a number of steps.
const MAX_NEWTON_STEPS: usize = 32;
const MAX_STEP: f64 = 0.2;
const REQUIRED_REDUCTION: f64 = 0.5;
const REDUCTION_STEPS: usize = 6;

/// Most times that a step is halved because it does not reduce the error.
const HALVINGS: usize = 5;

/// Most rounds that add tangents of shadow edges and surfaces that the found light has crossed.
const MAX_TANGENT_ROUNDS: usize = 4;

/// Searches for lights that have the feature under the cursor and keep all limits and hard pins, and yields each with
/// its iteration count.
///
/// The first start is the solution of the path without soft pins. Then follow the light at the start of the drag, the
/// rigid placement in closed form, the `known` lights with the feature under the cursor or near it, and random lights
/// around the first.
pub(crate) fn other_solutions<'a>(
    goal: &'a Goal,
    near: &'a TrackedPoints,
    visibility: &'a SceneVisibility,
    known: [&'a [f64]; 2],
) -> impl Iterator<Item = Solution> + 'a {
    // If the search with soft pins fails from that light, the light itself counts, without soft pins.
    let firmly = move || {
        let has_soft = goal.pins.iter().any(|pin| !pin.is_hard);
        let found = has_soft.then(|| solve_with_pins(goal, near, visibility, |pin| pin.is_hard)).flatten();
        let softly = found.as_ref().and_then(|found| solve_from(goal, near, visibility, found.iterate.x.clone()));
        softly.into_iter().chain(found)
    };
    let unmoved = vec![0.0; goal.unknowns.count()];
    let placed = rigid_start(goal, near).map(|(x, _)| x);
    let known = known.into_iter().map(<[f64]>::to_vec);
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let away = RESTART_DISTANCES.iter().map(move |size| {
        (0..goal.unknowns.count()).map(|k| size * random.next() * goal.unknowns.random_scale(k)).collect::<Vec<f64>>()
    });
    let starts = std::iter::once(unmoved).chain(placed).chain(known).chain(away);
    std::iter::once_with(firmly).flatten().chain(starts.filter_map(move |x| solve_from(goal, near, visibility, x)))
}

/// Solves the drag with only those pins for which `is_kept` is true.
pub(crate) fn solve_with_pins(
    goal: &Goal,
    near: &TrackedPoints,
    visibility: &SceneVisibility,
    is_kept: fn(&PinState) -> bool,
) -> Option<Solution> {
    let (mut goal, near) = goal.with_pins(near, is_kept);
    solve(&mut goal, &near, visibility)
}

/// Solves the drag by Newton's method, starting from the light that the unknowns `x` give. `None` if that does not
/// converge, or if the result violates a limit or pin.
fn solve_from(goal: &Goal, near: &TrackedPoints, visibility: &SceneVisibility, x: Vec<f64>) -> Option<Solution> {
    let mut goal = goal.clone();
    goal.tangents.clear();
    let near = goal.tracked_at_end(&x, near);
    let iterate = Iterate::new(&goal, x, 1.0, &near)?;
    let mut found = Solution { iterate, strongest_limit: None, iterations: 0 };
    for _ in 0..MAX_TANGENT_ROUNDS {
        found.descend(&goal)?;
        found.shrink(&goal);
        let tangents = visibility.violated_tangents(&goal, &found.iterate.x, false);
        if tangents.is_empty() {
            return visibility.violated_limit(&goal, &found.iterate.x).is_none().then_some(found);
        }
        goal.tangents.extend(tangents);
        found.iterate = found.iterate.at_share(&goal, 1.0)?;
    }
    None
}

impl Solution {
    /// Takes Newton steps that reduce the error. `None` if they do not converge.
    fn descend(&mut self, goal: &Goal) -> Option<()> {
        let unmoved = vec![0.0; self.iterate.x.len()];
        let mut merits = Vec::new();
        for _ in 0..MAX_NEWTON_STEPS {
            if self.iterate.is_converged() {
                return Some(());
            }
            let merit = self.iterate.merit();
            if merits.len() >= REDUCTION_STEPS && merit > REQUIRED_REDUCTION * merits[merits.len() - REDUCTION_STEPS] {
                return None;
            }
            merits.push(merit);
            self.iterations += 1;
            let linear = goal.linearize(&self.iterate.x, 1.0, &self.iterate.evaluation, DIFFERENCE);
            let values = self.iterate.evaluation.values(RowSelection::Firm);
            let (step, _) = smallest_step(&unmoved, &linear, values, 1e-15 * objective_trace(&linear));
            let mut factor = (MAX_STEP / length(&step)).min(1.0);
            let better = (0..HALVINGS).find_map(|_| {
                let x = scaled_sum(&self.iterate.x, &step, factor);
                factor *= 0.5;
                self.iterate.moved_to(goal, x, 1.0).filter(|at| at.merit() < merit || at.is_converged())
            });
            self.iterate = better?;
        }
        self.iterate.is_converged().then_some(())
    }
}

impl Unknowns {
    /// Returns the size of a random change of an unknown. Rotations vary more than translations, radii less.
    fn random_scale(&self, unknown: usize) -> f64 {
        match self {
            Self::Rigid { .. } if unknown >= 3 => 2.0,
            Self::Points { points, radii: RadiusMode::Solve, .. } if unknown >= 3 * points.len() => 0.1,
            _ => 1.0,
        }
    }
}

/// Linear congruential generator (Knuth's MMIX) with one fixed sequence for all drags.
struct Random(u64);

impl Random {
    /// Returns the next number between -1 and 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
