//! What waits to be sent to a client, in two queues: control messages, ordered, and frames, which may be dropped, each with
//! what is told of it.
//!
//! What is broadcast goes to each client as long as its outbox has room. Past that the client is behind: it is sent
//! nothing more until its outbox is empty, and then the session as it is by then, in one message. So a client may read as
//! slowly as it likes; it holds up nobody and takes a bounded part of the memory.

use std::sync::Arc;

use axum::extract::ws::{Message as SocketMessage, Utf8Bytes};
use protocol::{Problem, ServerMessage};
use tokio::sync::{mpsc, watch};

use crate::ServerError;
use crate::limits::{CONTROL_BYTES, CONTROL_QUEUE, FRAME_QUEUE};

/// The sending end. Dropping it closes the connection once the control queue is empty.
#[derive(Debug)]
pub struct Outbox {
    control: mpsc::UnboundedSender<Utf8Bytes>,
    frames: mpsc::Sender<Vec<SocketMessage>>,
    backlog: Arc<watch::Sender<Backlog>>,
    /// Answers to a client that is behind: they may refer to what it has not been told yet. `None` where it is not.
    held: Option<Vec<Utf8Bytes>>,
}

/// The receiving end, for the task that writes to the socket.
#[derive(Debug)]
pub struct OutboxReceiver {
    /// Texts to send, first of all.
    pub control: mpsc::UnboundedReceiver<Utf8Bytes>,
    /// Frames to send where no text waits: a message a tile, and what is told of the frame behind its last.
    pub frames: mpsc::Receiver<Vec<SocketMessage>>,
    backlog: Arc<watch::Sender<Backlog>>,
}

/// The control messages that a client has not taken yet, those that are held included.
#[derive(Clone, Copy, Debug, Default)]
pub struct Backlog {
    messages: usize,
    bytes: usize,
}

/// An empty outbox and its receiving end.
pub fn outbox() -> (Outbox, OutboxReceiver) {
    let (control, control_end) = mpsc::unbounded_channel();
    let (frames, frames_end) = mpsc::channel(FRAME_QUEUE);
    let backlog = Arc::new(watch::Sender::new(Backlog::default()));
    let end = OutboxReceiver { control: control_end, frames: frames_end, backlog: Arc::clone(&backlog) };
    (Outbox { control, frames, backlog, held: None }, end)
}

impl Outbox {
    /// Sends what this client has requested or alone is to know. It always gets there: a client that lets its answers
    /// pile up is not listened to meanwhile.
    pub fn send(&mut self, message: &ServerMessage) {
        self.send_text(text(message));
    }

    /// As [`Self::send`], of a message that is text already.
    pub fn send_text(&mut self, text: Utf8Bytes) {
        self.backlog.send_modify(|backlog| backlog.add(&text));
        match &mut self.held {
            Some(held) => held.push(text),
            None => self.queue(text),
        }
    }

    /// Sends what is broadcast, where there is room for it. Where there is none the client is behind.
    pub fn offer(&mut self, text: Utf8Bytes) {
        if self.held.is_some() {
            return;
        }
        if self.backlog.borrow().fits(&text) {
            self.send_text(text);
        } else {
            self.held = Some(Vec::new());
        }
    }

    /// Whether something that was broadcast did not fit.
    pub fn is_behind(&self) -> bool {
        self.held.is_some()
    }

    /// Whether the client is behind and has taken all that it was sent.
    pub fn can_catch_up(&self) -> bool {
        self.held.as_ref().is_some_and(|held| self.backlog.borrow().messages == held.len())
    }

    /// Sends a client that is behind the session as it is, and then its answers.
    pub fn catch_up(&mut self, resync: Utf8Bytes) {
        let held = self.held.take().unwrap_or_default();
        self.send_text(resync);
        for text in held {
            self.queue(text);
        }
    }

    /// Sends what is wrong; `fatal` where the connection ends with it.
    pub fn send_error(&mut self, error: &ServerError, fatal: bool) {
        self.send(&error_message(error, fatal));
    }

    /// Whether it takes one more frame. A client that is behind is shown nothing that it has not been told.
    pub fn takes_frame(&self) -> bool {
        self.held.is_none() && self.frames.capacity() > 0
    }

