//! Makes random drags, with the product and with the paper's formulas, and measures both.

use std::time::Instant;

use drag::{Drag, DragChoice, DragResult, DragStatus, drag, drag_least_change};
use light::{CheckedLight, Light};
use raycast::SeenPoint;
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

/// Length in pixels of the ways whose steps are measured, and one of how many drags has such a way.
const WAY_PX: usize = 12;
const WAY_EVERY: usize = 5;

/// Way of a control point in a step of a pixel that counts as a jump, in lengths of the light.
const JUMP: f64 = 0.05;

/// Distance in depths, and cosine between normals, of points of neighbouring pixels on one surface: a step over an edge is
/// longer, or turns by more than half a degree.
const MAX_STEP_SHARE: f64 = 0.02;
const MIN_NORMALS_COS: f64 = 0.99996;

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
    /// Results of the product, which moves what was asked for: the whole light or the chosen control points.
    pub ours: DragErrors,
    /// Results of the product with the page's defaults: the best alternative, with the source outside of surfaces.
    pub best: DragErrors,
    /// Results of a solver that changes the light as little as it can, whatever that does to the picture.
    pub least_change: DragErrors,
    /// Results of the paper's formulas.
    pub paper: DragErrors,
    /// Steps of `ours` and of `leastChange` between cursors a pixel apart.
    pub jumps: Jumps,
    pub jumps_of_least_change: Jumps,
    /// Iterations of the product's solver.
    pub iterations: Quantiles,
}

/// Results of one of the solvers.
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
    /// Share of the lit part of the picture that keeps half of its brightness after a landed drag.
    pub kept: KeptShares,
    /// Share of the picture that changes visibly by a landed drag.
    pub changed: Quantiles,
    /// Milliseconds, including the picks.
    pub ms: Quantiles,
}

/// Shares that landed drags keep.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct KeptShares {
    /// Landed drags of lights that reach enough of the picture.
    pub drags: usize,
    pub median: f64,
    /// Share that nine in ten of the drags keep at least.
    pub worst_tenth: f64,
}

/// Changes of the light along ways of the cursor, a pixel at a time.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Jumps {
    /// Steps on one surface between two cursors at which the feature lands.
    pub steps: usize,
    /// Steps that move a control point by more than a twentieth of the light's length.
    pub jumps: usize,
    /// Largest way of a control point in a step, in lengths of the light.
    pub longest: f64,
}

/// Results of one drag by all solvers.
#[derive(Clone, Debug)]
pub(super) struct MeasuredTrial {
    pub kind: TrialKind,
    pub ours: DragError,
    pub best: DragError,
    pub least_change: DragError,
    pub paper: DragError,
    iterations: usize,
    /// Largest ways of a control point, in lengths of the light, of steps of a pixel: by the product and by the least change.
    steps: [Vec<f64>; 2],
}

