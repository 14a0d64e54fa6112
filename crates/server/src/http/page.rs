//! The browser page, as built into the program.

use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{Html, IntoResponse};
use document::AssetHash;
use rust_embed::RustEmbed;

use super::answer::HandlerResult;
use super::constant::{tag, tagged};
use super::guard::wrong_method;
use super::read::excerpt;
use crate::ServerError;

#[derive(RustEmbed)]
#[folder = "../../web-client/dist"]
#[allow_missing = true]
struct Page;

const INDEX: &str = "index.html";
/// Folder of files with the hash of their content in their name.
const HASHED_FILES: &str = "assets/";
/// Sources that a page may load and connect to: this server. Frames are shown from memory. No other page may embed it,
/// and injected content cannot send forms or change its base address.
const CONTENT_SECURITY_POLICY: &str = "default-src 'self'; connect-src 'self'; img-src 'self' blob: data:; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const NOT_BUILT: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>BendyLights</title>\
    <h1>The page is not built</h1><p>This server was built without its page. Run <code>make build</code> in the source \
    folder and start the server again. The HTTP interface works all the same.</p></html>\n";

/// Answers with a file of the page. `/` is the page itself.
pub async fn page(method: Method, uri: Uri, headers: HeaderMap) -> HandlerResult {
    let path = uri.path().trim_start_matches('/');
    let path = if path.is_empty() { INDEX } else { path };
    let found = Page::get(path);
    if found.is_none() && path != INDEX {
        return Err(ServerError::NoRoute(excerpt(uri.path())));
    }
    if method != Method::GET && method != Method::HEAD {
        let error = wrong_method(method, uri).await;
        return Ok(([(header::ALLOW, "GET,HEAD")], error).into_response());
    }
    let mut answer = match found {
        Some(file) => {
            let cache = if path.starts_with(HASHED_FILES) { "public, max-age=31536000, immutable" } else { "no-cache" };
            let kind = file.metadata.mimetype().to_owned();
            let of_file = [(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, cache.into())];
            let tag = tag(&AssetHash(file.metadata.sha256_hash()).hex());
            tagged(&headers, tag, (of_file, file.data).into_response())
        }
        None => (StatusCode::SERVICE_UNAVAILABLE, Html(NOT_BUILT)).into_response(),
    };
    answer.headers_mut().insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(CONTENT_SECURITY_POLICY));
    Ok(answer)
}
