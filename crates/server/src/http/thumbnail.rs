//! Small pictures of documents that a program considers, in answers of JSON.

use std::sync::Arc;
use std::time::Instant;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use document::Document;
use drag::Viewport;
use protocol::RenderFormat;
use render::{Background, PictureOrigin};
use scene::View;

use super::picture_files::{DrawnPictures, PictureFiles};
use super::render::draw;
use crate::ServerError;
use crate::background as in_background;
use crate::charges::Payer;
use crate::renderer::{PictureFormat, PictureRequest, PictureTicket, RenderLease, Urgency};
use crate::scenes::DecodedScene;
use crate::state::AppState;

/// Width of a thumbnail in pixels, and its samples per pixel: edges of shadows are smooth with a few.
const WIDTH: u32 = 160;
const SAMPLES: u32 = 4;

/// Draws the beauty of a document in a view, [`WIDTH`] pixels wide. Returns a PNG file in base64.
pub async fn draw_thumbnail(
    state: &AppState,
    session: (&str, &Arc<RenderLease>),
    document: &Document,
    scene: &DecodedScene,
    viewport: &Viewport,
) -> Result<String, ServerError> {
    let [width, height] = viewport.size;
    let height = (f64::from(WIDTH) * f64::from(height) / f64::from(width)).round().clamp(1.0, 4.0 * f64::from(WIDTH));
    let (name, lease) = session;
    let viewer = state.services.renders.lease();
    let beauty = View::beauty(viewport.camera.clone(), [WIDTH, height as u32]);
    let view = View { samples: SAMPLES, slot: viewer.slot(), ..beauty };
    let lights = document.light_instances();
    let files = PictureFiles::new(&[RenderFormat::Png], Background::Black, &view);
    let request = PictureRequest {
        scene: Arc::clone(&scene.posed),
        view: view.clone(),
        session: Arc::clone(lease),
        viewer,
        payer: Payer::program(name),
        lights: lights.clone(),
        output: PictureFormat::File(files.needs(view.aov)),
        urgency: Urgency::Still,
        ticket: PictureTicket::since(Instant::now()),
    };
    let (pixels, mut trace) = draw(state, name, request).await?;
    let drawn = DrawnPictures { view, lights, light: None, pixels };
    let png = in_background::run(move || {
        let began = Instant::now();
        let png = files.add(&drawn)?.finish(&drawn.view, &PictureOrigin::default());
        trace.encoded(began.elapsed());
        png
    });
    let (_, png) = png.await??;
    Ok(STANDARD.encode(png))
}
