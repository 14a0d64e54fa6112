//! The outboxes of a session's clients.

use std::collections::BTreeMap;

use axum::extract::ws::{Message as SocketMessage, Utf8Bytes};
use protocol::ServerMessage;

use crate::ServerError;
use crate::outbox::{Outbox, error_message, text};

/// A client of a session. Counts from 1 while the session is open.
pub type ClientId = u64;

/// An outbox for each client.
#[derive(Debug, Default)]
pub struct Outboxes(BTreeMap<ClientId, Outbox>);

impl Outboxes {
    /// A client has come.
    pub fn insert(&mut self, client: ClientId, outbox: Outbox) {
        self.0.insert(client, outbox);
    }

    /// A client is let go: its connection closes once it has taken what waits.
    pub fn remove(&mut self, client: ClientId) {
        self.0.remove(&client);
    }

    /// Sends a client what it has requested, or alone is to know.
    pub fn send(&mut self, client: ClientId, message: &ServerMessage) {
        if let Some(outbox) = self.0.get_mut(&client) {
            outbox.send(message);
        }
    }

    /// Sends every client what each has to know, however far behind it is.
    pub fn send_all(&mut self, message: &ServerMessage) {
        let text: Utf8Bytes = text(message);
        for outbox in self.0.values_mut() {
            outbox.send_text(text.clone());
        }
    }

    /// Sends all clients but those that are behind; they will be sent the outcome. `requester` is sent it in any case.
    pub fn broadcast(&mut self, message: &ServerMessage, requester: Option<ClientId>) {
        let text: Utf8Bytes = text(message);
        for (id, outbox) in &mut self.0 {
            if Some(*id) == requester {
                outbox.send_text(text.clone());
            } else {
                outbox.offer(text.clone());
            }
        }
    }

    /// Sends a client what was wrong with its request.
    pub fn send_error(&mut self, client: ClientId, error: &ServerError) {
        self.send(client, &error_message(error, false));
    }

    /// Sends a client, unless it is behind, what is wrong without its doing.
    pub fn warn(&mut self, client: ClientId, error: &ServerError) {
        if let Some(outbox) = self.0.get_mut(&client) {
            outbox.offer(text(&error_message(error, false)));
        }
    }

    /// Whether a client takes one more frame.
    pub fn takes_frame(&self, client: ClientId) -> bool {
        self.0.get(&client).is_some_and(Outbox::takes_frame)
    }

    /// Whether a client has taken all frames that it was sent, and takes more.
    pub fn has_taken_frames(&self, client: ClientId) -> bool {
        self.0.get(&client).is_some_and(Outbox::has_taken_frames)
    }

    /// Sends a client the messages of a frame.
    pub fn send_frame(&self, client: ClientId, messages: Vec<SocketMessage>) {
        if let Some(outbox) = self.0.get(&client) {
            outbox.send_frame(messages);
        }
    }

    /// The clients whose connection is over.
    pub fn closed(&self) -> Vec<ClientId> {
        self.0.iter().filter(|(_, outbox)| outbox.is_closed()).map(|(id, _)| *id).collect()
    }

    /// Whether a client is behind.
    pub fn is_behind(&self, client: ClientId) -> bool {
        self.0.get(&client).is_some_and(Outbox::is_behind)
    }

    /// Whether there is one that `chosen` picks.
    pub fn any(&self, chosen: impl Fn(&Outbox) -> bool) -> bool {
        self.0.values().any(chosen)
    }

    /// Sends the clients that `chosen` picks of those behind the session as it is.
    pub fn catch_up(&mut self, chosen: impl Fn(&Outbox) -> bool, resync: &ServerMessage) {
        let resync = text(resync);
        for outbox in self.0.values_mut().filter(|outbox| chosen(outbox)) {
            outbox.catch_up(resync.clone());
        }
    }
}
