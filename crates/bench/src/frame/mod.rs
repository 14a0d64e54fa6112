//! Where does a frame's time go? What each kind of edit costs, stage by stage; lights of ours and other renderers beside
//! each other; and how frames grow with what they show.
//!
//! A frame is [`Renderer::render_display`]: bytes of a screen, read back. Everything that is compared is measured in turns.

mod chart;
mod contest;
mod costs;
mod edit;
mod growth;
mod peers;
mod subject;
mod table;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use render::{Backend, Cost, Gpu, MemoryBudget, Recording, Renderer, ShadowSettings, Stopwatch};
use scene::{Aov, View, ViewSlot};
use serde::Serialize;
use stream::MOVING_QUALITY;

use self::subject::Frame;
use crate::BenchError;

pub use contest::Contestant;
pub use costs::{Costs, Counted, Spread, StageCosts};
pub use edit::Edit;
pub use growth::{Axis, GrowthError, GrowthPlan, Point};
pub use peers::Peers;
pub use subject::Subject;

/// What to measure.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Frames of each kind, at least 1.
    pub repeats: usize,
    /// Lights of the crowd of which one moves.
    pub crowd: usize,
    /// Who draws; as the device is where nobody says.
    pub backend: Option<Backend>,
    /// Other renderers to run beside.
    pub peers: Option<&'a Peers>,
    /// Along which axes frames are to grow.
    pub growth: Option<&'a GrowthPlan>,
}

/// How far a measurement is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Steps that are done.
    pub done: usize,
    /// Of so many.
    pub of: usize,
    /// What is measured.
    pub what: String,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Report {
    /// Device, and the interface that it is used by.
    pub adapter: String,
    /// The driver and its version.
    pub driver: String,
    /// Who drew shadows and lights.
    pub backend: &'static str,
    /// What was drawn.
    pub scene: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Texels along each side of a map.
    pub shadow_resolution: u32,
    /// Pixels that see a surface inside the bent light, shadowed or not.
    pub pixels_in_tube: usize,
    /// Frames of each kind.
    pub repeats: usize,
    /// What each edit of one bent light costs.
    pub edits: Vec<EditReport>,
    /// Whole frames of different renderers and lights, in turns; `bent`, the first, is what the others are compared by.
    pub side_by_side: Vec<Contestant>,
    /// How frames grow with what they show; empty where that was not asked for.
    pub growth: Vec<Axis>,
}

/// The frames after an edit. Before each of them the subject was drawn as it is without the edit.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EditReport {
    /// What was changed.
    pub edit: Edit,
    /// Of a whole frame.
    pub frame: Costs,
    /// The JPEG that the picture would go to a viewer as; in no stage and not in `frame`.
    pub encode: Costs,
    /// The same frame drawn stage by stage, each waited for, so that together they take longer than `frame`.
    pub stages: Vec<StageCosts>,
    /// How much a frame has worked on.
    #[serde(flatten)]
    pub counted: Counted,
}

/// What does the measuring: a renderer, and how far it is.
struct Bench<'a> {
    gpu: Arc<Gpu>,
    renderer: Renderer,
    options: Options<'a>,
    progress: &'a dyn Fn(Progress),
    steps: usize,
    done: usize,
}

/// Measures `subject`. Returns what was measured and the chart, an SVG.
pub fn run(
    subject: &Subject,
    options: Options,
    progress: &dyn Fn(Progress),
) -> Result<(Report, String), BenchError> {
    let gpu = Arc::new(Gpu::open(MemoryBudget::default(), options.backend)?);
    let mut renderer = Renderer::new(Arc::clone(&gpu))?;
    renderer.set_scene(&subject.scene)?;
    let steps = options.repeats + contest::steps(&options) + options.growth.map_or(0, GrowthPlan::steps);
    let mut bench = Bench { gpu, renderer, options, progress, steps, done: 0 };
    let pixels_in_tube = bench.pixels_in_tube(subject)?;
    let edits = bench.edits(subject)?;
    let side_by_side = contest::measured(&mut bench, subject)?;
    let growth = options.growth.map_or_else(|| Ok(Vec::new()), |plan| growth::measured(&mut bench, plan))?;
    let report = Report {
        adapter: bench.gpu.adapter_name().into(),
        driver: bench.gpu.driver().into(),
        backend: bench.gpu.backend().name(),
        scene: subject.name.clone(),
        triangles: subject.scene.triangle_count(),
        width: subject.view.width,
        height: subject.view.height,
        shadow_resolution: ShadowSettings::default().resolution,
        pixels_in_tube,
        repeats: options.repeats,
        edits,
        side_by_side,
        growth,
    };
    let chart = chart::draw(&report).map_err(|why| BenchError::Chart(why.to_string()))?;
    Ok((report, chart))
}

