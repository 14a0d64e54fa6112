//! Pins: conditions that stay true while a light is dragged.

use std::fmt;

use drag::DragPin;
use light::LightId;

/// Identifies a pin for the life of its session. It is never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PinId(pub u64);

/// Pin with its light. If an undo removes the light, the pin stays without effect until a redo restores the light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPin {
    pub light: LightId,
    pub pin: DragPin,
}

impl fmt::Display for PinId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
