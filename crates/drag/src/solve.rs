//! One drag: to the cursor, or as far along the straight way to it as the feature lands.

use raycast::SeenPoint;

use crate::SOLVER;
use crate::landing::{DragToAnyEnd, Landing};
use crate::occlusion::seen_at;
use crate::request::{Drag, DragLimit, DragOutcome, DragRefusal, DragResult, DragStatus};
use crate::start::{DragStart, DragTask};

/// Number of parts of the way whose ends are tried, from the cursor backwards, before the last part is halved.
const PARTS: u32 = 8;

/// Least share of the way that a limited drag covers. A drag that covers less is refused.
const LEAST_SHARE: f64 = 1.0 / 3.0;

/// Places at which a drag may end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DragEnd {
    /// At the cursor, or as far along the way to it as the feature lands.
    CursorOrWay,
    /// At the cursor.
    Cursor,
    /// On the way. At the cursor the feature does not land, for this limit.
    Way(DragLimit),
}

/// Task with its start, the same for all alternatives of one light.
pub(crate) struct StartedTask<'a> {
    pub task: DragTask<'a>,
    picked: [Option<SeenPoint>; 2],
    /// Start of the drag, or the reason to refuse it.
    pub start: Result<DragStart<'a>, DragRefusal>,
}

impl<'a> StartedTask<'a> {
    /// Starts a drag. If it `keeps_picture`, the rest of the picture changes as little as it can, else the light.
    pub fn new(task: DragTask<'a>, keeps_picture: bool) -> Self {
        let DragTask { bvh, drag, work, .. } = task;
        let picked = [drag.from, drag.to].map(|pixel| seen_at(bvh, &drag.view, pixel, work));
        Self { task, picked, start: DragStart::new(task, &picked, keeps_picture) }
    }

    /// Drags what `drag.points` says; all else of `drag` is that of the task. The result has no changed share.
    pub fn solved(&self, drag: &Drag, end: DragEnd) -> DragResult {
        if drag.points.is_some() && self.task.light.tube().is_none() {
            return self.refused(DragRefusal::NotBendy);
        }
        let started = self.start.as_ref().map_err(|refusal| *refusal);
        let to_any_end = match started.and_then(|start| DragToAnyEnd::new(start, drag)) {
            Ok(to_any_end) => to_any_end,
            Err(refusal) => return self.limited_by_work(self.refused(refusal), drag),
        };
        let mut result = self.refused(DragRefusal::NoWeight);
        let origin = self.task.bvh.posed.origin_in_world;
        result.outcome.pivot_world = to_any_end.start.caster.map(|caster| caster.position + origin);
        result.outcome.residual_px = drag.from.distance(drag.to);
        if !to_any_end.has_no_effect() {
            write_farthest(&to_any_end, end, &mut result);
        }
        self.limited_by_work(result, drag)
    }

    /// Returns a result, or that of a drag that is refused since the budget is spent.
    fn limited_by_work(&self, mut result: DragResult, drag: &Drag) -> DragResult {
        if self.task.work.is_exhausted() && matches!(result.outcome.status, DragStatus::Refused(_)) {
            result.outcome.status = DragStatus::Refused(DragRefusal::Limited(DragLimit::TooMuchWork));
            result.outcome.residual_px = drag.from.distance(drag.to);
        }
        result
    }

    /// Returns the result of a drag that is refused.
    pub fn refused(&self, refusal: DragRefusal) -> DragResult {
        let DragTask { bvh, light, .. } = self.task;
        let [from_world, to_world] = self.picked.map(|seen| seen.map(|seen| seen.position + bvh.posed.origin_in_world));
        let (solver, version) = SOLVER;
        let outcome = DragOutcome {
            solver: solver.into(),
            version,
            status: DragStatus::Refused(refusal),
            alternative: None,
            changed_share: None,
            pinned_change: None,
            relaxed: Vec::new(),
            residual_px: f64::INFINITY,
            shadowed_by: None,
            iterations: 0,
            from_world,
            to_world,
            pivot_world: None,
        };
        DragResult { light: light.light().clone(), copy: None, outcome }
    }
}

/// Drags the feature to where it may `end`, as near to the cursor as it lands, and writes the result.
fn write_farthest(to_any_end: &DragToAnyEnd, end: DragEnd, result: &mut DragResult) {
    let Drag { from, to, .. } = *to_any_end.drag;
    let distance = from.distance(to);
    let at = |share: f64| from.lerp(to, share);
    // The limit is that at the cursor, whatever ends the way before.
    let at_cursor = if let DragEnd::Way(limit) = end { Err(limit) } else { to_any_end.land(at(1.0)) };
    let mut limit = match at_cursor {
        Ok(landing) => return write(to_any_end, &landing, DragStatus::Landed, result),
        Err(limit) => limit,
    };
    // The farthest of a few places at which the feature lands, then the last pixel before it no longer does.
    let share_of = |part: u32| f64::from(part) / f64::from(PARTS);
    let parts = (1..PARTS).rev().take_while(|part| end != DragEnd::Cursor && share_of(part + 1) > LEAST_SHARE);
    let mut reached = parts.map(share_of).find(|share| to_any_end.can_land(at(*share)));
    if let Some(share) = &mut reached {
        let mut beyond = *share + 1.0 / f64::from(PARTS);
        while (beyond - *share) * distance > 1.0 {
            let middle = f64::midpoint(*share, beyond);
            if to_any_end.can_land(at(middle)) { *share = middle } else { beyond = middle }
        }
    }
    let landed = reached.filter(|share| *share >= LEAST_SHARE).map(|share| (share, to_any_end.land(at(share))));
    if to_any_end.start.occlusion.work.is_exhausted() {
        limit = DragLimit::TooMuchWork;
    }
    match landed {
        Some((share, Ok(landing))) => {
            let residual_px = distance * (1.0 - share);
            write(to_any_end, &Landing { residual_px, ..landing }, DragStatus::Limited(limit), result);
        }
        _ => result.outcome.status = DragStatus::Refused(DragRefusal::Limited(limit)),
    }
}

fn write(to_any_end: &DragToAnyEnd, landing: &Landing, status: DragStatus, result: &mut DragResult) {
    let nodes = &to_any_end.start.occlusion.bvh.posed.scene.nodes;
    result.light = landing.light.light().clone();
    result.outcome.status = status;
    result.outcome.residual_px = landing.residual_px;
    result.outcome.iterations = landing.iterations;
    result.outcome.relaxed.clone_from(&landing.relaxed);
    result.outcome.pinned_change = to_any_end.largest_change_of_nodes(&landing.light);
    result.outcome.shadowed_by = landing.shadowed_by.map(|node| nodes[node].name.clone());
}