/// What a whole frame takes, and its bytes.
fn timed(renderer: &mut Renderer, frame: &Frame) -> Result<(Vec<u8>, Cost), BenchError> {
    let mut watch = Stopwatch::start();
    let bytes = renderer.render_display(&frame.view, &frame.lights)?;
    Ok((bytes, watch.lap()))
}

impl Bench<'_> {
    fn step(&mut self, what: impl Into<String>) {
        (self.progress)(Progress { done: self.done, of: self.steps, what: what.into() });
        self.done += 1;
    }

    fn pixels_in_tube(&mut self, subject: &Subject) -> Result<usize, BenchError> {
        let Frame { view, lights } = subject.under(subject.bent.clone())?;
        let picture = self.renderer.render(&View { aov: Aov::Visibility, ..view }, &lights)?;
        Ok(picture.pixels.iter().filter(|pixel| pixel[3] > 0.0).count())
    }

    /// Every edit in turn, again and again: what else the machine does hits all of them.
    fn edits(&mut self, subject: &Subject) -> Result<Vec<EditReport>, BenchError> {
        let mut measured: Vec<Measured> = Edit::ALL.map(Measured::new).into();
        // The zeroth turn compiles pipelines and is thrown away.
        for k in 0..=self.options.repeats {
            if k > 0 {
                self.step("edits");
            }
            for measured in &mut measured {
                let (frame, encode, recording) = self.edit(subject, measured.edit, k)?;
                if k > 0 {
                    measured.frames.push(frame);
                    measured.encodes.push(encode);
                    measured.recordings.push(recording);
                }
            }
        }
        Ok(measured.into_iter().map(Measured::report).collect())
    }

    /// The frame after an edit, whole and stage by stage.
    fn edit(
        &mut self,
        subject: &Subject,
        edit: Edit,
        k: usize,
    ) -> Result<(Cost, Cost, Recording), BenchError> {
        let (before, after) = (subject.under(subject.bent.clone())?, edit.frame(subject, k)?);
        self.before(edit, &before)?;
        let (bytes, frame) = timed(&mut self.renderer, &after)?;
        let mut watch = Stopwatch::start();
        let View { width, height, .. } = after.view;
        stream::jpeg(&bytes, width as u16, height as u16, MOVING_QUALITY)?;
        let encode = watch.lap();
        self.before(edit, &before)?;
        let (_, recording) = self.renderer.record_display(&after.view, &after.lights)?;
        Ok((frame, encode, recording))
    }

    /// The picture without the edit, or none.
    fn before(&mut self, edit: Edit, frame: &Frame) -> Result<(), BenchError> {
        if edit == Edit::First {
            self.renderer.forget(ViewSlot::default());
        } else {
            self.renderer.render_display(&frame.view, &frame.lights)?;
        }
        Ok(())
    }
}

/// What is known of an edit's frames.
struct Measured {
    edit: Edit,
    frames: Vec<Cost>,
    encodes: Vec<Cost>,
    recordings: Vec<Recording>,
}

impl Measured {
    fn new(edit: Edit) -> Self {
        Self { edit, frames: Vec::new(), encodes: Vec::new(), recordings: Vec::new() }
    }

    fn report(self) -> EditReport {
        EditReport {
            edit: self.edit,
            frame: Costs::of(&self.frames),
            encode: Costs::of(&self.encodes),
            stages: StageCosts::of(&self.recordings),
            counted: self.recordings.last().map_or_else(Counted::default, |last| last.counters.into()),
        }
    }
}

impl Report {
    /// Tables for a terminal.
    pub fn table(&self) -> String {
        table::of(self)
    }
}
