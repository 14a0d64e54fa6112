//! Measures random drags over scenes: the distance of features from the cursor and the time, in comparison with the
//! paper's formulas.

mod chart;
mod measured;
mod off;
mod paper;
mod picture;
mod stage;
#[cfg(test)]
mod tests;
mod trial;

use crate::{BenchError, Progress};

pub use measured::{DragBenchReport, DragErrors, Jumps, KeptShares, KindReport};
pub use off::{EquationError, distance_px};
pub use stage::TrialScene;
pub use trial::{FEATURES, Trial, TrialKind};

/// Makes `drags` random drags of every kind in each scene. Returns the report and the chart in SVG.
pub fn run(
    stages: &[TrialScene],
    drags: usize,
    seed: u64,
    progress: impl Fn(Progress),
) -> Result<(DragBenchReport, String), BenchError> {
    let (report, all) = measured::measure_trials(stages, drags, seed, progress);
    let chart = chart::draw(&all)?;
    Ok((report, chart))
}
