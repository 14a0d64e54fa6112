//! Answers that stay the same while the server runs, with a tag by which clients keep them (SPEC, HTTP-24).

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use document::AssetHash;
use serde::Serialize;

use super::answer::json_text;

/// JSON that is made once.
pub struct ConstantJson {
    text: Bytes,
    tag: HeaderValue,
}

impl ConstantJson {
    /// The JSON of `value`.
    pub fn json(value: &impl Serialize) -> Self {
        let text = json_text(value);
        Self { tag: tag(&AssetHash::of(text.as_bytes()).hex()), text: text.into() }
    }

    /// The answer to a request with these headers.
    pub fn answer(&self, asked: &HeaderMap) -> Response {
        let kind = [(header::CONTENT_TYPE, "application/json")];
        tagged(asked, self.tag.clone(), (kind, self.text.clone()).into_response())
    }
}

/// A strong entity tag of bytes that have this hash.
pub fn tag(hash: &str) -> HeaderValue {
    HeaderValue::from_str(&format!("\"{hash}\"")).expect("hexadecimal digits")
}

/// `answer` with its tag; 304 without a body where the request says that it has that one.
pub fn tagged(asked: &HeaderMap, tag: HeaderValue, mut answer: Response) -> Response {
    if client_has(asked, &tag) {
        return not_modified(tag);
    }
    answer.headers_mut().insert(header::ETAG, tag);
    answer
}

/// Whether a request says that it has what has that tag.
pub fn client_has(asked: &HeaderMap, tag: &HeaderValue) -> bool {
    asked.get_all(header::IF_NONE_MATCH).iter().any(|known| lists_tag(known, tag))
}

/// 304 without a body.
pub fn not_modified(tag: HeaderValue) -> Response {
    (StatusCode::NOT_MODIFIED, [(header::ETAG, tag)]).into_response()
}

/// Whether a list of tags has this one or is `*`. A weak tag counts too: RFC 9110, section 13.1.2.
fn lists_tag(known: &HeaderValue, tag: &HeaderValue) -> bool {
    let (Ok(known), Ok(tag)) = (known.to_str(), tag.to_str()) else { return false };
    known.split(',').map(str::trim).any(|one| one == "*" || one.strip_prefix("W/").unwrap_or(one) == tag)
}
