//! Do drags land? Random drags over scenes, where features end up, and what that takes.

mod off;
mod stage;
mod trial;

pub use off::{Off, distance_px};
pub use stage::Stage;
pub use trial::{FEATURES, Kind, Trial};
