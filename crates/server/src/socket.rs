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
use crate::in_flight::delivery_timeout;
use crate::limits::{
    CLIENT_SILENCE_TIMEOUT, CLOSE_TIMEOUT, FRAGMENT_BYTES, HELLO_TIMEOUT, MAX_ANONYMOUS_CONNECTIONS,
    MAX_MESSAGE_BYTES, MAX_QUEUED_MESSAGES, MAX_SOCKETS, PING_EVERY,
};
use crate::outbox::{Backlog, Outbox, OutboxReceiver, SocketMessage, outbox};
use crate::outboxes::ClientId;
use crate::pacing::SocketPacing;
use crate::request::{ClientRequest, actor, client_request};
use crate::room::{JoinRequest, RoomHandle, RoomMessage};
use crate::send_within::WriteTimeoutStream;
use crate::state::AppState;

/// A connection that has become a WebSocket.
pub type Socket = WebSocketStream<WriteTimeoutStream>;

/// Reason for closing a connection that takes its messages too slowly.
const TOO_SLOW: &str = "what was sent to this connection was not taken in time: connect again";

/// Serves a connection until either side closes it.
pub async fn serve(socket: Socket, state: Arc<AppState>, connection: Connection) {
    let (sink, mut messages) = socket.split();
    let (outbox, end) = outbox(state.backend.in_flight.clone());
    let backlog = end.backlog();
    let mut writing = tokio::spawn(write(sink, end));
    if let Some((room, (client, payer), _permit)) =
        handshake(&mut messages, outbox, &state, &connection).await
    {
        let pacing = SocketPacing::new(payer, &state.backend.edit_pacing);
        tokio::select! {
            () = read(&mut messages, backlog, pacing, (&room, client), &state) => {}
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

/// Waits for `hello` and joins its session. Sends the error if that fails.
async fn handshake(
    messages: &mut SplitStream<Socket>,
    mut outbox: Outbox,
    state: &AppState,
    connection: &Connection,
) -> Option<(RoomHandle, (ClientId, Payer), OwnedSemaphorePermit)> {
    let hello = tokio::select! {
        hello = hello(messages, &mut outbox) => hello?,
        () = sleep(HELLO_TIMEOUT) => Err(ServerError::HelloTooLate),
        () = connection.until_closed_by_server() => {
            Err(ServerError::TooMany { what: "connections without the token", limit: MAX_ANONYMOUS_CONNECTIONS })
        }
    };
    match join(hello, state, connection).await {
        Ok((room, (session, permit), (principal, epoch, last_seq))) => {
            let payer = Payer::new(&session, &principal.actor.id);
            let (joined, client) = oneshot::channel();
            let join = JoinRequest { principal, epoch, last_seq, outbox, joined };
            room.send(RoomMessage::Join(Box::new(join))).await.ok()?;
            let client = client.await.ok()?;
            Some((room, (client, payer), permit))
        }
        Err(error) => {
            outbox.send_error(&error, true);
            None
        }
    }
}

/// Joining client, and the epoch and record that it says it has.
type HelloClaims = (Principal, Option<String>, Option<u64>);

/// Waits for the first message. Returns `None` if the connection ends before. Answers unreadable messages with an error
/// and skips them.
async fn hello(
    messages: &mut SplitStream<Socket>,
    outbox: &mut Outbox,
) -> Option<Result<ClientMessage, ServerError>> {
    loop {
        match next(messages).await? {
            Ok(message @ ClientMessage::Hello { .. }) => return Some(Ok(message)),
            Ok(_) => return Some(Err(ServerError::Hello)),
            Err(error) => outbox.send_error(&error, false),
        }
    }
}

/// Finds the session of a `hello`. Returns it with its name, a permit for the socket, and the claims of the client.
async fn join(
    hello: Result<ClientMessage, ServerError>,
    state: &AppState,
    connection: &Connection,
) -> Result<(RoomHandle, (Arc<str>, OwnedSemaphorePermit), HelloClaims), ServerError> {
    let (session, newcomer) = admit(hello?, state)?;
    connection.mark_authenticated();
    let too_many = |_| ServerError::TooMany { what: "sockets", limit: MAX_SOCKETS };
    let permit = Arc::clone(&state.sockets).try_acquire_owned().map_err(too_many)?;
    Ok((state.rooms.find(&session).await?, (session.into(), permit), newcomer))
}

/// Checks a `hello` and returns its session.
fn admit(hello: ClientMessage, state: &AppState) -> Result<(String, HelloClaims), ServerError> {
    let ClientMessage::Hello { protocol, token, session, actor: wire, epoch, last_seq } = hello else {
        return Err(ServerError::Hello);
    };
    if protocol != PROTOCOL {
        return Err(ServerError::Protocol(protocol));
    }
    let credential = state.token.verify(&token).ok_or(ServerError::Unauthorized)?;
    Ok((session, (Principal { credential, actor: actor(wire)? }, epoch, last_seq)))
}

/// Passes requests of the client to the room, until it leaves or is silent for too long. While it does not take its
/// answers, its requests are not read.
async fn read(
    messages: &mut SplitStream<Socket>,
    mut backlog: watch::Receiver<Backlog>,
    mut pacing: SocketPacing,
    (room, client): (&RoomHandle, ClientId),
    state: &AppState,
) {
    let places = Arc::new(Semaphore::new(MAX_QUEUED_MESSAGES));
    while backlog.wait_for(Backlog::is_reading).await.is_ok()
        && let Some(message) = next(messages).await
    {
        pacing.wait().await;
        let request = match message {
            Ok(message) => client_request(message, &state.backend.scenes).await,
            Err(error) => ClientRequest::Invalid(error),
        };
        if matches!(request, ClientRequest::Step(_)) {
            pacing.wait_to_edit().await;
        }
        // Editing messages wait here for the client's earlier ones, so that no other client waits.
        let place = if request.may_edit() { Arc::clone(&places).acquire_owned().await.ok() } else { None };
        if room.send(RoomMessage::Client { client, request, queue_permit: place }).await.is_err() {
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
            WireMessage::Text(text) if text.len() > MAX_MESSAGE_BYTES => {
                let (what, limit) = ("a message", MAX_MESSAGE_BYTES);
                return Some(Err(ServerError::TooLarge { what, limit, unit: "bytes" }));
            }
            WireMessage::Text(text) => return Some(ClientMessage::parse(&text).map_err(ServerError::from)),
            WireMessage::Binary(_) => {
                let sentence = "a binary message came, but clients send text: send JSON as text";
                return Some(Err(ServerError::BadMessage(sentence.into())));
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

async fn send_all(
    sink: &mut SplitSink<Socket, WireMessage>,
    messages: Vec<SocketMessage>,
) -> Result<(), SendError> {
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
