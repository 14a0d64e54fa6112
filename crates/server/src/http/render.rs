//! `GET /sessions/S/render`: a picture of the document, as it is or as it was.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderName, HeaderValue, Uri, header};
use axum::response::IntoResponse;
use document::Document;
use light::Light;
use render::{Aov, PictureFormat, View};
use scene::{Camera, DEFAULT_ASPECT, framing_camera};
use serde::Deserialize;
use tokio::task::spawn_blocking;

use super::{Answer, SessionName, read_query};
use crate::ServerError;
use crate::limits::{MAX_SAMPLES, MAX_STILLS, MAX_VIEW_SIDE};
use crate::renderer::{Lease, Output, Request, Urgency};
use crate::room::{Message, Snapshot};
use crate::server::Shared;

/// The header that tells what a picture lacks.
const NOTE: HeaderName = HeaderName::from_static("x-bendylights-note");

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Query {
    camera: Option<String>,
    size: Option<String>,
    aov: Option<String>,
    samples: Option<u32>,
    light: Option<String>,
    fill: Option<f64>,
    at: Option<u64>,
    format: Option<Format>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Format {
    #[default]
    Png,
    Exr,
}

impl From<Format> for PictureFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Png => Self::Png,
            Format::Exr => Self::Exr,
        }
    }
}

/// The picture that the address asks for. It waits behind the views.
pub async fn render(State(shared): State<Arc<Shared>>, SessionName(name): SessionName, uri: Uri) -> Answer {
    let query: Query = read_query(&uri)?;
    let too_many = |_| ServerError::TooMany { what: "pictures", limit: MAX_STILLS };
    let _permit = shared.stills.try_acquire().map_err(too_many)?;
    let Snapshot { name, mut document, mut notes, lease: session, .. } =
        shared.rooms.find(&name).await?.ask(Message::Look).await?;
    if let Some(seq) = query.at {
        let replayed =
            shared.backend.storage.read_with_scenes(&shared.backend.scenes, move |store, scenes| {
                store.replay(&name, Some(seq), scenes)
            });
        document = replayed.await?.document().clone();
        notes = match document.scene_ref() {
            Some(scene) => shared.backend.scenes.load(scene.asset).await?.notes,
            None => Arc::default(),
        };
    }
    let format = query.format.unwrap_or_default();
    let notes = headers(&document, &notes);
    let request = request(query, document, (session, shared.backend.renders.lease())).await?;
    let (view, lights) = (request.view.clone(), request.lights.clone());
    let picture_format = format.into();
    let drawn = shared.backend.renders.draw(request).await;
    // Of a server that stops, the renderer's end is no fault.
    let stopped = matches!(drawn, Err(ServerError::Fault)) && shared.backend.draining.is_cancelled();
    let pixels = if stopped { Err(ServerError::Draining) } else { drawn }?.pixels;
    // Compressing takes seconds, in which the renderer can draw for others.
    let file = spawn_blocking(move || pixels.into_file(&view, &lights, picture_format));
    let file = file.await.map_err(|_| ServerError::Fault)??;
    let kind = match format {
        Format::Png => "image/png",
        Format::Exr => "image/x-exr",
    };
    let mut response = ([(header::CONTENT_TYPE, kind)], file).into_response();
    for note in notes {
        response.headers_mut().append(NOTE, note);
    }
    Ok(response)
}

/// What the picture lacks: the notes of its scene, and a sentence for each light that it leaves out.
fn headers(document: &Document, notes: &[String]) -> Vec<HeaderValue> {
    let left_out = document.reach().left_out(document.lights().values().map(|placed| &placed.light));
    let sentences = notes.iter().cloned().chain(left_out.into_iter().map(|why| why.to_string()));
    // Names can have any letters; a header's value has those of ASCII.
    let plain = |sentence: String| sentence.replace(|c: char| !matches!(c, ' '..='~'), "?");
    sentences.filter_map(|sentence| HeaderValue::from_str(&plain(sentence)).ok()).collect()
}

