//! One picture of a view: made by the renderer, encoded, and as a message to each client.

use std::time::{Duration, Instant};

use axum::body::Bytes;
use render::Pixels;
use stream::{Codec, Content, Flags, FrameHeader, HEADER_BYTES, MOVING_QUALITY, Quality, Tile};
use tokio::task::spawn_blocking;

use crate::ServerError;
use crate::backend::Backend;
use crate::renderer::Request;

/// Samples a pixel of the picture of a still view: smooth edges for four times the work.
const SETTLE_SAMPLES: u32 = 4;

/// An encoded picture and what it shows.
pub struct Frame {
    pub stamp: Stamp,
    payload: Vec<u8>,
    wait: Duration,
    render: Duration,
    encode: Duration,
}

/// What a picture shows.
pub struct Stamp {
    pub content: Content,
    pub quality: Quality,
    pub log_seq: u64,
    pub live_revision: u32,
    pub camera_revision: u32,
    pub size: [u32; 2],
}

/// What became of a picture.
pub type Picture = Result<Frame, ServerError>;

impl Frame {
    /// The binary message for one client.
    pub fn message(&self, frame: u64, key: bool) -> Bytes {
        let Stamp { content: _, quality, log_seq, live_revision, camera_revision, size } = self.stamp;
        let [width, height] = size.map(|side| side as u16);
        let header = FrameHeader {
            codec: codec(quality),
            flags: Flags { key, settle: quality == Quality::Settled, last_tile: true },
            view: 0,
            frame,
            log_seq,
            camera_revision,
            live_revision,
            samples: samples(quality) as u16,
            tile: Tile { x: 0, y: 0, width, height },
            width,
            height,
            wait_us: micros(self.wait),
            render_us: micros(self.render),
            encode_us: micros(self.encode),
        };
        let mut message = Vec::with_capacity(HEADER_BYTES + self.payload.len());
        message.extend(header.to_bytes());
        message.extend(&self.payload);
        message.into()
    }
}

/// Draws and encodes the picture that `request` describes and `stamp` says what it shows.
pub async fn make_picture(backend: Backend, request: Request, stamp: Stamp) -> Picture {
    let drawn = backend.renders.draw(request).await?;
    backend.metrics.frames_rendered.inc();
    backend.metrics.render_seconds.observe(drawn.took.as_secs_f64());
    let (quality, [width, height]) = (stamp.quality, stamp.size.map(|side| side as u16));
    let started = Instant::now();
    let Pixels::Display { bytes, .. } = drawn.pixels else { return Err(ServerError::Fault) };
    let encoded = spawn_blocking(move || match quality {
        Quality::Moving => stream::jpeg(&bytes, width, height, MOVING_QUALITY),
        Quality::Settled => stream::png(&bytes, width, height),
    });
    let payload = encoded.await.map_err(|_| ServerError::Fault)??;
    let encode = started.elapsed();
    backend.metrics.frames_encoded.get_or_create(&codec(quality).into()).inc();
    backend.metrics.encode_seconds.observe(encode.as_secs_f64());
    let wait = drawn.started.saturating_duration_since(stamp.content.changed_at);
    Ok(Frame { stamp, payload, wait, render: drawn.took, encode })
}

/// How pictures of that quality are encoded.
pub fn codec(quality: Quality) -> Codec {
    match quality {
        Quality::Moving => Codec::Jpeg,
        Quality::Settled => Codec::Png,
    }
}

/// Samples a pixel of pictures of that quality.
pub fn samples(quality: Quality) -> u32 {
    match quality {
        Quality::Moving => 1,
        Quality::Settled => SETTLE_SAMPLES,
    }
}

fn micros(duration: Duration) -> u32 {
    duration.as_micros().try_into().unwrap_or(u32::MAX)
}
