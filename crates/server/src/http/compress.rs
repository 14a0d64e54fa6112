//! Answers that are compressed on their way, for who takes that (SPEC, HTTP-31).

use axum::http::{HeaderValue, header};
use axum::response::Response;
use tower_http::CompressionLevel;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{NotForContentType, Predicate, SizeAbove};

use crate::limits::COMPRESSED_FROM_BYTES;

/// Compresses by gzip what is long and is not compressed already, quickly rather than well.
pub fn compression() -> CompressionLayer<impl Predicate> {
    let is_worth_it = SizeAbove::new(COMPRESSED_FROM_BYTES)
        .and(NotForContentType::const_new("image/"))
        .and(NotForContentType::const_new("application/zip"));
    CompressionLayer::new().quality(CompressionLevel::Fastest).compress_when(is_worth_it)
}

/// A strong tag is of the very bytes that are sent (RFC 9110, section 8.8.3): compressed ones have a weak one.
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