/// Error and time of one drag.
#[derive(Clone, Copy, Debug)]
pub(super) struct DragError {
    is_folded: bool,
    /// Distance from the cursor to the feature in pixels; infinite if the feature is not in the picture.
    pub px: f64,
    residual: f64,
    /// Change of the picture, if the feature landed.
    pub picture: Option<PictureChange>,
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
                let has_way = number < drags.div_ceil(WAY_EVERY);
                all.extend(trial.map(|trial| measure_trial(&grid, stage, &trial, has_way)));
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

fn measure_trial(grid: &PictureGrid, stage: &TrialScene, trial: &Trial, has_way: bool) -> MeasuredTrial {
    let bvh = &stage.reference.bvh;
    let by_picture = |asked: &Drag| drag(bvh, &trial.light, asked, &[]);
    let by_least_change = |asked: &Drag| drag_least_change(bvh, &trial.light, asked);
    let best = Drag { choice: Some(DragChoice::Best), points: None, source_outside: true, ..trial.drag.clone() };
    let error = |light, ms| DragError::new(grid, stage, trial, light, ms);
    let (result, result_ms) = timed(|| by_picture(&trial.drag));
    let (best, best_ms) = timed(|| by_picture(&best));
    let (least_change, least_change_ms) = timed(|| by_least_change(&trial.drag));
    let (moved, moved_ms) = timed(|| paper::moved(stage, trial));
    MeasuredTrial {
        kind: trial.kind,
        ours: error(Some(result.light), result_ms),
        best: error(Some(best.light), best_ms),
        least_change: error(Some(least_change.light), least_change_ms),
        paper: error(moved, moved_ms),
        iterations: result.outcome.iterations,
        steps: if has_way {
            [steps(stage, trial, by_picture), steps(stage, trial, by_least_change)]
        } else {
            Default::default()
        },
    }
}

/// Returns what `solve` does, and its time in milliseconds.
fn timed<T>(solve: impl FnOnce() -> T) -> (T, f64) {
    let began = Instant::now();
    let solved = solve();
    (solved, ms(began.elapsed()))
}

/// Drags to the cursor along the last pixels of its straight way, a pixel at a time. Returns the largest way of a control point in each step, in lengths
/// of the light. A step at which the surface under the cursor is another, or turns, is left out: there the light has to jump.
/// So is one at which the answer names other relaxed constraints.
fn steps(stage: &TrialScene, trial: &Trial, solve: impl Fn(&Drag) -> DragResult) -> Vec<f64> {
    let Drag { from, to, .. } = trial.drag;
    let ahead = (to - from).normalize_or_zero();
    let landed = |number: usize| {
        let to = to + ahead * (number as f64 - WAY_PX as f64);
        let seen = stage.seen(to)?;
        let result = solve(&Drag { to, ..trial.drag.clone() });
        (result.outcome.status == DragStatus::Landed).then_some((seen, result))
    };
    let ends: Vec<Option<(SeenPoint, DragResult)>> = (0..=WAY_PX).map(landed).collect();
    let way = |pair: &[Option<(SeenPoint, DragResult)>]| {
        let [(a, before), (b, after)] = [pair[0].as_ref()?, pair[1].as_ref()?];
        let is_alike = before.outcome.relaxed == after.outcome.relaxed;
        (is_one_surface(a, b) && is_alike).then(|| largest_way(&before.light, &after.light))
    };
    ends.windows(2).filter_map(way).collect()
}

/// True if two points of neighbouring pixels lie on a surface that goes on between them without an edge.
fn is_one_surface(a: &SeenPoint, b: &SeenPoint) -> bool {
    a.position.distance(b.position) < MAX_STEP_SHARE * b.depth && a.normal.dot(b.normal) > MIN_NORMALS_COS
}

/// Returns the largest distance between the control points of two lights, as a share of the length of their polyline.
fn largest_way(a: &Light, b: &Light) -> f64 {
    let in_world = |light: &Light| {
        let transform = light.transform();
        light.points().iter().map(|point| transform.world_from_local(point.position)).collect::<Vec<_>>()
    };
    let (a, b) = (in_world(a), in_world(b));
    let length: f64 = a.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    a.iter().zip(&b).map(|(a, b)| a.distance(*b) / length).fold(0.0, f64::max)
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
            kept: KeptShares::of(of_kind.iter().filter_map(|made| of(made).picture?.kept)),
            changed: Quantiles::of(of_kind.iter().filter_map(|made| Some(of(made).picture?.changed))),
            ms: values(|one| one.ms),
        }
    };
    let jumps = |solver: usize| Jumps::of(of_kind.iter().flat_map(|made| made.steps[solver].iter().copied()));
    KindReport {
        feature: kind.feature_name(),
        points: kind.points_name(),
        way: kind.distance_name(),
        drags: of_kind.len(),
        ours: side(|made| &made.ours),
        best: side(|made| &made.best),
        least_change: side(|made| &made.least_change),
        paper: side(|made| &made.paper),
        jumps: jumps(0),
        jumps_of_least_change: jumps(1),
        iterations: Quantiles::of(of_kind.iter().map(|made| made.iterations as f64)),
    }
}

impl KeptShares {
    fn of(shares: impl Iterator<Item = f64>) -> Self {
        let mut shares: Vec<f64> = shares.collect();
        shares.sort_by(f64::total_cmp);
        let at = |index: usize| shares.get(index).copied().unwrap_or(0.0);
        Self { drags: shares.len(), median: at(shares.len() / 2), worst_tenth: at(shares.len() / 10) }
    }
}

impl Jumps {
    fn of(ways: impl Iterator<Item = f64>) -> Self {
        let none = Self { steps: 0, jumps: 0, longest: 0.0 };
        ways.fold(none, |all, way| Self {
            steps: all.steps + 1,
            jumps: all.jumps + usize::from(way > JUMP),
            longest: all.longest.max(way),
        })
    }
}
