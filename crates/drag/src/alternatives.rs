//! Alternatives of a drag: other parts of the light that may follow the feature, ordered by what they do to the picture.

use std::cell::OnceCell;

use light::CheckedLight;

use crate::linked_copy::split_light;
use crate::occlusion::Occlusion;
use crate::past_caster::first_point_past_caster;
use crate::picture_change::PictureSample;
use crate::request::{Alternative, Drag, DragChoice, DragLimit, DragRefusal, DragResult, DragStatus, RadiusMode};
use crate::solve::{DragEnd, StartedTask};
use crate::start::DragTask;

/// Difference of the change of what is lit by which a later alternative displaces an earlier one. Smaller differences are
/// within the error of the measurement, and the choice would alternate along a cursor's way.
const CLEARLY_LESS: f64 = 0.03;

/// Change of what is lit that is small enough: no other alternative is tried.
const SMALL: f64 = 0.2;

/// Difference of the residual by which a limited drag is nearer, in pixels.
const CLEARLY_NEARER_PX: f64 = 2.0;

/// Result of an alternative.
struct Solved {
    result: DragResult,
    /// The picture's light after it; empty if the drag was refused.
    after: Vec<f64>,
    /// Mean relative change of what was lit.
    change_of_lit: f64,
}

/// Started drag, with the picture by which its alternatives are measured.
struct MeasuredTask<'a> {
    started: StartedTask<'a>,
    /// Pixels of the picture, measured when the first alternative is solved: a drag may be refused before.
    sample: OnceCell<PictureSample<'a>>,
}

/// Drags by the alternative that the drag chooses, or by what it names itself.
pub(crate) fn drag_chosen(task: DragTask) -> DragResult {
    let started = StartedTask::new(task, true);
    let measured_alone = |mut result: DragResult| {
        if let Some(lights) = lights_after(&result) {
            let sample = PictureSample::new(task.bvh, &task.drag.view, task.light, task.work);
            result.outcome.changed_share = sample.changed_share(&sample.irradiances(&lights));
        }
        result
    };
    match task.drag.choice {
        None => measured_alone(started.solved(task.drag, DragEnd::CursorOrWay)),
        Some(DragChoice::Only(alternative)) => {
            let result = solve_alternative(&started, alternative, DragEnd::CursorOrWay);
            let mut result = result.unwrap_or_else(|refusal| started.refused(refusal));
            result.outcome.alternative = Some(alternative);
            measured_alone(result)
        }
        Some(DragChoice::Best) => {
            let measured = MeasuredTask::new(started);
            // Whatever lands is better than what is limited. So limited drags are searched for only if nothing lands.
            let mut limits = Vec::new();
            let at_cursor = best_of(|alternative| {
                let new = measured.solved(alternative, DragEnd::Cursor)?;
                limits.extend(limit_at_cursor(&new).map(|limit| (alternative, limit)));
                Some(new)
            });
            let has_landed = |best: &Solved| best.result.outcome.status == DragStatus::Landed;
            let best = at_cursor.filter(has_landed).or_else(|| {
                best_of(|alternative| {
                    let known = limits.iter().find(|(tried, _)| *tried == alternative);
                    measured.solved(alternative, known.map_or(DragEnd::CursorOrWay, |(_, limit)| DragEnd::Way(*limit)))
                })
            });
            // The light as a whole can always be tried.
            best.map_or_else(|| measured.started.refused(DragRefusal::NotBendy), |best| best.result)
        }
    }
}

/// Solves a drag by one alternative after the other, until one lands that changes little of what is lit, and returns the
/// best.
fn best_of(mut solve: impl FnMut(Alternative) -> Option<Solved>) -> Option<Solved> {
    let mut best: Option<Solved> = None;
    let own = Alternative::ALL.into_iter().filter(|alternative| *alternative != Alternative::LinkedCopy);
    for alternative in own {
        if best.as_ref().is_some_and(Solved::is_good_enough) {
            break;
        }
        // Radii that need not shrink give the same light as those that are kept.
        let is_repeated = alternative == Alternative::Narrower && !best.as_ref().is_some_and(is_limited_by_fold);
        let Some(new) = (if is_repeated { None } else { solve(alternative) }) else { continue };
        if best.as_ref().is_none_or(|best| new.is_clearly_better(best)) {
            best = Some(new);
        }
    }
    best
}

