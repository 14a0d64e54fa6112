//! What came of drags of each kind.

use std::collections::BTreeMap;
use std::fmt::Write;

use bench::drag::TrialKind;
use drag::{DragLimit, DragRefusal, DragStatus};
use serde::Serialize;

/// All that was measured.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DragStudyReport {
    /// Drags of each kind in each scene.
    pub drags: usize,
    /// Where they began.
    pub seed: u64,
    /// Pins of each drag.
    pub pins: usize,
    /// A scene and kind each, and under the scene `all` those of all scenes together.
    pub cells: Vec<ReportCell>,
}

/// Drags of one kind in one scene.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ReportCell {
    /// File or demo.
    pub scene: String,
    /// `shadow`, `hotspot`, `highlight` or `diffuse`.
    pub feature: &'static str,
    /// `rigid` or `deforming`.
    pub points: &'static str,
    /// `small` or `large`.
    pub way: &'static str,
    /// Drags that were found and made.
    pub drags: usize,
    /// Those that say that they landed.
    pub landed: usize,
    /// Those that a limit holds, by its name.
    pub limited: BTreeMap<String, usize>,
    /// Those that are refused, by the reason's name.
    pub refused: BTreeMap<String, usize>,
    /// Of those that did not land, the ones that the slow solver landed.
    pub missed: usize,
    /// The same by limit or reason.
    pub missed_by: BTreeMap<String, usize>,
    /// Landed, of landed and missed; null of none.
    pub landed_of_feasible: Option<f64>,
    /// Of those that landed, the share that the slow solver landed too: how far it can be trusted.
    pub slow_of_landed: Option<f64>,
    /// Those that say that they landed and did not, by the independent way.
    pub wrong: usize,
    /// Hard pins that do not hold in the product's light.
    pub broken: usize,
    /// Drags that land without their pins, and that nothing lands with them.
    pub infeasible: usize,
    /// Of these, the ones that a pin limits.
    pub infeasible_named: usize,
    /// The farthest that the equation is off at the cursor of those that say that they landed: pixels of shadow and hotspot,
    /// degrees of highlight and diffuse.
    pub worst_off: f64,
    /// The farthest on screen, in pixels.
    pub worst_px: f64,
    /// A drag's time with its picks: half are faster.
    pub p50_ms: f64,
    /// 95 in 100 are faster.
    pub p95_ms: f64,
    /// Steps of the solver, the median of those that landed.
    pub p50_iterations: usize,
}

/// What came of one drag.
#[derive(Clone, Debug)]
pub struct StudyOutcome {
    /// Of which kind it was.
    pub kind: TrialKind,
    /// What the product says.
    pub status: DragStatus,
    /// Steps of the product's solver.
    pub iterations: usize,
    /// What it took, picks included.
    pub ms: f64,
    /// How far the equation is off at the cursor, in pixels or degrees; `None` where the light does not hold that place.
    pub equation_error: Option<f64>,
    /// Of one that says that it landed, how far the feature is off on screen; `None` where it is not seen.
    pub px: Option<f64>,
    /// Whether one that says that it landed is too far off.
    pub is_wrong: bool,
    /// Whether the slow solver landed it.
    pub is_feasible: bool,
    /// Whether nothing lands it with its pins, and it lands without.
    pub is_infeasible: bool,
    /// Hard pins that do not hold.
    pub broken: usize,
}

