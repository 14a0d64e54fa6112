//! Clients of both interfaces.

use futures_util::{SinkExt, StreamExt};
use protocol::{Actor, ClientMessage, PROTOCOL, ServerMessage, Welcome};
use serde_json::Value;
use stream::FrameHeader;
use tokio::net::{TcpSocket, TcpStream};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::Request;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, client_async, connect_async};
use ureq::http::HeaderMap;

use crate::documented::check;
use crate::server::ServerDoor;

/// A message from a socket.
#[derive(Debug)]
pub enum ReceivedMessage {
    Control(ServerMessage),
    /// The last tile of a frame. Earlier tiles are skipped.
    Frame(FrameHeader),
    /// The server has closed the connection.
    End,
}

/// Returns a connection with a small receive buffer of the client's system, which soon reports a read.
pub async fn connect_with_small_buffers(door: &ServerDoor) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(16 << 10).unwrap();
    socket.connect(door.address).await.unwrap()
}

pub struct Client(WebSocketStream<MaybeTlsStream<TcpStream>>);

impl Client {
    pub async fn connect(door: &ServerDoor) -> Self {
        Self(connect_async(socket_request(door)).await.unwrap().0)
    }

    /// Connects and says hello.
    pub async fn join(door: &ServerDoor, session: &str, name: &str) -> (Self, Welcome) {
        Self::connect(door).await.welcomed(door, session, name).await
    }

    /// Joins like [`Self::join`], with a small receive buffer.
    pub async fn join_with_small_buffers(door: &ServerDoor, session: &str, name: &str) -> (Self, Welcome) {
        Self::connect_with_small_buffers(door).await.welcomed(door, session, name).await
    }

    /// Connects like [`Self::connect`], with a small receive buffer.
    pub async fn connect_with_small_buffers(door: &ServerDoor) -> Self {
        let stream = MaybeTlsStream::Plain(connect_with_small_buffers(door).await);
        Self(client_async(socket_request(door), stream).await.unwrap().0)
    }

    /// Connects and says hello. Returns the welcome if that is the answer.
    pub async fn greeted(door: &ServerDoor, session: &str, name: &str) -> Option<Welcome> {
        let mut client = Self::connect(door).await;
        client.say(&hello(&door.token, session, name)).await;
        match client.next().await {
            ReceivedMessage::Control(ServerMessage::Welcome(welcome)) => Some(*welcome),
            _ => None,
        }
    }

    pub fn into_stream(self) -> MaybeTlsStream<TcpStream> {
        self.0.into_inner()
    }

    async fn welcomed(self, door: &ServerDoor, session: &str, name: &str) -> (Self, Welcome) {
        let mut client = self;
        client.say(&hello(&door.token, session, name)).await;
        match client.next().await {
            ReceivedMessage::Control(ServerMessage::Welcome(welcome)) => (client, *welcome),
            other => panic!("no welcome but {other:?}"),
        }
    }

    pub async fn say(&mut self, message: &ClientMessage) {
        self.say_text(serde_json::to_string(message).unwrap()).await;
    }

    pub async fn say_text(&mut self, text: impl Into<String>) {
        self.0.send(Message::text(text.into())).await.unwrap();
    }

    pub async fn say_bytes(&mut self, bytes: Vec<u8>) {
        self.0.send(Message::binary(bytes)).await.unwrap();
    }

    /// Returns the next control message, frame or end.
    pub async fn next(&mut self) -> ReceivedMessage {
        loop {
            match self.0.next().await {
                Some(Ok(Message::Text(text))) => {
                    return ReceivedMessage::Control(ServerMessage::parse(&text).unwrap());
                }
                Some(Ok(Message::Binary(bytes))) => {
                    let header = FrameHeader::from_bytes(&bytes).unwrap();
                    if header.flags.is_last_tile {
                        return ReceivedMessage::Frame(header);
                    }
                }
                Some(Ok(Message::Close(_)) | Err(_)) | None => return ReceivedMessage::End,
                Some(Ok(_)) => {}
            }
        }
    }

    /// Skips messages until `wanted` returns a value.
    pub async fn until<T>(&mut self, mut wanted: impl FnMut(ReceivedMessage) -> Option<T>) -> T {
        loop {
            let came = self.next().await;
            assert!(!matches!(came, ReceivedMessage::End), "the server has closed");
            if let Some(found) = wanted(came) {
                return found;
            }
        }
    }

    /// Returns the next tile of a frame. Skips other messages.
    pub async fn tile(&mut self) -> FrameHeader {
        loop {
            match self.0.next().await {
                Some(Ok(Message::Binary(bytes))) => return FrameHeader::from_bytes(&bytes).unwrap(),
                Some(Ok(Message::Close(_)) | Err(_)) | None => panic!("the server has closed"),
                Some(Ok(_)) => {}
            }
        }
    }