/// Returns the limit for which a drag was refused, if any.
fn limit_at_cursor(solved: &Solved) -> Option<DragLimit> {
    match solved.result.outcome.status {
        DragStatus::Refused(DragRefusal::Limited(limit)) => Some(limit),
        _ => None,
    }
}

/// Solves a drag by each alternative that the light and the feature have. Returns the best first, then those that land,
/// are limited and are refused, each by what they change. Of those with the same picture, the first remains.
pub(crate) fn drag_all(task: DragTask) -> Vec<DragResult> {
    let measured = MeasuredTask::new(StartedTask::new(task, true));
    let mut all: Vec<Solved> = Vec::new();
    for alternative in Alternative::ALL {
        // Radii that need not shrink give the same light as those that are kept.
        if alternative != Alternative::Narrower || all.first().is_some_and(is_limited_by_fold) {
            all.extend(measured.solved(alternative, DragEnd::CursorOrWay));
        }
    }
    let own = (0..all.len()).filter(|index| all[*index].result.outcome.alternative != Some(Alternative::LinkedCopy));
    let best = own.reduce(|best, index| if all[index].is_clearly_better(&all[best]) { index } else { best });
    let first = best.map(|best| all.remove(best));
    all.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
    let mut distinct: Vec<Solved> = Vec::new();
    for solved in first.into_iter().chain(all) {
        let is_solved = |solved: &Solved| !solved.after.is_empty();
        let is_twin = |other: &Solved| is_solved(other) && measured.sample().are_alike(&solved.after, &other.after);
        if !(is_solved(&solved) && distinct.iter().any(is_twin)) {
            distinct.push(solved);
        }
    }
    distinct.into_iter().map(|solved| solved.result).collect()
}

impl Solved {
    /// Returns a number that is less for a better result: the change of what is lit of one that landed, then 1 and more by
    /// the residual of a limited one, then 3.
    fn rank(&self) -> f64 {
        let outcome = &self.result.outcome;
        match outcome.status {
            DragStatus::Landed => self.change_of_lit,
            DragStatus::Limited(_) => 1.0 + outcome.residual_px / (1.0 + outcome.residual_px),
            DragStatus::Refused(_) => 3.0,
        }
    }

    /// True if no later alternative displaces this one.
    fn is_good_enough(&self) -> bool {
        self.rank() <= SMALL
    }

    /// True if this result is clearly better than an earlier alternative's.
    fn is_clearly_better(&self, other: &Self) -> bool {
        let (own, others) = (&self.result.outcome, &other.result.outcome);
        match (own.status, others.status) {
            (DragStatus::Limited(_), DragStatus::Limited(_)) => {
                own.residual_px < others.residual_px - CLEARLY_NEARER_PX
            }
            (DragStatus::Landed, DragStatus::Landed) => {
                !other.is_good_enough() && self.rank() < other.rank() - CLEARLY_LESS
            }
            _ => self.rank() < other.rank(),
        }
    }
}

impl<'a> MeasuredTask<'a> {
    fn new(started: StartedTask<'a>) -> Self {
        Self { started, sample: OnceCell::new() }
    }

