//! Do drags land? Random drags over scenes, where features end up, and what that takes, beside the paper's formulas.

mod chart;
mod measured;
mod off;
mod paper;
mod stage;
#[cfg(test)]
mod tests;
mod trial;

use crate::{BenchError, Progress};

pub use measured::{KindReport, Options, Report, Side};
pub use off::{Off, distance_px};
pub use stage::Stage;
pub use trial::{FEATURES, Kind, Trial};

/// Makes random drags of every kind in each scene. Returns what was measured and the chart, an SVG.
pub fn run(
    stages: &[Stage],
    options: Options,
    progress: impl Fn(Progress),
) -> Result<(Report, String), BenchError> {
    let (report, all) = measured::measured(stages, options, progress);
    let chart = chart::draw(&all)?;
    Ok((report, chart))
}
