//! Makes random drags, with the product and with the paper's formulas, and measures both.

use std::time::Instant;

use drag::{drag, drag_least_change};
use light::{CheckedLight, Light};
use serde::Serialize;

use super::off::{EquationError, distance_px};
use super::paper;
use super::picture::{PictureChange, PictureGrid};
use super::stage::TrialScene;
use super::trial::{Trial, TrialKind};
use crate::circle::ms;
use crate::{Progress, Quantiles};

/// Distance in pixels from the cursor within which a feature counts as being under the cursor.
pub(super) const LANDED_PX: f64 = 0.5;

/// Results of the benchmark of drags.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DragBenchReport {
    /// Names of the scenes.
    pub scenes: Vec<String>,
    /// Drags of each kind in each scene.
    pub drags: usize,
    /// Seed of the random drags.
    pub seed: u64,
    /// Results of the sixteen kinds of drags.
    pub kinds: Vec<KindReport>,
}

/// Results of the drags of one kind, in all scenes.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct KindReport {
    /// `shadow`, `hotspot`, `highlight` or `diffuse`.
    pub feature: &'static str,
    /// `rigid` or `deforming`.
    pub points: &'static str,
    /// `small` or `large`.
    pub way: &'static str,
    /// Number of drags made.
    pub drags: usize,
    /// Results of the product.
    pub ours: DragErrors,
    /// Results of a solver that changes the light as little as it can, whatever that does to the picture.
    pub least_change: DragErrors,
    /// Results of the paper's formulas.
    pub paper: DragErrors,
    /// Iterations of the product's solver.
    pub iterations: Quantiles,
}

/// Results of one of the two solvers.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DragErrors {
    /// Number of drags after which the feature is within half a pixel of the cursor and the light is valid.
    pub landed: usize,
    /// Number of lights that fold.
    pub folded: usize,
    /// Number of drags after which the feature is not in the picture.
    pub lost: usize,
    /// Distance from the cursor to the feature, in pixels.
    pub px: Quantiles,
    /// Residual of the drag's equation at the cursor: in radii for shadow and hotspot, in radians for the others.
    pub residual: Quantiles,
    /// Landed features that could be seen where they were taken, and those of them that can be seen at the cursor.
    pub visible: usize,
    pub seen: usize,
    /// Share of the lit part of the picture that loses more than half of its brightness by a landed drag.
    pub picture_lost: Quantiles,
    /// Milliseconds, including the picks.
    pub ms: Quantiles,
}

/// Results of one drag by both solvers.
#[derive(Clone, Debug)]
pub(super) struct MeasuredTrial {
    pub kind: TrialKind,
    pub ours: DragError,
    least_change: DragError,
    pub paper: DragError,
    iterations: usize,
}

/// Error and time of one drag.
#[derive(Clone, Copy, Debug)]
pub(super) struct DragError {
    is_folded: bool,
    /// Distance from the cursor to the feature in pixels; infinite if the feature is not in the picture.
    pub px: f64,
    residual: f64,
    /// Change of the picture, if the feature landed.
    picture: Option<PictureChange>,
    pub ms: f64,
}

impl DragError {
    fn new(grid: &PictureGrid, stage: &TrialScene, trial: &Trial, light: Option<Light>, ms: f64) -> Self {
        let light = light.and_then(|light| CheckedLight::new(light).ok());
        let px = light.as_ref().and_then(|light| distance_px(stage, trial, light));
        let off = light.as_ref().and_then(|light| EquationError::at_target(stage, trial, light));
        // A near feature can still be absent: outside of the light, or on a light path that only touches the caster of
        // the shadow.
        let px = px.filter(|px| off.is_some() || *px > LANDED_PX).unwrap_or(f64::INFINITY);
        Self {
            is_folded: light.is_none(),
            px,
            picture: light.filter(|_| px <= LANDED_PX).map(|light| grid.change(trial, &light)),
            residual: off.map_or(f64::INFINITY, |off| off.residual),
            ms,
        }
    }
}

/// Makes `drags` random drags of every kind in each scene.
pub(super) fn measure_trials(
    stages: &[TrialScene],
    drags: usize,
    seed: u64,
    progress: impl Fn(Progress),
) -> (DragBenchReport, Vec<MeasuredTrial>) {
    let (mut all, mut done) = (Vec::new(), 0);
    let of = stages.len() * TrialKind::all().count() * drags;
    for stage in stages {
        let grid = PictureGrid::new(stage);
        for kind in TrialKind::all() {
            for number in 0..drags {
                let trial = Trial::random(stage, kind, Trial::seed(seed, &stage.name, kind, number));
                all.extend(trial.map(|trial| measure_trial(&grid, stage, &trial)));
                done += 1;
                progress(Progress { done, of, what: stage.name.clone() });
            }
        }
    }
    let report = DragBenchReport {
        scenes: stages.iter().map(|stage| stage.name.clone()).collect(),
        drags,
        seed,
        kinds: TrialKind::all().map(|kind| kind_report(kind, &all)).collect(),
    };
    (report, all)
}

fn measure_trial(grid: &PictureGrid, stage: &TrialScene, trial: &Trial) -> MeasuredTrial {
    let began = Instant::now();
    let result = drag(&stage.reference.bvh, &trial.light, &trial.drag, &[]);
    let ours_ms = ms(began.elapsed());
    let began = Instant::now();
    let least_change = drag_least_change(&stage.reference.bvh, &trial.light, &trial.drag);
    let least_change_ms = ms(began.elapsed());
    let began = Instant::now();
    let moved = paper::moved(stage, trial);
    let paper_ms = ms(began.elapsed());
    MeasuredTrial {
        kind: trial.kind,
        ours: DragError::new(grid, stage, trial, Some(result.light), ours_ms),
        least_change: DragError::new(grid, stage, trial, Some(least_change.light), least_change_ms),
        paper: DragError::new(grid, stage, trial, moved, paper_ms),
        iterations: result.outcome.iterations,
    }
}

fn kind_report(kind: TrialKind, all: &[MeasuredTrial]) -> KindReport {
    let of_kind: Vec<&MeasuredTrial> = all.iter().filter(|made| made.kind == kind).collect();
    let side = |of: fn(&MeasuredTrial) -> &DragError| {
        let values = |value: fn(&DragError) -> f64| Quantiles::of(of_kind.iter().map(move |made| value(of(made))));
        let count = |is: fn(&DragError) -> bool| of_kind.iter().filter(|made| is(of(made))).count();
        DragErrors {
            landed: count(|one| one.px <= LANDED_PX),
            folded: count(|one| one.is_folded),
            lost: count(|one| !one.is_folded && one.px.is_infinite()),
            px: values(|one| one.px),
            residual: values(|one| one.residual),
            visible: count(|one| one.picture.is_some_and(|picture| picture.is_seen.is_some())),
            seen: count(|one| one.picture.is_some_and(|picture| picture.is_seen == Some(true))),
            picture_lost: Quantiles::of(of_kind.iter().filter_map(|made| of(made).picture?.lost)),
            ms: values(|one| one.ms),
        }
    };
    KindReport {
        feature: kind.feature_name(),
        points: kind.points_name(),
        way: kind.distance_name(),
        drags: of_kind.len(),
        ours: side(|made| &made.ours),
        least_change: side(|made| &made.least_change),
        paper: side(|made| &made.paper),
        iterations: Quantiles::of(of_kind.iter().map(|made| made.iterations as f64)),
    }
}
