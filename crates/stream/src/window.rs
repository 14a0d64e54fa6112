//! How many frames may be on their way to a client.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Most frames on their way that the client has not acknowledged.
pub const MAX_FRAMES_IN_FLIGHT: usize = 3;

/// The frames on their way to one client.
///
/// Frames arrive in order and a client may pass over one that a later one has overtaken. So an
/// acknowledgement counts for all frames before it too.
#[derive(Clone, Debug, Default)]
pub struct AckWindow {
    /// Number and time of sending, in the order of sending; at most [`MAX_FRAMES_IN_FLIGHT`].
    in_flight: VecDeque<(u64, Instant)>,
    /// Whether the client has ever acknowledged one. Until then one is under way at most: nothing is drawn for who shows nothing.
    has_acked: bool,
}

impl AckWindow {
    /// Whether one more frame may be sent.
    pub fn is_open(&self) -> bool {
        self.free_slots() > 0
    }

    /// How many more frames may be sent.
    pub fn free_slots(&self) -> usize {
        let window = if self.has_acked { MAX_FRAMES_IN_FLIGHT } else { 1 };
        window.saturating_sub(self.in_flight.len())
    }

    /// How many frames are on their way.
    pub fn in_flight(&self) -> usize {
        self.in_flight.len()
    }

    /// A frame was sent; only while the window is open.
    pub fn sent(&mut self, frame: u64, now: Instant) {
        debug_assert!(self.is_open(), "frame {frame} was sent into a closed window");
        self.in_flight.push_back((frame, now));
    }

    /// The client has shown a frame. Returns how long that took, or `None` where the frame is not on its way
    /// (it was given up, or never sent), which changes nothing.
    pub fn acked(&mut self, frame: u64, now: Instant) -> Option<Duration> {
        let index = self.in_flight.iter().position(|(sent, _)| *sent == frame)?;
        let (_, sent_at) = self.in_flight.drain(..=index).next_back()?;
        self.has_acked = true;
        Some(now.saturating_duration_since(sent_at))
    }

    /// Gives up everything on its way.
    pub fn clear(&mut self) {
        self.in_flight.clear();
    }
}
