//! Report of the drags of each kind.

use std::collections::BTreeMap;
use std::fmt::Write;

use bench::Quantiles;
use bench::drag::TrialKind;
use drag::{DragLimit, DragStatus};
use serde::Serialize;

/// Report of the study of drags.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DragStudyReport {
    /// Drags of each kind in each scene.
    pub drags: usize,
    /// Seed of the random drags.
    pub seed: u64,
    /// Pins of each drag.
    pub pins: usize,
    /// One per scene and kind, and one per kind with the scene `all` for all scenes together.
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
    /// Number of drags that were found and made.
    pub drags: usize,
    /// Number of drags that the product reports as converged.
    pub landed: usize,
    /// Number of drags that each limit stopped, by the limit's name.
    pub limited: BTreeMap<String, usize>,
    /// Number of drags that were refused for each reason, by the reason's name.
    pub refused: BTreeMap<String, usize>,
    /// Number of drags that did not converge with the product's solver, but did with the slow solver.
    pub missed: usize,
    /// Number of these missed drags, by the limit or the reason of a refusal.
    pub missed_by: BTreeMap<String, usize>,
    /// `landed / (landed + missed)`; null if both are 0.
    pub landed_of_feasible: Option<f64>,
    /// Share of the drags converged with the product's solver that also converge with the slow solver. It measures how
    /// reliable the slow solver is.
    pub slow_of_landed: Option<f64>,
    /// Number of drags that the product reports as converged, although the independent measures find that they are not.
    pub wrong: usize,
    /// Number of hard pins that the product's light does not preserve.
    pub broken: usize,
    /// Number of drags that converge without their pins, but with neither solver if the pins are kept.
    pub infeasible: usize,
    /// Number of those infeasible drags that the product reports as limited by a pin.
    pub infeasible_named: usize,
    /// Largest error of the equation at the cursor among drags reported as converged: pixels for shadow and hotspot,
    /// degrees for highlight and diffuse.
    pub worst_off: f64,
    /// Largest distance in pixels on the screen between cursor and feature, among drags reported as converged.
    pub worst_px: f64,
    /// Median milliseconds of a drag, including the picks.
    pub p50_ms: f64,
    /// 95th percentile of the milliseconds of a drag.
    pub p95_ms: f64,
    /// Median iterations of the product's solver over the converged drags.
    pub p50_iterations: usize,
}

/// Results of one drag.
#[derive(Clone, Debug)]
pub struct StudyOutcome {
    pub kind: TrialKind,
    /// Status that the product reports.
    pub status: DragStatus,
    /// Iterations of the product's solver.
    pub iterations: usize,
    /// Milliseconds, including the picks.
    pub ms: f64,
    /// Error of the equation at the cursor, in pixels or degrees; `None` if that point is outside of the light.
    pub equation_error: Option<f64>,
    /// Distance in pixels on screen between cursor and feature of a drag reported as converged; `None` if the feature
    /// is not visible.
    pub px: Option<f64>,
    /// True if the drag is reported as converged, but the feature is too far from the cursor.
    pub is_wrong: bool,
    /// True if the slow solver finds a light with the feature under the cursor.
    pub is_feasible: bool,
    /// True if neither solver finds a light that keeps the pins, but the product's solver finds one without them.
    pub is_infeasible: bool,
    /// Number of hard pins that the light does not preserve.
    pub broken: usize,
}

impl ReportCell {
    /// Summarizes the outcomes of one kind.
    pub fn of<'a>(scene: &str, kind: TrialKind, outcomes: impl Iterator<Item = &'a StudyOutcome>) -> Self {
        let of_kind: Vec<_> = outcomes.filter(|outcome| outcome.kind == kind).collect();
        let count = |is: &dyn Fn(&StudyOutcome) -> bool| of_kind.iter().filter(|outcome| is(outcome)).count();
        let landed = count(&|outcome| outcome.status == DragStatus::Landed);
        let missed = count(&|outcome| outcome.is_feasible && outcome.status != DragStatus::Landed);
        let by_both = count(&|outcome| outcome.is_feasible && outcome.status == DragStatus::Landed);
        let of_landed = || of_kind.iter().filter(|outcome| outcome.status == DragStatus::Landed);
        let worst = |of: &dyn Fn(&StudyOutcome) -> Option<f64>| {
            of_landed().map(|outcome| of(outcome).unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
        };
        let ms = Quantiles::of(of_kind.iter().map(|outcome| outcome.ms));
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
            p50_ms: ms.p50,
            p95_ms: ms.p95,
            p50_iterations: Quantiles::of(of_landed().map(|outcome| outcome.iterations as f64)).p50 as usize,
            ..Self::default()
        };
        for outcome in of_kind {
            let (held, name) = match outcome.status {
                DragStatus::Landed => continue,
                DragStatus::Limited(limit) => (&mut cell.limited, name_of(protocol::DragLimit::from(limit))),
                DragStatus::Refused(reason) => (&mut cell.refused, name_of(protocol::DragReason::from(reason))),
            };
            *held.entry(name.clone()).or_default() += 1;
            if outcome.is_feasible {
                *cell.missed_by.entry(name).or_default() += 1;
            }
        }
        cell
    }
}

/// Returns the name of a limit or a reason in the protocol.
fn name_of(value: impl Serialize) -> String {
    serde_json::to_value(value).expect("a word").as_str().unwrap_or_default().to_owned()
}

impl DragStudyReport {
    /// Formats one line per cell.
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
            let ReportCell { worst_off, worst_px, p50_ms, p95_ms, broken, infeasible, infeasible_named, .. } = cell;
            let _ = writeln!(
                text,
                "{name:16} {feature:9} {points:9} {way:5} {drags:5} {landed:6} {missed:6} {share:>12} {slow:>7} {wrong:6} {broken:6} {infeasible_named:5} of {infeasible:10}  {worst_off:10.2e} \
                 {worst_px:10.2e} {p50_ms:7.2} {p95_ms:7.2}  [{missed_by}] {held}"
            );
        }
        text
    }
}
