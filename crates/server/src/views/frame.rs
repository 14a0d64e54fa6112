//! Life of one picture of a view: drawing, encoding, and messages to clients.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use protocol::{FrameStats, PassRun, TraceLine, TraceWhat};
use render::Pixels;
use stream::{Codec, FrameFlags, FrameHeader, FrameQuality, FrameTile, HEADER_BYTES, MOVING_QUALITY, ViewContent};
use tokio::task::spawn_blocking;

use super::detail::{Detail, TimedPicture};
use super::moving_pixels::PictureScale;
use crate::ServerError;
use crate::background;
use crate::charges::Payer;
use crate::limits::LARGE_ENCODE_PIXELS;
use crate::outboxes::ClientId;
use crate::picture_stats::{micros, wire_pass_runs};
use crate::renderer::PictureRequest;
use crate::services::Services;
use crate::trace::PictureTrace;

/// Samples per pixel of a still view: smooth edges for four times the work.
const SETTLE_SAMPLES: u32 = 4;

/// Side of the tile that is sent if nothing differs, in pixels.
const MIN_TILE_SIDE: u16 = 16;

/// An encoded picture and its content.
pub struct EncodedFrame {
    /// The picture before its encoding. The next picture is compared with its pixels.
    pub drawn: DrawnFrame,
    /// Number of the picture among all of the session's views. Counts from 1.
    pub number: u64,
    /// Picture onto which the client draws these tiles. `None` if the tiles cover the whole picture.
    pub base: Option<FrameId>,
    /// Rectangle and encoded file of each tile. Each tile becomes one message.
    tiles: Vec<(FrameTile, Vec<u8>)>,
    encode: Duration,
}

/// Content of a picture and its revisions.
pub struct FrameStamp {
    pub content: ViewContent,
    pub quality: FrameQuality,
    pub log_seq: u64,
    pub live_revision: u32,
    pub camera_revision: u32,
    /// Reduction of the picture while something moves. A lossless picture has full detail.
    pub detail: Detail,
    /// Size of the view in pixels.
    pub view_size: [u32; 2],
    /// Additional scale beside the detail's resolution.
    pub picture_scale: PictureScale,
}

/// Identifies a picture among all pictures of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameId {
    revision: u64,
    quality: FrameQuality,
    detail: Detail,
    size: [u32; 2],
}

impl FrameStamp {
    pub fn frame_id(&self) -> FrameId {
        let Self { content, quality, detail, .. } = *self;
        FrameId { revision: content.revision, quality, detail, size: self.size() }
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.picture_scale.size(self.detail.resolution.of(self.view_size))
    }
}

/// A drawn picture before its encoding.
pub struct DrawnFrame {
    pub stamp: FrameStamp,
    /// RGBA, rows from the top.
    pixels: Vec<u8>,
    wait: Duration,
    render: Duration,
    /// True if a shadow map was drawn for it.
    drew_map: bool,
    passes: Vec<PassRun>,
    trace: PictureTrace,
}

/// A finished step of a picture.
pub enum ViewStep {
    Drawn(DrawnFrame),
    Encoded(EncodedFrame),
}

/// Result of drawing or encoding a picture.
pub type ViewStepResult = Result<ViewStep, ServerError>;

impl EncodedFrame {
    /// Returns the time that drawing and encoding took, for the choice of detail.
    pub fn timed_picture(&self) -> TimedPicture {
        TimedPicture {
            detail: self.drawn.stamp.detail,
            took: self.drawn.render + self.encode,
            drew_map: self.drawn.drew_map,
        }
    }

    /// Returns the statistics for a client that receives the picture as frame `frame`, in `bytes` bytes. If the picture
    /// was reused, no passes ran for the client.
    pub fn stats(&self, frame: u64, bytes: usize, is_reused: bool) -> FrameStats {
        FrameStats {
            frame,
            wait_us: micros(self.drawn.wait),
            render_us: micros(self.drawn.render),
            encode_us: micros(self.encode),
            bytes: bytes as u64,
            tiles: self.tiles.len() as u32,
            size: self.drawn.stamp.size(),
            shadow_map_divisor: self.drawn.stamp.detail.shadow_map.divisor(),
            quality: wire_quality(self.drawn.stamp.quality),
            passes: if is_reused { Vec::new() } else { self.drawn.passes.clone() },
        }
    }

    /// Returns the number of messages, one per tile.
    pub fn message_count(&self) -> usize {
        self.tiles.len()
    }

    /// Makes the binary message of that index for one client.
    pub fn message(&self, index: usize, frame: u64, key: bool) -> Bytes {
        let (tile, payload) = &self.tiles[index];
        let FrameStamp { quality, log_seq, live_revision, camera_revision, detail, view_size, .. } = self.drawn.stamp;
        let [width, height] = self.drawn.stamp.size().map(|side| side as u16);
        let [view_width, view_height] = view_size.map(|side| side as u16);
        let header = FrameHeader {
            codec: codec(quality),
            flags: FrameFlags {
                is_key: key,
                is_settled: quality == FrameQuality::Settled,
                is_last_tile: index + 1 == self.tiles.len(),
            },
            view: 0,
            frame,
            log_seq,
            camera_revision,
            live_revision,
            samples: samples(quality) as u16,
            shadow_map_divisor: detail.shadow_map.divisor(),
            tile: *tile,
            width,
            height,
            wait_us: micros(self.drawn.wait),
            render_us: micros(self.drawn.render),
            encode_us: micros(self.encode),
            view_width,
            view_height,
        };
        let mut message = Vec::with_capacity(HEADER_BYTES + payload.len());
        message.extend(header.to_bytes());
        message.extend(payload);
        message.into()
    }
}

