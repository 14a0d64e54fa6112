//! Outbox of a client, with two queues: ordered control messages, and frames with their statistics, which may be
//! dropped.
//!
//! Broadcasts go to a client while its outbox has room. A client without room falls behind: it gets nothing more until
//! its outbox is empty, and then the current state of the session in one message. So a client may read as slowly as it
//! likes. It delays nobody and takes a bounded part of the memory.

use std::sync::Arc;

use axum::body::Bytes;
use protocol::{Problem, ServerMessage};
use tokio::sync::{mpsc, watch};

use crate::ServerError;
use crate::in_flight::ByteBudget;
use crate::limits::{CONTROL_BYTES, CONTROL_QUEUE, FRAME_QUEUE, READ_PAUSE_BYTES, SMALL_BYTES};

/// A message to a socket.
#[derive(Debug)]
pub enum SocketMessage {
    Text(SharedText),
    /// Binary message: a frame, or a tile of one.
    Binary(Bytes),
}

/// Control message as text for the socket, in pieces. The text of a document that many clients get is a piece that they
/// share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedText {
    pieces: Vec<Bytes>,
    /// Size in bytes without the text of a document.
    own_bytes: usize,
}

impl SharedText {
    /// Makes the text of a message. Its bytes count as in flight until all receivers have taken it.
    pub fn of(message: &ServerMessage, in_flight: &ByteBudget) -> Self {
        let text = counted(json(message), in_flight);
        Self { own_bytes: text.len(), pieces: vec![text] }
    }

    /// Makes the text of a message, with `document` in place of the empty document that the message holds.
    pub fn with_document(message: &ServerMessage, document: Bytes, in_flight: &ByteBudget) -> Self {
        let (before, after) = protocol::json_around_document(message);
        let own_bytes = before.len() + after.len();
        Self { pieces: vec![counted(before, in_flight), document, counted(after, in_flight)], own_bytes }
    }

    /// Returns the pieces of the text, in order.
    pub fn into_pieces(self) -> Vec<Bytes> {
        self.pieces
    }
}

impl From<String> for SharedText {
    fn from(text: String) -> Self {
        Self { own_bytes: text.len(), pieces: vec![text.into()] }
    }
}

/// Sending end of an outbox. Dropping it closes the connection once the control queue is empty.
#[derive(Debug)]
pub struct Outbox {
    control: mpsc::UnboundedSender<SharedText>,
    frames: mpsc::Sender<Vec<SocketMessage>>,
    backlog: Arc<watch::Sender<Backlog>>,
    /// Answers held back while the client is behind, since they may refer to messages that it has not received. `None`
    /// if the client is not behind.
    deferred_answers: Option<Vec<SharedText>>,
    in_flight: ByteBudget,
}

/// Receiving end of an outbox, for the task that writes to the socket.
#[derive(Debug)]
pub struct OutboxReceiver {
    /// Texts, to be sent before frames.
    pub control: mpsc::UnboundedReceiver<SharedText>,
    /// Frames, which are sent while no text waits. Each has one message per tile. Its statistics follow its last tile.
    pub frames: mpsc::Receiver<Vec<SocketMessage>>,
    backlog: Arc<watch::Sender<Backlog>>,
}

/// Number and size of the control messages that a client has not taken yet, including answers held back.
#[derive(Clone, Copy, Debug, Default)]
pub struct Backlog {
    messages: usize,
    bytes: usize,
}

/// Makes an empty outbox and its receiving end. The bytes of its messages count in `in_flight`.
pub fn outbox(in_flight: ByteBudget) -> (Outbox, OutboxReceiver) {
    let (control, control_end) = mpsc::unbounded_channel();
    let (frames, frames_end) = mpsc::channel(FRAME_QUEUE);
    let backlog = Arc::new(watch::Sender::new(Backlog::default()));
    let end = OutboxReceiver { control: control_end, frames: frames_end, backlog: Arc::clone(&backlog) };
    (Outbox { control, frames, backlog, deferred_answers: None, in_flight }, end)
}

