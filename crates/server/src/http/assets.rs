//! `POST /assets`.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use protocol::Asset;
use store::MAX_ASSET_BYTES;

use super::{Answer, created, read_body};
use crate::ServerError;
use crate::limits::MAX_UPLOADS;
use crate::server::Shared;

/// Keeps a scene's file once it is known to decode, and names it.
pub async fn add(State(shared): State<Arc<Shared>>, body: Body) -> Answer {
    let too_many = |_| ServerError::TooMany { what: "scenes on their way here", limit: MAX_UPLOADS };
    let _permit = shared.uploads.try_acquire().map_err(too_many)?;
    let bytes = read_body(body, "a scene's file", MAX_ASSET_BYTES as usize).await?;
    let asset = shared.backend.scenes.add(bytes).await?;
    Ok(created(&Asset { asset: asset.to_string() }))
}