/// Draws the picture of `request`, with the content that `stamp` describes, for the view of a client of that session.
pub async fn draw_picture(
    services: Services,
    request: PictureRequest,
    stamp: FrameStamp,
    session: Arc<str>,
    client: ClientId,
) -> ViewStepResult {
    let drawn = services.renders.draw(request).await?;
    services.metrics.frames_rendered.inc();
    services.metrics.render_seconds.observe(drawn.render_time.as_secs_f64());
    let Pixels::Display { bytes: pixels, .. } = drawn.pixels else { return Err(ServerError::Internal) };
    let wait = drawn.started.saturating_duration_since(stamp.content.changed_at);
    services.metrics.frame_wait_seconds.observe(wait.as_secs_f64());
    let (render, drew_map, passes) = (drawn.render_time, drawn.drew_map, wire_pass_runs(&drawn.passes));
    let trace = services.trace.drawn(|| TraceLine {
        time: drawn.started.saturating_duration_since(services.started).as_secs_f64(),
        session: session.to_string(),
        what: TraceWhat::View { client },
        size: stamp.size(),
        quality: wire_quality(stamp.quality),
        wait_us: micros(wait),
        render_us: micros(render),
        encode_us: None,
        passes: passes.clone(),
        left_out: 0,
    });
    Ok(ViewStep::Drawn(DrawnFrame { stamp, pixels, wait, render, drew_map, passes, trace }))
}

/// Encodes a picture and charges `payer` for the time. For a moving picture with a `base`, encodes only the parts that
/// differ from it. The renderer may draw the next picture meanwhile.
pub async fn encode_picture(
    services: Services,
    drawing: DrawnFrame,
    base: Option<Arc<EncodedFrame>>,
    payer: Payer,
) -> ViewStepResult {
    let (quality, [width, height]) = (drawing.stamp.quality, drawing.stamp.size());
    let is_large = width * height > LARGE_ENCODE_PIXELS;
    let started = Instant::now();
    let work = move || encode(drawing, base.as_deref(), started);
    let frame = match quality {
        // A large picture would take both cores of a small machine from the next picture of another client.
        FrameQuality::Moving if is_large && services.moving_pixels.is_shared() => background::run(work).await??,
        FrameQuality::Moving => spawn_blocking(work).await.map_err(|_| ServerError::Internal)??,
        // Lossless encoding takes several times as long, and no interaction waits for it.
        FrameQuality::Settled => background::run(work).await??,
    };
    services.metrics.count_encoded_frame(codec(quality));
    services.metrics.encode_seconds.observe(frame.encode.as_secs_f64());
    services.renders.charge(&payer, frame.encode);
    Ok(ViewStep::Encoded(frame))
}

fn encode(mut drawn: DrawnFrame, base: Option<&EncodedFrame>, started: Instant) -> Result<EncodedFrame, ServerError> {
    let DrawnFrame { stamp, pixels, .. } = &drawn;
    let [width, height] = stamp.size().map(|side| side as u16);
    let whole = stream::whole_tile(width, height);
    let (base, tiles) = match (stamp.quality, base) {
        (FrameQuality::Settled, _) => (None, stream::png_bands(pixels, width, height)?),
        (FrameQuality::Moving, base) => {
            let mut tiles =
                base.map_or(Ok(vec![whole]), |base| stream::changed_tiles(&base.drawn.pixels, pixels, width, height))?;
            if tiles.is_empty() {
                // A tile is sent nevertheless, since its header tells the new revisions.
                let side = |length: u16| length.min(MIN_TILE_SIDE);
                tiles.push(FrameTile { x: 0, y: 0, width: side(width), height: side(height) });
            }
            let base = base.filter(|_| tiles != [whole]).map(|base| base.drawn.stamp.frame_id());
            let jpeg = |tile: FrameTile| {
                let part = stream::crop(pixels, width, tile);
                Ok((tile, stream::jpeg(&part, tile.width, tile.height, MOVING_QUALITY)?))
            };
            (base, tiles.into_iter().map(jpeg).collect::<Result<_, ServerError>>()?)
        }
    };
    let encode = started.elapsed();
    drawn.trace.encoded(encode);
    Ok(EncodedFrame { drawn, number: 0, base, tiles, encode })
}

/// Returns the codec for frames of that quality.
pub fn codec(quality: FrameQuality) -> Codec {
    if quality == FrameQuality::Settled { Codec::Png } else { Codec::Jpeg }
}

/// Returns the number of samples per pixel for frames of that quality.
pub fn samples(quality: FrameQuality) -> u32 {
    if quality == FrameQuality::Settled { SETTLE_SAMPLES } else { 1 }
}

fn wire_quality(quality: FrameQuality) -> protocol::FrameQuality {
    match quality {
        FrameQuality::Moving => protocol::FrameQuality::Moving,
        FrameQuality::Settled => protocol::FrameQuality::Settled,
    }
}
