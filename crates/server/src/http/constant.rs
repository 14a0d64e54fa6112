//! Answers that stay the same while the server runs, with a tag for clients' caches (SPEC, HTTP-24).

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use document::AssetHash;
use serde::Serialize;

use super::answer::json_text;

/// JSON that is serialized once and sent unchanged to every request.
pub struct ConstantJson {
    text: Bytes,
    tag: HeaderValue,
}

impl ConstantJson {
    pub fn json(value: &impl Serialize) -> Self {
        let text = json_text(value);
        Self { tag: tag(&AssetHash::of(text.as_bytes()).hex()), text: text.into() }
    }

    /// Answers a request with the JSON, or with 304 if the request's headers say that the client has it.
    pub fn answer(&self, headers: &HeaderMap) -> Response {
        let kind = [(header::CONTENT_TYPE, "application/json")];
        tagged(headers, self.tag.clone(), (kind, self.text.clone()).into_response())
    }
}

/// Returns the strong entity tag of bytes with this hash.
pub fn tag(hash: &str) -> HeaderValue {
    HeaderValue::from_str(&format!("\"{hash}\"")).expect("hexadecimal digits")
}

/// Adds the tag to `answer`. Returns 304 without a body if the request has that tag.
pub fn tagged(headers: &HeaderMap, tag: HeaderValue, mut answer: Response) -> Response {
    not_modified(headers, &tag).unwrap_or_else(|| {
        answer.headers_mut().insert(header::ETAG, tag);
        answer
    })
}

/// Makes a 304 answer without a body if a request has that tag.
pub fn not_modified(headers: &HeaderMap, tag: &HeaderValue) -> Option<Response> {
    let is_known = headers.get_all(header::IF_NONE_MATCH).iter().any(|known| lists_tag(known, tag));
    is_known.then(|| (StatusCode::NOT_MODIFIED, [(header::ETAG, tag.clone())]).into_response())
}

/// True if a list of tags has this one or is `*`. A weak tag counts too: RFC 9110, section 13.1.2.
fn lists_tag(known: &HeaderValue, tag: &HeaderValue) -> bool {
    let (Ok(known), Ok(tag)) = (known.to_str(), tag.to_str()) else { return false };
    known.split(',').map(str::trim).any(|one| one == "*" || one.strip_prefix("W/").unwrap_or(one) == tag)
}
