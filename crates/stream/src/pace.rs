//! When a client gets its next frame, and which.

use std::time::{Duration, Instant};

use crate::AckWindow;

/// How long after the last change a view counts as still.
pub const SETTLE_AFTER: Duration = Duration::from_millis(250);

/// What a view shows at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewContent {
    /// Another one for all that can change the picture: the document, a gesture, the camera, the size.
    pub revision: u64,
    /// When it last did.
    pub changed_at: Instant,
}

/// How good a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameQuality {
    /// Quick, with loss: things move.
    Moving,
    /// Lossless: things are still.
    Settled,
}

/// What a client needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextFrame {
    /// Nothing, until the content changes or the client acknowledges a frame.
    Nothing,
    /// Nothing before this time either; ask again then.
    WaitUntil(Instant),
    /// A frame of [`FrameQuality::Moving`], now.
    Moving,
    /// A frame of [`FrameQuality::Settled`], now. Give it up when the content changes meanwhile.
    Settle,
}

/// What one client of a view has been sent, and what follows from it.
///
/// A new content is sent at once as a moving frame, if the window has room; what lies between two such
/// moments is never sent. Once the content is still, one settled frame of it follows. Whoever uses it asks
/// for [`FramePacer::next`] when the content has changed, a frame was acknowledged, or the time it named has come.
#[derive(Clone, Debug, Default)]
pub struct FramePacer {
    window: AckWindow,
    /// The revision and quality of the latest frame; `None` where the client has to start anew.
    latest: Option<(u64, FrameQuality)>,
}

impl FramePacer {
    /// For a client that has seen nothing of this view.
    pub fn new() -> Self {
        Self::default()
    }

    /// What the client needs: nothing while it acknowledges nothing of what is on its way.
    pub fn next(&self, content: ViewContent, now: Instant) -> NextFrame {
        let still_at = content.changed_at + SETTLE_AFTER;
        match self.latest {
            _ if !self.window.is_open() => NextFrame::Nothing,
            Some((revision, FrameQuality::Settled)) if revision == content.revision => NextFrame::Nothing,
            Some((revision, FrameQuality::Moving)) if revision == content.revision => {
                if still_at <= now {
                    NextFrame::Settle
                } else {
                    NextFrame::WaitUntil(still_at)
                }
            }
            _ => NextFrame::Moving,
        }
    }

    /// The client has nothing any more that a frame could go onto, and shows nothing of what is on its way: its next frame is a
    /// key frame.
    pub fn start_anew(&mut self) {
        self.window.clear();
        self.latest = None;
    }

    /// Whether the client's next frame is a key frame: its first, and that of [`Self::start_anew`].
    pub fn needs_key_frame(&self) -> bool {
        self.latest.is_none()
    }

    /// How many more frames may be on their way.
    pub fn free_slots(&self) -> usize {
        self.window.free_slots()
    }

    /// A frame of that revision was sent, as [`FramePacer::next`] asked for.
    pub fn sent(&mut self, frame: u64, revision: u64, quality: FrameQuality, now: Instant) {
        self.window.sent(frame, now);
        self.latest = Some((revision, quality));
    }

    /// The client has shown a frame. Returns how long after sending, or `None` where the frame is not on its
    /// way.
    pub fn acked(&mut self, frame: u64, now: Instant) -> Option<Duration> {
        self.window.acked(frame, now)
    }
}
