//! Measures frames: the cost of each kind of edit, stage by stage; lights of this renderer and other renderers side by
//! side; and growth with scene, lights and picture size.
//!
//! A frame is [`render::Renderer::render_display`]: bytes of a screen, read back. Everything that is compared is
//! measured in turns. If the CPU shades the pictures, wgpu is measured too.

mod chart;
mod contest;
mod costs;
mod edit;
mod error;
mod growth;
mod side;
mod subject;
mod table;
#[cfg(test)]
mod tests;

use render::{Backend, ShadowSettings};
use scene::{Aov, View};
use serde::Serialize;

use self::error::REFERENCE_DIVISOR;
use self::side::MeasuredBackend;
use self::subject::FrameRequest;
use crate::{BenchError, Peers, Progress};

pub use contest::ComparedRenderer;
pub use costs::{Costs, StageCosts, WorkCounts};
pub use edit::{EditReport, FrameEdit};
pub use error::{BackendError, PictureError};
pub use growth::{GrowthAxis, GrowthCosts, GrowthPlan, GrowthPoint};
pub(crate) use side::backends;
pub use subject::FrameSubject;

/// Options of the benchmark of frame times.
#[derive(Clone, Copy, Debug)]
pub struct FrameBenchOptions<'a> {
    /// Frames of each kind, at least 1.
    pub repeats: usize,
    /// Number of lights in a crowd, of which one moves.
    pub crowd: usize,
    /// Backend that draws shadows and lights. `None` lets the device decide.
    pub backend: Option<Backend>,
    /// Other renderers to run for comparison.
    pub peers: Option<&'a Peers>,
    /// Numbers of triangles, lights, segments and pixels for which frame times are measured too; `None` for none.
    pub growth: Option<&'a GrowthPlan>,
}

/// Results of the benchmark of frame times.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct FrameBenchReport {
    /// Device, and the graphics API by which it is used.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// Backend that drew shadows and lights. If it is not wgpu, wgpu is measured too.
    pub backend: &'static str,
    pub scene: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Texels per side of a shadow map.
    pub shadow_resolution: u32,
    /// Pixels that see a surface inside the bent light, shadowed or not.
    pub pixels_in_tube: usize,
    /// Frames of each kind.
    pub repeats: usize,
    /// Costs of each edit of one bent light, by this backend and then by wgpu if that is another.
    pub edits: Vec<EditReport>,
    /// Errors of the pictures that each backend draws, in the order of the backends in `edits`.
    pub errors: Vec<BackendError>,
    /// Times of whole frames of different renderers and lights, which were measured in rotation. All are compared with
    /// the first, `bent`.
    pub side_by_side: Vec<ComparedRenderer>,
    /// Frame times by number of triangles, lights, segments and pixels; empty if they were not requested.
    pub growth: Vec<GrowthAxis>,
}

/// Measured renderers, and progress.
struct Bench<'a> {
    /// The measured backend, then wgpu if that is another.
    backends: Vec<MeasuredBackend>,
    options: FrameBenchOptions<'a>,
    progress: &'a dyn Fn(Progress),
    steps: usize,
    done: usize,
}

/// Measures `subject`. Returns the report and the chart in SVG.
pub fn run(
    subject: &FrameSubject,
    options: FrameBenchOptions,
    progress: &dyn Fn(Progress),
) -> Result<(FrameBenchReport, String), BenchError> {
    let sides = side::open_backends(options.backend, &subject.posed)?;
    let steps = options.repeats + 1 + contest::steps(&options) + options.growth.map_or(0, GrowthPlan::steps);
    let mut bench = Bench { backends: sides, options, progress, steps, done: 0 };
    let pixels_in_tube = bench.pixels_in_tube(subject)?;
    let edits = edit::measured(&mut bench, subject)?;
    let errors = bench.errors(subject)?;
    let side_by_side = contest::measured(&mut bench, subject)?;
    let growth = options.growth.map_or_else(|| Ok(Vec::new()), |plan| growth::measured(&mut bench, plan))?;
    let main = &bench.backends[0];
    let report = FrameBenchReport {
        adapter: main.device.name(),
        driver: main.device.driver().into(),
        backend: main.backend(),
        scene: subject.name.clone(),
        triangles: subject.posed.triangle_count(),
        width: subject.view.width,
        height: subject.view.height,
        shadow_resolution: ShadowSettings::default().resolution,
        pixels_in_tube,
        repeats: options.repeats,
        edits,
        errors,
        side_by_side,
        growth,
    };
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

impl Bench<'_> {
    fn step(&mut self, what: impl Into<String>) {
        (self.progress)(Progress { done: self.done, of: self.steps, what: what.into() });
        self.done += 1;
    }

    fn pixels_in_tube(&mut self, subject: &FrameSubject) -> Result<usize, BenchError> {
        let FrameRequest { view, lights } = subject.under(subject.bent.clone())?;
        let picture = self.backends[0].renderer.render(&View { aov: Aov::Visibility, ..view }, &lights)?;
        Ok(picture.pixels.iter().filter(|pixel| pixel[3] > 0.0).count())
    }

    /// Measures the error of each backend's picture of the bent light.
    fn errors(&mut self, subject: &FrameSubject) -> Result<Vec<BackendError>, BenchError> {
        self.step("error against the reference");
        let View { width, height, .. } = subject.view;
        let [width, height] = [width, height].map(|side| (side / REFERENCE_DIVISOR).max(1));
        let view = View { width, height, ..subject.view.clone() };
        let (scene, lights) = (&subject.posed.scene, [subject.bent.clone()]);
        let errors = error::errors_of_backends(&mut self.backends, scene, &lights, &view)?;
        let of_side = |(side, error): (&MeasuredBackend, _)| BackendError { backend: side.backend(), error };
        Ok(self.backends.iter().zip(errors).map(of_side).collect())
    }
}
