//! `POST /sessions/S/probe`: the reasons for which a pixel is lit or not.

use std::collections::BTreeSet;

use axum::extract::State;
use protocol::ProbeRequest;

use super::answer::{HandlerResult, json};
use super::read::{JsonBody, SessionName};
use super::render::default_camera;
use crate::probe::{ProbeJob, chosen_camera, probe};
use crate::room::SessionSnapshot;
use crate::state::App;

/// Answers with the effect of every light of the document at that pixel.
pub async fn answer(
    State(state): App,
    SessionName(name): SessionName,
    JsonBody(request): JsonBody<ProbeRequest>,
) -> HandlerResult {
    let ProbeRequest { camera, size, pixel, highlights: wants_highlights } = request;
    let SessionSnapshot { document, scene, .. } = state.rooms.snapshot(&name).await?;
    let camera = match camera {
        Some(choice) => chosen_camera(choice, &document)?,
        None => default_camera(&document, &scene, f64::from(size[0].max(1)) / f64::from(size[1].max(1))),
    };
    let (lights, muted) = (document.light_instances(), BTreeSet::new());
    let job = ProbeJob { camera, size, pixel, wants_highlights, lights, muted, scene };
    Ok(json(&probe(&state.services, job).await?))
}