impl ReportCell {
    /// Of outcomes of one kind.
    pub fn of<'a>(scene: &str, kind: TrialKind, outcomes: impl Iterator<Item = &'a StudyOutcome>) -> Self {
        let of_kind: Vec<_> = outcomes.filter(|outcome| outcome.kind == kind).collect();
        let count = |is: &dyn Fn(&StudyOutcome) -> bool| of_kind.iter().filter(|outcome| is(outcome)).count();
        let landed = count(&|outcome| outcome.status == DragStatus::Converged);
        let missed = count(&|outcome| outcome.is_feasible && outcome.status != DragStatus::Converged);
        let by_both = count(&|outcome| outcome.is_feasible && outcome.status == DragStatus::Converged);
        let of_landed = || of_kind.iter().filter(|outcome| outcome.status == DragStatus::Converged);
        let worst = |of: &dyn Fn(&StudyOutcome) -> Option<f64>| {
            of_landed().map(|outcome| of(outcome).unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
        };
        let mut cell = Self {
            scene: scene.into(),
            feature: kind.feature_name(),
            points: kind.points_name(),
            way: kind.distance_name(),
            drags: of_kind.len(),
            landed,
            missed,
            landed_of_feasible: (landed + missed > 0).then(|| landed as f64 / (landed + missed) as f64),
            slow_of_landed: (landed > 0).then(|| by_both as f64 / landed as f64),
            wrong: count(&|outcome| outcome.is_wrong),
            broken: of_kind.iter().map(|outcome| outcome.broken).sum(),
            infeasible: count(&|outcome| outcome.is_infeasible),
            infeasible_named: count(&|outcome| {
                outcome.is_infeasible && matches!(outcome.status, DragStatus::Limited(DragLimit::Pin(_)))
            }),
            worst_off: worst(&|outcome| outcome.equation_error),
            worst_px: worst(&|outcome| outcome.px),
            p50_ms: quantile(of_kind.iter().map(|outcome| outcome.ms), 0.5),
            p95_ms: quantile(of_kind.iter().map(|outcome| outcome.ms), 0.95),
            p50_iterations: quantile(of_landed().map(|outcome| outcome.iterations as f64), 0.5) as usize,
            ..Self::default()
        };
        for outcome in of_kind {
            let (held, name) = match outcome.status {
                DragStatus::Converged => continue,
                DragStatus::Limited(limit) => (&mut cell.limited, limit_name(limit)),
                DragStatus::Refused(reason) => (&mut cell.refused, reason_name(reason)),
            };
            *held.entry(name.clone()).or_default() += 1;
            if outcome.is_feasible {
                *cell.missed_by.entry(name).or_default() += 1;
            }
        }
        cell
    }
}

/// The names that the contract has.
fn limit_name(limit: DragLimit) -> String {
    let name = serde_json::to_value(protocol::DragLimit::from(limit));
    name.expect("a word").as_str().unwrap_or_default().to_owned()
}

fn reason_name(reason: DragRefusal) -> String {
    let name = serde_json::to_value(protocol::DragReason::from(reason));
    name.expect("a word").as_str().unwrap_or_default().to_owned()
}

/// Of values in any order; 0 of none.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let index = (share * values.len() as f64).ceil() as usize;
    values.get(index.saturating_sub(1)).copied().unwrap_or(0.0)
}

impl DragStudyReport {
    /// A line a cell.
    pub fn table(&self) -> String {
        let mut text = String::from(
            "scene            feature   points    way   drags landed missed  of feasible    slow  wrong broken named of infeasible  worst off   worst px  \
             p50 ms  p95 ms  [missed by] held back by\n",
        );
        for cell in &self.cells {
            let share = cell.landed_of_feasible.map_or("-".into(), |share| format!("{:.1} %", 100.0 * share));
            let slow = cell.slow_of_landed.map_or("-".into(), |share| format!("{:.1} %", 100.0 * share));
            let words = |counts: &BTreeMap<String, usize>| {
                let words = counts.iter().map(|(name, count)| format!("{name} {count}"));
                words.collect::<Vec<_>>().join(", ")
            };
            let missed_by = words(&cell.missed_by);
            let held = [words(&cell.limited), words(&cell.refused)].join(" ");
            let name: String = cell.scene.chars().take(16).collect();
            let ReportCell { feature, points, way, drags, landed, missed, wrong, .. } = cell;
            let ReportCell {
                worst_off, worst_px, p50_ms, p95_ms, broken, infeasible, infeasible_named, ..
            } = cell;
            let _ = writeln!(
                text,
                "{name:16} {feature:9} {points:9} {way:5} {drags:5} {landed:6} {missed:6} {share:>12} {slow:>7} {wrong:6} {broken:6} {infeasible_named:5} of {infeasible:10}  {worst_off:10.2e} \
                 {worst_px:10.2e} {p50_ms:7.2} {p95_ms:7.2}  [{missed_by}] {held}"
            );
        }
        text
    }
}
