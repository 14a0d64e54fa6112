//! `GET /sessions/S/render`: a picture of the document, as it is or as it was.

use std::sync::Arc;
use std::time::Instant;

use axum::extract::State;
use axum::http::{HeaderName, HeaderValue, Uri, header};
use axum::response::IntoResponse;
use document::Document;
use protocol::{
    FrameQuality, RenderFormat, RenderLimits, RenderParameters, RenderRequest, TraceLine, TraceWhat,
};
use render::{PictureFormat, RenderError};
use scene::{Camera, framing_camera};

use super::answer::Answer;
use super::read::{SessionName, read_query};
use crate::ServerError;
use crate::background;
use crate::picture_stats::{micros, on_the_wire};
use crate::renderer::{Lease, Output, Place, Request, Urgency};
use crate::room::{Message, Snapshot};
use crate::scenes::Decoded;
use crate::state::AppState;
use crate::turns::Payer;

/// The header that tells what a picture lacks.
const NOTE: HeaderName = HeaderName::from_static("x-bendylights-note");

/// The picture that the address asks for. It waits behind the views.
pub async fn render(State(state): State<Arc<AppState>>, SessionName(name): SessionName, uri: Uri) -> Answer {
    let query: RenderParameters = read_query(&uri)?;
    let (seq, format) = (query.at, query.format);
    let asked = query.request()?;
    let _permit = state.stills.take(&name)?;
    let Snapshot { name, mut document, mut scene, lease: session, .. } =
        state.rooms.find(&name).await?.request(Message::Snapshot).await?;
    let session_name = name.clone();
    if let Some(seq) = seq {
        let replayed = state.backend.storage.read(move |store| store.replay(&name, Some(seq)));
        document = replayed.await?.document().clone();
        scene = state.backend.scenes.of(&document).await?;
    }
    let notes = headers(&document, &scene);
    let picture_format = match format {
        RenderFormat::Png => PictureFormat::Png,
        RenderFormat::Exr => PictureFormat::Exr,
    };
    let leases = (session, state.backend.renders.lease());
    let payer = Payer::program(&session_name);
    let request = request(&asked, picture_format, (&document, &scene), (leases, payer))?;
    let (view, lights, asked_at) = (request.view.clone(), request.lights.clone(), Instant::now());
    let drawn = state.backend.renders.draw(request).await;
    // Of a server that stops, the renderer's end is no fault.
    let stopped = matches!(drawn, Err(ServerError::Fault)) && state.backend.draining.is_cancelled();
    let drawn = if stopped { Err(ServerError::Draining) } else { drawn }?;
    let trace = state.backend.trace.drawn(|| TraceLine {
        time: drawn.started.saturating_duration_since(state.backend.started).as_secs_f64(),
        session: session_name,
        what: TraceWhat::Still {},
        size: [view.width, view.height],
        quality: FrameQuality::Settled,
        wait_us: micros(drawn.started.saturating_duration_since(asked_at)),
        render_us: micros(drawn.took),
        encode_us: None,
        passes: on_the_wire(&drawn.passes),
        left_out: 0,
    });
    // Compressing takes seconds, in which the renderer can draw for others.
    let file = background::run(move || {
        let began = Instant::now();
        let file = drawn.pixels.into_file(&view, &lights, picture_format)?;
        trace.encoded(began.elapsed());
        Ok::<_, RenderError>(file)
    });
    let file = file.await??;
    let kind = match format {
        RenderFormat::Png => "image/png",
        RenderFormat::Exr => "image/x-exr",
    };
    let mut response = ([(header::CONTENT_TYPE, kind)], file).into_response();
    for note in notes {
        response.headers_mut().append(NOTE, note);
    }
    Ok(response)
}

/// What the picture lacks: the notes of its scene, and a sentence for each light that it leaves out.
fn headers(document: &Document, scene: &Decoded) -> Vec<HeaderValue> {
    let left_out = scene.posed.reach().left_out(document.lights().values().map(|placed| &*placed.light));
    let sentences = scene.notes.iter().cloned().chain(left_out.into_iter().map(|why| why.to_string()));
    // Names can have any letters; a header's value has those of ASCII.
    let plain = |sentence: String| sentence.replace(|c: char| !matches!(c, ' '..='~'), "?");
    sentences.filter_map(|sentence| HeaderValue::from_str(&plain(sentence)).ok()).collect()
}

fn request(
    asked: &RenderRequest,
    format: PictureFormat,
    (document, scene): (&Document, &Decoded),
    ((session, viewer), payer): ((Arc<Lease>, Arc<Lease>), Payer),
) -> Result<Request, ServerError> {
    let light = asked.light.as_deref().map_or(Ok(0), |wanted| choose_light(document, wanted))?;
    let camera = match &asked.camera {
        Some(wanted) => choose_camera(document, wanted)?,
        None => default_camera(document, scene, asked.framing_aspect()),
    };
    Ok(Request {
        scene: Arc::clone(&scene.posed),
        view: asked.view(camera, light, RenderLimits::HTTP, viewer.slot()),
        session,
        viewer,
        payer,
        lights: document.instances(),
        output: Output::File(format),
        urgency: Urgency::Still,
        place: Place::since(Instant::now()),
    })
}

/// The index of a light by its id or its name.
fn choose_light(document: &Document, wanted: &str) -> Result<usize, ServerError> {
    let by_id = document.lights().keys().position(|id| id.to_string() == wanted);
    let by_name = || document.lights().values().position(|placed| placed.light.light().name() == wanted);
    by_id.or_else(by_name).ok_or_else(|| not_found("light", wanted))
}

/// A camera by its id or its name.
fn choose_camera(document: &Document, wanted: &str) -> Result<Camera, ServerError> {
    let cameras = document.cameras();
    let by_id = cameras.iter().find(|(id, _)| id.to_string() == wanted).map(|(_, camera)| camera);
    let by_name = || cameras.values().find(|camera| camera.name == wanted);
    by_id.or_else(by_name).cloned().ok_or_else(|| not_found("camera", wanted))
}

/// The first camera, or one that sees everything in a picture of that width over height.
pub fn default_camera(document: &Document, scene: &Decoded, aspect: f64) -> Camera {
    let first = document.cameras().values().next().cloned();
    first.unwrap_or_else(|| framing_camera(&scene.posed.reach(), aspect))
}

fn not_found(what: &'static str, wanted: &str) -> ServerError {
    let remedy = "give the id or the name of one of the document's";
    ServerError::NotFound { what, name: wanted.chars().take(64).collect(), remedy }
}
