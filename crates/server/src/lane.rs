//! The two lanes to a client: control messages, ordered, and frames, which may be dropped.
//!
//! What all clients are told goes to each as long as its lane has room. Past that the client is behind: it is told
//! nothing more until its lane is empty, and then the session as it is by then, in one message. So a client may read as
//! slowly as it likes; it holds up nobody and takes a bounded part of the memory.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use protocol::{Problem, ServerMessage};
use tokio::sync::{mpsc, watch};

use crate::ServerError;
use crate::limits::{CONTROL_BYTES, CONTROL_QUEUE, FRAME_QUEUE};

/// The sending end. Dropping it closes the connection once the control lane is empty.
#[derive(Debug)]
pub struct Lane {
    control: mpsc::UnboundedSender<Utf8Bytes>,
    frames: mpsc::Sender<Bytes>,
    waiting: Arc<watch::Sender<Waiting>>,
    /// Answers to a client that is behind: they may refer to what it has not been told yet. `None` where it is not.
    held: Option<Vec<Utf8Bytes>>,
}

/// The receiving end, for the task that writes to the socket.
#[derive(Debug)]
pub struct LaneEnd {
    /// Texts to send, first of all.
    pub control: mpsc::UnboundedReceiver<Utf8Bytes>,
    /// Frames to send where no text waits.
    pub frames: mpsc::Receiver<Bytes>,
    waiting: Arc<watch::Sender<Waiting>>,
}

/// The control messages that a client has not taken yet, those that are held included.
#[derive(Clone, Copy, Debug, Default)]
pub struct Waiting {
    messages: usize,
    bytes: usize,
}

/// A pair of ends.
pub fn lane() -> (Lane, LaneEnd) {
    let (control, control_end) = mpsc::unbounded_channel();
    let (frames, frames_end) = mpsc::channel(FRAME_QUEUE);
    let waiting = Arc::new(watch::Sender::new(Waiting::default()));
    let end = LaneEnd { control: control_end, frames: frames_end, waiting: Arc::clone(&waiting) };
    (Lane { control, frames, waiting, held: None }, end)
}

impl Lane {
    /// Sends what this client has asked for or alone is to know. It always gets there: a client that lets its answers
    /// pile up is not listened to meanwhile.
    pub fn say(&mut self, message: &ServerMessage) {
        self.say_text(text(message));
    }

    /// As [`Self::say`], of a message that is text already.
    pub fn say_text(&mut self, text: Utf8Bytes) {
        self.waiting.send_modify(|waiting| waiting.add(&text));
        match &mut self.held {
            Some(held) => held.push(text),
            None => self.queue(text),
        }
    }

    /// Sends what goes to all clients, where there is room for it. Where there is none the client is behind.
    pub fn spread(&mut self, text: Utf8Bytes) {
        if self.held.is_some() {
            return;
        }
        if self.waiting.borrow().has_room_for(&text) {
            self.say_text(text);
        } else {
            self.held = Some(Vec::new());
        }
    }

    /// Whether the client has not been told all.
    pub fn is_behind(&self) -> bool {
        self.held.is_some()
    }

    /// Whether the client is behind and has taken all that it was sent.
    pub fn can_catch_up(&self) -> bool {
        self.held.as_ref().is_some_and(|held| self.waiting.borrow().messages == held.len())
    }

    /// Tells a client that is behind how things are, and then its answers.
    pub fn catch_up(&mut self, resync: Utf8Bytes) {
        let held = self.held.take().unwrap_or_default();
        self.say_text(resync);
        for text in held {
            self.queue(text);
        }
    }

    /// Says what is wrong.
    pub fn complain(&mut self, error: &ServerError, fatal: bool) {
        self.say(&complaint(error, fatal));
    }

    /// Whether the frame lane takes one more. A client that is behind is shown nothing that it has not been told.
    pub fn has_room(&self) -> bool {
        self.held.is_none() && self.frames.capacity() > 0
    }

    /// Sends a frame; without room for it, it is lost.
    pub fn show(&self, frame: Bytes) {
        let _ = self.frames.try_send(frame);
    }

    /// Whether the connection is over.
    pub fn is_over(&self) -> bool {
        self.control.is_closed()
    }

    fn queue(&self, text: Utf8Bytes) {
        // A connection that is over takes nothing; the session lets go of its client soon.
        let _ = self.control.send(text);
    }
}

impl LaneEnd {
    /// The client has taken a text.
    pub fn taken(&self, text: &Utf8Bytes) {
        self.waiting.send_modify(|waiting| waiting.remove(text));
    }

    /// What the client has not taken, to wait on.
    pub fn waiting(&self) -> watch::Receiver<Waiting> {
        self.waiting.subscribe()
    }
}

impl Waiting {
    /// Whether the client reads what it is sent.
    pub fn has_room(&self) -> bool {
        self.messages < CONTROL_QUEUE && self.bytes < CONTROL_BYTES
    }

    /// Whether `text` fits. Where nothing waits, anything does.
    fn has_room_for(&self, text: &Utf8Bytes) -> bool {
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
pub fn complaint(error: &ServerError, fatal: bool) -> ServerMessage {
    let Problem { code, message } = error.problem();
    ServerMessage::Error { code, message, fatal }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(end: &mut LaneEnd) -> Vec<Utf8Bytes> {
        let texts: Vec<Utf8Bytes> = std::iter::from_fn(|| end.control.try_recv().ok()).collect();
        for text in &texts {
            end.taken(text);
        }
        texts
    }

    #[test]
    fn who_does_not_read_is_sent_a_bounded_part_and_the_rest_at_once() {
        let (mut lane, mut end) = lane();
        for _ in 0..2 * CONTROL_QUEUE {
            lane.spread("news".into());
        }
        lane.say_text("answer".into());
        assert!(lane.is_behind() && !lane.has_room() && !lane.can_catch_up());
        assert!(!end.waiting().borrow().has_room(), "it is not listened to meanwhile");
        assert_eq!(sent(&mut end).len(), CONTROL_QUEUE, "the answer waits for what it refers to");
        assert!(lane.can_catch_up());
        lane.catch_up("all".into());
        lane.spread("more".into());
        assert_eq!(sent(&mut end), ["all", "answer", "more"]);
        assert!(!lane.is_behind() && lane.has_room() && end.waiting().borrow().has_room());
    }

    #[test]
    fn large_messages_are_bounded_by_their_bytes_and_one_alone_always_fits() {
        let (mut lane, mut end) = lane();
        let large: Utf8Bytes = "x".repeat(CONTROL_BYTES / 2 + 1).into();
        let huge: Utf8Bytes = "x".repeat(2 * CONTROL_BYTES).into();
        lane.spread(large.clone());
        lane.spread(large.clone());
        assert!(lane.is_behind());
        assert_eq!(sent(&mut end), [large]);
        lane.catch_up(huge.clone());
        assert_eq!(sent(&mut end), std::slice::from_ref(&huge));
        lane.spread(huge.clone());
        assert!(!lane.is_behind());
        assert_eq!(sent(&mut end), [huge]);
    }
}
