//! The two lanes to a client: control messages, ordered and never dropped, and frames, which may be.

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use protocol::{Problem, ServerMessage};
use tokio::sync::mpsc;
use tokio::sync::mpsc::error::TrySendError;
use tokio_util::sync::CancellationToken;

use crate::ServerError;
use crate::limits::{CONTROL_QUEUE, FRAME_QUEUE};

/// The sending end. Dropping it closes the connection once the control lane is empty.
#[derive(Debug)]
pub struct Lane {
    control: mpsc::Sender<Utf8Bytes>,
    frames: mpsc::Sender<Bytes>,
    too_slow: CancellationToken,
}

/// The receiving end, for the task that writes to the socket.
#[derive(Debug)]
pub struct LaneEnd {
    /// Texts to send, first of all.
    pub control: mpsc::Receiver<Utf8Bytes>,
    /// Frames to send where no text waits.
    pub frames: mpsc::Receiver<Bytes>,
    /// The control lane ran over: say so and close.
    pub too_slow: CancellationToken,
}

/// A pair of ends.
pub fn lane() -> (Lane, LaneEnd) {
    let (control, control_end) = mpsc::channel(CONTROL_QUEUE);
    let (frames, frames_end) = mpsc::channel(FRAME_QUEUE);
    let too_slow = CancellationToken::new();
    let end = LaneEnd { control: control_end, frames: frames_end, too_slow: too_slow.clone() };
    (Lane { control, frames, too_slow }, end)
}

impl Lane {
    /// Sends a control message; one too many ends the connection.
    pub fn say(&self, message: &ServerMessage) {
        self.say_text(text(message));
    }

    /// As [`Self::say`], of a message that is text already, as it goes to many.
    pub fn say_text(&self, text: Utf8Bytes) {
        if let Err(TrySendError::Full(_)) = self.control.try_send(text) {
            self.too_slow.cancel();
        }
    }

    /// Says what is wrong.
    pub fn complain(&self, error: &ServerError, fatal: bool) {
        self.say(&complaint(error, fatal));
    }

    /// Whether the frame lane takes one more.
    pub fn has_room(&self) -> bool {
        self.frames.capacity() > 0
    }

    /// Sends a frame; without room for it, it is lost.
    pub fn show(&self, frame: Bytes) {
        let _ = self.frames.try_send(frame);
    }

    /// Whether the connection is over, or about to be.
    pub fn is_over(&self) -> bool {
        self.too_slow.is_cancelled() || self.control.is_closed()
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
