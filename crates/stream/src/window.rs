//! Limit on the frames in flight to a client.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Greatest number of frames in flight that the client has not acknowledged.
pub const MAX_FRAMES_IN_FLIGHT: usize = 3;

/// The frames in flight to one client.
///
/// Frames arrive in order, and a client may skip one that a later one has superseded. So an acknowledgement also counts
/// for all earlier frames.
#[derive(Clone, Debug, Default)]
pub struct AckWindow {
    /// Number of each frame in flight and the time at which it was sent, in the order of sending. At most
    /// [`MAX_FRAMES_IN_FLIGHT`].
    in_flight: VecDeque<(u64, Instant)>,
    /// True once the client has acknowledged a frame. Until then at most one is in flight, so that nothing is drawn for
    /// a client that shows nothing.
    has_acked: bool,
}

impl AckWindow {
    /// True if another frame may be sent.
    pub fn is_open(&self) -> bool {
        self.free_slots() > 0
    }

    /// Returns the number of frames that may still be sent.
    pub fn free_slots(&self) -> usize {
        let window = if self.has_acked { MAX_FRAMES_IN_FLIGHT } else { 1 };
        window.saturating_sub(self.in_flight.len())
    }

    /// Returns the number of frames in flight.
    pub fn in_flight(&self) -> usize {
        self.in_flight.len()
    }

    /// Notes that a frame was sent. The window must be open.
    pub fn sent(&mut self, frame: u64, now: Instant) {
        debug_assert!(self.is_open(), "frame {frame} was sent into a closed window");
        self.in_flight.push_back((frame, now));
    }

    /// Notes that the client has shown a frame. Returns the time since it was sent. Returns `None` and changes nothing
    /// if the frame is not in flight, because it was cleared or never sent.
    pub fn acked(&mut self, frame: u64, now: Instant) -> Option<Duration> {
        let index = self.in_flight.iter().position(|(sent, _)| *sent == frame)?;
        let (_, sent_at) = self.in_flight.drain(..=index).next_back()?;
        self.has_acked = true;
        Some(now.saturating_duration_since(sent_at))
    }

    /// Forgets all frames in flight.
    pub fn clear(&mut self) {
        self.in_flight.clear();
    }
}