    /// Returns the next frame after acknowledging it.
    pub async fn frame(&mut self) -> FrameHeader {
        let header = self
            .until(|came| match came {
                ReceivedMessage::Frame(header) => Some(header),
                ReceivedMessage::Control(_) | ReceivedMessage::End => None,
            })
            .await;
        self.say(&ClientMessage::Ack { frame: header.frame }).await;
        header
    }
}

pub fn hello(token: &str, session: &str, name: &str) -> ClientMessage {
    ClientMessage::Hello {
        protocol: PROTOCOL,
        token: token.into(),
        session: session.into(),
        actor: Actor { id: name.to_lowercase(), name: name.into() },
        epoch: None,
        last_seq: None,
    }
}

fn socket_request(door: &ServerDoor) -> Request<()> {
    format!("ws://{}/socket", door.address).into_client_request().unwrap()
}

/// Returns the status that refuses a socket with these headers. `None` if it is accepted.
pub async fn socket_with(door: &ServerDoor, headers: &[(&'static str, &str)]) -> Option<u16> {
    let mut request = socket_request(door);
    for (name, value) in headers {
        request.headers_mut().insert(*name, value.parse().unwrap());
    }
    match connect_async(request).await {
        Ok(_) => None,
        Err(Error::Http(response)) => Some(response.status().as_u16()),
        Err(other) => panic!("{other}"),
    }
}

#[derive(Clone, Debug)]
pub struct HttpAnswer {
    pub status: u16,
    pub kind: String,
    pub headers: HeaderMap,
    pub body: Vec<u8>,
}

impl HttpAnswer {
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.body).unwrap()
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Returns the status and code of an error. Checks that it has a message too.
    pub fn refusal(&self) -> (u16, String) {
        let json = self.json();
        let error = json["error"].as_object().expect("an error");
        assert!(error["message"].as_str().unwrap().len() > 20 && error.len() == 2, "{json}");
        (self.status, error["code"].as_str().unwrap().to_owned())
    }
}

/// Sends a request with only those headers. Checks that `/openapi.json` names the answer.
pub fn send(
    door: &ServerDoor,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &[u8],
) -> HttpAnswer {
    let config = ureq::Agent::config_builder().http_status_as_error(false).allow_non_standard_methods(true);
    let agent: ureq::Agent = config.build().into();
    let request = Request::builder().method(method).uri(format!("http://{}{path}", door.address));
    let request = headers.iter().fold(request, |request, (name, value)| request.header(*name, *value));
    let response = match body {
        [] if method != "POST" => agent.run(request.body(()).unwrap()),
        body => agent.run(request.body(body).unwrap()),
    };
    let mut response = response.unwrap();
    let headers = response.headers().clone();
    let kind = headers.get("content-type").map_or("", |kind| kind.to_str().unwrap()).to_owned();
    let body = response.body_mut().with_config().limit(1 << 30).read_to_vec().unwrap();
    let answer = HttpAnswer { status: response.status().as_u16(), kind, headers, body };
    if let Err(why) = check(method, path, &answer) {
        panic!("{method} {path}: {why}, by /openapi.json");
    }
    answer
}

/// Requests with only those headers. A `body` makes it a POST.
pub fn ask_with(door: &ServerDoor, path: &str, headers: &[(&str, &str)], body: Option<&[u8]>) -> HttpAnswer {
    send(door, if body.is_some() { "POST" } else { "GET" }, path, headers, body.unwrap_or_default())
}

/// Requests with the token.
pub fn get(door: &ServerDoor, path: &str) -> HttpAnswer {
    ask_with(door, path, &[("authorization", &bearer(door))], None)
}

/// Sends JSON with the token.
pub fn post(door: &ServerDoor, path: &str, body: &str) -> HttpAnswer {
    let headers = [("authorization", bearer(door)), ("content-type", "application/json".into())];
    ask_with(
        door,
        path,
        &headers.each_ref().map(|(name, value)| (*name, value.as_str())),
        Some(body.as_bytes()),
    )
}

/// Returns the value of the header with the token.
pub fn bearer(door: &ServerDoor) -> String {
    format!("Bearer {}", door.token)
}

/// Opens a new session of the demo scene, with a name that only its test uses.
pub fn new_session(door: &ServerDoor, name: &str) {
    let made = post(door, "/sessions", &format!(r#"{{"name": "{name}", "scene": "demo:vases"}}"#));
    assert_eq!(made.status, 201, "{}", made.text());
}
