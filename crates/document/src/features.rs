//! Drags of features: the solution in a scene, and its changes to a document.

use std::sync::Arc;

use drag::{Drag, DragLimit, DragRefusal, DragResult, DragStatus, LightCopy, NumberedPin, WorkBudget};
use light::parameters::{LIGHT_LINK, NAME, ROTATION, TRANSLATION};
use light::{CheckedLight, LightId, MAX_NAME_BYTES};
use raycast::Bvh;

use crate::pins::{check_drag_pin, pin_change};
use crate::points::point_move_changes;
use crate::{Change, Document, EditError, LightPin, MAX_PINS, NumberedLight, PinId};

/// Maximum number of control points chosen for a drag. With more, hardly any drag converges within its work limit.
pub const MAX_CHOSEN_POINTS: usize = 128;

/// Solves a drag of the light `id` of `document` in its scene. A pin of the document is numbered by its id. It takes
/// some hundredths of a second, and some seconds at most.
pub fn solve_drag(document: &Document, id: LightId, drag: &Drag, bvh: &Bvh) -> Result<DragResult, EditError> {
    solve_drag_budgeted(document, id, drag, bvh, &WorkBudget::new(&|_| true))
}

/// Solves a drag as `solve_drag` does, and counts the steps in `work`. If `work` stops the drag, the result has no
/// meaning.
pub fn solve_drag_budgeted(
    document: &Document,
    id: LightId,
    drag: &Drag,
    bvh: &Bvh,
    work: &WorkBudget,
) -> Result<DragResult, EditError> {
    let placed = document.lights.get(&id).ok_or(EditError::NoLight(id))?;
    check_drag(drag)?;
    let pins = document.pins_of(id).map(|(id, pin)| NumberedPin { number: id.0, pin: pin.clone() });
    Ok(drag::drag_budgeted(bvh, &placed.light, drag, &pins.collect::<Vec<_>>(), work))
}

/// Checks that a drag is within limits.
pub fn check_drag(drag: &Drag) -> Result<(), EditError> {
    let Drag { points, view, from, to, pins, .. } = drag;
    view.camera.check().map_err(EditError::InvalidCamera)?;
    if view.camera.name.len() > MAX_NAME_BYTES {
        return Err(EditError::TooLong { field: "name", limit: MAX_NAME_BYTES });
    }
    let counts = [
        ("control points", points.as_ref().map_or(0, Vec::len), MAX_CHOSEN_POINTS),
        ("pins", pins.as_ref().map_or(0, Vec::len), MAX_PINS),
    ];
    if let Some((what, _, limit)) = counts.into_iter().find(|(_, count, limit)| count > limit) {
        return Err(EditError::TooManyChosen { what, limit });
    }
    if view.size.contains(&0) || !(from.is_finite() && to.is_finite()) {
        return Err(EditError::EmptyViewport);
    }
    pins.iter().flatten().try_for_each(|pin| check_drag_pin(&pin.pin))
}

/// Returns the changes that give the document's light the placement or the control points of the solved light.
pub(crate) fn feature_drag_changes(
    document: &Document,
    id: LightId,
    placed: &NumberedLight,
    solved: &DragResult,
) -> Result<Vec<Change>, EditError> {
    if let DragStatus::Refused(reason) = solved.outcome.status {
        let light = document.light_name(id);
        return Err(match reason {
            DragRefusal::PinDoesNotHold(pin) => EditError::PinDoesNotHold { light, pin: document.pin_name(PinId(pin)) },
            DragRefusal::Limited(DragLimit::Pin(pin)) => {
                EditError::PinLimits { light, pin: document.pin_name(PinId(pin)) }
            }
            reason => EditError::DragRefused { light, reason },
        });
    }
    let (light, moved) = (placed.light.light(), &solved.light);
    let placement = [TRANSLATION.row(), ROTATION.row(), LIGHT_LINK.row()].into_iter().filter_map(|parameter| {
        let (old, new) = (light.value(parameter)?.clone(), moved.value(parameter)?.clone());
        Some(Change::LightParameter { light: id, parameter, old, new })
    });
    // Changes of points that did not move have equal values and are dropped later.
    let moves = placement.chain(point_move_changes(id, placed, moved.points()));
    let added = solved.copy.as_ref().map_or(Ok(Vec::new()), |copy| copy_changes(document, copy))?;
    Ok(moves.chain(added).collect())
}

/// Returns the changes that add a copy of a light, with the pins that hold on what it illuminates.
fn copy_changes(document: &Document, copy: &LightCopy) -> Result<Vec<Change>, EditError> {
    let invalid = |reason| EditError::InvalidLight { light: copy.light.get(NAME), reason };
    let light = CheckedLight::new(copy.light.clone()).map_err(invalid)?;
    let number = document.next_number();
    let moved_pin =
        |pin: &u64| pin_change(document, PinId(*pin), |held| Some(LightPin { light: LightId(number), ..held }));
    let pins = copy.pins.iter().map(moved_pin).collect::<Result<Vec<_>, _>>()?;
    Ok([vec![Change::added_light(number, &Arc::new(light))], pins].concat())
}
