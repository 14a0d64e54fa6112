//! Pictures of views: made only for who can take one, and once for all who look at the same.

use std::sync::Arc;
use std::time::Instant;

use axum::body::Bytes;
use render::{Aov, RenderError, View as RenderView};
use stream::{Content, Next, Quality};
use tokio::task::{Id, JoinError};

use super::frame::{Frame, Picture, Stamp, codec, make_picture, samples};
use super::view::UnderWay;
use super::{Live, Viewer, Views, now};
use crate::ServerError;
use crate::limits::{IDLE_AT_MOST, STALLED_CHECK_EVERY};
use crate::outboxes::{ClientId, Outboxes};
use crate::renderer::{Output, Request, Urgency};

impl Views {
    /// A client has shown a frame.
    pub fn acknowledge(&mut self, id: ClientId, frame: u64) {
        if let Some(viewer) = self.viewers.get_mut(&id) {
            // One that is not under way was given up before.
            viewer.pace.acked(frame, now());
        }
    }

    /// Sends what there is to who lacks it and starts what is needed. Returns when to look again.
    pub fn update(&mut self, now: Instant, live: Live, outboxes: &mut Outboxes) -> Instant {
        let mut wake = now + IDLE_AT_MOST;
        let ids: Vec<ClientId> = self.viewers.keys().copied().collect();
        for owner in ids {
            let Some(view) = self.own_view(owner) else { continue };
            let content = view.content;
            if let Some(frame) = view.latest.clone().filter(|latest| latest.stamp.content == content) {
                self.deliver(owner, &frame, content, outboxes);
            }
            let mut wanted = None;
            for id in self.watchers_of(owner) {
                match self.next_of(id, content, now, outboxes) {
                    Next::Nothing => {}
                    Next::WaitUntil(time) => wake = wake.min(time),
                    Next::Moving => wanted = Some(Quality::Moving),
                    Next::Settle => wanted = wanted.or(Some(Quality::Settled)),
                }
            }
            if let Some(quality) = wanted {
                self.start_picture(owner, quality, live, outboxes);
            }
        }
        wake
    }

    /// The next picture that is there, or will never be; `None` where none is under way.
    pub async fn next_picture(&mut self) -> Option<Result<(Id, Picture), JoinError>> {
        self.pictures.join_next_with_id().await
    }

    /// Takes what [`Self::next_picture`] gave, and sends it to who wants it.
    pub fn take_picture(&mut self, picture: Result<(Id, Picture), JoinError>, outboxes: &mut Outboxes) {
        let task = picture.as_ref().map_or_else(JoinError::id, |(id, _)| *id);
        let own_views = self.viewers.iter_mut().filter_map(|(id, viewer)| Some((*id, viewer.source.own()?)));
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
                self.deliver(owner, &frame, content, outboxes);
            }
            Ok((_, Err(error))) => {
                view.failed = drawn_revision;
                for id in self.watchers_of(owner) {
                    outboxes.warn(id, &error);
                }
            }
            Err(fault) => {
                tracing::error!("a picture failed: {fault}");
                view.failed = drawn_revision;
            }
        }
    }

    /// Sends a frame to all who look at its view and want it.
    fn deliver(&mut self, owner: ClientId, frame: &Frame, content: Content, outboxes: &mut Outboxes) {
        let now = now();
        for id in self.watchers_of(owner) {
            let wants = match self.next_of(id, content, now, outboxes) {
                Next::Moving => true,
                Next::Settle => frame.stamp.quality == Quality::Settled,
                Next::Nothing | Next::WaitUntil(_) => false,
            };
            if wants && let Some(viewer) = self.viewers.get_mut(&id) {
                let message = viewer.next_message(frame, now);
                let metrics = &self.backend.metrics;
                metrics.frames_sent.get_or_create(&codec(frame.stamp.quality).into()).inc();
                metrics.frame_bytes_sent.inc_by(message.len() as u64);
                outboxes.send_frame(id, message);
            }
        }
    }

    /// What a client needs of its view.
    fn next_of(&mut self, id: ClientId, content: Content, now: Instant, outboxes: &Outboxes) -> Next {
        let Some(viewer) = self.viewers.get_mut(&id) else { return Next::Nothing };
        if !outboxes.takes_frame(id) {
            // The socket has stalled. What it is sent when it goes on is what there is then.
            return Next::WaitUntil(now + STALLED_CHECK_EVERY);
        }
        let owed_key = viewer.pace.owes_key();
        let next = viewer.pace.next(content, now);
        if viewer.pace.owes_key() && !owed_key {
            self.backend.metrics.window_stalls.inc();
        }
        next
    }

    /// Starts a picture of a view, unless one is under way or cannot be made.
    fn start_picture(&mut self, owner: ClientId, quality: Quality, live: Live, outboxes: &mut Outboxes) {
        let (log_seq, live_revision) = (live.session.seq(), live.revision);
        let session = Arc::clone(&self.session);
        let Some(view) = self.viewers.get_mut(&owner).and_then(|viewer| viewer.source.own()) else { return };
        if view.under_way.is_some() || view.failed == Some(view.content.revision) {
            return;
        }
        let lights = view.settings.shown(live.session.live_document().instances());
        let (size, camera_revision, content) = (view.size, view.camera_revision, view.content);
        let stamp = Stamp { content, quality, log_seq, live_revision, camera_revision, size };
        let request = Request {
            session,
            viewer: Arc::clone(&view.lease),
            scene: Arc::clone(live.scene),
            view: RenderView {
                camera: view.camera.clone(),
                width: size[0],
                height: size[1],
                samples: samples(quality),
                aov: Aov::Beauty,
                light: 0,
                fill: 1.0,
                exposure: view.settings.exposure,
                slot: view.lease.slot(),
            },
            lights,
            output: Output::Display,
            urgency: match quality {
                Quality::Moving => Urgency::Moving,
                Quality::Settled => Urgency::Settling,
            },
        };
        let left_out = match quality {
            Quality::Moving => None,
            Quality::Settled => {
                Some(live.scene.reach().left_out(request.lights.iter().map(|instance| &*instance.light)))
            }
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
                outboxes.send_error(id, &error);
            }
        }
    }
}

impl Viewer {
    /// The message of its next frame, which is sent now.
    fn next_message(&mut self, frame: &Frame, now: Instant) -> Bytes {
        self.frame += 1;
        let message = frame.message(self.frame, self.pace.owes_key());
        self.pace.sent(self.frame, frame.stamp.content.revision, frame.stamp.quality, now);
        message
    }
}
