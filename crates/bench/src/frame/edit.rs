//! Measures the frames after each kind of edit.

use glam::DVec3;
use light::parameters::{COLOR, ENABLED, INTENSITY};
use light::{Light, LightError};
use render::{Recording, Renderer, StageCost, Stopwatch};
use scene::{View, ViewSlot};
use serde::Serialize;
use stream::MOVING_QUALITY;

use super::costs::{Costs, StageCosts, WorkCounts};
use super::side::timed;
use super::subject::{FrameRequest, FrameSubject, moved};
use super::{Bench, MeasuredBackend};
use crate::BenchError;

/// Edit that changes the picture before it into the measured one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum FrameEdit {
    /// First picture of a new view. Pipelines are compiled and the scene is on the device, but nothing else is cached.
    First,
    /// Position of the camera.
    Camera,
    /// Change of the light's position.
    LightMove,
    /// Position of the light's third control point.
    ControlPoint,
    /// Radius at the end of the light.
    Radius,
    Color,
    Intensity,
    /// The light is switched off.
    Mute,
    /// Nothing changed: the same picture is requested again.
    Idle,
}

/// Measurements of the frames after an edit. Before each of them the subject was drawn without the edit.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EditReport {
    pub backend: &'static str,
    pub edit: FrameEdit,
    /// Costs of a whole frame.
    pub frame: Costs,
    /// Encoding of the picture as the JPEG that a viewer would get; part of no stage and not of `frame`.
    pub encode: Costs,
    /// Costs of the same frame drawn stage by stage, with a wait for each, so that together they exceed `frame`.
    pub stages: Vec<StageCosts>,
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

    /// Returns the name for people.
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

    /// Returns the frame after the `k`th variant of the edit. No two variants are equal, and none equals the unedited
    /// subject.
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
        // The light's own length, light-local.
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

/// Measures every edit on each backend once, and repeats that, so that other work of the machine disturbs all of them
/// alike. Returns one row per edit of the first backend, then those of the other.
pub(super) fn measured(bench: &mut Bench, subject: &FrameSubject) -> Result<Vec<EditReport>, BenchError> {
    let mut measured: Vec<[EditMeasurements; FrameEdit::ALL.len()]> =
        bench.backends.iter().map(|_| Default::default()).collect();
    // Turn 0 compiles pipelines and is not timed.
    for k in 0..=bench.options.repeats {
        if k > 0 {
            bench.step("edits");
        }
        for (at, edit) in FrameEdit::ALL.into_iter().enumerate() {
            for (side, rows) in bench.backends.iter_mut().zip(&mut measured) {
                let mut turn = EditMeasurements::default();
                let taken = if k > 0 { &mut rows[at] } else { &mut turn };
                measure_frame(&mut side.renderer, subject, edit, k, taken)?;
            }
        }
    }
    let of_backend = |(side, rows): (&MeasuredBackend, [EditMeasurements; FrameEdit::ALL.len()])| {
        let edits = FrameEdit::ALL.into_iter().zip(rows);
        edits.map(|(edit, row)| row.report(side.backend(), edit)).collect::<Vec<_>>()
    };
    Ok(bench.backends.iter().zip(measured).flat_map(of_backend).collect())
}

/// Draws the frame after an edit, once whole and once stage by stage, and adds its times to `taken`.
fn measure_frame(
    renderer: &mut Renderer,
    subject: &FrameSubject,
    edit: FrameEdit,
    k: usize,
    taken: &mut EditMeasurements,
) -> Result<(), BenchError> {
    let (unedited, edited) = (subject.under(subject.bent.clone())?, edit.frame(subject, k)?);
    draw_unedited(renderer, edit, &unedited)?;
    let (bytes, frame) = timed(renderer, &edited)?;
    let mut watch = Stopwatch::start();
    let View { width, height, .. } = edited.view;
    stream::jpeg(&bytes, width as u16, height as u16, MOVING_QUALITY)?;
    taken.encodes.push(watch.lap());
    taken.frames.push(frame);
    draw_unedited(renderer, edit, &unedited)?;
    taken.recordings.push(renderer.record_display(&edited.view, &edited.lights)?.1);
    Ok(())
}

/// Draws the picture without the edit, or drops the view if the edit is a first frame.
fn draw_unedited(renderer: &mut Renderer, edit: FrameEdit, frame: &FrameRequest) -> Result<(), BenchError> {
    if edit == FrameEdit::First {
        renderer.drop_view(ViewSlot::default());
    } else {
        renderer.render_display(&frame.view, &frame.lights)?;
    }
    Ok(())
}

/// Measurements of all frames of an edit.
#[derive(Default)]
struct EditMeasurements {
    frames: Vec<StageCost>,
    encodes: Vec<StageCost>,
    recordings: Vec<Recording>,
}

impl EditMeasurements {
    fn report(self, backend: &'static str, edit: FrameEdit) -> EditReport {
        EditReport {
            backend,
            edit,
            frame: Costs::of(&self.frames),
            encode: Costs::of(&self.encodes),
            stages: StageCosts::of(&self.recordings),
            counted: self.recordings.last().map_or_else(WorkCounts::default, |last| last.counters.into()),
        }
    }
}
