//! Drags of features: the solution in a scene, and its changes to a document.

use drag::{Drag, DragLimit, DragRefusal, DragResult, DragStatus, SOLVER, WorkBudget};
use light::parameters::{ROTATION, TRANSLATION};
use light::{Light, LightId, MAX_NAME_BYTES};
use raycast::Bvh;

use crate::points::point_move_changes;
use crate::{Change, Document, DragOutcome, EditError, FeatureDrag, NumberedLight, PinId};

/// Maximum number of control points chosen for a drag. With more, hardly any drag converges within its work limit.
pub const MAX_CHOSEN_POINTS: usize = 128;

/// Solved drag of a feature.
#[derive(Clone, Debug, PartialEq)]
pub struct SolvedDrag {
    pub outcome: DragOutcome,
    /// Light at the end of the drag.
    light: Light,
}

/// Solves a drag of the light `id` of `document` in its scene. It takes some hundredths of a second, and some seconds
/// at most.
pub fn solve_drag(document: &Document, id: LightId, request: &FeatureDrag, bvh: &Bvh) -> Result<SolvedDrag, EditError> {
    solve_drag_budgeted(document, id, request, bvh, &WorkBudget::new(&|_| true))
}

/// Solves a drag as `solve_drag` does, and counts the steps in `work`. If `work` stops the drag, the result has no
/// meaning.
pub fn solve_drag_budgeted(
    document: &Document,
    id: LightId,
    request: &FeatureDrag,
    bvh: &Bvh,
    work: &WorkBudget,
) -> Result<SolvedDrag, EditError> {
    let placed = document.lights.get(&id).ok_or(EditError::NoLight(id))?;
    let FeatureDrag { feature, points, radii, view, from, to, source_outside } = request.clone();
    view.camera.check().map_err(EditError::InvalidCamera)?;
    if view.camera.name.len() > MAX_NAME_BYTES {
        return Err(EditError::TooLong { field: "name", limit: MAX_NAME_BYTES });
    }
    if points.as_ref().is_some_and(|points| points.len() > MAX_CHOSEN_POINTS) {
        return Err(EditError::TooManyChosen { what: "control points", limit: MAX_CHOSEN_POINTS });
    }
    if view.size.contains(&0) || !(from.is_finite() && to.is_finite()) {
        return Err(EditError::EmptyViewport);
    }
    let (ids, pins): (Vec<_>, Vec<_>) = document.pins_of(id).map(|(id, pin)| (id, pin.clone())).unzip();
    let drag = Drag { feature, points, radii, from, to, pins, source_outside };
    let result = drag::drag_budgeted(bvh, &view, &placed.light, &drag, work);
    let name = |pin: usize| ids.get(pin).map_or(pin, |id| id.0 as usize);
    let status = match result.status {
        DragStatus::Limited(DragLimit::Pin(pin)) => DragStatus::Limited(DragLimit::Pin(name(pin))),
        DragStatus::Refused(DragRefusal::PinDoesNotHold(pin)) => {
            DragStatus::Refused(DragRefusal::PinDoesNotHold(name(pin)))
        }
        status => status,
    };
    let DragResult { light, residual_px, iterations, from_world, to_world, pivot_world, .. } = result;
    let shadowed_by = result.shadowed_by.map(|node| bvh.posed.scene.nodes[node].name.clone());
    let (solver, version) = SOLVER;
    let outcome = DragOutcome {
        solver: solver.into(),
        version,
        status,
        residual_px,
        shadowed_by,
        iterations,
        from_world,
        to_world,
        pivot_world,
    };
    Ok(SolvedDrag { outcome, light })
}

/// Returns the changes that give the document's light the placement or the control points of the solved light.
pub(crate) fn feature_drag_changes(
    document: &Document,
    id: LightId,
    placed: &NumberedLight,
    solved: &SolvedDrag,
) -> Result<Vec<Change>, EditError> {
    if let DragStatus::Refused(reason) = solved.outcome.status {
        let light = document.light_name(id);
        return Err(match reason {
            DragRefusal::PinDoesNotHold(pin) => {
                EditError::PinDoesNotHold { light, pin: document.pin_name(PinId(pin as u64)) }
            }
            reason => EditError::DragRefused { light, reason },
        });
    }
    let (light, moved) = (placed.light.light(), &solved.light);
    let placement = [TRANSLATION.row(), ROTATION.row()].into_iter().filter_map(|parameter| {
        let (old, new) = (light.value(parameter)?.clone(), moved.value(parameter)?.clone());
        Some(Change::LightParameter { light: id, parameter, old, new })
    });
    // Changes of points that did not move have equal values and are dropped later.
    Ok(placement.chain(point_move_changes(id, placed, moved.points())).collect())
}
