//! A client's connection: a task that reads and a task that writes.

use std::sync::Arc;

use axum::body::Bytes;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, Stream, StreamExt};
use protocol::{ClientMessage, PROTOCOL};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot, watch};
use tokio::time::{Instant, interval_at, sleep, timeout, timeout_at};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::CloseFrame;
use tokio_tungstenite::tungstenite::protocol::frame::Frame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::{CloseCode, Data, OpCode};
use tokio_tungstenite::tungstenite::{Error, Message as WireMessage};

use crate::ServerError;
use crate::access::Principal;
use crate::charges::Payer;
use crate::connections::Connection;
use crate::error::check_size;
use crate::in_flight::delivery_timeout;
use crate::limits::{
    CLIENT_SILENCE_TIMEOUT, CLOSE_TIMEOUT, FRAGMENT_BYTES, HELLO_TIMEOUT, MAX_ANONYMOUS_CONNECTIONS, MAX_MESSAGE_BYTES,
    MAX_QUEUED_MESSAGES, MAX_SOCKETS, PING_EVERY,
};
use crate::outbox::{Backlog, Outbox, OutboxReceiver, SocketMessage, outbox};
use crate::outboxes::ClientId;
use crate::pacing::SocketPacing;
use crate::request::{ClientRequest, actor, client_request};
use crate::room::{JoinRequest, RoomHandle, RoomMessage};
use crate::state::AppState;
use crate::write_timeout::WriteTimeoutStream;

/// A connection that has become a WebSocket.
pub type Socket = WebSocketStream<WriteTimeoutStream>;

/// Reason for closing a connection that takes its messages too slowly.
const TOO_SLOW: &str = "what was sent to this connection was not taken in time: connect again";

/// Serves a connection until either side closes it.
pub async fn serve(socket: Socket, state: Arc<AppState>, connection: Connection) {
    let (sink, mut messages) = socket.split();
    let (outbox, end) = outbox(state.services.in_flight.clone());
    let backlog = end.backlog();
    let mut writing = tokio::spawn(write(sink, end));
    if let Some(JoinedClient { room, client, pacing, _permit }) =
        handshake(&mut messages, outbox, &state, &connection).await
    {
        tokio::select! {
            () = read(&mut messages, backlog, pacing, &room, client, &state) => {}
            // The room removed the client, or the connection is broken.
            _ = &mut writing => {}
        }
        // A closed room has already removed all clients.
        let _ = room.send(RoomMessage::Leave(client)).await;
    }
    // The rest of the control queue is still sent.
    if !writing.is_finished() {
        let _ = writing.await;
    }
    // Reads the rest. Otherwise the system resets the connection, and the client never sees the reason for closing.
    let _ = timeout(CLOSE_TIMEOUT, async { while let Some(Ok(_)) = messages.next().await {} }).await;
}

/// A client that has joined its session.
struct JoinedClient {
    room: RoomHandle,
    client: ClientId,
    pacing: SocketPacing,
    _permit: OwnedSemaphorePermit,
}

/// Waits for `hello` and joins its session. Sends the error if that fails.
async fn handshake(
    messages: &mut SplitStream<Socket>,
    mut outbox: Outbox,
    state: &AppState,
    connection: &Connection,
) -> Option<JoinedClient> {
    let hello = tokio::select! {
        hello = hello(messages, &mut outbox) => hello?,
        () = sleep(HELLO_TIMEOUT) => Err(ServerError::HelloTooLate),
        () = connection.until_closed_by_server() => {
            Err(ServerError::TooMany { what: "connections without the token", limit: MAX_ANONYMOUS_CONNECTIONS })
        }
    };
    match admit(hello, state, connection).await {
        Ok(AdmittedClient { room, session, principal, epoch, last_seq, permit }) => {
            let payer = Payer::new(&session.into(), &principal.actor.id);
            let (joined, client) = oneshot::channel();
            let join = JoinRequest { principal, epoch, last_seq, outbox, joined };
            room.send(RoomMessage::Join(Box::new(join))).await.ok()?;
            let client = client.await.ok()?;
            let pacing = SocketPacing::new(payer, &state.services.edit_pacing);
            Some(JoinedClient { room, client, pacing, _permit: permit })
        }
        Err(error) => {
            outbox.send_error(&error, true);
            None
        }
    }
}

/// Waits for the first message. Returns `None` if the connection ends before. Answers unreadable messages with an error
/// and skips them.
async fn hello(messages: &mut SplitStream<Socket>, outbox: &mut Outbox) -> Option<Result<ClientMessage, ServerError>> {
    loop {
        match next(messages).await? {
            Ok(message @ ClientMessage::Hello { .. }) => return Some(Ok(message)),
            Ok(_) => return Some(Err(ServerError::Hello)),
            Err(error) => outbox.send_error(&error, false),
        }
    }
}

/// A client whose `hello` was checked, and the room of its session.
struct AdmittedClient {
    room: RoomHandle,
    session: String,
    principal: Principal,
    /// History that the client says it has, and its latest record.
    epoch: Option<String>,
    last_seq: Option<u64>,
    permit: OwnedSemaphorePermit,
}

