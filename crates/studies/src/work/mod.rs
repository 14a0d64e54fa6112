//! Measures the cost of drags: counted steps and seconds of drags of every size, and a search for the most expensive
//! one.

mod case;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;
use std::time::Instant;

use bench::drag::TrialScene;
use drag::{DragOutcome, DragResult, WorkBudget, drag, drag_budgeted};
use fastrand::Rng;
use light::parameters::{ROTATION, TRANSLATION};
use serde::Serialize;

pub use case::{CaseSizes, WorkCase, stages};

/// Share of a search's tries that are random drags. The others change one number of the most expensive drag so far.
const RANDOM: f64 = 0.75;

/// Cost of a drag.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DragCost {
    pub scene: String,
    /// Control points of the light, 0 if it has none.
    pub points: usize,
    /// Number of chosen control points; 0 moves the light as a whole.
    pub chosen: usize,
    pub pins: usize,
    /// Steps that the solver counted.
    pub steps: u64,
    /// Wall time.
    pub seconds: f64,
    pub status: String,
}

/// Measures a drag with a limit of `most` steps; `None` if the case gives no light in its scene.
fn measure(stages: &[TrialScene], case: &WorkCase, most: u64) -> Option<DragCost> {
    let stage = &stages[case.scene];
    let (light, requested) = case.in_scene(stage)?;
    let work = WorkBudget::with_limit(most, &|_| true);
    let began = Instant::now();
    let result = drag_budgeted(&stage.reference.bvh, &light, &requested, &[], &work);
    Some(DragCost {
        scene: stage.name.clone(),
        points: light.light().points().len(),
        chosen: requested.points.as_ref().map_or(0, Vec::len),
        pins: requested.pins.as_ref().map_or(0, Vec::len),
        steps: work.spent_steps(),
        seconds: began.elapsed().as_secs_f64(),
        status: format!("{:?}", result.outcome.status),
    })
}

/// Measures random drags. Calls `progress` for each.
pub fn random(stages: &[TrialScene], count: usize, seed: u64, most: u64, progress: impl Fn()) -> Vec<DragCost> {
    let mut rng = Rng::with_seed(seed);
    let cases = (0..count).filter_map(|_| {
        progress();
        measure(stages, &WorkCase::random(&mut rng, stages.len(), CaseSizes::ALL), most)
    });
    cases.collect()
}

/// Searches the most expensive drags in `tries` tries. Returns each drag that was more expensive than all before it.
pub fn search(stages: &[TrialScene], tries: usize, seed: u64, most: u64, progress: impl Fn()) -> Vec<DragCost> {
    let mut rng = Rng::with_seed(seed);
    let mut found: Vec<DragCost> = Vec::new();
    let mut best: Option<WorkCase> = None;
    for number in 0..tries {
        progress();
        let is_random = (number as f64) < RANDOM * tries as f64;
        let case = match &best {
            Some(best) if !is_random => best.with_one_change(&mut rng, stages.len(), CaseSizes::ALL),
            _ => WorkCase::random(&mut rng, stages.len(), CaseSizes::ALL),
        };
        let Some(made) = measure(stages, &case, most) else { continue };
        if found.last().is_none_or(|most| made.steps > most.steps) {
            best = Some(case);
            found.push(made);
        }
    }
    found
}

/// Returns the results of `count` random drags, one per line, exact to the last bit.
pub fn answers(stages: &[TrialScene], sizes: CaseSizes, count: usize, seed: u64) -> String {
    let mut rng = Rng::with_seed(seed);
    let mut text = String::new();
    let mut made = 0;
    while made < count {
        let case = WorkCase::random(&mut rng, stages.len(), sizes);
        let stage = &stages[case.scene];
        let Some((light, requested)) = case.in_scene(stage) else { continue };
        made += 1;
        let result = drag(&stage.reference.bvh, &light, &requested, &[]);
        writeln!(text, "{}", line(&result)).expect("writing to a string does not fail");
    }
    text
}

/// Returns the text of a result. Rust formats numbers so that different ones have different texts.
fn line(result: &DragResult) -> String {
    let DragResult { light, outcome, .. } = result;
    let DragOutcome {
        status,
        changed_share,
        residual_px,
        shadowed_by,
        iterations,
        from_world,
        to_world,
        pivot_world,
        ..
    } = outcome;
    let placement = (light.get(TRANSLATION), light.get(ROTATION));
    format!(
        "{status:?} {changed_share:?} {residual_px:?} {shadowed_by:?} {iterations} {from_world:?} {to_world:?} {pivot_world:?} {:?} {:?} {:?}",
        light.points(),
        placement.0,
        placement.1
    )
}
