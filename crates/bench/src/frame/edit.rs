//! The edits that frames are drawn for, and what those frames take.

use glam::DVec3;
use light::parameters::{COLOR, ENABLED, INTENSITY};
use light::{Light, LightError};
use render::{Recording, Renderer, StageCost, Stopwatch};
use scene::{View, ViewSlot};
use serde::Serialize;
use stream::MOVING_QUALITY;

use super::Bench;
use super::costs::{Costs, StageCosts, WorkCounts};
use super::side::timed;
use super::subject::{FrameRequest, FrameSubject, moved};
use crate::BenchError;

/// What has changed since the picture before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum FrameEdit {
    /// All of it: nobody has looked before. Pipelines are compiled, and the scene is on the device.
    First,
    /// Where it is seen from.
    Camera,
    /// Where the light stands.
    LightMove,
    /// Where its third control point is.
    ControlPoint,
    /// How wide it ends.
    Radius,
    /// What colour it has.
    Color,
    /// How bright it is.
    Intensity,
    /// That it shines: it is switched off.
    Mute,
    /// Nothing: the same picture is asked for again.
    Idle,
}

/// The frames after an edit. Before each of them the subject was drawn as it is without the edit.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EditReport {
    /// Who drew them.
    pub backend: &'static str,
    /// What was changed.
    pub edit: FrameEdit,
    /// Of a whole frame.
    pub frame: Costs,
    /// The JPEG that the picture would go to a viewer as; in no stage and not in `frame`.
    pub encode: Costs,
    /// The same frame drawn stage by stage, each waited for, so that together they take longer than `frame`.
    pub stages: Vec<StageCosts>,
    /// How much a frame has worked on.
    #[serde(flatten)]
    pub counted: WorkCounts,
}

impl FrameEdit {
    /// Every edit, in the order of reports.
    pub const ALL: [Self; 9] = [
        Self::First,
        Self::Camera,
        Self::LightMove,
        Self::ControlPoint,
        Self::Radius,
        Self::Color,
        Self::Intensity,
        Self::Mute,
        Self::Idle,
    ];

    /// What it is called for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::First => "first frame",
            Self::Camera => "camera",
            Self::LightMove => "light move",
            Self::ControlPoint => "control point",
            Self::Radius => "radius",
            Self::Color => "color",
            Self::Intensity => "intensity",
            Self::Mute => "mute",
            Self::Idle => "idle",
        }
    }

    /// The frame after the edit's `k`th form. No two forms are alike, and none is the subject as it was.
    pub(super) fn frame(self, subject: &FrameSubject, k: usize) -> Result<FrameRequest, LightError> {
        let (sin, cos) = (0.2 * k as f64).sin_cos();
        let mut frame = subject.under(self.edited(subject, k))?;
        if self == Self::Camera {
            frame.view.camera.translation += subject.step() * DVec3::new(sin, 0.0, cos);
        }
        Ok(frame)
    }

    fn edited(self, subject: &FrameSubject, k: usize) -> Light {
        let light = subject.bent.clone();
        let (sin, cos) = (0.2 * k as f64).sin_cos();
        // A light's own length, in its own units.
        let length = light.points().last().map_or(1.0, |point| point.position.length());
        let last = light.points().len().saturating_sub(1);
        match self {
            Self::First | Self::Camera | Self::Idle => light,
            Self::LightMove => moved(&light, k, subject.step()),
            Self::ControlPoint => light.map_points(|index, point| {
                if index == 2.min(last) {
                    point.position += 0.02 * length * DVec3::new(sin, cos, 0.0);
                }
            }),
            Self::Radius => light.map_points(|index, point| {
                if index == last {
                    point.radius *= 1.03 + 0.02 * sin;
                }
            }),
            Self::Color => {
                let color = light.get(COLOR) * DVec3::new(1.0, 0.9 + 0.05 * sin, 0.8 + 0.05 * cos);
                light.with(COLOR, color)
            }
            Self::Intensity => {
                let intensity = light.get(INTENSITY) * (1.2 + 0.1 * sin);
                light.with(INTENSITY, intensity)
            }
            Self::Mute => light.with(ENABLED, false),
        }
    }
}

/// Every edit in turn by each side, again and again: what else the machine does hits all of them. A row an edit of the
/// first side, then those of the other.
pub(super) fn measured(bench: &mut Bench, subject: &FrameSubject) -> Result<Vec<EditReport>, BenchError> {
    let rows = |side: &super::MeasuredBackend| {
        FrameEdit::ALL.map(|edit| EditMeasurements::new(side.backend(), edit))
    };
    let mut measured: Vec<EditMeasurements> = bench.backends.iter().flat_map(rows).collect();
    // The zeroth turn compiles pipelines and is thrown away.
    for k in 0..=bench.options.repeats {
        if k > 0 {
            bench.step("edits");
        }
        for (at, edit) in FrameEdit::ALL.into_iter().enumerate() {
            for (side, rows) in bench.backends.iter_mut().zip(measured.chunks_mut(FrameEdit::ALL.len())) {
                let taken = measure_frame(&mut side.renderer, subject, edit, k)?;
                if k > 0 {
                    rows[at].add(taken);
                }
            }
        }
    }
    Ok(measured.into_iter().map(EditMeasurements::report).collect())
}

/// What a frame after an edit took.
struct MeasuredFrame {
    frame: StageCost,
    encode: StageCost,
    recording: Recording,
}

/// The frame after an edit, whole and stage by stage.
fn measure_frame(
    renderer: &mut Renderer,
    subject: &FrameSubject,
    edit: FrameEdit,
    k: usize,
) -> Result<MeasuredFrame, BenchError> {
    let (unedited, edited) = (subject.under(subject.bent.clone())?, edit.frame(subject, k)?);
    draw_unedited(renderer, edit, &unedited)?;
    let (bytes, frame) = timed(renderer, &edited)?;
    let mut watch = Stopwatch::start();
    let View { width, height, .. } = edited.view;
    stream::jpeg(&bytes, width as u16, height as u16, MOVING_QUALITY)?;
    let encode = watch.lap();
    draw_unedited(renderer, edit, &unedited)?;
    let (_, recording) = renderer.record_display(&edited.view, &edited.lights)?;
    Ok(MeasuredFrame { frame, encode, recording })
}

/// The picture without the edit, or none.
fn draw_unedited(renderer: &mut Renderer, edit: FrameEdit, frame: &FrameRequest) -> Result<(), BenchError> {
    if edit == FrameEdit::First {
        renderer.drop_view(ViewSlot::default());
    } else {
        renderer.render_display(&frame.view, &frame.lights)?;
    }
    Ok(())
}

/// What is known of an edit's frames.
struct EditMeasurements {
    backend: &'static str,
    edit: FrameEdit,
    frames: Vec<StageCost>,
    encodes: Vec<StageCost>,
    recordings: Vec<Recording>,
}

impl EditMeasurements {
    fn new(backend: &'static str, edit: FrameEdit) -> Self {
        Self { backend, edit, frames: Vec::new(), encodes: Vec::new(), recordings: Vec::new() }
    }

    fn add(&mut self, MeasuredFrame { frame, encode, recording }: MeasuredFrame) {
        self.frames.push(frame);
        self.encodes.push(encode);
        self.recordings.push(recording);
    }

    fn report(self) -> EditReport {
        EditReport {
            backend: self.backend,
            edit: self.edit,
            frame: Costs::of(&self.frames),
            encode: Costs::of(&self.encodes),
            stages: StageCosts::of(&self.recordings),
            counted: self.recordings.last().map_or_else(WorkCounts::default, |last| last.counters.into()),
        }
    }
}