async fn request(
    query: Query,
    document: Document,
    (session, viewer): (Arc<Lease>, Arc<Lease>),
) -> Result<Request, ServerError> {
    let asked = query.size.as_deref().map(size).transpose()?;
    let samples = query.samples.unwrap_or(1);
    if samples == 0 {
        return Err(ServerError::BadMessage(
            "a picture takes at least 1 sample a pixel: ask for more than 0".into(),
        ));
    }
    if samples > MAX_SAMPLES {
        let (what, limit) = ("a pixel", MAX_SAMPLES as usize);
        return Err(ServerError::TooLarge { what, limit, unit: "samples" });
    }
    let fill = query.fill.unwrap_or(1.0);
    if !View::FILL.contains(&fill) {
        let most = View::FILL.end();
        return Err(ServerError::BadMessage(format!(
            "the fill's factor is {fill}: give one from 0 to {most}"
        )));
    }
    let aov = query.aov.as_deref().map_or(Ok(Aov::Beauty), str::parse)?;
    let light = query.light.as_deref().map_or(Ok(0), |wanted| choose_light(&document, wanted))?;
    let camera = match query.camera {
        Some(wanted) => choose_camera(&document, &wanted)?,
        None => default_camera(&document, asked).await?,
    };
    let [width, height] = asked.unwrap_or_else(|| camera.projection.default_size(MAX_VIEW_SIDE));
    Ok(Request {
        scene: Arc::clone(document.scene()),
        view: View { camera, width, height, samples, aov, light, fill, slot: viewer.slot() },
        session,
        viewer,
        lights: lights(&document),
        output: Output::File(query.format.unwrap_or_default().into()),
        urgency: Urgency::Still,
    })
}

fn lights(document: &Document) -> Vec<Light> {
    document.lights().values().map(|placed| placed.light.clone()).collect()
}

fn size(text: &str) -> Result<[u32; 2], ServerError> {
    let side = |text: &str| text.parse().ok().filter(|side: &u32| *side > 0 && !text.starts_with('+'));
    let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    let Some(size) = sides else {
        return Err(ServerError::BadMessage(format!("size is `{text:.20}`: write it as WIDTHxHEIGHT")));
    };
    if size.iter().any(|side| *side > MAX_VIEW_SIDE) {
        let (what, limit) = ("a side of a picture", MAX_VIEW_SIDE as usize);
        return Err(ServerError::TooLarge { what, limit, unit: "pixels" });
    }
    Ok(size)
}

/// The index of a light by its id or its name.
fn choose_light(document: &Document, wanted: &str) -> Result<usize, ServerError> {
    let by_id = document.lights().keys().position(|id| id.to_string() == wanted);
    let by_name = || document.lights().values().position(|placed| placed.light.name == wanted);
    by_id.or_else(by_name).ok_or_else(|| not_found("light", wanted))
}

/// A camera by its id or its name.
fn choose_camera(document: &Document, wanted: &str) -> Result<Camera, ServerError> {
    let cameras = document.cameras();
    let by_id = cameras.iter().find(|(id, _)| id.to_string() == wanted).map(|(_, camera)| camera);
    let by_name = || cameras.values().find(|camera| camera.name == wanted);
    by_id.or_else(by_name).cloned().ok_or_else(|| not_found("camera", wanted))
}

/// The first camera, or one that sees everything in a picture of the size that is asked for.
async fn default_camera(document: &Document, asked: Option<[u32; 2]>) -> Result<Camera, ServerError> {
    if let Some(first) = document.cameras().values().next() {
        return Ok(first.clone());
    }
    let aspect = asked.map_or(DEFAULT_ASPECT, |[width, height]| f64::from(width) / f64::from(height));
    let scene = Arc::clone(document.scene());
    spawn_blocking(move || framing_camera(&scene, aspect)).await.map_err(|_| ServerError::Fault)
}

fn not_found(what: &'static str, wanted: &str) -> ServerError {
    let remedy = "give the id or the name of one of the document's";
    ServerError::NotFound { what, name: wanted.chars().take(64).collect(), remedy }
}
