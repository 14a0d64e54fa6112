//! The outboxes of a session's clients.

use std::collections::BTreeMap;

use protocol::ServerMessage;

use crate::ServerError;
use crate::in_flight::ByteBudget;
use crate::outbox::{Outbox, SharedText, SocketMessage, error_message};

/// A client of a session. Counts from 1 while the session is open.
pub type ClientId = u64;

/// An outbox for each client.
#[derive(Debug)]
pub struct Outboxes {
    boxes: BTreeMap<ClientId, Outbox>,
    in_flight: ByteBudget,
}

impl Outboxes {
    /// None yet. What waits in them is on that account.
    pub fn new(in_flight: ByteBudget) -> Self {
        Self { boxes: BTreeMap::new(), in_flight }
    }

    /// A client has come.
    pub fn insert(&mut self, client: ClientId, outbox: Outbox) {
        self.boxes.insert(client, outbox);
    }

    /// A client is let go: its connection closes once it has taken what waits.
    pub fn remove(&mut self, client: ClientId) {
        self.boxes.remove(&client);
    }

    /// Sends a client what it has requested, or alone is to know.
    pub fn send(&mut self, client: ClientId, message: &ServerMessage) {
        if let Some(outbox) = self.boxes.get_mut(&client) {
            outbox.send(message);
        }
    }

    /// As [`Self::send`], of a message that is text already.
    pub fn send_text(&mut self, client: ClientId, text: SharedText) {
        if let Some(outbox) = self.boxes.get_mut(&client) {
            outbox.send_text(text);
        }
    }

    /// Sends every client what each has to know, however far behind it is.
    pub fn send_all(&mut self, message: &ServerMessage) {
        let text = SharedText::of(message, &self.in_flight);
        for outbox in self.boxes.values_mut() {
            outbox.send_text(text.clone());
        }
    }

    /// Sends all clients but those that are behind; they will be sent the outcome. `requester` is sent it in any case.
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

    /// Sends a client what was wrong with its request.
    pub fn send_error(&mut self, client: ClientId, error: &ServerError) {
        self.send(client, &error_message(error, false));
    }

    /// Sends a client, unless it is behind, what is wrong without its doing.
    pub fn warn(&mut self, client: ClientId, error: &ServerError) {
        if let Some(outbox) = self.boxes.get_mut(&client) {
            outbox.try_broadcast(SharedText::of(&error_message(error, false), &self.in_flight));
        }
    }

    /// Whether a client takes one more frame.
    pub fn can_take_frame(&self, client: ClientId) -> bool {
        self.boxes.get(&client).is_some_and(Outbox::can_take_frame)
    }

    /// Whether a client has taken all frames that it was sent, and takes more.
    pub fn has_empty_frame_queue(&self, client: ClientId) -> bool {
        self.boxes.get(&client).is_some_and(Outbox::has_empty_frame_queue)
    }

    /// Sends a client the messages of a frame.
    pub fn send_frame(&self, client: ClientId, messages: Vec<SocketMessage>) {
        if let Some(outbox) = self.boxes.get(&client) {
            outbox.send_frame(messages);
        }
    }

    /// The clients whose connection is over.
    pub fn closed(&self) -> Vec<ClientId> {
        self.boxes.iter().filter(|(_, outbox)| outbox.is_closed()).map(|(id, _)| *id).collect()
    }

    /// Whether a client is behind.
    pub fn is_behind(&self, client: ClientId) -> bool {
        self.boxes.get(&client).is_some_and(Outbox::is_behind)
    }

    /// Whether there is one that `chosen` picks.
    pub fn any(&self, chosen: impl Fn(&Outbox) -> bool) -> bool {
        self.boxes.values().any(chosen)
    }

    /// Sends the clients that `chosen` picks of those behind the session as it is.
    pub fn catch_up(&mut self, chosen: impl Fn(&Outbox) -> bool, resync: &SharedText) {
        for outbox in self.boxes.values_mut().filter(|outbox| chosen(outbox)) {
            outbox.catch_up(resync.clone());
        }
    }
}