    /// Whether it takes a frame and holds none that the client has not taken.
    pub fn has_taken_frames(&self) -> bool {
        self.held.is_none() && self.frames.capacity() == FRAME_QUEUE
    }

    /// Sends the messages of a frame, or some of them; without room for them they are lost.
    pub fn send_frame(&self, messages: Vec<SocketMessage>) {
        let _ = self.frames.try_send(messages);
    }

    /// Whether the connection is over.
    pub fn is_closed(&self) -> bool {
        self.control.is_closed()
    }

    fn queue(&self, text: Utf8Bytes) {
        // A connection that is over takes nothing; the session lets go of its client soon.
        let _ = self.control.send(text);
    }
}

impl OutboxReceiver {
    /// The client has taken a text.
    pub fn taken(&self, text: &Utf8Bytes) {
        self.backlog.send_modify(|backlog| backlog.remove(text));
    }

    /// What the client has not taken, to wait on.
    pub fn backlog(&self) -> watch::Receiver<Backlog> {
        self.backlog.subscribe()
    }
}

impl Backlog {
    /// Whether the client reads what it is sent.
    pub fn takes_more(&self) -> bool {
        self.messages < CONTROL_QUEUE && self.bytes < CONTROL_BYTES
    }

    /// Whether `text` fits. Where nothing waits, anything does.
    fn fits(&self, text: &Utf8Bytes) -> bool {
        self.messages == 0 || self.messages < CONTROL_QUEUE && self.bytes + text.len() <= CONTROL_BYTES
    }

    fn add(&mut self, text: &Utf8Bytes) {
        self.messages += 1;
        self.bytes += text.len();
    }

    fn remove(&mut self, text: &Utf8Bytes) {
        self.messages -= 1;
        self.bytes -= text.len();
    }
}

/// A control message as it goes over the wire.
pub fn text(message: &ServerMessage) -> Utf8Bytes {
    serde_json::to_string(message).expect("plain data with string keys").into()
}

/// The message that says what is wrong.
pub fn error_message(error: &ServerError, fatal: bool) -> ServerMessage {
    let Problem { code, message } = error.problem();
    ServerMessage::Error { code, message, fatal }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(end: &mut OutboxReceiver) -> Vec<Utf8Bytes> {
        let texts: Vec<Utf8Bytes> = std::iter::from_fn(|| end.control.try_recv().ok()).collect();
        for text in &texts {
            end.taken(text);
        }
        texts
    }

    #[test]
    fn who_does_not_read_is_sent_a_bounded_part_and_the_rest_at_once() {
        let (mut outbox, mut end) = outbox();
        for _ in 0..2 * CONTROL_QUEUE {
            outbox.offer("news".into());
        }
        outbox.send_text("answer".into());
        assert!(outbox.is_behind() && !outbox.takes_frame() && !outbox.can_catch_up());
        assert!(!end.backlog().borrow().takes_more(), "it is not listened to meanwhile");
        assert_eq!(sent(&mut end).len(), CONTROL_QUEUE, "the answer waits for what it refers to");
        assert!(outbox.can_catch_up());
        outbox.catch_up("all".into());
        outbox.offer("more".into());
        assert_eq!(sent(&mut end), ["all", "answer", "more"]);
        assert!(!outbox.is_behind() && outbox.takes_frame() && end.backlog().borrow().takes_more());
    }

    #[test]
    fn large_messages_are_bounded_by_their_bytes_and_one_alone_always_fits() {
        let (mut outbox, mut end) = outbox();
        let large: Utf8Bytes = "x".repeat(CONTROL_BYTES / 2 + 1).into();
        let huge: Utf8Bytes = "x".repeat(2 * CONTROL_BYTES).into();
        outbox.offer(large.clone());
        outbox.offer(large.clone());
        assert!(outbox.is_behind());
        assert_eq!(sent(&mut end), [large]);
        outbox.catch_up(huge.clone());
        assert_eq!(sent(&mut end), std::slice::from_ref(&huge));
        outbox.offer(huge.clone());
        assert!(!outbox.is_behind());
        assert_eq!(sent(&mut end), [huge]);
    }
}
