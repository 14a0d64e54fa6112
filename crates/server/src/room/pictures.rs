//! Pictures of views: made only for who can take one, and once for all who look at the same.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use render::{Aov, Pixels, RenderError, View as RenderView};
use stream::{Codec, Content, Flags, FrameHeader, HEADER_BYTES, MOVING_QUALITY, Next, Quality, Tile};
use tokio::task::{Id, JoinError, spawn_blocking};

use super::clients::Client;
use super::message::ClientId;
use super::views::UnderWay;
use super::{Room, now};
use crate::ServerError;
use crate::backend::Backend;
use crate::limits::{IDLE_AT_MOST, STALLED_CHECK_EVERY};
use crate::metrics::Metrics;
use crate::renderer::{Output, Request, Urgency};

/// Samples a pixel of the picture of a still view: smooth edges for four times the work.
const SETTLE_SAMPLES: u32 = 4;

/// An encoded picture and what it shows.
pub(super) struct Frame {
    stamp: Stamp,
    payload: Vec<u8>,
    wait: Duration,
    render: Duration,
    encode: Duration,
}

/// What a picture shows.
struct Stamp {
    content: Content,
    quality: Quality,
    log_seq: u64,
    live_revision: u32,
    camera_revision: u32,
    size: [u32; 2],
}

/// What became of a picture.
pub(super) type Picture = Result<Frame, ServerError>;

impl Room {
    pub(super) fn acknowledge(&mut self, id: ClientId, frame: u64) {
        if let Some(client) = self.clients.get_mut(&id) {
            // One that is not under way was given up before.
            client.pace.acked(frame, now());
        }
    }

    /// Sends what there is to who lacks it and starts what is needed. Returns when to look again.
    pub(super) fn pump(&mut self, now: tokio::time::Instant) -> tokio::time::Instant {
        let mut wake = now + IDLE_AT_MOST;
        let ids: Vec<ClientId> = self.clients.keys().copied().collect();
        for owner in ids {
            let Some(view) = self.own_view(owner) else { continue };
            let content = view.content;
            if let Some(frame) = view.latest.clone().filter(|latest| latest.stamp.content == content) {
                self.deliver(owner, &frame, content);
            }
            let mut wanted = None;
            for id in self.watchers_of(owner) {
                match self.next_of(id, content, now.into_std()) {
                    Next::Nothing => {}
                    Next::WaitUntil(time) => wake = wake.min(time.into()),
                    Next::Moving => wanted = Some(Quality::Moving),
                    Next::Settle => wanted = wanted.or(Some(Quality::Settled)),
                }
            }
            if let Some(quality) = wanted {
                self.start_picture(owner, quality);
            }
        }
        wake
    }

    /// A picture is there, or will never be.
    pub(super) fn take_picture(&mut self, picture: Result<(Id, Picture), JoinError>) {
        let task = picture.as_ref().map_or_else(JoinError::id, |(id, _)| *id);
        let own_views = self.clients.iter_mut().filter_map(|(id, client)| Some((*id, client.source.own()?)));
        let mut drawn =
            own_views.filter(|(_, view)| view.under_way.as_ref().is_some_and(|u| u.task.id() == task));
        // One that was given up belongs to no view.
        let Some((owner, view)) = drawn.next() else { return };
        let drawn_revision = view.under_way.take().map(|job| job.revision);
        let content = view.content;
        match picture {
            // A lossless picture of the past is of no use; a moving one is the latest there is.
            Ok((_, Ok(frame)))
                if frame.stamp.quality == Quality::Settled && frame.stamp.content != content => {}
            Ok((_, Ok(frame))) => {
                let frame = Arc::new(frame);
                view.latest = Some(Arc::clone(&frame));
                self.deliver(owner, &frame, content);
            }
            Ok((_, Err(error))) => {
                view.failed = drawn_revision;
                for id in self.watchers_of(owner) {
                    self.warn(id, &error);
                }
            }
            Err(fault) => {
                tracing::error!("a picture failed: {fault}");
                view.failed = drawn_revision;
            }
        }
    }

