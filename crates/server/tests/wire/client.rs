//! Clients of both interfaces.

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use protocol::{Actor, ClientMessage, Command, ErrorCode, Outcome, PROTOCOL, ServerMessage, ViewSource, Welcome};
use serde_json::{Value, json};
use stream::FrameHeader;
use tokio::io::AsyncWriteExt;
use tokio::net::{TcpSocket, TcpStream};
use tokio::task::spawn_blocking;
use tokio::time::sleep;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::Request;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{WebSocketStream, client_async};
use ureq::http::HeaderMap;

use crate::documented::check;
use crate::server::ServerDoor;

/// Returns a connection with a receive buffer of `bytes` in the client's system. A small one soon reports a read.
pub async fn connect_with_buffer(door: &ServerDoor, bytes: u32) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(bytes).unwrap();
    socket.connect(door.address).await.unwrap()
}

/// Returns the head of a request with the token and those header lines.
pub fn head_of(door: &ServerDoor, request: &str, headers: &str) -> String {
    format!("{request} HTTP/1.1\r\nHost: localhost\r\nAuthorization: {}\r\n{headers}\r\n\r\n", bearer(door))
}

/// Connects and sends bytes as they are.
pub async fn send_raw(door: &ServerDoor, bytes: impl AsRef<[u8]>) -> TcpStream {
    let mut stream = TcpStream::connect(door.address).await.unwrap();
    stream.write_all(bytes.as_ref()).await.unwrap();
    stream
}

/// Size of a receive buffer that a few messages fill.
pub const SMALL_BUFFER_BYTES: u32 = 16 << 10;

pub struct Client(WebSocketStream<TcpStream>);

impl Client {
    pub async fn connect(door: &ServerDoor) -> Self {
        Self::over(door, TcpStream::connect(door.address).await.unwrap()).await
    }

    /// Connects and says hello.
    pub async fn join(door: &ServerDoor, session: &str, name: &str) -> (Self, Welcome) {
        Self::connect(door).await.greet(door, session, name).await.expect("a welcome")
    }

    /// Connects like [`Self::connect`], with a small receive buffer.
    pub async fn connect_with_small_buffers(door: &ServerDoor) -> Self {
        Self::over(door, connect_with_buffer(door, SMALL_BUFFER_BYTES).await).await
    }

    async fn over(door: &ServerDoor, stream: TcpStream) -> Self {
        Self(client_async(socket_request(door), stream).await.unwrap().0)
    }

    /// Says hello. Returns `None` if the answer is no welcome.
    pub async fn greet(mut self, door: &ServerDoor, session: &str, name: &str) -> Option<(Self, Welcome)> {
        self.say_hello(door, session, name).await;
        match self.next().await {
            Some(ServerMessage::Welcome(welcome)) => Some((self, *welcome)),
            _ => None,
        }
    }

    pub fn into_stream(self) -> TcpStream {
        self.0.into_inner()
    }

    pub async fn say_hello(&mut self, door: &ServerDoor, session: &str, name: &str) {
        self.say(&hello(&door.token, session, name)).await;
    }

