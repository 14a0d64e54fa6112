//! Drags a control point in a circle and measures the frames.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use image::RgbImage;
use protocol::{ServerMessage, ViewSettings};
use serde::Serialize;
use stream::FrameHeader;

use crate::dragged::DragCircle;
use crate::{BenchError, Client, Incoming, Quantiles, Tiles};

/// Shortest interval between updates: a page sends at most one per animation frame.
pub(crate) const ANIMATION_FRAME: Duration = Duration::from_micros(16_667);

/// Id that the client gives to its gesture.
pub(crate) const GESTURE: &str = "bench";

/// Stages of the latency from an update to the decoded frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LatencyStages<T> {
    /// Time from the change in the session to the start of its render: the render before it, and the wait for an open
    /// slot of the client.
    pub wait: T,
    /// Time of the render, readback included.
    pub render: T,
    pub encode: T,
    /// All other time: the update and the frame in sockets and queues.
    pub send: T,
    /// Time of decoding in the client.
    pub decode: T,
}

/// Measurements of one decoded frame of the drag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShownFrame {
    /// Times in milliseconds.
    pub stages: LatencyStages<f64>,
    pub bytes: usize,
}

/// Drags a control point in a circle, with one update per animation frame, until a frame shows the last update.
pub(crate) fn drag_in_a_circle(client: &mut Client, updates: u64) -> Result<CircleDrag, BenchError> {
    let circle = DragCircle::of(client)?;
    client.begin_gesture(GESTURE, circle.light)?;
    let mut drag = CircleDrag::default();
    let began = Instant::now();
    for update in 1..=updates {
        let command = circle.command(std::f64::consts::TAU * update as f64 / updates as f64);
        drag.sent.insert(update, Instant::now());
        client.update_gesture(GESTURE, update, command)?;
        while let Some(left) = time_until(began + ANIMATION_FRAME * update as u32) {
            drag.take(client, left)?;
        }
    }
    while drag.latest_shown < updates {
        drag.take(client, Duration::from_secs(1))?;
        if began.elapsed() > Duration::from_mins(10) {
            return Err(BenchError::Silent { what: "the last update's frame", within: began.elapsed() });
        }
    }
    drag.seconds = began.elapsed().as_secs_f64();
    Ok(drag)
}

/// Opens a view and waits for its first lossless picture, so that no other frame is in flight.
pub(crate) fn open_view(client: &mut Client, size: [u32; 2], settings: Option<ViewSettings>) -> Result<(), BenchError> {
    client.open_view(size, settings)?;
    client.wait_until_settled("a first lossless picture")
}

/// State of a drag in progress, and its measurements.
#[derive(Debug, Default)]
pub(crate) struct CircleDrag {
    /// Time at which each update was sent.
    sent: BTreeMap<u64, Instant>,
    /// Number of the update that each live revision shows.
    update_of: BTreeMap<u32, u64>,
    /// Number of the latest update that a decoded frame shows.
    latest_shown: u64,
    /// Milliseconds from each update to the frame that shows it.
    latencies_ms: Vec<f64>,
    pub shown: Vec<ShownFrame>,
    /// Length of the drag.
    pub seconds: f64,
    /// Picture to which all tiles so far have been decoded.
    pub picture: RgbImage,
}

impl CircleDrag {
    /// Receives one message or frame, for at most `timeout`.
    fn take(&mut self, client: &mut Client, timeout: Duration) -> Result<(), BenchError> {
        match client.receive(timeout)? {
            Some(Incoming::Message(message)) => match *message {
                ServerMessage::GestureState(state) => {
                    BenchError::check(state.status.problem())?;
                    self.update_of.insert(state.live_revision, state.update);
                }
                ServerMessage::Error { message, .. } => return Err(BenchError::Refused(message)),
                _ => {}
            },
            Some(Incoming::Frame(header, tiles)) => {
                let received = Instant::now();
                decode(&header, &tiles, &mut self.picture)?;
                let decoded = Instant::now();
                client.ack(&header)?;
                self.note(&header, tiles.byte_count(), decoded - received, decoded);
            }
            None => {}
        }
        Ok(())
    }

    fn note(&mut self, header: &FrameHeader, bytes: usize, decode: Duration, decoded: Instant) {
        let shows = self.update_of.range(..=header.live_revision).next_back().map_or(0, |(_, update)| *update);
        if shows <= self.latest_shown {
            return;
        }
        let first_new = self.latest_shown + 1;
        for update in first_new..=shows {
            self.latencies_ms.extend(self.sent.get(&update).map(|sent| ms(decoded - *sent)));
        }
        self.latest_shown = shows;
        let Some(sent) = self.sent.get(&shows) else { return };
        let us = |us: u32| f64::from(us) / 1000.0;
        let (wait, render, encode) = (us(header.wait_us), us(header.render_us), us(header.encode_us));
        let decode = ms(decode);
        // The header's wait counts from the oldest change that the frame shows first. The newest update cannot have
        // waited longer than its own latency minus the other stages.
        let wait = wait.min((ms(decoded - *sent) - render - encode - decode).max(0.0));
        let send = (ms(decoded - *sent) - wait - render - encode - decode).max(0.0);
        self.shown.push(ShownFrame { stages: LatencyStages { wait, render, encode, send, decode }, bytes });
    }

    /// Returns the quantiles of the time from each update to the first decoded frame that shows it.
    pub fn edit_to_decoded_ms(&self) -> Quantiles {
        Quantiles::of(self.latencies_ms.iter().copied())
    }

    /// Returns the median bytes of a frame; 0 if there is none.
    pub fn frame_bytes_p50(&self) -> usize {
        let mut bytes: Vec<usize> = self.shown.iter().map(|shown| shown.bytes).collect();
        bytes.sort_unstable();
        bytes.get(bytes.len() / 2).copied().unwrap_or(0)
    }
}

/// Decodes a frame onto `picture`, which is replaced by a black one if its size differs.
pub(crate) fn decode(header: &FrameHeader, tiles: &Tiles, picture: &mut RgbImage) -> Result<(), BenchError> {
    let size = (header.width.into(), header.height.into());
    if picture.dimensions() != size {
        *picture = RgbImage::new(size.0, size.1);
    }
    tiles.draw_on(picture)
}

/// Returns the time that is left until `end`; `None` if it has passed.
pub(crate) fn time_until(end: Instant) -> Option<Duration> {
    end.checked_duration_since(Instant::now()).filter(|left| !left.is_zero())
}

pub(crate) fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1000.0
}
