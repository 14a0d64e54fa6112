//! Who may ask, and how many at once.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, header};
use axum::middleware::Next;
use axum::response::Response;

use crate::ServerError;
use crate::limits::MAX_REQUESTS;
use crate::server::Shared;

/// Refuses pages of other places. They could not know the token, but need not be let near it.
pub async fn refuse_foreign_origins(request: Request, next: Next) -> Result<Response, ServerError> {
    let headers = request.headers();
    if let Some(origin) = headers.get(header::ORIGIN) {
        let origin = origin.to_str().unwrap_or("an unreadable origin");
        let host = text(headers, header::HOST).unwrap_or_default();
        let own = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        if own != Some(host) {
            return Err(ServerError::ForeignOrigin(origin.chars().take(100).collect()));
        }
    }
    Ok(next.run(request).await)
}

/// Lets pass who has the token.
pub async fn need_token(
    State(shared): State<Arc<Shared>>,
    request: Request,
    next: Next,
) -> Result<Response, ServerError> {
    let bearer =
        text(request.headers(), header::AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer "));
    if !bearer.is_some_and(|token| shared.token.is(token)) {
        return Err(ServerError::Unauthorized);
    }
    Ok(next.run(request).await)
}

/// Lets pass while there is room.
pub async fn limit_requests(
    State(shared): State<Arc<Shared>>,
    request: Request,
    next: Next,
) -> Result<Response, ServerError> {
    let too_many = |_| ServerError::TooMany { what: "requests", limit: MAX_REQUESTS };
    let _permit = shared.requests.try_acquire().map_err(too_many)?;
    Ok(next.run(request).await)
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    headers.get(name)?.to_str().ok()
}
