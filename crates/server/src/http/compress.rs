//! Compression of answers for clients that accept it (SPEC, HTTP-31).

use axum::http::{HeaderValue, header};
use axum::response::Response;
use tower_http::CompressionLevel;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{NotForContentType, Predicate, SizeAbove};

use crate::limits::COMPRESSED_FROM_BYTES;

/// Compresses long answers by gzip unless they are compressed already. Prefers speed to size.
pub fn compression() -> CompressionLayer<impl Predicate> {
    let is_worth_it = SizeAbove::new(COMPRESSED_FROM_BYTES)
        .and(NotForContentType::const_new("image/"))
        .and(NotForContentType::const_new("application/zip"));
    CompressionLayer::new().quality(CompressionLevel::Fastest).compress_when(is_worth_it)
}

/// Weakens the tag of a compressed answer. A strong tag belongs to exactly the sent bytes (RFC 9110, section 8.8.3).
pub async fn weaken_tag(mut answer: Response) -> Response {
    let headers = answer.headers_mut();
    if headers.contains_key(header::CONTENT_ENCODING)
        && let Some(tag) = headers.get(header::ETAG).and_then(|tag| tag.to_str().ok())
        && let Ok(weak) = HeaderValue::from_str(&format!("W/{tag}"))
    {
        headers.insert(header::ETAG, weak);
    }
    answer
}