impl Outbox {
    /// Sends an answer, or another message for this client alone. There is always room for it, because the server does
    /// not read requests of a client that does not take its answers.
    pub fn send(&mut self, message: &ServerMessage) {
        self.send_text(SharedText::of(message, &self.in_flight));
    }

    /// Sends a message that is already text, like [`Self::send`].
    pub fn send_text(&mut self, text: SharedText) {
        self.backlog.send_modify(|backlog| backlog.add(&text));
        match &mut self.deferred_answers {
            Some(answers) => answers.push(text),
            None => self.queue(text),
        }
    }

    /// Sends a broadcast if there is room for it. Otherwise the client falls behind.
    pub fn try_broadcast(&mut self, text: SharedText) {
        if self.deferred_answers.is_some() {
            return;
        }
        let backlog = *self.backlog.borrow();
        if backlog.fits(&text) && (backlog.stays_small_with(&text) || !self.in_flight.is_full()) {
            self.send_text(text);
        } else {
            self.deferred_answers = Some(Vec::new());
        }
    }

    /// True if a broadcast did not fit.
    pub fn is_behind(&self) -> bool {
        self.deferred_answers.is_some()
    }

    /// True if the client is behind and has taken everything that it was sent.
    pub fn can_catch_up(&self) -> bool {
        self.deferred_answers.as_ref().is_some_and(|answers| self.backlog.borrow().messages == answers.len())
    }

    /// Sends a client that is behind the current state of the session, and then its answers.
    pub fn catch_up(&mut self, resync: SharedText) {
        let answers = self.deferred_answers.take().unwrap_or_default();
        self.send_text(resync);
        for text in answers {
            self.queue(text);
        }
    }

    /// Sends an error. If it is `fatal`, the connection closes after it.
    pub fn send_error(&mut self, error: &ServerError, fatal: bool) {
        self.send(&error_message(error, fatal));
    }

    /// True if there is room for a frame. A client that is behind gets no frames, since they may show records it has
    /// not received.
    pub fn can_take_frame(&self) -> bool {
        self.deferred_answers.is_none() && self.frames.capacity() > 0
    }

    /// True if there is room for a frame and the client has taken all earlier ones.
    pub fn has_empty_frame_queue(&self) -> bool {
        self.deferred_answers.is_none() && self.frames.capacity() == FRAME_QUEUE
    }

    /// Sends some or all messages of a frame. Drops them if there is no room.
    pub fn send_frame(&self, messages: Vec<SocketMessage>) {
        let _ = self.frames.try_send(messages);
    }

    /// True if the connection is closed.
    pub fn is_closed(&self) -> bool {
        self.control.is_closed()
    }

    fn queue(&self, text: SharedText) {
        // A closed connection takes nothing. The room removes its client soon.
        let _ = self.control.send(text);
    }
}

impl OutboxReceiver {
    /// Notes that the client has taken a text.
    pub fn note_delivered(&self, text: &SharedText) {
        self.backlog.send_modify(|backlog| backlog.remove(text));
    }

    /// Returns the client's backlog, for a task that waits until it changes.
    pub fn backlog(&self) -> watch::Receiver<Backlog> {
        self.backlog.subscribe()
    }
}

impl Backlog {
    /// True if the client reads its messages.
    pub fn is_reading(&self) -> bool {
        self.messages < CONTROL_QUEUE && self.bytes < READ_PAUSE_BYTES
    }

    /// True if `text` fits. In an empty queue any text does.
    fn fits(&self, text: &SharedText) -> bool {
        self.messages == 0 || self.messages < CONTROL_QUEUE && self.bytes + text.own_bytes <= CONTROL_BYTES
    }

    /// True if the queue stays small with `text`, so large bodies and answers of other clients do not delay small
    /// messages. In an empty queue any text does.
    fn stays_small_with(&self, text: &SharedText) -> bool {
        self.messages == 0 || self.bytes + text.own_bytes <= SMALL_BYTES
    }

    fn add(&mut self, text: &SharedText) {
        self.messages += 1;
        self.bytes += text.own_bytes;
    }

    fn remove(&mut self, text: &SharedText) {
        self.messages -= 1;
        self.bytes -= text.own_bytes;
    }
}

