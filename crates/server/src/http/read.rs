//! Reads requests.

use axum::body::{Body, BodyDataStream, Bytes, HttpBody};
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::request::Parts;
use axum::http::{Uri, header};
use futures_util::StreamExt;
use serde::de::DeserializeOwned;
use tokio::time::{Instant, timeout};

use crate::ServerError;
use crate::error::check_size;
use crate::in_flight::{BodyReservation, ByteBudget};
use crate::limits::{BODY_COST, BODY_IDLE_TIMEOUT, LARGE_BODY_TIMEOUT, MAX_BODY_BYTES, SMALL_BYTES};

/// Greatest number of characters of a request that a refusal quotes.
const MAX_EXCERPT_CHARS: usize = 100;

/// Returns the quoted part of a request's text.
pub fn excerpt(text: &str) -> String {
    text.chars().take(MAX_EXCERPT_CHARS).collect()
}

/// Name of the session in a path.
pub struct SessionName(pub String);

impl<S: Send + Sync> FromRequestParts<S> for SessionName {
    type Rejection = ServerError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ServerError> {
        let name = Path::from_request_parts(parts, state).await;
        name.map(|Path(name)| Self(name)).map_err(|why| ServerError::BadMessage(why.body_text()))
    }
}

/// JSON of a request. A body without a media type counts as JSON.
pub struct JsonBody<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for JsonBody<T> {
    type Rejection = ServerError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ServerError> {
        if let Some(kind) = request.headers().get(header::CONTENT_TYPE) {
            let kind = kind.to_str().unwrap_or("unreadable");
            if !is_json(kind) {
                return Err(ServerError::NotJson(excerpt(kind)));
            }
        }
        let body = Bytes::from_request(request, state).await;
        let body = body.map_err(|why| ServerError::BadMessage(why.body_text()))?;
        let text = std::str::from_utf8(&body)
            .map_err(|_| ServerError::bad_message("the body is not UTF-8: send JSON as UTF-8"))?;
        Ok(Self(protocol::parse_body(text)?))
    }
}

/// True if a media type is JSON or based on it.
fn is_json(kind: &str) -> bool {
    let kind = kind.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    kind == "application/json" || (kind.starts_with("application/") && kind.ends_with("+json"))
}

/// Reads the whole body of a request, with its reservation in the budget of bytes in flight. A length in the head is
/// reserved before any of the body is read. A body of unknown length is reserved as it arrives.
pub async fn read_body(body: Body, in_flight: &ByteBudget) -> Result<(Vec<u8>, BodyReservation), ServerError> {
    let announced = body.size_hint().exact().and_then(|bytes| usize::try_from(bytes).ok()).unwrap_or_default();
    let mut read = BodyRead { bytes: Vec::new(), reservation: in_flight.body(), refused: None };
    if announced <= MAX_BODY_BYTES {
        read.make_room(announced);
    }
    let (mut parts, began, mut length) = (body.into_data_stream(), Instant::now(), 0);
    while let Some(part) = next_part(&mut parts).await? {
        length += part.len();
        check_size("a request", length, MAX_BODY_BYTES, "bytes")?;
        if length > SMALL_BYTES && began.elapsed() > LARGE_BODY_TIMEOUT {
            return Err(ServerError::TooSlow);
        }
        read.take(&part);
    }
    read.refused.map_or(Ok((read.bytes, read.reservation)), Err)
}

/// A partly read body.
struct BodyRead {
    bytes: Vec<u8>,
    reservation: BodyReservation,
    /// Error of a body that did not fit into the budget of bytes in flight. The rest of the body is read and dropped,
    /// because a client that is still sending may not see the answer.
    refused: Option<ServerError>,
}

impl BodyRead {
    /// Reserves room for a body of `bytes` bytes in the budget of bytes in flight.
    fn make_room(&mut self, bytes: usize) {
        let room = if bytes > SMALL_BYTES { self.reservation.grow_to(BODY_COST * bytes) } else { Ok(()) };
        match room {
            Ok(()) => self.bytes.reserve_exact(bytes.saturating_sub(self.bytes.len())),
            Err(error) => (self.refused, self.bytes) = (Some(error), Vec::new()),
        }
    }

    fn take(&mut self, part: &[u8]) {
        let length = self.bytes.len() + part.len();
        if self.refused.is_none() && length > self.bytes.capacity() {
            self.make_room(length.next_power_of_two());
        }
        if self.refused.is_none() {
            self.bytes.extend_from_slice(part);
        }
    }
}

/// Returns the next part of a body, even if the whole is slow. Returns `None` at its end.
pub async fn next_part(parts: &mut BodyDataStream) -> Result<Option<Bytes>, ServerError> {
    let next = timeout(BODY_IDLE_TIMEOUT, parts.next()).await.map_err(|_| ServerError::BodyTimedOut)?;
    next.transpose().map_err(|error| {
        tracing::debug!("a body broke: {error}");
        ServerError::CutOff
    })
}

/// Reads the query parameters. Gives an error for unknown ones.
pub fn read_query<T: DeserializeOwned>(uri: &Uri) -> Result<T, ServerError> {
    let Query(query) = Query::try_from_uri(uri).map_err(|error| ServerError::BadMessage(error.body_text()))?;
    Ok(query)
}
