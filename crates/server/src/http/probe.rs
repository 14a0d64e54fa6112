//! `POST /sessions/S/probe`: the reasons for which a pixel is lit or not.

use std::collections::BTreeSet;
use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use protocol::ProbeRequest;

use super::answer::{HandlerResult, json};
use super::read::{SessionName, read_json};
use super::render::default_camera;
use crate::probe::{ProbeJob, chosen_camera, probe};
use crate::room::{RoomMessage, SessionSnapshot};
use crate::state::AppState;

/// Answers with the effect of every light of the document at that pixel.
pub async fn answer(
    State(state): State<Arc<AppState>>,
    SessionName(name): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> HandlerResult {
    let ProbeRequest { camera, size, pixel, highlights } = read_json(&headers, &body)?;
    let SessionSnapshot { document, scene, .. } =
        state.rooms.find(&name).await?.request(RoomMessage::Snapshot).await?;
    let aspect = f64::from(size[0].max(1)) / f64::from(size[1].max(1));
    let default = || default_camera(&document, &scene, aspect);
    let camera = camera.map_or_else(|| Ok(default()), |wanted| chosen_camera(wanted, &document))?;
    let (lights, muted) = (document.light_instances(), BTreeSet::new());
    let found = probe(
        &state.backend,
        ProbeJob { camera, size, pixel, wants_highlights: highlights, lights, muted, scene },
    )
    .await?;
    Ok(json(&found))
}
