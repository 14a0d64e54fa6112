//! Compares the random drags that converge with the product's solver and those that converge with a slow solver with
//! restarts.

pub(crate) mod pins;
mod relaxed;
mod report;
mod slow;
#[cfg(test)]
mod tests;

use std::time::Instant;

use bench::drag::{EquationError, Trial, TrialKind, TrialScene, distance_px};
use drag::{Drag, DragResult, DragStatus, Feature, PinKind, drag};
use glam::DVec3;
use light::CheckedLight;
use rayon::prelude::*;
use reference::ReferenceLight;
use serde_json::{Value, json};

pub use report::{DragStudyReport, ReportCell, StudyOutcome};

use pins::StudyPin;
use slow::FoundLight;

/// Options of the study of drags.
#[derive(Clone, Copy, Debug)]
pub struct DragStudyOptions {
    /// Drags of each kind.
    pub drags: usize,
    /// Seed of the random drags.
    pub seed: u64,
    /// Pins of each drag.
    pub pins: usize,
}

/// Drag that did not converge although a solution exists, or whose result is reported as converged and is not.
#[derive(Clone, Debug)]
pub struct DragFailure {
    /// Name for a file: scene, kind and number.
    pub name: String,
    /// JSON of a light file.
    pub light: String,
    /// JSON of a drag file with the one drag.
    pub drags: Value,
    /// Result of the product, and a light with the feature under the cursor if one is known.
    pub found: Value,
}

/// Drag with the result of the product's solver.
struct StudiedDrag {
    number: usize,
    trial: Trial,
    pins: Vec<StudyPin>,
    result: DragResult,
    ms: f64,
}

/// Makes random drags in one scene and judges them. Calls `progress` for each.
pub fn run(
    stage: &TrialScene,
    options: DragStudyOptions,
    progress: impl Fn() + Sync,
) -> (Vec<StudyOutcome>, Vec<DragFailure>) {
    let mut outcomes = Vec::new();
    let mut failures = Vec::new();
    for kind in TrialKind::all() {
        let seed = |number: usize| Trial::seed(options.seed, &file_name_of(&stage.name), kind, number);
        let trials: Vec<_> = (0..options.drags)
            .into_par_iter()
            .filter_map(|number| {
                progress();
                let mut trial = Trial::random(stage, kind, seed(number))?;
                let pins = pins::random_pins(stage, &trial, options.pins, seed(number))?;
                trial.drag.pins = pins.iter().map(|pinned| pinned.pin.clone()).collect();
                Some((number, trial, pins))
            })
            .collect();
        // One after the other, since they are timed.
        let made = trials.into_iter().map(|(number, trial, pins)| {
            let began = Instant::now();
            let result = drag(&stage.reference.bvh, &stage.view, &trial.light, &trial.drag);
            StudiedDrag { number, trial, pins, result, ms: began.elapsed().as_secs_f64() * 1e3 }
        });
        let made: Vec<_> = made.collect();
        let judged: Vec<_> = made.par_iter().map(|made| judge_drag(stage, made, seed(made.number))).collect();
        for (outcome, failure) in judged {
            outcomes.push(outcome);
            failures.extend(failure);
        }
    }
    (outcomes, failures)
}