    fn sample(&self) -> &PictureSample<'a> {
        self.sample.get_or_init(|| {
            let DragTask { bvh, light, drag, work, .. } = self.started.task;
            let mut sample = PictureSample::new(bvh, &drag.view, light, work);
            sample.add_lit_pixels(&drag.view, light);
            sample
        })
    }

    /// Solves the drag by an alternative. `None` if the light or the feature does not have it.
    fn solved(&self, alternative: Alternative, end: DragEnd) -> Option<Solved> {
        let mut result = match solve_alternative(&self.started, alternative, end) {
            Ok(result) => result,
            Err(refusal @ DragRefusal::TooLittleRoom) => self.started.refused(refusal),
            Err(_) => return None,
        };
        result.outcome.alternative = Some(alternative);
        let Some(lights) = lights_after(&result) else {
            return Some(Solved { result, after: Vec::new(), change_of_lit: 1.0 });
        };
        let sample = self.sample();
        let after = sample.irradiances(&lights);
        result.outcome.changed_share = sample.changed_share(&after);
        // Node whose shadow is dragged.
        let moved_caster = self.started.start.as_ref().ok().and_then(|start| start.caster).map(|caster| caster.node);
        let change_of_lit = sample.change_of_lit(&lights[0], &after, moved_caster);
        Some(Solved { result, after, change_of_lit })
    }
}

/// Solves a drag by an alternative, or says why the light or the feature does not have it.
fn solve_alternative(started: &StartedTask, alternative: Alternative, end: DragEnd) -> Result<DragResult, DragRefusal> {
    let DragTask { bvh, light, drag, pins, work } = started.task;
    let whole = Drag { points: None, ..drag.clone() };
    let movable = || drag.points.clone().unwrap_or_else(|| (1..light.light().points().len()).collect());
    let by_points = |points: Vec<usize>, radii| Drag { points: Some(points), radii, ..drag.clone() };
    let tube = light.tube().ok_or(DragRefusal::NotBendy);
    match alternative {
        Alternative::WholeLight => Ok(started.solved(&whole, end)),
        Alternative::ControlPoints => {
            // Radii shrink by themselves in the narrower alternative only.
            let radii = if drag.radii == RadiusMode::Solve { RadiusMode::Solve } else { RadiusMode::Keep };
            tube.map(|_| started.solved(&by_points(movable(), radii), end))
        }
        Alternative::Narrower => tube.map(|_| started.solved(&by_points(movable(), RadiusMode::Follow), end)),
        Alternative::PastCaster => {
            let start = started.start.as_ref().map_err(|refusal| *refusal)?;
            let first = first_point_past_caster(start, drag)?;
            let past = movable().into_iter().filter(|point| *point >= first).collect();
            Ok(started.solved(&by_points(past, RadiusMode::Keep), end))
        }
        Alternative::LinkedCopy => {
            let occlusion = Occlusion::new(bvh, light, work);
            let split = split_light(&occlusion, light, drag, pins).ok_or(DragRefusal::NoShadow)?;
            let started = StartedTask::new(DragTask { light: &split.dragged, pins: &split.pins, ..started.task }, true);
            let bent = light.tube().map(|_| started.solved(&by_points(movable(), RadiusMode::Keep), end));
            let landed = bent.filter(|result| result.outcome.status == DragStatus::Landed);
            let mut result = landed.unwrap_or_else(|| started.solved(&whole, end));
            if let DragStatus::Refused(_) = result.outcome.status {
                result.light = light.light().clone();
            } else {
                result.copy = Some(split.copy);
            }
            Ok(result)
        }
    }
}

fn is_limited_by_fold(solved: &Solved) -> bool {
    let status = solved.result.outcome.status;
    [DragStatus::Limited(DragLimit::Fold), DragStatus::Refused(DragRefusal::Limited(DragLimit::Fold))].contains(&status)
}

/// Returns the light after a drag, then its copy. `None` if the drag was refused: there is no picture to measure.
fn lights_after(result: &DragResult) -> Option<Vec<CheckedLight>> {
    if let DragStatus::Refused(_) = result.outcome.status {
        return None;
    }
    let lights = [Some(&result.light), result.copy.as_ref().map(|copy| &copy.light)];
    lights.into_iter().flatten().map(|light| CheckedLight::new(light.clone()).ok()).collect()
}
