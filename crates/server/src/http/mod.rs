//! The HTTP interface: section 9 of the protocol.

mod assets;
mod guard;
mod page;
mod render;
mod sessions;

use std::sync::Arc;

use axum::body::{Body, BodyDataStream, Bytes};
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::{DefaultBodyLimit, FromRequestParts, Path, Query, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Router};
use futures_util::StreamExt;
use protocol::ErrorBody;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::time::timeout;

use crate::ServerError;
use crate::connections::Connection;
use crate::limits::{BODY_RESTS_AT_MOST, MAX_MESSAGE_BYTES};
use crate::renderer::Warmth;
use crate::server::Shared;
use crate::socket;

/// Characters of what came that a refusal says again.
const SAID_AGAIN: usize = 100;

/// What a handler answers.
type Answer = Result<Response, ServerError>;

/// Every route.
pub fn router(shared: Arc<Shared>) -> Router {
    let needs_token = Router::new()
        .route("/sessions", get(sessions::list).post(sessions::create))
        .route("/sessions/{name}", get(sessions::show))
        .route("/sessions/{name}/edits", post(sessions::edit))
        .route("/sessions/{name}/log", get(sessions::log))
        .route("/sessions/{name}/render", get(render::render))
        .route("/metrics", get(metrics))
        .route_layer(middleware::from_fn_with_state(Arc::clone(&shared), guard::limit_requests))
        .route("/assets", post(assets::add))
        .method_not_allowed_fallback(wrong_method)
        .route_layer(middleware::from_fn_with_state(Arc::clone(&shared), guard::need_token));
    Router::new()
        .merge(needs_token)
        .route("/socket", get(open_socket))
        .route("/healthz", get(|| async { "the server runs\n" }))
        .route("/readyz", get(ready))
        .route("/openapi.json", get(|| async { json(&protocol::openapi()) }))
        .fallback(page::page)
        .method_not_allowed_fallback(wrong_method)
        .layer(DefaultBodyLimit::disable())
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard::refuse_strange_pages))
        .layer(middleware::map_response(guard::believe_no_guesses))
        .with_state(shared)
}

/// A known address with a method that it does not take. The router adds the header `Allow`.
async fn wrong_method(method: Method, uri: Uri) -> ServerError {
    ServerError::MethodNotAllowed { path: excerpt(uri.path()), method: excerpt(method.as_str()) }
}

/// What is said again of what came.
fn excerpt(text: &str) -> String {
    text.chars().take(SAID_AGAIN).collect()
}

/// `GET /socket`.
async fn open_socket(
    State(shared): State<Arc<Shared>>,
    Extension(connection): Extension<Connection>,
    upgrade: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Answer {
    let upgrade = upgrade.map_err(|why| {
        ServerError::BadMessage(format!("{}: connect with a WebSocket client", why.body_text()))
    })?;
    if shared.backend.draining.is_cancelled() {
        return Err(ServerError::Draining);
    }
    let sockets = shared.backend.sockets.clone();
    // A message a little over the limit is answered with a sentence; one far over it ends the connection.
    let upgrade = upgrade.max_message_size(4 * MAX_MESSAGE_BYTES).max_frame_size(4 * MAX_MESSAGE_BYTES);
    Ok(upgrade.on_upgrade(move |socket| sockets.track_future(socket::serve(socket, shared, connection))))
}

/// `GET /readyz`.
async fn ready(State(shared): State<Arc<Shared>>) -> Answer {
    if shared.backend.draining.is_cancelled() {
        return Err(ServerError::Draining);
    }
    match shared.backend.renders.warmth() {
        Warmth::Warm => Ok("every pipeline has drawn\n".into_response()),
        Warmth::Warming => Err(ServerError::WarmingUp),
        Warmth::Failed(error) => Err(ServerError::Cold(error)),
    }
}

/// `GET /metrics`.
async fn metrics(State(shared): State<Arc<Shared>>) -> Response {
    let kind = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, kind)], shared.backend.metrics.to_text()).into_response()
}

/// The session that an address names.
struct SessionName(String);

impl<S: Send + Sync> FromRequestParts<S> for SessionName {
    type Rejection = ServerError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ServerError> {
        let name = Path::from_request_parts(parts, state).await;
        name.map(|Path(name)| Self(name)).map_err(|why| ServerError::BadMessage(why.body_text()))
    }
}

impl IntoResponse for ServerError {
    fn into_response(self) -> Response {
        let problem = self.problem();
        let status = StatusCode::from_u16(problem.code.http_status()).unwrap_or(StatusCode::BAD_REQUEST);
        (status, json(&ErrorBody { error: problem })).into_response()
    }
}

/// A body of JSON.
fn json(value: &impl Serialize) -> Response {
    let text = serde_json::to_string(value).expect("plain data with string keys");
    ([(header::CONTENT_TYPE, "application/json")], text + "\n").into_response()
}

/// The JSON of a request. Where no header says what the body is, it is taken for JSON.
fn read_json<T: DeserializeOwned>(headers: &HeaderMap, body: &[u8]) -> Result<T, ServerError> {
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
async fn read_body(body: Body, what: &'static str, limit: usize) -> Result<Vec<u8>, ServerError> {
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
async fn next_part(parts: &mut BodyDataStream) -> Result<Option<Bytes>, ServerError> {
    let next = timeout(BODY_RESTS_AT_MOST, parts.next()).await.map_err(|_| ServerError::Stalled)?;
    next.transpose().map_err(|error| {
        tracing::debug!("a body broke: {error}");
        ServerError::CutOff
    })
}

/// The parameters after the `?`; unknown ones are refused.
fn read_query<T: DeserializeOwned>(uri: &Uri) -> Result<T, ServerError> {
    let Query(query) =
        Query::try_from_uri(uri).map_err(|error| ServerError::BadMessage(error.body_text()))?;
    Ok(query)
}

/// 201 with a body of JSON.
fn created(value: &impl Serialize) -> Response {
    (StatusCode::CREATED, json(value)).into_response()
}