/// Makes the text of a control message that is sent with a frame and counts as part of it.
pub fn text(message: &ServerMessage) -> SharedText {
    json(message).into()
}

fn json(message: &ServerMessage) -> String {
    serde_json::to_string(message).expect("plain data with string keys")
}

fn counted(text: String, in_flight: &ByteBudget) -> Bytes {
    in_flight.reserve_unchecked(text.len()).attach_to(text)
}

/// Makes the message that reports an error.
pub fn error_message(error: &ServerError, fatal: bool) -> ServerMessage {
    let Problem { code, message } = error.problem();
    ServerMessage::Error { code, message, fatal }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shared(text: &str) -> SharedText {
        text.to_owned().into()
    }

    fn sent(end: &mut OutboxReceiver) -> Vec<SharedText> {
        let texts: Vec<SharedText> = std::iter::from_fn(|| end.control.try_recv().ok()).collect();
        for text in &texts {
            end.note_delivered(text);
        }
        texts
    }

    #[test]
    fn a_client_that_does_not_read_gets_a_bounded_part_and_then_the_current_state() {
        let (mut outbox, mut end) = outbox(ByteBudget::default());
        for _ in 0..2 * CONTROL_QUEUE {
            outbox.try_broadcast(shared("news"));
        }
        outbox.send_text(shared("answer"));
        assert!(outbox.is_behind() && !outbox.can_take_frame() && !outbox.can_catch_up());
        assert!(!end.backlog().borrow().is_reading(), "it is not listened to meanwhile");
        assert_eq!(sent(&mut end).len(), CONTROL_QUEUE, "the answer waits for what it refers to");
        assert!(outbox.can_catch_up());
        outbox.catch_up(shared("all"));
        outbox.try_broadcast(shared("more"));
        assert_eq!(sent(&mut end), ["all", "answer", "more"].map(shared));
        assert!(!outbox.is_behind() && outbox.can_take_frame() && end.backlog().borrow().is_reading());
    }

    #[test]
    fn large_messages_are_bounded_by_their_bytes_and_one_alone_always_fits() {
        let (mut outbox, mut end) = outbox(ByteBudget::default());
        let large: SharedText = "x".repeat(CONTROL_BYTES / 2 + 1).into();
        let huge: SharedText = "x".repeat(2 * CONTROL_BYTES).into();
        outbox.try_broadcast(large.clone());
        outbox.try_broadcast(large.clone());
        assert!(outbox.is_behind());
        assert_eq!(sent(&mut end), [large]);
        outbox.catch_up(huge.clone());
        assert_eq!(sent(&mut end), std::slice::from_ref(&huge));
        outbox.try_broadcast(huge.clone());
        assert!(!outbox.is_behind());
        assert_eq!(sent(&mut end), [huge]);
    }

    #[test]
    fn texts_count_once_and_a_full_budget_leaves_clients_behind_that_do_not_read() {
        let in_flight = ByteBudget::default();
        let ((mut one, mut end), (mut two, _two_end)) = (outbox(in_flight.clone()), outbox(in_flight.clone()));
        let news = ServerMessage::Draining { retry_after_ms: 1 };
        let text = SharedText::of(&news, &in_flight);
        let length = text.own_bytes;
        one.try_broadcast(text.clone());
        two.try_broadcast(text);
        assert_eq!(in_flight.bytes(), length, "both wait for the same bytes");
        let full = in_flight.reserve_unchecked(crate::limits::MAX_BYTES_IN_FLIGHT);
        sent(&mut end);
        let text = SharedText::of(&news, &in_flight);
        one.try_broadcast(text.clone());
        two.try_broadcast(text);
        assert!(!one.is_behind() && !two.is_behind(), "others' large messages hold up no small ones");
        sent(&mut end);
        let large = shared(&"x".repeat(SMALL_BYTES));
        one.try_broadcast(large.clone());
        two.try_broadcast(large);
        assert!(!one.is_behind() && two.is_behind(), "who reads is told, who does not is behind");
        drop((full, one, end));
    }
}
