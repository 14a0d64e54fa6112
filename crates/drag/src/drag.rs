//! Drags of features: by what they name, or by alternatives.

use light::CheckedLight;
use raycast::Bvh;

use crate::alternatives::{drag_all, drag_chosen};
use crate::request::{Drag, DragResult, NumberedPin};
use crate::solve::{DragEnd, StartedTask};
use crate::start::DragTask;
use crate::work::WorkBudget;

/// Drags a feature of `light` from one point of a picture to another, and changes the rest of the picture as little as
/// it can. Keeps `pins` if the drag has none of its own.
///
/// If the feature does not land under the cursor, the result is that of the same drag to the last pixel of the straight
/// way at which it lands. With less than a third of the way, the drag is refused.
pub fn drag(bvh: &Bvh, light: &CheckedLight, drag: &Drag, pins: &[NumberedPin]) -> DragResult {
    drag_budgeted(bvh, light, drag, pins, &WorkBudget::new(&|_| true))
}

/// Drags a feature like [`drag`] and counts the steps in `work`. If `work` is cancelled, the result has no meaning.
pub fn drag_budgeted(
    bvh: &Bvh,
    light: &CheckedLight,
    drag: &Drag,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> DragResult {
    drag_chosen(DragTask { bvh, light, drag, pins: drag.pins.as_deref().unwrap_or(pins), work })
}

/// Solves a drag by each alternative that the light and the feature have. Returns the best first, then those that land,
/// are limited and are refused, each by what they change. Of those with the same picture, the first remains.
///
/// `drag.points` restricts the points that may move, and `drag.choice` has no effect. If `work` is cancelled, the results
/// have no meaning.
pub fn drag_alternatives(
    bvh: &Bvh,
    light: &CheckedLight,
    drag: &Drag,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> Vec<DragResult> {
    drag_all(DragTask { bvh, light, drag, pins: drag.pins.as_deref().unwrap_or(pins), work })
}

/// Drags a feature like [`drag`], but changes the light as little as it can, whatever that does to the picture: a
/// comparison by which benchmarks and tests show that the difference matters.
pub fn drag_least_change(bvh: &Bvh, light: &CheckedLight, drag: &Drag) -> DragResult {
    let work = WorkBudget::new(&|_| true);
    let task = DragTask { bvh, light, drag, pins: &[], work: &work };
    StartedTask::new(task, false).solved(drag, DragEnd::CursorOrWay)
}
