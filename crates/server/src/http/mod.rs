//! The HTTP interface: section 9 of the protocol.

mod answer;
mod assets;
mod compress;
mod constant;
mod count;
mod drags;
mod guard;
mod page;
mod pick;
mod picture_files;
mod probe;
mod read;
mod render;
mod session_list;
mod sessions;
mod thumbnail;
mod upgrade;

use std::io;
use std::sync::{Arc, LazyLock};

use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderMap, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Router};

use crate::ServerError;
use crate::connections::Connection;
use crate::renderer::Readiness;
use crate::socket;
use crate::state::{App, AppState};
use answer::HandlerResult;
use constant::ConstantJson;

static OPENAPI: LazyLock<ConstantJson> = LazyLock::new(|| ConstantJson::json(&protocol::openapi()));
static SCENES: LazyLock<ConstantJson> = LazyLock::new(|| ConstantJson::json(&session_list::scenes()));
static PARAMETERS: LazyLock<ConstantJson> = LazyLock::new(|| ConstantJson::json(&protocol::parameter_table()));

/// Makes the router with all routes.
pub fn router(state: Arc<AppState>) -> Router {
    let needs_token = Router::new()
        .route("/sessions", get(session_list::list).post(sessions::create))
        .route("/sessions/{name}", get(sessions::show).patch(session_list::change).delete(session_list::delete))
        .route("/sessions/{name}/duplicate", post(session_list::duplicate))
        .route("/scenes", get(|headers: HeaderMap| async move { SCENES.answer(&headers) }))
        .route("/sessions/{name}/edits", post(sessions::edit))
        .route("/sessions/{name}/nodes", get(sessions::nodes))
        .route("/sessions/{name}/log", get(sessions::log))
        .route("/sessions/{name}/render", get(render::render))
        .route("/sessions/{name}/pick", post(pick::answer))
        .route("/sessions/{name}/drags", post(drags::answer))
        .route("/sessions/{name}/probe", post(probe::answer))
        .route("/parameters", get(|headers: HeaderMap| async move { PARAMETERS.answer(&headers) }))
        .route("/metrics", get(metrics))
        .route_layer(middleware::from_fn_with_state(Arc::clone(&state), guard::limit_requests))
        .route("/assets", post(assets::add))
        .method_not_allowed_fallback(guard::wrong_method)
        .route_layer(middleware::from_fn_with_state(Arc::clone(&state), guard::require_token));
    Router::new()
        .merge(needs_token)
        .route("/socket", get(open_socket))
        .route("/healthz", get(|| async { "the server runs\n" }))
        .route("/readyz", get(ready))
        .route("/openapi.json", get(|headers: HeaderMap| async move { OPENAPI.answer(&headers) }))
        .fallback(page::page)
        .method_not_allowed_fallback(guard::wrong_method)
        .layer(DefaultBodyLimit::disable())
        .layer(middleware::from_fn_with_state(Arc::clone(&state), guard::check_origin))
        .layer(middleware::from_fn_with_state(Arc::clone(&state), guard::throttle))
        .layer(middleware::map_response(guard::security_headers))
        .layer(middleware::from_fn_with_state(Arc::clone(&state), count::count_requests))
        .layer(compress::compression())
        .layer(middleware::map_response(compress::weaken_tag))
        .with_state(state)
}

/// Handles `GET /socket`: joins the connection to a session as a WebSocket.
async fn open_socket(
    State(state): App,
    Extension(connection): Extension<Connection>,
    mut request: Request,
) -> HandlerResult {
    let (upgrade, answer) = upgrade::upgrade(&mut request)?;
    if state.services.draining.is_cancelled() {
        return Err(ServerError::Draining);
    }
    let sockets = state.services.sockets.clone();
    let runtime = state.socket_runtime.clone();
    runtime.spawn(sockets.track_future(async move {
        let opened = async { upgrade::open(upgrade.await.map_err(io::Error::other)?).await };
        match opened.await {
            Ok(socket) => socket::serve(socket, state, connection).await,
            Err(error) => tracing::debug!("a connection broke: {error}"),
        }
    }));
    Ok(answer)
}

/// Handles `GET /readyz`: gives an error until the server can serve pictures.
async fn ready(State(state): App) -> HandlerResult {
    if state.services.draining.is_cancelled() {
        return Err(ServerError::Draining);
    }
    match state.services.renders.readiness() {
        Readiness::Ready => Ok("every pipeline has drawn\n".into_response()),
        Readiness::WarmingUp => Err(ServerError::WarmingUp),
        Readiness::Failed(error) => Err(ServerError::NotReady(error)),
    }
}

/// Handles `GET /metrics`: all metrics in Prometheus' text format.
async fn metrics(State(state): App) -> Response {
    let kind = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, kind)], state.services.metrics.to_text()).into_response()
}
