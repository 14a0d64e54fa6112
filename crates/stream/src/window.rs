//! How many frames may be on their way to a client.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Most frames on their way that the client has not acknowledged.
pub const WINDOW: usize = 3;

/// The frames on their way to one client.
///
/// Frames arrive in order and a client may pass over one that a later one has overtaken. So an
/// acknowledgement counts for all frames before it too.
#[derive(Clone, Debug, Default)]
pub struct AckWindow {
    /// Number and time of sending, in the order of sending; at most [`WINDOW`].
    under_way: VecDeque<(u64, Instant)>,
    /// Whether the client has ever acknowledged one. Until then one is under way at most: nothing is drawn for who shows nothing.
    has_acked: bool,
}

impl AckWindow {
    /// Whether one more frame may be sent.
    pub fn is_open(&self) -> bool {
        self.room() > 0
    }

    /// How many more frames may be sent.
    pub fn room(&self) -> usize {
        let window = if self.has_acked { WINDOW } else { 1 };
        window.saturating_sub(self.under_way.len())
    }

    /// How many frames are on their way.
    pub fn under_way(&self) -> usize {
        self.under_way.len()
    }

    /// A frame was sent; only while the window is open.
    pub fn sent(&mut self, frame: u64, now: Instant) {
        debug_assert!(self.is_open(), "frame {frame} was sent into a closed window");
        self.under_way.push_back((frame, now));
    }

    /// The client has shown a frame. Returns how long that took, or `None` where the frame is not on its way
    /// (it was given up, or never sent), which changes nothing.
    pub fn acked(&mut self, frame: u64, now: Instant) -> Option<Duration> {
        let index = self.under_way.iter().position(|(sent, _)| *sent == frame)?;
        let (_, sent_at) = self.under_way.drain(..=index).next_back()?;
        self.has_acked = true;
        Some(now.saturating_duration_since(sent_at))
    }

    /// Gives up everything on its way.
    pub fn clear(&mut self) {
        self.under_way.clear();
    }
}