/// Judges the product's result by independent measures and by the slow solver.
fn judge_drag(stage: &TrialScene, made: &StudiedDrag, seed: u64) -> (StudyOutcome, Option<DragFailure>) {
    let StudiedDrag { trial, pins, result, .. } = made;
    let (kind, is_landed) = (trial.kind, result.status == DragStatus::Landed);
    let light = CheckedLight::new(result.light.clone()).ok();
    let off = light.as_ref().and_then(|light| EquationError::at_target(stage, trial, light));
    let px = light.as_ref().filter(|_| is_landed).and_then(|light| distance_px(stage, trial, light));
    // The error of a highlight is the distance to its visible center, even if directions change quickly over the
    // surface there.
    let is_near = px.is_some_and(|px| px < 0.5) && kind.feature == Feature::Highlight;
    let is_wrong = is_landed && !is_near && !off.is_some_and(|off| off.is_landed(kind.feature));
    let found = slow::feasible(stage, trial, pins, seed);
    let is_broken =
        |pinned: &&StudyPin| pinned.pin.is_hard && !light.as_ref().is_some_and(|light| pinned.holds(stage, light));
    let broken = pins.iter().filter(is_broken).count();
    let is_infeasible = !is_landed && found.is_none() && !pins.is_empty() && {
        let free = Drag { pins: Vec::new(), ..trial.drag.clone() };
        drag(&stage.reference.bvh, &stage.view, &trial.light, &free).status == DragStatus::Landed
    };
    let outcome = StudyOutcome {
        kind,
        status: result.status,
        iterations: result.iterations,
        ms: made.ms,
        equation_error: off.map(|off| off.px_or_degrees),
        px,
        is_wrong,
        is_feasible: found.is_some(),
        is_infeasible,
        broken,
    };
    let is_failure = is_wrong || broken > 0 || is_infeasible || (found.is_some() && !is_landed);
    (outcome, is_failure.then(|| failure(stage, made, light.as_ref(), found.as_ref(), broken)))
}

fn failure(
    stage: &TrialScene,
    StudiedDrag { number, trial, result, .. }: &StudiedDrag,
    light: Option<&CheckedLight>,
    found: Option<&FoundLight>,
    broken: usize,
) -> DragFailure {
    let kind = trial.kind;
    let names = [kind.feature_name(), kind.points_name(), kind.distance_name()].join("-");
    let folds = |light: &CheckedLight| light.tube().map(light::Tube::r_kappa_max);
    DragFailure {
        name: format!("{}-{names}-{number}", file_name_of(&stage.name)),
        light: protocol::light_file::to_json(trial.light.light()),
        drags: drag_json(stage, trial),
        found: json!({
            "scene": stage.name,
            "status": format!("{:?}", result.status),
            "residual_px": result.residual_px,
            "iterations": result.iterations,
            "broken_pins": broken,
            "begin_r_kappa": folds(&trial.light),
            "after": light.map(|light| at_the_cursor(stage, trial, light)),
            "after_r_kappa": light.and_then(folds),
            "found_by_restart": found.map(|found| found.restart),
            "feasible": found.map(|found| protocol::Light::from(found.light.light())),
            "feasible_r_kappa": found.and_then(|found| folds(&found.light)),
        }),
    }
}

/// Returns the tube coordinates of M' and of a shadow's pivot in a light, and the visibility at M' by the reference.
fn at_the_cursor(stage: &TrialScene, trial: &Trial, light: &CheckedLight) -> Value {
    let place = |position: DVec3| stage.locate(light, position).map(|place| [place.t, place.v, place.w]);
    let to = stage.surface(trial.drag.to);
    let visible =
        to.and_then(|to| stage.reference.sample(&ReferenceLight::new(light), &to)).map(|sample| sample.is_visible);
    json!({
        "to_tvw": to.and_then(|to| place(to.position)),
        "pivot_tvw": trial.pivot_in_scene.and_then(place),
        "visible": visible,
    })
}

/// Returns the JSON of the drag for `bendylights drag`.
fn drag_json(stage: &TrialScene, trial: &Trial) -> Value {
    json!([{
        "light": 0,
        "kind": trial.kind.feature_name(),
        "points": trial.drag.points,
        "size": stage.view.size,
        "from": trial.drag.from.to_array(),
        "to": trial.drag.to.to_array(),
        "pins": trial.drag.pins.iter().map(pin).collect::<Vec<_>>(),
    }])
}

fn pin(pin: &drag::DragPin) -> Value {
    let kind = match pin.kind {
        PinKind::Direction => "direction",
        PinKind::Lit => "lit",
        PinKind::Shadowed => "shadowed",
        PinKind::Shadow => "shadow",
    };
    json!({ "kind": kind, "light": 0, "at": pin.at.to_array(), "hard": pin.is_hard })
}

/// Makes a scene's name usable as a file name.
pub fn file_name_of(scene: &str) -> String {
    let name = std::path::Path::new(scene).file_stem().map_or(scene.into(), |stem| stem.to_string_lossy());
    name.replace(':', "-")
}
