//! Access to the server, and limits of requests.

use std::sync::Arc;

use axum::Extension;
use axum::body::{HttpBody, to_bytes};
use axum::extract::{FromRequestParts, Request, State};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderValue, Method, Uri, header};
use axum::middleware::Next;
use axum::response::Response;

use super::read::{SessionName, excerpt, read_body};
use crate::ServerError;
use crate::access::Credential;
use crate::charges::Payer;
use crate::connections::Connection;
use crate::in_flight::ByteReservation;
use crate::limits::SMALL_BYTES;
use crate::state::{App, AppState};

/// Refuses pages of other origins and unknown host names. They cannot know the token, but should not get near it.
pub async fn check_origin(State(state): App, request: Request, next: Next) -> Result<Response, ServerError> {
    let headers = request.headers();
    let readable = |value: &HeaderValue| value.to_str().unwrap_or("an unreadable name").to_owned();
    // Every browser sends it, so requests of pages have it.
    let host = headers.get(header::HOST).map(readable).unwrap_or_default();
    if !host.is_empty() && !state.hosts.is_known_host(&host) {
        return Err(ServerError::ForeignHost(excerpt(&host)));
    }
    if let Some(origin) = headers.get(header::ORIGIN) {
        let origin = readable(origin);
        if !state.hosts.is_own_origin(&origin, &host) {
            return Err(ServerError::ForeignOrigin(excerpt(&origin)));
        }
    }
    Ok(next.run(request).await)
}

/// Tells browsers to take an answer's media type literally and to send no referrer.
pub async fn security_headers(mut response: Response) -> Response {
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(header::REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    response
}

/// Refuses requests without the token, and adds the credential to the others.
pub async fn require_token(
    State(state): App,
    Extension(connection): Extension<Connection>,
    mut request: Request,
    next: Next,
) -> Result<Response, ServerError> {
    let credential = credential(&state, request.headers()).ok_or(ServerError::Unauthorized)?;
    request.extensions_mut().insert(credential);
    connection.mark_authenticated();
    Ok(next.run(request).await)
}

/// Returns the credential of a request's headers, or `None` without the token.
pub fn credential(state: &AppState, headers: &HeaderMap) -> Option<Credential> {
    let (scheme, token) = headers.get(header::AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    if scheme.eq_ignore_ascii_case("bearer") { state.token.verify(token.trim_start_matches(' ')) } else { None }
}

/// Limits the number of requests. A request counts once it has arrived completely, so a slow one keeps nobody out.
pub async fn limit_requests(
    State(state): App,
    Extension(connection): Extension<Connection>,
    request: Request,
    next: Next,
) -> Result<Response, ServerError> {
    let (mut head, body) = request.into_parts();
    let session = session_name(&mut head, &state).await;
    let in_flight = &state.services.in_flight;
    let (body, reservation) = read_body(body, in_flight).await?;
    // A render request has drawn its picture, and there are few at once (`MAX_STILLS`).
    let is_done = !head.method.is_safe() || head.uri.path().ends_with("/render");
    let permit = state.requests.acquire(&session)?;
    let answer = next.run(Request::from_parts(head, body.into())).await;
    drop((permit, reservation));
    // The answer to finished work is sent even if all bytes of `in_flight` are reserved.
    let reserve = |bytes| if is_done { Ok(in_flight.reserve_unchecked(bytes)) } else { in_flight.reserve(bytes) };
    reserve_answer_bytes(answer, reserve, &connection).await
}

/// Returns the session of a request. Empty if it has none.
async fn session_name(head: &mut Parts, state: &Arc<AppState>) -> String {
    if !head.uri.path().starts_with("/sessions/") {
        return String::new();
    }
    SessionName::from_request_parts(head, state).await.map_or(String::new(), |SessionName(name)| name)
}

/// Counts a large answer as bytes in flight until the client has taken it, within a time limit.
async fn reserve_answer_bytes(
    answer: Response,
    reserve: impl FnOnce(usize) -> Result<ByteReservation, ServerError>,
    connection: &Connection,
) -> Result<Response, ServerError> {
    let length = answer.body().size_hint().exact().and_then(|bytes| usize::try_from(bytes).ok());
    let Some(length) = length.filter(|length| *length > SMALL_BYTES) else { return Ok(answer) };
    let reservation = reserve(length)?;
    let (head, body) = answer.into_parts();
    // The body exists in one piece already.
    let bytes = to_bytes(body, length).await.map_err(|_| ServerError::Internal)?;
    Ok(Response::from_parts(head, connection.with_delivery_timeout(reservation.attach_to(bytes)).into()))
}

/// Lets anonymous requests wait for a permit. While a user moves a view, other requests wait too, by session. Liveness
/// checks and opening sockets have their own permits, so they stay fast while others load pages.
pub async fn throttle(
    State(state): App,
    Extension(connection): Extension<Connection>,
    request: Request,
    next: Next,
) -> Response {
    let path = request.uri().path();
    let is_short = matches!(path, "/healthz" | "/readyz" | "/socket");
    if connection.is_authenticated() || credential(&state, request.headers()).is_some() {
        if !is_short {
            let session = path.strip_prefix("/sessions/").and_then(|rest| rest.split('/').next());
            state.services.request_pacing.wait(&Payer::program(session.unwrap_or_default()), 1.0).await;
        }
        return next.run(request).await;
    }
    let permits = if is_short { &state.anonymous_short_permits } else { &state.anonymous_permits };
    let permit = permits.acquire().await;
    let answer = next.run(request).await;
    permit.release_after_bytes(answer.body().size_hint().lower());
    answer
}

/// Answers a request for a known path with a method that the path does not support. The router adds the header `Allow`.
pub async fn wrong_method(method: Method, uri: Uri) -> ServerError {
    ServerError::MethodNotAllowed { path: excerpt(uri.path()), method: excerpt(method.as_str()) }
}
