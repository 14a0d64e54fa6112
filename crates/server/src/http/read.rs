//! What handlers read of a request.

use axum::body::{Body, BodyDataStream, Bytes};
use axum::extract::{FromRequestParts, Path, Query};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Uri, header};
use futures_util::StreamExt;
use serde::de::DeserializeOwned;
use tokio::time::timeout;

use crate::ServerError;
use crate::limits::BODY_RESTS_AT_MOST;

/// Characters of what came that a refusal says again.
const SAID_AGAIN: usize = 100;

/// What is said again of what came.
pub fn excerpt(text: &str) -> String {
    text.chars().take(SAID_AGAIN).collect()
}

/// The session that an address names.
pub struct SessionName(pub String);

impl<S: Send + Sync> FromRequestParts<S> for SessionName {
    type Rejection = ServerError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ServerError> {
        let name = Path::from_request_parts(parts, state).await;
        name.map(|Path(name)| Self(name)).map_err(|why| ServerError::BadMessage(why.body_text()))
    }
}

/// The JSON of a request. Where no header says what the body is, it is taken for JSON.
pub fn read_json<T: DeserializeOwned>(headers: &HeaderMap, body: &[u8]) -> Result<T, ServerError> {
    if let Some(kind) = headers.get(header::CONTENT_TYPE) {
        let kind = kind.to_str().unwrap_or("unreadable");
        if !is_json(kind) {
            return Err(ServerError::NotJson(excerpt(kind)));
        }
    }
    let text = std::str::from_utf8(body)
        .map_err(|_| ServerError::BadMessage("the body is not UTF-8: send JSON as UTF-8".into()))?;
    Ok(protocol::parse_body(text)?)
}

/// Whether a media type is that of JSON, or of a kind of it.
fn is_json(kind: &str) -> bool {
    let kind = kind.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    kind == "application/json" || (kind.starts_with("application/") && kind.ends_with("+json"))
}

/// All of a body, up to a limit.
pub async fn read_body(body: Body, what: &'static str, limit: usize) -> Result<Vec<u8>, ServerError> {
    let (mut parts, mut bytes) = (body.into_data_stream(), Vec::new());
    while let Some(part) = next_part(&mut parts).await? {
        if bytes.len() + part.len() > limit {
            return Err(ServerError::TooLarge { what, limit, unit: "bytes" });
        }
        bytes.extend_from_slice(&part);
    }
    Ok(bytes)
}

/// The next part of a body, however slowly the whole comes; `None` at its end.
pub async fn next_part(parts: &mut BodyDataStream) -> Result<Option<Bytes>, ServerError> {
    let next = timeout(BODY_RESTS_AT_MOST, parts.next()).await.map_err(|_| ServerError::Stalled)?;
    next.transpose().map_err(|error| {
        tracing::debug!("a body broke: {error}");
        ServerError::CutOff
    })
}

/// The parameters after the `?`; unknown ones are refused.
pub fn read_query<T: DeserializeOwned>(uri: &Uri) -> Result<T, ServerError> {
    let Query(query) =
        Query::try_from_uri(uri).map_err(|error| ServerError::BadMessage(error.body_text()))?;
    Ok(query)
}
