//! The edits that frames are drawn for.

use glam::DVec3;
use light::parameters::{COLOR, ENABLED, INTENSITY};
use light::{Light, LightError};
use serde::Serialize;

use super::subject::{Frame, Subject, moved};

/// What has changed since the picture before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Edit {
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

impl Edit {
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
    pub(super) fn frame(self, subject: &Subject, k: usize) -> Result<Frame, LightError> {
        let (sin, cos) = (0.2 * k as f64).sin_cos();
        let mut frame = subject.under(self.edited(subject, k))?;
        if self == Self::Camera {
            frame.view.camera.translation += subject.step() * DVec3::new(sin, 0.0, cos);
        }
        Ok(frame)
    }

    fn edited(self, subject: &Subject, k: usize) -> Light {
        let light = subject.bent.clone();
        let (sin, cos) = (0.2 * k as f64).sin_cos();
        // A light's own length, in its own units.
        let length = light.points().last().map_or(1.0, |point| point.position.length());
        let last = light.points().len().saturating_sub(1);
        match self {
            Self::First | Self::Camera | Self::Idle => light,
            Self::LightMove => moved(&light, k, subject.step()),
            Self::ControlPoint => light.with_points(|index, point| {
                if index == 2.min(last) {
                    point.position += 0.02 * length * DVec3::new(sin, cos, 0.0);
                }
            }),
            Self::Radius => light.with_points(|index, point| {
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
