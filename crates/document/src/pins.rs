//! Addition, change and removal of pins.

use drag::{DragPin, PinTarget};
use light::LightId;
use scene::MAX_PATH_BYTES;

use crate::{Change, Document, EditError, LightPin, PinId};

/// Maximum number of pins in a document.
pub const MAX_PINS: usize = 256;

impl Document {
    /// Returns the pins of a light, in the order of their ids.
    pub fn pins_of(&self, light: LightId) -> impl Iterator<Item = (PinId, &DragPin)> {
        self.pins.iter().filter(move |(_, held)| held.light == light).map(|(id, held)| (*id, &held.pin))
    }
}

/// Makes the change that adds a pin. Drags check its condition, since the scene is not available here.
pub(crate) fn pin_addition(document: &Document, pin: &LightPin) -> Result<Change, EditError> {
    if !document.lights.contains_key(&pin.light) {
        return Err(EditError::NoLight(pin.light));
    }
    Ok(Change::Pin { pin: PinId(document.next_number()), old: None, new: Some(pin.clone()) })
}

/// Makes the change of the pin `id`. `edit` gets the pin and returns the new one, or `None` to remove it.
pub(crate) fn pin_change(
    document: &Document,
    id: PinId,
    edit: impl FnOnce(LightPin) -> Option<LightPin>,
) -> Result<Change, EditError> {
    let old = document.pins.get(&id).ok_or(EditError::NoPin(id))?.clone();
    Ok(Change::Pin { pin: id, new: edit(old.clone()), old: Some(old) })
}

/// Makes the changes that remove all pins for which `goes` is true.
pub(crate) fn pin_removals(document: &Document, goes: impl Fn(&LightPin) -> bool) -> Vec<Change> {
    let gone = document.pins.iter().filter(|(_, pin)| goes(pin));
    gone.map(|(&pin, old)| Change::Pin { pin, old: Some(old.clone()), new: None }).collect()
}

/// Checks that a pin is within limits.
pub(crate) fn check_pin(held: &LightPin) -> Result<(), EditError> {
    check_drag_pin(&held.pin)
}

/// Checks that a pin of a drag is within limits.
pub(crate) fn check_drag_pin(pin: &DragPin) -> Result<(), EditError> {
    let DragPin { at, caster, .. } = pin;
    if caster.as_ref().is_some_and(|caster| caster.len() > MAX_PATH_BYTES) {
        return Err(EditError::TooLong { field: "caster", limit: MAX_PATH_BYTES });
    }
    match at {
        PinTarget::Point(at) if !at.is_finite() => Err(EditError::InvalidPin),
        PinTarget::Node(node) if node.len() > MAX_PATH_BYTES => {
            Err(EditError::TooLong { field: "at", limit: MAX_PATH_BYTES })
        }
        PinTarget::Point(_) | PinTarget::Node(_) => Ok(()),
    }
}
