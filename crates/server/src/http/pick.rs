//! `POST /sessions/S/pick`: the point that a camera looks at.

use axum::extract::State;
use protocol::{Pick, Picked};

use super::answer::{HandlerResult, json};
use super::read::{JsonBody, SessionName};
use crate::probe::pick;
use crate::request::valid_camera;
use crate::state::App;

/// Answers with the point in the middle of the camera's picture.
pub async fn answer(
    State(state): App,
    SessionName(name): SessionName,
    JsonBody(Pick { camera }): JsonBody<Pick>,
) -> HandlerResult {
    let camera = valid_camera(camera)?;
    let scene = state.rooms.snapshot(&name).await?.scene;
    let point = pick(&state.services, camera, &scene).await?;
    Ok(json(&Picked { point: point.map(|point| point.to_array()) }))
}
