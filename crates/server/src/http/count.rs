//! Counts of requests for `GET /metrics`.

use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::Response;
use protocol::ErrorCode;

use crate::metrics::RequestLabel;
use crate::state::App;

/// Counts a request, its answer, and the time to the answer's first byte, waits included. A request that is abandoned
/// earlier is not counted.
pub async fn count_requests(State(state): App, request: Request, next: Next) -> Response {
    let metrics = &state.services.metrics;
    // Paths without a route are answered by the page.
    let route = request.extensions().get::<MatchedPath>().map_or("page", MatchedPath::as_str).to_owned();
    let method = match *request.method() {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        _ => "other",
    };
    let under_way = metrics.request_begins();
    let began = Instant::now();
    let answer = next.run(request).await;
    drop(under_way);
    let took = began.elapsed();
    let status = answer.status().as_u16();
    let code = answer.extensions().get::<ErrorCode>().copied();
    metrics.count_request(&RequestLabel { method, route, status }, code, took);
    answer
}
