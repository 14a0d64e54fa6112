//! A pin: what is to stay as it is while a light is dragged.

use std::fmt;

use drag::DragPin;
use light::LightId;

/// Identifies a pin for as long as a session lives. Never used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PinId(pub u64);

/// A pin and the light that it holds. It outlives the light where undo takes that away, holds nothing meanwhile, and holds again
/// once redo brings it back.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPin {
    /// The light of which something stays.
    pub light: LightId,
    /// What stays of it, and where.
    pub pin: DragPin,
}

impl fmt::Display for PinId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
