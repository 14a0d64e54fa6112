//! Choice of a client's next frame and of its time.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Greatest number of frames in flight that the client has not acknowledged.
pub const MAX_FRAMES_IN_FLIGHT: usize = 3;

/// Time after the last change at which a view counts as still.
pub const SETTLE_AFTER: Duration = Duration::from_millis(250);

/// Current content of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewContent {
    /// Changes with everything that can change the picture: the document, a gesture, the camera, the size.
    pub revision: u64,
    /// Time at which the revision last changed.
    pub changed_at: Instant,
}

/// Quality of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameQuality {
    /// Fast and lossy, while something moves.
    Moving,
    /// Lossless, once nothing moves.
    Settled,
}

/// Frame that a client needs next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextFrame {
    /// No frame, until the content changes or the client acknowledges a frame.
    Nothing,
    /// No frame before this time. The caller asks again at this time, or earlier if the content changes or the client
    /// acknowledges a frame.
    WaitUntil(Instant),
    /// Frame of [`FrameQuality::Moving`], at once.
    Moving,
    /// Frame of [`FrameQuality::Settled`], at once. The caller abandons it if the content changes meanwhile.
    Settle,
}

/// State of the frames that were sent to one client of a view. It determines the next frame.
///
/// New content goes out at once as a moving frame if the window has a free slot. Content between two such moments is
/// never sent. Once the content is still, one settled frame of it follows. The caller calls [`FramePacer::next`] when
/// the content has changed, a frame was acknowledged, or the time of [`NextFrame::WaitUntil`] has come.
///
/// Frames arrive in order, and a client may skip one that a later one has superseded. So an acknowledgement also counts
/// for all earlier frames.
#[derive(Clone, Debug, Default)]
pub struct FramePacer {
    /// Number of each frame in flight and the time at which it was sent, in the order of sending. At most
    /// [`MAX_FRAMES_IN_FLIGHT`].
    in_flight: VecDeque<(u64, Instant)>,
    /// True once the client has acknowledged a frame. Until then at most one is in flight, so that nothing is drawn for
    /// a client that shows nothing.
    has_acked: bool,
    /// Revision and quality of the latest frame that was sent. `None` if the next frame must be a key frame.
    latest: Option<(u64, FrameQuality)>,
}

impl FramePacer {
    /// Returns the frame that the client needs next. A client that has acknowledged none of the frames in flight gets
    /// no further frame.
    pub fn next(&self, content: ViewContent, now: Instant) -> NextFrame {
        let still_at = content.changed_at + SETTLE_AFTER;
        match self.latest {
            _ if self.free_slots() == 0 => NextFrame::Nothing,
            Some((revision, _)) if revision != content.revision => NextFrame::Moving,
            Some((_, FrameQuality::Settled)) => NextFrame::Nothing,
            Some((_, FrameQuality::Moving)) if still_at <= now => NextFrame::Settle,
            Some((_, FrameQuality::Moving)) => NextFrame::WaitUntil(still_at),
            None => NextFrame::Moving,
        }
    }

    /// Resets the state of a client that has no picture left to draw tiles on and shows none of its frames in flight.
    /// Its next frame is a key frame.
    pub fn start_anew(&mut self) {
        self.in_flight.clear();
        self.latest = None;
    }

    /// True if the client's next frame is a key frame: its first one, and the one after [`Self::start_anew`].
    pub fn needs_key_frame(&self) -> bool {
        self.latest.is_none()
    }

    /// Returns the number of frames that may still be sent before an acknowledgement.
    pub fn free_slots(&self) -> usize {
        let limit = if self.has_acked { MAX_FRAMES_IN_FLIGHT } else { 1 };
        limit.saturating_sub(self.in_flight.len())
    }

    /// Notes that a frame of that revision was sent after [`FramePacer::next`] requested it.
    pub fn sent(&mut self, frame: u64, revision: u64, quality: FrameQuality, now: Instant) {
        debug_assert!(self.free_slots() > 0, "frame {frame} was sent into a closed window");
        self.in_flight.push_back((frame, now));
        self.latest = Some((revision, quality));
    }

    /// Notes that the client has shown a frame. Returns the time since it was sent. Returns `None` and changes nothing
    /// if the frame is not in flight, because it was dropped or never sent.
    pub fn acked(&mut self, frame: u64, now: Instant) -> Option<Duration> {
        let index = self.in_flight.iter().position(|(sent, _)| *sent == frame)?;
        let (_, sent_at) = self.in_flight.drain(..=index).next_back()?;
        self.has_acked = true;
        Some(now.saturating_duration_since(sent_at))
    }
}
