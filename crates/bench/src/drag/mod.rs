//! Do drags land? Random drags over scenes, where features end up, and what that takes, beside the paper's formulas.

mod chart;
mod measured;
mod off;
mod paper;
mod stage;
#[cfg(test)]
mod tests;
mod trial;

pub use measured::{KindReport, Options, Report, Side, Spread, run};
pub use off::{Off, distance_px};
pub use stage::Stage;
pub use trial::{FEATURES, Kind, Trial};
