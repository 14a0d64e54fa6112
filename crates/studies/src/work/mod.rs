//! What do drags cost? Counted steps and seconds of drags of every size, and a search for the most expensive one.

mod case;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;
use std::time::Instant;

use bench::drag::TrialScene;
use drag::{DragResult, WorkBudget, drag, drag_budgeted};
use fastrand::Rng;
use light::parameters::{ROTATION, TRANSLATION};
use serde::Serialize;

pub use case::{CaseSizes, WorkCase, stages};

/// The share of a search's tries that are random; the others are neighbours of the most expensive one.
const RANDOM: f64 = 0.75;

/// A drag, and what it took.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DragCost {
    /// Where.
    pub scene: String,
    /// Control points of the light, 0 where it has none.
    pub points: usize,
    /// How many of them are chosen; 0 moves the light as a whole.
    pub chosen: usize,
    /// Pins that are asked for.
    pub pins: usize,
    /// Counted.
    pub steps: u64,
    /// On a clock.
    pub seconds: f64,
    /// How it ended.
    pub status: String,
}

/// What a drag takes within a bound of steps; `None` where its light has none of the feature.
fn measure(stages: &[TrialScene], case: &WorkCase, most: u64) -> Option<DragCost> {
    let stage = &stages[case.scene];
    let (light, asked) = case.in_scene(stage)?;
    let work = WorkBudget::with_limit(most, &|_| true);
    let began = Instant::now();
    let landing = drag_budgeted(&stage.reference.bvh, &stage.view, &light, &asked, &work);
    Some(DragCost {
        scene: stage.name.clone(),
        points: light.light().points().len(),
        chosen: asked.points.as_ref().map_or(0, Vec::len),
        pins: asked.pins.len(),
        steps: work.spent_steps(),
        seconds: began.elapsed().as_secs_f64(),
        status: format!("{:?}", landing.status),
    })
}

/// Random drags; `progress` is called for each.
pub fn random(
    stages: &[TrialScene],
    count: usize,
    (seed, most): (u64, u64),
    progress: impl Fn(),
) -> Vec<DragCost> {
    let mut rng = Rng::with_seed(seed);
    let cases = (0..count).filter_map(|_| {
        progress();
        measure(stages, &WorkCase::random(&mut rng, stages.len(), CaseSizes::ALL), most)
    });
    cases.collect()
}

/// The most expensive drags that are found in so many tries, each more expensive than those before.
pub fn search(
    stages: &[TrialScene],
    tries: usize,
    (seed, most): (u64, u64),
    progress: impl Fn(),
) -> Vec<DragCost> {
    let mut rng = Rng::with_seed(seed);
    let mut found: Vec<DragCost> = Vec::new();
    let mut best: Option<WorkCase> = None;
    for number in 0..tries {
        progress();
        let is_random = (number as f64) < RANDOM * tries as f64;
        let case = match &best {
            Some(best) if !is_random => best.neighbour(&mut rng, stages.len(), CaseSizes::ALL),
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

/// What comes of `count` random drags, a line each, to the last bit.
pub fn answers(stages: &[TrialScene], sizes: CaseSizes, count: usize, seed: u64) -> String {
    let mut rng = Rng::with_seed(seed);
    let mut text = String::new();
    let mut made = 0;
    while made < count {
        let case = WorkCase::random(&mut rng, stages.len(), sizes);
        let stage = &stages[case.scene];
        let Some((light, asked)) = case.in_scene(stage) else { continue };
        made += 1;
        let landing = drag(&stage.reference.bvh, &stage.view, &light, &asked);
        writeln!(text, "{}", line(&landing)).expect("writing to a string does not fail");
    }
    text
}

/// All of an answer: Rust writes numbers so that no two have the same text.
fn line(landing: &DragResult) -> String {
    let DragResult { status, light, residual_px, shadowed_by, iterations, from_world, to_world, pivot_world } =
        landing;
    let placement = (light.get(TRANSLATION), light.get(ROTATION));
    format!(
        "{status:?} {residual_px:?} {shadowed_by:?} {iterations} {from_world:?} {to_world:?} {pivot_world:?} {:?} {:?} {:?}",
        light.points(),
        placement.0,
        placement.1
    )
}