    /// Sends an edit.
    pub async fn say_edit(&mut self, op_id: &str, base_seq: u64, command: Command) {
        self.say(&ClientMessage::Edit { op_id: op_id.into(), base_seq, command }).await;
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

    /// Returns the next control message, or `None` at the end of the connection. Skips frames.
    pub async fn next(&mut self) -> Option<ServerMessage> {
        loop {
            match self.0.next().await? {
                Ok(Message::Text(text)) => return Some(protocol::parse_body(&text).unwrap()),
                Ok(Message::Binary(bytes)) => drop(FrameHeader::from_bytes(&bytes).unwrap()),
                Ok(Message::Close(_)) | Err(_) => return None,
                Ok(_) => {}
            }
        }
    }

    /// Skips messages until `wanted` returns a value.
    pub async fn until<T>(&mut self, mut wanted: impl FnMut(ServerMessage) -> Option<T>) -> T {
        loop {
            let message = self.next().await.expect("the server has closed");
            if let Some(found) = wanted(message) {
                return found;
            }
        }
    }

    /// Returns the outcome of an operation. Skips messages before it.
    pub async fn outcome(&mut self, op_id: &str) -> Outcome {
        let outcome_in = |message| match message {
            ServerMessage::EditResult(result) if result.op_id == op_id => Some(result.outcome),
            _ => None,
        };
        self.until(outcome_in).await
    }

    /// Returns the code and message of the next fatal error.
    pub async fn fatal_error(&mut self) -> (ErrorCode, String) {
        match self.next().await {
            Some(ServerMessage::Error { code, message, fatal: true }) => (code, message),
            other => panic!("no fatal error but {other:?}"),
        }
    }

    /// Returns the next tile of a frame. Skips other messages.
    pub async fn tile(&mut self) -> FrameHeader {
        loop {
            match self.0.next().await.expect("the server has closed").unwrap() {
                Message::Binary(bytes) => return FrameHeader::from_bytes(&bytes).unwrap(),
                Message::Close(_) => panic!("the server has closed"),
                _ => {}
            }
        }
    }

    /// Returns the next frame after acknowledging it.
    pub async fn frame(&mut self) -> FrameHeader {
        let header = loop {
            let tile = self.tile().await;
            if tile.flags.is_last_tile {
                break tile;
            }
        };
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
    match client_async(request, TcpStream::connect(door.address).await.unwrap()).await {
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
pub fn send(door: &ServerDoor, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> HttpAnswer {
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
pub fn post(door: &ServerDoor, path: &str, body: &(impl ToString + ?Sized)) -> HttpAnswer {
    send_json(door, "POST", path, body)
}

/// Sends JSON with the token and that method.
pub fn send_json(door: &ServerDoor, method: &str, path: &str, body: &(impl ToString + ?Sized)) -> HttpAnswer {
    let headers = [("authorization", &*bearer(door)), ("content-type", "application/json")];
    send(door, method, path, &headers, body.to_string().as_bytes())
}

/// Requests with the token, unless the client has the answer with that tag.
pub fn get_unless(door: &ServerDoor, path: &str, tag: &str) -> HttpAnswer {
    ask_with(door, path, &[("authorization", &bearer(door)), ("if-none-match", tag)], None)
}

/// Sends a scene's file.
pub fn upload(door: &ServerDoor, query: &str, file: &[u8]) -> HttpAnswer {
    ask_with(door, &format!("/assets{query}"), &[("authorization", &bearer(door))], Some(file))
}

/// Returns the value of the header with the token.
pub fn bearer(door: &ServerDoor) -> String {
    format!("Bearer {}", door.token)
}

/// Stores a scene's file and returns the answer, which must be no error.
pub fn add_asset(door: &ServerDoor, query: &str, file: &[u8]) -> Value {
    let sent = upload(door, query, file);
    assert_eq!(sent.status, 201, "{query}: {}", sent.text());
    sent.json()
}

/// Makes a session and returns its state.
pub fn make_session(door: &ServerDoor, session: &Value) -> Value {
    let made = post(door, "/sessions", session);
    assert_eq!(made.status, 201, "{session}: {}", made.text());
    made.json()
}

/// Makes a session of the demo scene, with a name that only its test uses.
pub fn new_session(door: &ServerDoor, name: &str) {
    make_session(door, &json!({"name": name, "scene": "demo:vases"}));
}

/// Returns the state of a session.
pub fn state(door: &ServerDoor, session: &str) -> Value {
    get(door, &format!("/sessions/{session}")).json()
}

/// Sends a request of edits to a session.
pub fn post_edits(door: &ServerDoor, session: &str, request: &Value) -> HttpAnswer {
    post(door, &format!("/sessions/{session}/edits"), request)
}

/// Sends a request of edits to a session and returns the answer, which must be no error.
pub fn edit(door: &ServerDoor, session: &str, request: &Value) -> Value {
    let answer = post_edits(door, session, request);
    assert_eq!(answer.status, 200, "{}", answer.text());
    answer.json()
}

/// Carries out edits in a session and returns their results, in order.
pub fn results_of(door: &ServerDoor, session: &str, edits: &Value) -> Vec<Value> {
    edit(door, session, &json!({ "edits": edits }))["results"].as_array().expect("results").clone()
}

/// Returns a command that adds a spot light.
pub fn spot(name: &str) -> Value {
    json!({"type": "addLight", "light": {"type": "spot", "name": name, "transform": {"translation": [0, 3, 2]}}})
}

/// Returns a command that sets the property at an address.
pub fn set(target: &str, value: impl Into<Value>) -> Value {
    json!({"type": "set", "target": target, "value": value.into()})
}

/// Returns the value of a metric, whose name includes its labels.
pub fn metric(door: &ServerDoor, name: &str) -> Option<f64> {
    get(door, "/metrics").text().lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')?.parse().ok())
}

/// Runs requests on another thread, since the server runs on this one.
pub async fn on_thread<T: Send + 'static>(door: &ServerDoor, ask: impl FnOnce(&ServerDoor) -> T + Send + 'static) -> T {
    let door = door.clone();
    spawn_blocking(move || ask(&door)).await.unwrap()
}

/// Waits until `condition` is true, for 20 seconds and the time that it takes to ask.
pub async fn wait_until(what: &str, mut condition: impl AsyncFnMut() -> bool) {
    let mut tries = 0..4_000;
    while !condition().await {
        assert!(tries.next().is_some(), "{what}");
        sleep(Duration::from_millis(5)).await;
    }
}

/// Returns the message that opens a view of that size in pixels.
pub fn open_view(source: ViewSource, [width, height]: [u32; 2]) -> ClientMessage {
    ClientMessage::OpenView {
        source,
        width,
        height,
        camera_revision: 7,
        settings: None,
        interaction: None,
        stats: false,
    }
}

/// Returns a command that adds a light whose records have 40 kB, because of their digits.
pub fn large_light() -> Value {
    let third = 1.0 / 3.0;
    let points: Vec<[f64; 3]> = (0..200).map(|k| [0.0, 0.0, -third * f64::from(k)]).collect();
    let (colors, numbers) = ([[third; 3]; 200].to_vec(), [third; 200].to_vec());
    json!({"type": "addLight", "light":
        {"type": "bendy", "points": points, "radii": numbers, "colors": colors, "intensities": numbers}})
}

/// Returns commands that insert a point into light 1 and remove it again.
pub fn insert_and_remove_point() -> [Value; 2] {
    ["insertPoint", "removePoint"].map(|command| json!({"type": command, "light": 1, "point": 100}))
}
