//! Solves of commands whose result their scene determines: drags of features, and edits of lights with hard pins.

use drag::{NumberedPin, RadiusMode, WorkBudget, first_broken_pin};
use light::{LightId, SceneBounds};
use raycast::Bvh;

use crate::{
    Command, CommandContext, CommandSolution, Document, EditError, PinId, execute_command, solve_drag_budgeted,
};

/// Solves a command that needs a solution ([`crate::needs_solution`]) in its scene, whose bounds are `scene_bounds`.
/// Counts the steps in `work`. If `work` is cancelled, the solution has no meaning.
///
/// Errors are those of drags that [`crate::check_drag`] refuses. A command that is invalid for another reason than its
/// pins has the solution [`CommandSolution::PinsHold`], and its execution gives the error.
pub fn solve_command(
    document: &Document,
    command: &Command,
    scene_bounds: SceneBounds,
    bvh: &Bvh,
    work: &WorkBudget,
) -> Result<CommandSolution, EditError> {
    if let Command::DragFeature { light, drag } = command {
        let solved = solve_drag_budgeted(document, *light, drag, bvh, work)?;
        return Ok(CommandSolution::Drag(Box::new(solved)));
    }
    let context =
        CommandContext { scene_bounds, solved: Some(&CommandSolution::PinsHold), ..CommandContext::default() };
    let of_light = |document: &Document, id: LightId| document.lights().get(&id).map(|placed| placed.light.clone());
    let asked = command.light().and_then(|id| {
        let after = execute_command(document, command, context).ok()?.document;
        Some((id, of_light(document, id)?, of_light(&after, id)?))
    });
    let Some((id, before, after)) = asked else { return Ok(CommandSolution::PinsHold) };
    let pins = document.pins_of(id).map(|(id, pin)| NumberedPin { number: id.0, pin: pin.clone() });
    let pins: Vec<NumberedPin> = pins.collect();
    let Some(broken) = first_broken_pin(bvh, &before, &after, &pins, work) else {
        return Ok(CommandSolution::PinsHold);
    };
    let slide = match *command {
        Command::DragPoint { point, position, radii_follow, .. } => {
            let radii = if radii_follow { RadiusMode::Follow } else { RadiusMode::Keep };
            drag::slide_point_along_pins(bvh, &before, point, position, radii, &pins, work)
        }
        // A light does not slide in its size.
        Command::PlaceLight { translation, rotation, scale, .. }
            if scale.is_none_or(|scale| scale == before.light().transform().scale) =>
        {
            drag::place_along_pins(bvh, &before, translation, rotation, &pins, work)
        }
        _ => None,
    };
    Ok(slide.map_or(CommandSolution::PinBreaks(PinId(broken)), |slide| CommandSolution::Slid(Box::new(slide.light))))
}
