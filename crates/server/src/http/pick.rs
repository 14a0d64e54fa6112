//! `POST /sessions/S/pick`: the point that a camera looks at.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use protocol::{Pick, Picked};

use super::answer::{HandlerResult, json};
use super::read::{SessionName, read_json};
use crate::probe::pick;
use crate::request::valid_camera;
use crate::room::{RoomMessage, SessionSnapshot};
use crate::state::AppState;

/// Answers with the point in the middle of the camera's picture.
pub async fn answer(
    State(state): State<Arc<AppState>>,
    SessionName(name): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> HandlerResult {
    let Pick { camera } = read_json(&headers, &body)?;
    let camera = valid_camera(camera)?;
    let SessionSnapshot { scene, .. } = state.rooms.find(&name).await?.request(RoomMessage::Snapshot).await?;
    let point = pick(&state.backend, camera, &scene).await?;
    Ok(json(&Picked { point: point.map(|point| point.to_array()) }))
}
