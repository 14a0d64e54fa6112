//! `GET /sessions/S/render`: pictures of the current document, of an earlier one, or with properties set for them
//! alone.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::State;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Uri, header};
use document::{AssetHash, Document, execute_command};
use light::LightInstance;
use protocol::{
    Aovs, CameraChoice, Command, FrameQuality, RenderBackground, RenderFormat, RenderLimits, RenderParameters,
    RenderRefusal, RenderRequest, TraceLine, TraceWhat,
};
use render::{Background, ExrFile, PictureOrigin, Pixels, WantedPicture, wanted_pictures};
use scene::{Camera, View, framing_camera};

use super::answer::{HandlerResult, file};
use super::constant::{not_modified, tag};
use super::picture_files::{DrawnPictures, PictureFiles};
use super::read::{SessionName, read_query};
use crate::ServerError;
use crate::background as in_background;
use crate::charges::Payer;
use crate::limits::MAX_PICTURE_BYTES;
use crate::picture_stats::{micros, wire_pass_runs};
use crate::renderer::{PictureFormat, PictureRequest, PictureTicket, RenderLease, Urgency};
use crate::request::valid_camera;
use crate::room::SessionSnapshot;
use crate::scenes::DecodedScene;
use crate::state::{App, AppState};
use crate::trace::PictureTrace;

/// Header that tells what a picture lacks.
const NOTE_HEADER: HeaderName = HeaderName::from_static("x-bendylights-note");

/// Pictures of a request, with their names resolved, before they are drawn.
struct ResolvedRender {
    document: Document,
    scene: DecodedScene,
    /// View of all pictures, except for AOV and light.
    view: View,
    /// Lights that shine.
    lights: Vec<LightInstance>,
    /// The pictures to draw.
    pictures: Vec<WantedPicture>,
    /// Origin of the pictures, for the header of an EXR.
    origin: PictureOrigin,
}

/// Handles `GET /sessions/S/render`: draws the requested pictures. Views are drawn before them.
pub async fn render(State(state): App, SessionName(name): SessionName, headers: HeaderMap, uri: Uri) -> HandlerResult {
    let query: RenderParameters = read_query(&uri)?;
    let (request, formats) = (query.request()?, query.formats()?);
    request.check_quantities()?;
    let SessionSnapshot { name, epoch, seq, document, scene, lease: session, .. } = state.rooms.snapshot(&name).await?;
    // Identifies the current document by its hash, or by its record if the file contains that. An earlier document is
    // identified by its record.
    let version = match query.at {
        None if !formats.contains(&RenderFormat::Exr) => document.hash().to_string(),
        at => format!("{epoch} {}", at.unwrap_or(seq)),
    };
    // Another run may have another driver.
    let all = format!("{} {version} {name} {}", state.services.run, uri.query().unwrap_or_default());
    let tag = tag(&AssetHash::of(all.as_bytes()).hex());
    if let Some(answer) = not_modified(&headers, &tag) {
        return Ok(answer);
    }
    let _permit = state.stills.acquire(&name)?;
    let (document, scene, seq) = match query.at {
        None => (document, scene, seq),
        Some(at) => {
            let session = name.clone();
            let replayed = state.services.storage.read(move |store| store.replay(&session, Some(at)));
            let document = replayed.await?.document().clone();
            let scene = state.services.scenes.of(&document).await?;
            (document, scene, at)
        }
    };
    let viewer = state.services.renders.lease();
    let resolved = resolve_render(&query, &request, document, scene, &viewer)?;
    let notes = notes(&resolved);
    let ResolvedRender { scene, view, lights, pictures, origin, .. } = resolved;
    let origin = PictureOrigin { name: Some(name.clone()), seq: Some(seq), ..origin };
    let background = match query.background {
        RenderBackground::Black => Background::Black,
        RenderBackground::Transparent => Background::Transparent,
    };
    let mut files = PictureFiles::new(&formats, background, &view);
    let payer = Payer::program(&name);
    let mut last: Option<(PictureTrace, Duration)> = None;
    for WantedPicture { aov, light, name: light_name } in pictures {
        let (view, lights) = (View { aov, light, ..view.clone() }, lights.clone());
        let request = PictureRequest {
            scene: Arc::clone(&scene.posed),
            view: view.clone(),
            session: Arc::clone(&session),
            viewer: Arc::clone(&viewer),
            payer: payer.clone(),
            lights: lights.clone(),
            output: PictureFormat::File(files.needs(aov)),
            urgency: Urgency::Still,
            ticket: PictureTicket::since(Instant::now()),
        };
        let (pixels, trace) = draw(&state, &name, request).await?;
        let drawn = DrawnPictures { view, lights, light: light_name, pixels };
        if let Some((mut trace, took)) = last.take() {
            trace.encoded(took);
        }
        // Compression takes seconds, in which the renderer can draw for others.
        let added = in_background::run(move || {
            let began = Instant::now();
            (files.add(&drawn), began.elapsed())
        });
        let (added, took) = added.await?;
        files = added?;
        last = Some((trace, took));
    }
    let finished = in_background::run(move || {
        let began = Instant::now();
        let finished = files.finish(&view, &origin);
        if let Some((mut trace, took)) = last {
            trace.encoded(took + began.elapsed());
        }
        finished
    });
    let (kind, bytes) = finished.await??;
    let mut response = file(kind, bytes);
    response.headers_mut().insert(header::ETAG, tag);
    for note in notes {
        response.headers_mut().append(NOTE_HEADER, note);
    }
    Ok(response)
}