    /// Sends a frame to all who look at its view and want it.
    fn deliver(&mut self, owner: ClientId, frame: &Frame, content: Content) {
        let now = now();
        for id in self.watchers_of(owner) {
            let wants = match self.next_of(id, content, now) {
                Next::Moving => true,
                Next::Settle => frame.stamp.quality == Quality::Settled,
                Next::Nothing | Next::WaitUntil(_) => false,
            };
            if wants && let Some(client) = self.clients.get_mut(&id) {
                client.send(frame, now, &self.backend.metrics);
            }
        }
    }

    /// What a client needs of its view.
    fn next_of(&mut self, id: ClientId, content: Content, now: Instant) -> Next {
        let Some(client) = self.clients.get_mut(&id) else { return Next::Nothing };
        if !client.lane.has_room() {
            // The socket has stalled. What it is sent when it goes on is what there is then.
            return Next::WaitUntil(now + STALLED_CHECK_EVERY);
        }
        let owed_key = client.pace.owes_key();
        let next = client.pace.next(content, now);
        if client.pace.owes_key() && !owed_key {
            self.backend.metrics.window_stalls.inc();
        }
        next
    }

    /// Starts a picture of a view, unless one is under way or cannot be made.
    fn start_picture(&mut self, owner: ClientId, quality: Quality) {
        let (log_seq, live_revision) = (self.session.seq(), self.live_revision);
        let session = Arc::clone(&self.lease);
        let Some(view) = self.clients.get_mut(&owner).and_then(|client| client.source.own()) else { return };
        if view.under_way.is_some() || view.failed == Some(view.content.revision) {
            return;
        }
        // Gestures are of lights, and lights need no scene.
        let document = self.session.live_document(&|_| None);
        let (size, camera_revision, content) = (view.size, view.camera_revision, view.content);
        let stamp = Stamp { content, quality, log_seq, live_revision, camera_revision, size };
        let request = Request {
            session,
            viewer: Arc::clone(&view.lease),
            scene: document.scene().clone(),
            view: RenderView {
                camera: view.camera.clone(),
                width: size[0],
                height: size[1],
                samples: samples(quality),
                aov: Aov::Beauty,
                light: 0,
                fill: 1.0,
                slot: view.lease.slot(),
            },
            lights: document.lights().values().map(|placed| placed.light.clone()).collect(),
            output: Output::Display,
            urgency: match quality {
                Quality::Moving => Urgency::Moving,
                Quality::Settled => Urgency::Settling,
            },
        };
        let left_out = match quality {
            Quality::Moving => None,
            Quality::Settled => Some(document.reach().left_out(&request.lights)),
        };
        let news = left_out.filter(|left_out| *left_out != view.left_out);
        if let Some(left_out) = &news {
            view.left_out.clone_from(left_out);
        }
        let task = self.pictures.spawn(make_picture(self.backend.clone(), request, stamp));
        view.under_way = Some(UnderWay { quality, revision: content.revision, task });
        // Said once, to all who see it.
        for why in news.into_iter().flatten() {
            let error = ServerError::from(RenderError::from(why));
            for id in self.watchers_of(owner) {
                self.complain_to(id, &error);
            }
        }
    }
}

impl Client {
    fn send(&mut self, frame: &Frame, now: Instant, metrics: &Metrics) {
        self.frame += 1;
        let message = frame.message(self.frame, self.pace.owes_key());
        let bytes = message.len() as u64;
        self.lane.show(message);
        metrics.frames_sent.get_or_create(&codec(frame.stamp.quality).into()).inc();
        metrics.frame_bytes_sent.inc_by(bytes);
        self.pace.sent(self.frame, frame.stamp.content.revision, frame.stamp.quality, now);
    }
}

impl Frame {
    /// The binary message for one client.
    fn message(&self, frame: u64, key: bool) -> Bytes {
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

async fn make_picture(backend: Backend, request: Request, stamp: Stamp) -> Picture {
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

fn codec(quality: Quality) -> Codec {
    match quality {
        Quality::Moving => Codec::Jpeg,
        Quality::Settled => Codec::Png,
    }
}

fn samples(quality: Quality) -> u32 {
    match quality {
        Quality::Moving => 1,
        Quality::Settled => SETTLE_SAMPLES,
    }
}

fn micros(duration: Duration) -> u32 {
    duration.as_micros().try_into().unwrap_or(u32::MAX)
}
