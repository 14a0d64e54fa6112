//! `POST /assets`.

use std::fs::File;
use std::path::Path;

use axum::body::{Body, HttpBody};
use axum::extract::State;
use axum::http::Uri;
use serde::Deserialize;
use store::{MAX_ASSET_BYTES, check_scene_name};
use tokio::io::AsyncWriteExt;

use super::answer::{HandlerResult, created};
use super::read::{next_part, read_query};
use crate::ServerError;
use crate::error::check_size;
use crate::limits::MAX_UPLOADS;
use crate::state::App;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Query {
    name: Option<String>,
}

/// Stores a scene's file with its name once it was decoded.
pub async fn add(State(state): App, uri: Uri, body: Body) -> HandlerResult {
    let Query { name } = read_query(&uri)?;
    // Checked before the file arrives, which may take long.
    name.as_deref().map_or(Ok(()), check_scene_name)?;
    check_length(body.size_hint().exact().unwrap_or_default())?;
    let too_many = |_| ServerError::TooMany { what: "scenes on their way here", limit: MAX_UPLOADS };
    let _permit = state.uploads.try_acquire().map_err(too_many)?;
    let file = receive(body, state.services.storage.folder()).await?;
    Ok(created(&state.services.scenes.add(file, name).await?))
}

/// Receives the body into an unnamed file in `folder`, which never outlives the request. So a slow sender takes space
/// on disk and not in memory.
async fn receive(body: Body, folder: &Path) -> Result<File, ServerError> {
    let unusable = |reason| ServerError::Data { path: folder.into(), reason };
    let mut file = tokio::fs::File::from_std(tempfile::tempfile_in(folder).map_err(unusable)?);
    let (mut parts, mut length) = (body.into_data_stream(), 0);
    while let Some(part) = next_part(&mut parts).await? {
        length += part.len() as u64;
        check_length(length)?;
        file.write_all(&part).await.map_err(unusable)?;
    }
    file.flush().await.map_err(unusable)?;
    Ok(file.into_std().await)
}

fn check_length(length: u64) -> Result<(), ServerError> {
    check_size("a scene's file", length as usize, MAX_ASSET_BYTES as usize, "bytes")
}
