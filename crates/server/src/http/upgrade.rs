//! `GET /socket`: turns a request into a WebSocket.
//!
//! It replaces axum's sockets, which cannot send a message in parts (`crate::socket`).

use std::io;

use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use hyper::upgrade::{OnUpgrade, Parts, Upgraded};
use hyper_util::rt::TokioIo;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;
use tokio_tungstenite::tungstenite::protocol::{Role, WebSocketConfig};

use crate::ServerError;
use crate::limits::{MAX_MESSAGE_BYTES, SOCKET_READ_BYTES};
use crate::socket::Socket;
use crate::write_timeout::WriteTimeoutStream;

/// Returns the future of the upgraded connection, and the answer that accepts the upgrade (RFC 6455, section 4.2).
pub fn upgrade(request: &mut Request) -> Result<(OnUpgrade, Response), ServerError> {
    let headers = request.headers();
    let asks = request.method() == Method::GET
        && has_word(headers, header::CONNECTION, "upgrade")
        && has_word(headers, header::UPGRADE, "websocket")
        && has_word(headers, header::SEC_WEBSOCKET_VERSION, "13");
    let key = headers.get(header::SEC_WEBSOCKET_KEY).filter(|_| asks).map(|key| key.as_bytes().to_vec());
    let (Some(key), Some(upgrade)) = (key, request.extensions_mut().remove::<OnUpgrade>()) else {
        let sentence = "sockets of version 13 are opened here: connect with a WebSocket client";
        return Err(ServerError::BadMessage(sentence.into()));
    };
    let headers = [
        (header::CONNECTION, "upgrade".into()),
        (header::UPGRADE, "websocket".into()),
        (header::SEC_WEBSOCKET_ACCEPT, derive_accept_key(&key)),
    ];
    Ok((upgrade, (StatusCode::SWITCHING_PROTOCOLS, headers, Body::empty()).into_response()))
}

/// Opens the socket on an upgraded connection, in the current runtime. That is not the one of requests, which has a
/// lower priority.
pub async fn open(upgraded: Upgraded) -> io::Result<Socket> {
    let parts = upgraded.downcast::<TokioIo<WriteTimeoutStream>>();
    let Parts { io, read_buf, .. } = parts.map_err(|_| io::Error::other("it is none of this server's"))?;
    let stream = io.into_inner().into_current_runtime()?;
    // A message slightly over the limit is answered with an error, and a much larger one ends the connection. Data is
    // written at once, so only the current part of a message waits in memory.
    let config = WebSocketConfig::default()
        .max_message_size(Some(4 * MAX_MESSAGE_BYTES))
        .max_frame_size(Some(4 * MAX_MESSAGE_BYTES))
        .read_buffer_size(SOCKET_READ_BYTES)
        .write_buffer_size(0);
    Ok(WebSocketStream::from_partially_read(stream, read_buf.into(), Role::Server, Some(config)).await)
}

/// True if a header has that word in its comma-separated list.
fn has_word(headers: &HeaderMap, name: HeaderName, word: &str) -> bool {
    let lines = headers.get_all(name).into_iter().filter_map(|line| line.to_str().ok());
    lines.flat_map(|line| line.split(',')).any(|found| found.trim().eq_ignore_ascii_case(word))
}
