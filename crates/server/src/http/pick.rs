//! `POST /sessions/S/pick`: what a camera looks at.

use std::sync::Arc;
use std::time::Instant;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use protocol::{Pick, Picked};
use render::{Aov, PictureFormat, Pixels, View};

use super::answer::{Answer, json};
use super::read::{SessionName, read_json};
use crate::ServerError;
use crate::renderer::{Output, Place, Request, Urgency};
use crate::request::valid_camera;
use crate::room::{Message, Snapshot};
use crate::state::AppState;
use crate::turns::Payer;

/// The point in the middle of the camera's picture, which is the only pixel of one: its depth tells where.
pub async fn pick(
    State(state): State<Arc<AppState>>,
    SessionName(name): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> Answer {
    let Pick { camera } = read_json(&headers, &body)?;
    let camera = valid_camera(camera)?;
    let _permit = state.stills.take(&name)?;
    let Snapshot { scene, lease: session, .. } =
        state.rooms.find(&name).await?.request(Message::Snapshot).await?;
    let (viewer, world_from_camera) = (state.backend.renders.lease(), camera.world_from_camera());
    let view = View { aov: Aov::Depth, slot: viewer.slot(), ..View::beauty(camera, [1, 1]) };
    let request = Request {
        scene: Arc::clone(&scene.posed),
        view,
        session,
        viewer,
        payer: Payer::program(&name),
        lights: Vec::new(),
        output: Output::File(PictureFormat::Exr),
        urgency: Urgency::Still,
        place: Place::since(Instant::now()),
    };
    let Pixels::Raw(picture) = state.backend.renders.draw(request).await?.pixels else {
        return Err(ServerError::Fault);
    };
    let seen = picture.pixels.first().filter(|[.., alpha]| *alpha > 0.0);
    let at = |depth: f32| world_from_camera.translation - world_from_camera.z_axis * f64::from(depth);
    let point = seen.map(|[depth, ..]| at(*depth));
    Ok(json(&Picked { point: point.map(|point| point.to_array()) }))
}