/// Draws the picture of one AOV. Returns its pixels and its line for the trace, which still lacks the time of encoding.
pub async fn draw(
    state: &AppState,
    session: &str,
    request: PictureRequest,
) -> Result<(Pixels, PictureTrace), ServerError> {
    let (size, asked_at) = ([request.view.width, request.view.height], Instant::now());
    let drawn = state.services.renders.draw(request).await;
    // While the server stops, the end of the renderer is no fault.
    let stopped = matches!(drawn, Err(ServerError::Internal)) && state.services.draining.is_cancelled();
    let drawn = if stopped { Err(ServerError::Draining) } else { drawn }?;
    let trace = state.services.trace.drawn(|| TraceLine {
        time: drawn.started.saturating_duration_since(state.services.started).as_secs_f64(),
        session: session.into(),
        what: TraceWhat::Still {},
        size,
        quality: FrameQuality::Settled,
        wait_us: micros(drawn.started.saturating_duration_since(asked_at)),
        render_us: micros(drawn.render_time),
        encode_us: None,
        passes: wire_pass_runs(&drawn.passes),
        left_out: 0,
    });
    Ok((drawn.pixels, trace))
}

/// Resolves a request in a document.
fn resolve_render(
    query: &RenderParameters,
    request: &RenderRequest,
    mut document: Document,
    scene: DecodedScene,
    viewer: &RenderLease,
) -> Result<ResolvedRender, ServerError> {
    let set = query.set()?;
    for (address, value) in &set {
        let target = document.address_by_id(address)?;
        // A picture of other values is no edit, so pins have no say.
        let command = Command::Set { target, value: value.clone(), ignore_pins: true }.try_into()?;
        document = execute_command(&document, &command, scene.context(None, None))?.document;
    }
    let mut lights = document.light_instances();
    let mut origin = PictureOrigin {
        document_hash: Some(document.hash().to_string()),
        scene: document.scene().map(|scene| scene.asset.to_string()),
        set: (!set.is_empty()).then(|| query.set.clone()).flatten(),
        ..PictureOrigin::default()
    };
    if let Some(chosen) = query.lights()? {
        let ids = chosen.iter().map(|light| document.find_light(light)).collect::<Result<BTreeSet<_>, _>>()?;
        lights.retain(|light| ids.contains(&light.id));
        let names: Vec<&str> = lights.iter().map(|light| light.light.light().name()).collect();
        origin.lights = serde_json::to_string(&names).ok();
    }
    let light = match &request.light {
        None => 0,
        Some(name) => {
            let id = document.find_light(name)?;
            let index = lights.iter().position(|light| light.id == id);
            index.ok_or_else(|| ServerError::bad_message("`light` is not one of `lights`: add it to them"))?
        }
    };
    let camera = match &request.camera {
        None => default_camera(&document, &scene, request.framing_aspect()),
        Some(CameraChoice::Own(camera)) => valid_camera((**camera).clone())?,
        Some(CameraChoice::Named(name)) => {
            let id = document.find_camera(name)?;
            document.cameras().get(&id).cloned().ok_or(ServerError::Internal)?
        }
    };
    let is_of_all_lights = request.aovs == Aovs::All && request.light.is_none();
    let pictures = wanted_pictures(request.aovs.each(), (!is_of_all_lights).then_some(light), &lights);
    let view = request.view(camera, light, RenderLimits::HTTP, viewer.slot());
    let pixels = view.width as usize * view.height as usize;
    let bytes: usize = pictures.iter().map(|of| pixels * ExrFile::bytes_a_pixel(of.aov)).sum();
    if bytes > MAX_PICTURE_BYTES {
        return Err(RenderRefusal::TooMuch { limit_mib: MAX_PICTURE_BYTES >> 20 }.into());
    }
    Ok(ResolvedRender { document, scene, view, lights, pictures, origin })
}

/// Returns the defects of the pictures: notes on the scene, and a sentence for each light that the pictures leave out.
fn notes(resolved: &ResolvedRender) -> Vec<HeaderValue> {
    let ResolvedRender { document, scene, .. } = resolved;
    let left_out = scene.posed.bounds().undrawable_of(document.lights().values().map(|placed| &*placed.light));
    let sentences = scene.notes.iter().cloned().chain(left_out.into_iter().map(|why| why.to_string()));
    // Names can have any characters, and the value of a header only ASCII.
    let plain = |sentence: String| sentence.replace(|c: char| !matches!(c, ' '..='~'), "?");
    sentences.filter_map(|sentence| HeaderValue::from_str(&plain(sentence)).ok()).collect()
}

/// Returns the first camera, or one that frames the whole scene in a picture of that aspect ratio.
pub fn default_camera(document: &Document, scene: &DecodedScene, aspect: f64) -> Camera {
    let first = document.cameras().values().next().cloned();
    first.unwrap_or_else(|| framing_camera(&scene.posed.subject_bounds(), aspect))
}
