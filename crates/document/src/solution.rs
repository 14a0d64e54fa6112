//! Solutions of commands whose result only their scene determines, and the commands that need one.

use drag::DragResult;
use light::parameters::{POINT_COLOR, POINT_INTENSITY, SHADOW_COLOR};
use light::{CheckedLight, Parameter, ParameterTouches};

use crate::{Command, Document, EditError, PinId};

/// Part of a command's result that its scene determines.
#[derive(Clone, Debug, PartialEq)]
pub enum CommandSolution {
    /// Result of a drag of a feature.
    Drag(Box<DragResult>),
    /// The command keeps the hard pins of its light.
    PinsHold,
    /// Light that comes as near to what the command asks as the hard pins allow.
    Slid(Box<CheckedLight>),
    /// Hard pin that the command would break. It is refused.
    PinBreaks(PinId),
}

/// Returns true if `command` can only be executed with a [`CommandSolution`].
pub fn needs_solution(document: &Document, command: &Command) -> bool {
    matches!(command, Command::DragFeature { .. }) || checks_pins(document, command)
}

/// Returns true if `command` may break hard pins of its light in `document`: it may change where light arrives, from
/// where, or what blocks it. How bright or of what color the light is has no effect on pins.
pub fn checks_pins(document: &Document, command: &Command) -> bool {
    let (light, ignore_pins) = match command {
        Command::SetLight { light, setting, ignore_pins } | Command::SetPoint { light, setting, ignore_pins, .. } => {
            (light, *ignore_pins || !changes_arrival(setting.parameter))
        }
        Command::PlaceLight { light, ignore_pins, .. }
        | Command::DragPoint { light, ignore_pins, .. }
        | Command::InsertPoint { light, ignore_pins, .. }
        | Command::RemovePoint { light, ignore_pins, .. }
        | Command::BendLight { light, ignore_pins, .. }
        | Command::StraightenLight { light, ignore_pins } => (light, *ignore_pins),
        Command::LoadScene { .. }
        | Command::AddLight(_)
        | Command::RemoveLight(_)
        | Command::DragFeature { .. }
        | Command::AddPin(_)
        | Command::RemovePin(_)
        | Command::SetPin { .. }
        | Command::AddCamera(_)
        | Command::RemoveCamera(_)
        | Command::PlaceCamera { .. }
        | Command::SetCamera { .. } => return false,
    };
    !ignore_pins && document.pins_of(*light).any(|(_, pin)| pin.is_hard)
}

/// Returns an error if the command breaks a pin, or if it has no solution and needs one.
pub(crate) fn check_solution(
    document: &Document,
    command: &Command,
    solved: Option<&CommandSolution>,
) -> Result<(), EditError> {
    let Some(id) = command.light().filter(|_| checks_pins(document, command)) else { return Ok(()) };
    let light = document.light_name(id);
    match solved {
        Some(CommandSolution::PinsHold | CommandSolution::Slid(_)) => Ok(()),
        Some(CommandSolution::PinBreaks(pin)) => Err(EditError::PinBreaks { light, pin: document.pin_name(*pin) }),
        Some(CommandSolution::Drag(_)) | None => Err(EditError::NotSolved(light)),
    }
}

/// Returns the light that slid along its pins.
pub(crate) fn slid_light(solved: Option<&CommandSolution>) -> Option<&CheckedLight> {
    if let Some(CommandSolution::Slid(light)) = solved { Some(light) } else { None }
}

/// Returns true if a parameter of lights or control points changes where light arrives, from where, or what blocks it.
fn changes_arrival(parameter: &Parameter) -> bool {
    let is_of_amount = [SHADOW_COLOR.row(), POINT_COLOR.row(), POINT_INTENSITY.row()].contains(&parameter);
    parameter.touches() >= ParameterTouches::Radiance && !is_of_amount
}
