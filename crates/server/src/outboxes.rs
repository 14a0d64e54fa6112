//! The outboxes of a session's clients.

use std::collections::BTreeMap;

use protocol::ServerMessage;

use crate::ServerError;
use crate::in_flight::ByteBudget;
use crate::outbox::{Outbox, SharedText, SocketMessage, error_message};

/// Number of a client in a session. Counts from 1 while the session is open.
pub type ClientId = u64;

#[derive(Debug)]
pub struct Outboxes {
    boxes: BTreeMap<ClientId, Outbox>,
    in_flight: ByteBudget,
}

impl Outboxes {
    /// Makes a set without outboxes. The bytes of their messages will count in `in_flight`.
    pub fn new(in_flight: ByteBudget) -> Self {
        Self { boxes: BTreeMap::new(), in_flight }
    }

    pub fn insert(&mut self, client: ClientId, outbox: Outbox) {
        self.boxes.insert(client, outbox);
    }

    /// Removes a client. Its connection closes once it has taken its waiting messages.
    pub fn remove(&mut self, client: ClientId) {
        self.boxes.remove(&client);
    }

    /// Sends a client an answer, or a message for it alone.
    pub fn send(&mut self, client: ClientId, message: &ServerMessage) {
        if let Some(outbox) = self.boxes.get_mut(&client) {
            outbox.send(message);
        }
    }

    /// Sends a message that is already text, like [`Self::send`].
    pub fn send_text(&mut self, client: ClientId, text: SharedText) {
        if let Some(outbox) = self.boxes.get_mut(&client) {
            outbox.send_text(text);
        }
    }

    /// Sends every client a message, even if it is behind.
    pub fn send_all(&mut self, message: &ServerMessage) {
        let text = SharedText::of(message, &self.in_flight);
        for outbox in self.boxes.values_mut() {
            outbox.send_text(text.clone());
        }
    }

    /// Sends a message to all clients that are not behind. Those that are get the current state later. `requester` gets
    /// the message in any case.
    pub fn broadcast(&mut self, message: &ServerMessage, requester: Option<ClientId>) {
        let text = SharedText::of(message, &self.in_flight);
        for (id, outbox) in &mut self.boxes {
            if Some(*id) == requester {
                outbox.send_text(text.clone());
            } else {
                outbox.try_broadcast(text.clone());
            }
        }
    }

    /// Sends a client the error of its request.
    pub fn send_error(&mut self, client: ClientId, error: &ServerError) {
        self.send(client, &error_message(error, false));
    }

    /// Sends a client an error that it did not cause, unless it is behind.
    pub fn warn(&mut self, client: ClientId, error: &ServerError) {
        if let Some(outbox) = self.boxes.get_mut(&client) {
            outbox.try_broadcast(SharedText::of(&error_message(error, false), &self.in_flight));
        }
    }

    /// True if `condition` is true for a client's outbox.
    pub fn is(&self, client: ClientId, condition: impl Fn(&Outbox) -> bool) -> bool {
        self.boxes.get(&client).is_some_and(condition)
    }

    /// Sends a client the messages of a frame.
    pub fn send_frame(&self, client: ClientId, messages: Vec<SocketMessage>) {
        if let Some(outbox) = self.boxes.get(&client) {
            outbox.send_frame(messages);
        }
    }

    /// Returns the clients whose connection is closed.
    pub fn closed(&self) -> Vec<ClientId> {
        self.boxes.iter().filter(|(_, outbox)| outbox.is_closed()).map(|(id, _)| *id).collect()
    }

    /// True if `chosen` is true for any client's outbox.
    pub fn any(&self, chosen: impl Fn(&Outbox) -> bool) -> bool {
        self.boxes.values().any(chosen)
    }

    /// Sends the current state of the session to the clients for which `chosen` is true, which must be behind.
    pub fn catch_up(&mut self, chosen: impl Fn(&Outbox) -> bool, resync: &SharedText) {
        for outbox in self.boxes.values_mut().filter(|outbox| chosen(outbox)) {
            outbox.catch_up(resync.clone());
        }
    }
}