/// Checks a `hello`, takes a permit for the socket, and finds the room of the session.
async fn admit(
    hello: Result<ClientMessage, ServerError>,
    state: &AppState,
    connection: &Connection,
) -> Result<AdmittedClient, ServerError> {
    let ClientMessage::Hello { protocol, token, session, actor: wire, epoch, last_seq } = hello? else {
        return Err(ServerError::Hello);
    };
    if protocol != PROTOCOL {
        return Err(ServerError::Protocol(protocol));
    }
    let credential = state.token.verify(&token).ok_or(ServerError::Unauthorized)?;
    let principal = Principal { credential, actor: actor(wire)? };
    connection.mark_authenticated();
    let too_many = |_| ServerError::TooMany { what: "sockets", limit: MAX_SOCKETS };
    let permit = Arc::clone(&state.sockets).try_acquire_owned().map_err(too_many)?;
    let room = state.rooms.find(&session).await?;
    Ok(AdmittedClient { room, session, principal, epoch, last_seq, permit })
}

/// Passes requests of the client to the room, until it leaves or is silent for too long. While it does not take its
/// answers, its requests are not read.
async fn read(
    messages: &mut SplitStream<Socket>,
    mut backlog: watch::Receiver<Backlog>,
    mut pacing: SocketPacing,
    room: &RoomHandle,
    client: ClientId,
    state: &AppState,
) {
    let permits = Arc::new(Semaphore::new(MAX_QUEUED_MESSAGES));
    while backlog.wait_for(Backlog::is_reading).await.is_ok()
        && let Some(message) = next(messages).await
    {
        pacing.wait().await;
        let request = match message {
            Ok(message) => client_request(message, &state.services.scenes).await,
            Err(error) => Err(error),
        };
        let request = request.unwrap_or_else(ClientRequest::Invalid);
        if matches!(request, ClientRequest::Step(_)) {
            pacing.wait_to_edit().await;
        }
        // Editing messages wait here for the client's earlier ones, so that no other client waits.
        let queue_permit = if request.may_edit() { Arc::clone(&permits).acquire_owned().await.ok() } else { None };
        if room.send(RoomMessage::Client { client, request, queue_permit }).await.is_err() {
            return;
        }
    }
}

/// Receives the next control message, or the error of its conversion. `None` at the end of the connection.
async fn next(
    messages: &mut (impl Stream<Item = Result<WireMessage, Error>> + Unpin),
) -> Option<Result<ClientMessage, ServerError>> {
    loop {
        let frame = timeout(CLIENT_SILENCE_TIMEOUT, messages.next()).await.ok()??;
        match frame.inspect_err(|error| tracing::debug!("a connection broke: {error}")).ok()? {
            WireMessage::Text(text) => {
                let checked = check_size("a message", text.len(), MAX_MESSAGE_BYTES, "bytes");
                return Some(checked.and_then(|()| Ok(protocol::parse_body(&text)?)));
            }
            WireMessage::Binary(_) => {
                let sentence = "a binary message came, but clients send text: send JSON as text";
                return Some(Err(ServerError::bad_message(sentence)));
            }
            WireMessage::Ping(_) | WireMessage::Pong(_) | WireMessage::Frame(_) => {}
            WireMessage::Close(_) => return None,
        }
    }
}

/// Sends the messages of the outbox, control before frames. Closes the connection when the control queue ends.
async fn write(mut sink: SplitSink<Socket, WireMessage>, mut end: OutboxReceiver) {
    let mut pings = interval_at(Instant::now() + PING_EVERY, PING_EVERY);
    loop {
        let sent = tokio::select! {
            biased;
            text = end.control.recv() => match text {
                Some(text) => {
                    let sent = send(&mut sink, SocketMessage::Text(text.clone())).await;
                    end.note_delivered(&text);
                    sent
                }
                None => break,
            },
            Some(frame) = end.frames.recv() => send_all(&mut sink, frame).await,
            _ = pings.tick() => sink.send(WireMessage::Ping(Bytes::new())).await.map_err(SendError::from),
        };
        match sent {
            Ok(()) => {}
            Err(SendError::Broken) => return,
            Err(SendError::TooSlow) => {
                let why = CloseFrame { code: CloseCode::Policy, reason: TOO_SLOW.into() };
                let _ = timeout(CLOSE_TIMEOUT, sink.send(WireMessage::Close(Some(why)))).await;
                return;
            }
        }
    }
    let _ = sink.close().await;
}

enum SendError {
    /// The connection is broken.
    Broken,
    /// The client takes its data too slowly.
    TooSlow,
}

impl From<Error> for SendError {
    fn from(error: Error) -> Self {
        tracing::debug!("a connection broke: {error}");
        Self::Broken
    }
}

async fn send_all(sink: &mut SplitSink<Socket, WireMessage>, messages: Vec<SocketMessage>) -> Result<(), SendError> {
    for message in messages {
        send(sink, message).await?;
    }
    Ok(())
}

/// Sends a message in parts, each after the client has taken the one before. A large message to many clients shares its
/// bytes, and the socket copies only those of one part.
async fn send(sink: &mut SplitSink<Socket, WireMessage>, message: SocketMessage) -> Result<(), SendError> {
    let (kind, pieces) = match message {
        SocketMessage::Text(text) => (Data::Text, text.into_pieces()),
        SocketMessage::Binary(bytes) => (Data::Binary, vec![bytes]),
    };
    let mut left: usize = pieces.iter().map(Bytes::len).sum();
    let deadline = Instant::now() + delivery_timeout(left);
    let mut opcode = OpCode::Data(kind);
    for mut piece in pieces {
        while !piece.is_empty() {
            let part = piece.split_to(piece.len().min(FRAGMENT_BYTES));
            left -= part.len();
            let frame = WireMessage::Frame(Frame::message(part, opcode, left == 0));
            timeout_at(deadline, sink.send(frame)).await.map_err(|_| SendError::TooSlow)??;
            opcode = OpCode::Data(Data::Continue);
        }
    }
    Ok(())
}
