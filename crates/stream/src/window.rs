//! How many frames may be on their way to a client.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Most frames on their way that the client has not acknowledged.
pub const WINDOW: usize = 3;

/// How long a client may acknowledge nothing before the frames on their way are given up.
pub const STALL_AFTER: Duration = Duration::from_secs(2);

/// The frames on their way to one client.
///
/// Frames arrive in order and a client may pass over one that a later one has overtaken. So an
/// acknowledgement counts for all frames before it too.
#[derive(Clone, Debug, Default)]
pub struct AckWindow {
    /// Number and time of sending, in the order of sending; at most [`WINDOW`].
    under_way: VecDeque<(u64, Instant)>,
    /// When it last acknowledged a frame, or took a part of one.
    last_ack: Option<Instant>,
}

impl AckWindow {
    /// Whether one more frame may be sent.
    pub fn is_open(&self) -> bool {
        self.under_way.len() < WINDOW
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
        self.last_ack = Some(now);
        Some(now.saturating_duration_since(sent_at))
    }

    /// The client has taken a part of a frame.
    pub fn went_on(&mut self, now: Instant) {
        self.last_ack = Some(now);
    }

    /// When the client counts as stalled unless it acknowledges something; `None` where nothing is on its
    /// way.
    pub fn stalls_at(&self) -> Option<Instant> {
        let (_, oldest_sent) = *self.under_way.front()?;
        Some(self.last_ack.map_or(oldest_sent, |ack| ack.max(oldest_sent)) + STALL_AFTER)
    }

    /// Whether it does by now.
    pub fn stalled(&self, now: Instant) -> bool {
        self.stalls_at().is_some_and(|stalls_at| stalls_at <= now)
    }

    /// Gives up everything on its way.
    pub fn clear(&mut self) {
        self.under_way.clear();
    }
}
