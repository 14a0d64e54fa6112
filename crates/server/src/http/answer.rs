//! Answers of handlers.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use protocol::ErrorBody;
use serde::Serialize;

use crate::ServerError;
use crate::limits::RETRY_AFTER;

/// Result of a handler.
pub type HandlerResult = Result<Response, ServerError>;

impl IntoResponse for ServerError {
    fn into_response(self) -> Response {
        let problem = self.problem();
        let status = StatusCode::from_u16(problem.code.http_status()).unwrap_or(StatusCode::BAD_REQUEST);
        let code = problem.code;
        let mut answer = (status, json(&ErrorBody { error: problem })).into_response();
        // The middleware that counts errors reads it.
        answer.extensions_mut().insert(code);
        if matches!(status, StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS) {
            answer.headers_mut().insert(header::RETRY_AFTER, RETRY_AFTER.as_secs().into());
        }
        answer
    }
}

/// Makes an answer with a body of JSON.
pub fn json(value: &impl Serialize) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], json_text(value)).into_response()
}

/// Makes an answer with a body of another media type.
pub fn file(kind: &'static str, bytes: Vec<u8>) -> Response {
    ([(header::CONTENT_TYPE, kind)], bytes).into_response()
}

/// Returns `value` as JSON in one line.
pub fn json_text(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data with string keys") + "\n"
}

/// Makes a 201 answer with a body of JSON.
pub fn created(value: &impl Serialize) -> Response {
    (StatusCode::CREATED, json(value)).into_response()
}
