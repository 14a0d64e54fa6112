//! Do drags land? Of random drags, those that the product lands beside those that a slow solver with restarts does.

mod pins;
mod relaxed;
mod report;
mod slow;
#[cfg(test)]
mod tests;

use std::time::Instant;

use bench::drag::{Kind, Off, Stage, Trial, distance_px};
use drag::{Drag, Feature, Landing, PinKind, Status, drag};
use glam::DVec3;
use light::CheckedLight;
use rayon::prelude::*;
use reference::Source;
use serde_json::{Value, json};

pub use report::{Cell, Outcome, Report};

use pins::Pinned;

/// What to try.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Drags of each kind.
    pub drags: usize,
    /// Another number, other drags.
    pub seed: u64,
    /// Pins of each drag.
    pub pins: usize,
}

/// A drag that did not land though it could, or that says that it landed and did not.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Of scene, kind and number: a name for a file.
    pub name: String,
    /// A light file.
    pub light: String,
    /// A drag file with the one drag.
    pub drags: Value,
    /// What the product says, and a light that lands, as far as one is known.
    pub found: Value,
}

/// A drag that the product has made.
struct Made {
    number: usize,
    trial: Trial,
    pins: Vec<Pinned>,
    landing: Landing,
    ms: f64,
}

/// Drags in one scene, and `progress` for each.
pub fn run(stage: &Stage, options: Options, progress: impl Fn() + Sync) -> (Vec<Outcome>, Vec<Failure>) {
    let mut outcomes = Vec::new();
    let mut failures = Vec::new();
    for kind in Kind::all() {
        let seed = |number: usize| Trial::seed(options.seed, &short(&stage.name), kind, number);
        let trials: Vec<_> = (0..options.drags)
            .into_par_iter()
            .filter_map(|number| {
                progress();
                let mut trial = Trial::random(stage, kind, seed(number))?;
                let pins = pins::draw(stage, &trial, options.pins, seed(number))?;
                trial.drag.pins = pins.iter().map(|pinned| pinned.pin.clone()).collect();
                Some((number, trial, pins))
            })
            .collect();
        // One after the other, since they are timed.
        let made = trials.into_iter().map(|(number, trial, pins)| {
            let began = Instant::now();
            let landing = drag(&stage.reference.bvh, &stage.view, &trial.light, &trial.drag);
            Made { number, trial, pins, landing, ms: began.elapsed().as_secs_f64() * 1e3 }
        });
        let made: Vec<_> = made.collect();
        let judged: Vec<_> = made.par_iter().map(|made| judged(stage, made, seed(made.number))).collect();
        for (outcome, failure) in judged {
            outcomes.push(outcome);
            failures.extend(failure);
        }
    }
    (outcomes, failures)
}

/// Holds what the product says to the independent way and to the slow solver.
fn judged(stage: &Stage, made: &Made, seed: u64) -> (Outcome, Option<Failure>) {
    let Made { trial, pins, landing, .. } = made;
    let (kind, is_landed) = (trial.kind, landing.status == Status::Landed);
    let light = CheckedLight::new(landing.light.clone()).ok();
    let off = light.as_ref().and_then(|light| Off::of(stage, trial, light));
    let px = light.as_ref().filter(|_| is_landed).and_then(|light| distance_px(stage, trial, light));
    // A highlight lies where its centre is seen, however fast directions change over the surface there.
    let is_near = px.is_some_and(|px| px < 0.5) && kind.feature == Feature::Highlight;
    let is_wrong = is_landed && !is_near && !off.is_some_and(|off| off.is_landed(kind.feature));
    let found = slow::feasible(stage, trial, pins, seed);
    let is_broken = |pinned: &&Pinned| {
        pinned.pin.is_hard && !light.as_ref().is_some_and(|light| pinned.holds(stage, light))
    };
    let broken = pins.iter().filter(is_broken).count();
    let is_infeasible = !is_landed && found.is_none() && !pins.is_empty() && {
        let free = Drag { pins: Vec::new(), ..trial.drag.clone() };
        drag(&stage.reference.bvh, &stage.view, &trial.light, &free).status == Status::Landed
    };
    let outcome = Outcome {
        kind,
        status: landing.status,
        iterations: landing.iterations,
        ms: made.ms,
        off: off.map(|off| off.share),
        px,
        is_wrong,
        is_feasible: found.is_some(),
        is_infeasible,
        broken,
    };
    let is_failure = is_wrong || broken > 0 || is_infeasible || (found.is_some() && !is_landed);
    (outcome, is_failure.then(|| failure(stage, made, light.as_ref(), (found.as_ref(), broken))))
}

fn failure(
    stage: &Stage,
    Made { number, trial, landing, .. }: &Made,
    light: Option<&CheckedLight>,
    (found, broken): (Option<&(usize, CheckedLight)>, usize),
) -> Failure {
    let kind = trial.kind;
    let names = [kind.feature_name(), kind.points_name(), kind.way_name()].join("-");
    let folds = |light: &CheckedLight| light.tube().map(light::Tube::r_kappa_max);
    Failure {
        name: format!("{}-{names}-{number}", short(&stage.name)),
        light: protocol::light_file::to_json(trial.light.light()),
        drags: contract(stage, trial),
        found: json!({
            "scene": stage.name,
            "status": format!("{:?}", landing.status),
            "residual_px": landing.residual_px,
            "iterations": landing.iterations,
            "broken_pins": broken,
            "begin_r_kappa": folds(&trial.light),
            "after": light.map(|light| at_the_cursor(stage, trial, light)),
            "after_r_kappa": light.and_then(folds),
            "found_by_restart": found.map(|(restart, _)| restart),
            "feasible": found.map(|(_, light)| protocol::Light::from(light.light())),
            "feasible_r_kappa": found.and_then(|(_, light)| folds(light)),
        }),
    }
}

/// Where M' and a shadow's pivot lie in a light, and whether the reference sees light at M'.
fn at_the_cursor(stage: &Stage, trial: &Trial, light: &CheckedLight) -> Value {
    let place = |position: DVec3| stage.locate(light, position).map(|place| [place.t, place.v, place.w]);
    let to = stage.surface(trial.drag.to);
    let visible =
        to.and_then(|to| stage.reference.sample(&Source::new(light), &to)).map(|sample| sample.visible);
    json!({
        "to_tvw": to.and_then(|to| place(to.position)),
        "pivot_tvw": trial.pivot.and_then(place),
        "visible": visible,
    })
}

/// The drag as `bendylights drag` reads it.
fn contract(stage: &Stage, trial: &Trial) -> Value {
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

fn pin(pin: &drag::Pin) -> Value {
    let kind = match pin.kind {
        PinKind::Direction => "direction",
        PinKind::Lit => "lit",
        PinKind::Shadowed => "shadowed",
        PinKind::Shadow => "shadow",
    };
    json!({ "kind": kind, "light": 0, "at": pin.at.to_array(), "hard": pin.is_hard })
}

/// The scene's name without what a file name cannot have.
pub fn short(scene: &str) -> String {
    let name = std::path::Path::new(scene).file_stem().map_or(scene.into(), |stem| stem.to_string_lossy());
    name.replace(':', "-")
}
