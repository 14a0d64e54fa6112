//! Measures the error of the pictures that were timed.

use light::{Light, LightInstance};
use render::{Renderer, ShadowSettings};
use scene::{Scene, View, ViewSlot};
use serde::Serialize;

use super::side::MeasuredBackend;
use crate::BenchError;
use crate::compare::{ComparisonSubject, ExpectedPicture, RenderedSubject, radiance_rmse_of_all};

/// Divisor of each side of a picture that is compared with the reference.
pub(super) const REFERENCE_DIVISOR: u32 = 4;

/// Error against the reference, excluding pixels near a shadow edge.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PictureError {
    /// Pixels of the compared picture.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Compared pixels: both pictures see the same surface, and no edge of any light is near.
    pub compared: usize,
    /// `sqrt(mean |picture - reference|^2) / sqrt(mean |reference|^2)` over the compared pixels.
    pub radiance_rmse: f64,
}

/// Error of a backend's picture.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BackendError {
    pub backend: &'static str,
    /// Error of a picture with a fourth of the width and height, under the bent light as it is before the edits.
    #[serde(flatten)]
    pub error: PictureError,
}

/// Measures each backend's picture of `scene` under all `lights` at once, none of which is straight. Leaves the
/// renderers with that scene without its fill.
pub(super) fn errors_of_backends(
    sides: &mut [MeasuredBackend],
    scene: &Scene,
    lights: &[Light],
    view: &View,
) -> Result<Vec<PictureError>, BenchError> {
    let subject = |light: &Light| ComparisonSubject::new("frame", scene.clone(), light.clone(), view.clone());
    let subjects: Vec<_> = lights.iter().map(subject).collect();
    let expected = subjects.iter().map(|subject| ExpectedPicture::new(subject, || {}));
    let expected = expected.collect::<Result<Vec<_>, _>>()?;
    sides.iter_mut().map(|side| error_of_renderer(&mut side.renderer, &subjects, &expected, view)).collect()
}

fn error_of_renderer(
    renderer: &mut Renderer,
    subjects: &[ComparisonSubject],
    expected: &[ExpectedPicture],
    view: &View,
) -> Result<PictureError, BenchError> {
    if let Some(first) = expected.first() {
        renderer.set_scene(first.posed())?;
    }
    let alone = subjects.iter().zip(expected).map(|(subject, expected)| {
        Ok(expected.compare(&RenderedSubject::new(renderer, subject, ShadowSettings::default())?))
    });
    let comparisons = alone.collect::<Result<Vec<_>, BenchError>>()?;
    let lights = LightInstance::numbered(subjects.iter().map(|subject| subject.light.clone()))?;
    let beauty = renderer.render(&View { fill: 0.0, ..view.clone() }, &lights)?;
    let (radiance_rmse, compared) = radiance_rmse_of_all(expected, &comparisons, &beauty);
    renderer.drop_view(ViewSlot::default());
    Ok(PictureError { width: view.width, height: view.height, compared, radiance_rmse })
}
