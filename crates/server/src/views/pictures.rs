//! Pictures of views: made only for clients that can receive one, and once for all clients of the same view.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use protocol::ServerMessage;
use render::{RenderError, View as RenderView};
use stream::{FrameQuality, NextFrame, ViewContent};
use tokio::task::{Id, JoinError};

use super::detail::Detail;
use super::frame::{
    EncodedFrame, FrameId, FrameStamp, ViewStep, ViewStepResult, codec, draw_picture, encode_picture, samples,
};
use super::moving_pixels::PictureScale;
use super::view::{ClientView, PendingPicture};
use super::{LiveSession, OutgoingFrame, Viewer, Views, now};
use crate::ServerError;
use crate::limits::{INTERACTIVE_FOR, SESSION_IDLE_TIMEOUT, STALLED_CHECK_EVERY, TILES_CHECK_EVERY};
use crate::outbox::{Outbox, SocketMessage, text};
use crate::outboxes::{ClientId, Outboxes};
use crate::renderer::{PictureFormat, PictureRequest, PictureTicket, Urgency};

impl Views {
    /// Notes that a client has shown a frame, which frees a slot of its window.
    pub fn acknowledge(&mut self, id: ClientId, frame: u64) {
        if let Some(viewer) = self.viewers.get_mut(&id) {
            // A frame that is not in flight was dropped before.
            viewer.pace.acked(frame, now());
        }
    }

    /// Handles a frame that a client could not decode. The client has no picture to draw tiles on, so its next one is
    /// complete. If a complete one was begun since, it is already in flight and nothing changes.
    pub fn request_key_frame(&mut self, id: ClientId, frame: u64) {
        if let Some(viewer) = self.viewers.get_mut(&id)
            && (viewer.last_key_frame..=viewer.frame).contains(&frame)
        {
            viewer.pace.start_anew();
            (viewer.shown_frame, viewer.sending) = (None, None);
        }
    }

    /// Sends finished pictures to clients that lack them and starts needed ones. Returns the time of the next call.
    pub fn update(&mut self, now: Instant, live: LiveSession, outboxes: &mut Outboxes) -> Instant {
        let mut wake = now + SESSION_IDLE_TIMEOUT;
        let ids: Vec<ClientId> = self.viewers.keys().copied().collect();
        // Computed once for all views, since a session may have as many views as clients.
        let mut watchers: BTreeMap<ClientId, Vec<ClientId>> = BTreeMap::new();
        for &id in &ids {
            if let Some(owner) = self.owner_of(id) {
                watchers.entry(owner).or_default().push(id);
            }
        }
        for (owner, watchers) in watchers {
            let Some(view) = self.own_view(owner) else { continue };
            let content = view.content;
            if let Some(frame) = view.latest.clone().filter(|latest| latest.drawn.stamp.content == content) {
                self.deliver(&watchers, &frame, content, outboxes);
            }
            let mut needed = None;
            for &id in &watchers {
                match self.next_frame_for(id, content, now, outboxes) {
                    NextFrame::WaitUntil(time) => wake = wake.min(time),
                    NextFrame::Moving if self.has_room_for_more(id, owner) => {
                        needed = Some(FrameQuality::Moving);
                    }
                    NextFrame::Moving | NextFrame::Nothing => {}
                    NextFrame::Settle => needed = needed.or(Some(FrameQuality::Settled)),
                }
            }
            if let Some(quality) = needed {
                self.start_picture(owner, &watchers, quality, live, outboxes);
            }
        }
        // Pictures that were only just started have remaining tiles too.
        for id in ids {
            wake = self.send_tiles(id, outboxes).map_or(wake, |next| wake.min(next));
        }
        wake
    }

    /// Waits for the next finished or failed step. Returns `None` if no picture is in progress.
    pub async fn next_step(&mut self) -> Option<Result<(Id, ViewStepResult), JoinError>> {
        self.pictures.join_next_with_id().await
    }

    /// Handles the result of [`Self::next_step`] and all other finished steps. Each change cancels as many pictures as
    /// there are views.
    pub fn take_steps(&mut self, first: Result<(Id, ViewStepResult), JoinError>, outboxes: &mut Outboxes) {
        let mut next = Some(first);
        while let Some(step) = next {
            self.take_step(step, outboxes);
            next = self.pictures.try_join_next_with_id();
        }
    }

    /// Starts the encoding of a drawn picture, or sends an encoded picture to the clients that need it.
    fn take_step(&mut self, step: Result<(Id, ViewStepResult), JoinError>, outboxes: &mut Outboxes) {
        let task = step.as_ref().map_or_else(JoinError::id, |(id, _)| *id);
        let is_it = |job: &mut PendingPicture| job.task.id() == task;
        let mut own_views = self.viewers.iter_mut().filter_map(|(id, viewer)| Some((*id, viewer.source.own_mut()?)));
        // A cancelled picture belongs to no view.
        let Some((owner, view, job)) = own_views.find_map(|(id, view)| {
            let job = view.drawing.take_if(is_it).or_else(|| view.encoding.take_if(is_it))?;
            Some((id, view, job))
        }) else {
            return;
        };
        let content = view.content;
        match step {
            Ok((_, Ok(ViewStep::Drawn(drawing)))) => view.drawn = Some(drawing),
            Ok((_, Ok(ViewStep::Encoded(mut frame)))) => {
                self.picture_count += 1;
                frame.number = self.picture_count;
                if frame.drawn.stamp.quality == FrameQuality::Moving {
                    view.detail_choice.record_picture(frame.timed_picture(), now());
                }
                let frame = Arc::new(frame);
                view.latest = Some(Arc::clone(&frame));
                self.deliver(&self.watchers_of(owner), &frame, content, outboxes);
            }
            Ok((_, Err(error))) => {
                view.failed = Some(job.revision);
                for id in self.watchers_of(owner) {
                    outboxes.warn(id, &error);
                }
            }
            Err(fault) => {
                tracing::error!("a picture failed: {fault}");
                view.failed = Some(job.revision);
            }
        }
        self.start_encoding(owner, outboxes);
    }

    /// Starts to encode the drawn picture of a view. Only one is encoded at a time, so that pictures stay in order. If
    /// every client that needs the picture has the one before, only the differences are encoded.
    fn start_encoding(&mut self, owner: ClientId, outboxes: &Outboxes) {
        let Some(view) = self.own_view(owner).filter(|view| view.encoding.is_none()) else { return };
        let Some(drawing) = view.drawn.take() else { return };
        let is_as_large = |latest: &Arc<EncodedFrame>| latest.drawn.stamp.size() == drawing.stamp.size();
        let (content, base) = (view.content, view.latest.clone().filter(is_as_large));
        let now = now();
        let mut receivers = self.watchers_of(owner);
        receivers.retain(|id| self.next_frame_for(*id, content, now, outboxes) == NextFrame::Moving);
        let base =
            base.filter(|base| receivers.iter().all(|id| self.has_base_of(*id, Some(base.drawn.stamp.frame_id()))));
        let (quality, revision) = (drawing.stamp.quality, drawing.stamp.content.revision);
        let Some(payer) = self.viewers.get(&owner).map(|viewer| viewer.payer.clone()) else { return };
        let task = self.pictures.spawn(encode_picture(self.services.clone(), drawing, base, payer));
        if let Some(view) = self.own_view(owner) {
            view.encoding = Some(PendingPicture { quality, revision, ticket: None, asked_at: now, task });
        }
    }

    /// True if a client can take another picture of the view of `owner`, after those that are drawn and not sent yet.
    fn has_room_for_more(&self, id: ClientId, owner: ClientId) -> bool {
        let pending = self.view_of(owner).map_or(0, ClientView::encoding_count);
        self.viewers.get(&id).is_some_and(|viewer| viewer.pace.free_slots() > pending)
    }

    /// True if a viewer of a view edits or moves it.
    fn has_interactive_viewer(&self, watchers: &[ClientId]) -> bool {
        watchers.iter().any(|id| self.viewers.get(id).is_some_and(Viewer::is_interactive))
    }

    /// Sends a frame to all clients of its view that need it and have its base.
    fn deliver(
        &mut self,
        watchers: &[ClientId],
        frame: &Arc<EncodedFrame>,
        content: ViewContent,
        outboxes: &mut Outboxes,
    ) {
        let now = now();
        for &id in watchers {
            let wants = match self.next_frame_for(id, content, now, outboxes) {
                NextFrame::Moving => self.has_base_of(id, frame.base),
                NextFrame::Settle => frame.drawn.stamp.quality == FrameQuality::Settled,
                NextFrame::Nothing | NextFrame::WaitUntil(_) => false,
            };
            if wants && let Some(viewer) = self.viewers.get_mut(&id) {
                viewer.start_sending(Arc::clone(frame), now);
                self.services.metrics.count_sent_frame(codec(frame.drawn.stamp.quality));
                self.send_tiles(id, outboxes);
            }
        }
    }

    /// Sends a client as many tiles of its current picture as it can take. Returns the time of the next call if tiles
    /// are left.
    fn send_tiles(&mut self, id: ClientId, outboxes: &mut Outboxes) -> Option<Instant> {
        let content = self.owner_of(id).and_then(|owner| Some(self.view_of(owner)?.content));
        let (viewer, now) = (self.viewers.get_mut(&id)?, now());
        // The rest of an outdated lossless picture is useless, even if no newer one exists.
        viewer.sending.take_if(|sending| {
            let FrameStamp { quality, content: of, .. } = sending.picture.drawn.stamp;
            quality == FrameQuality::Settled && Some(of) != content
        });
        let sending = viewer.sending.as_mut()?;
        let count = sending.picture.message_count();
        // A moving picture is sent as a whole. The next tile of a lossless one is sent once the last was taken, so an
        // edit drops the remaining tiles.
        let to = match sending.picture.drawn.stamp.quality {
            FrameQuality::Moving => count,
            FrameQuality::Settled if outboxes.is(id, Outbox::has_empty_frame_queue) => sending.sent + 1,
            // A client that takes no tile for that long has stalled.
            FrameQuality::Settled if now.saturating_duration_since(sending.sent_at) < STALLED_CHECK_EVERY => {
                return Some(now + TILES_CHECK_EVERY);
            }
            FrameQuality::Settled => return Some(now + STALLED_CHECK_EVERY),
        };
        let bytes_before = sending.bytes;
        let message = |tile| {
            let bytes = sending.picture.message(tile, sending.frame, sending.is_key_frame);
            sending.bytes += bytes.len();
            SocketMessage::Binary(bytes)
        };
        let mut messages: Vec<SocketMessage> = (sending.sent..to.min(count)).map(message).collect();
        self.services.metrics.frame_bytes_sent.inc_by((sending.bytes - bytes_before) as u64);
        if viewer.wants_stats && to == count {
            // Statistics are sent with the last tile. They are dropped with it if there is no room, and delay no
            // picture.
            let stats = sending.picture.stats(sending.frame, sending.bytes, sending.is_reused);
            messages.push(SocketMessage::Text(text(&ServerMessage::Stats(Box::new(stats)))));
        }
        outboxes.send_frame(id, messages);
        (sending.sent, sending.sent_at) = (to, now);
        if to < count {
            return Some(now + TILES_CHECK_EVERY);
        }
        viewer.shown_frame = viewer.sending.take().map(|sending| sending.picture.drawn.stamp.frame_id());
        None
    }

    /// True if the client has the picture `base` to draw tiles onto, or if the frame needs no base.
    fn has_base_of(&self, id: ClientId, base: Option<FrameId>) -> bool {
        let has = |viewer: &Viewer| viewer.shown_frame == base && !viewer.pace.needs_key_frame();
        base.is_none() || self.viewers.get(&id).is_some_and(has)
    }

    /// Returns the frame that a client of the view needs next, if it needs one.
    fn next_frame_for(&self, id: ClientId, content: ViewContent, now: Instant, outboxes: &Outboxes) -> NextFrame {
        let Some(viewer) = self.viewers.get(&id) else { return NextFrame::Nothing };
        if !outboxes.is(id, Outbox::can_take_frame) {
            // The socket has stalled. Once it continues, the client gets the content of that time.
            return NextFrame::WaitUntil(now + STALLED_CHECK_EVERY);
        }
        viewer.pace.next(content, now)
    }

    /// Starts a picture of a view, unless one is in progress or cannot be made.
    fn start_picture(
        &mut self,
        owner: ClientId,
        watchers: &[ClientId],
        quality: FrameQuality,
        live: LiveSession,
        outboxes: &mut Outboxes,
    ) {
        let (log_seq, live_revision) = (live.session.seq(), live.revision);
        let session = Arc::clone(&self.session);
        let urgency = match quality {
            FrameQuality::Moving if self.has_interactive_viewer(watchers) => Urgency::Moving,
            FrameQuality::Moving => Urgency::Watched,
            FrameQuality::Settled => Urgency::Settling,
        };
        let Some(viewer) = self.viewers.get_mut(&owner) else { return };
        let payer = viewer.payer.clone();
        let Some(view) = viewer.source.own_mut() else { return };
        if view.is_pending_or_failed(quality) {
            return;
        }
        let ticket = PictureTicket::since(view.waits_since.take().unwrap_or_else(Instant::now));
        let lights = view.parameters.settings.visible_lights(live.session.live_document().light_instances());
        let (view_size, camera_revision, content) =
            (view.parameters.size, view.parameters.camera_revision, view.content);
        let detail = match quality {
            FrameQuality::Moving => view.detail_choice.detail(),
            FrameQuality::Settled => Detail::FULL,
        };
        let actor_id = payer.actor_id().filter(|_| quality == FrameQuality::Moving);
        let picture_scale = actor_id.map_or(PictureScale::FULL, |actor_id| {
            let size = detail.resolution.of(view_size);
            let (slot, is_interactive) = (view.lease.slot(), urgency == Urgency::Moving);
            self.services.moving_pixels.record_picture(actor_id, slot, is_interactive, size, Instant::now())
        });
        let is_newly_reduced = picture_scale != PictureScale::FULL && !view.was_warned_smaller;
        view.was_warned_smaller |= is_newly_reduced;
        let stamp =
            FrameStamp { content, quality, log_seq, live_revision, camera_revision, detail, view_size, picture_scale };
        let request = PictureRequest {
            session,
            viewer: Arc::clone(&view.lease),
            payer,
            scene: Arc::clone(live.scene),
            view: RenderView {
                samples: samples(quality),
                exposure: view.parameters.settings.exposure,
                shadow_map: detail.shadow_map,
                slot: view.lease.slot(),
                ..RenderView::beauty(view.parameters.camera.clone(), stamp.size())
            },
            lights,
            output: PictureFormat::Display,
            urgency,
            ticket: ticket.clone(),
        };
        let mut newly_left_out = Vec::new();
        if quality == FrameQuality::Settled {
            let lights = request.lights.iter().map(|instance| &*instance.light);
            let left_out = live.scene.bounds().undrawable_of(lights);
            if left_out != view.left_out {
                view.left_out.clone_from(&left_out);
                newly_left_out = left_out;
            }
        }
        let session = Arc::clone(&self.name);
        let task = self.pictures.spawn(draw_picture(self.services.clone(), request, stamp, session, owner));
        let (revision, ticket, asked_at) = (content.revision, Some(ticket), Instant::now());
        view.drawing = Some(PendingPicture { quality, revision, ticket, asked_at, task });
        // Sent once, to all viewers.
        if is_newly_reduced {
            for &id in watchers {
                outboxes.warn(id, &ServerError::ViewsMoveTooMuch);
            }
        }
        for why in newly_left_out {
            let error = ServerError::from(RenderError::from(why));
            for &id in watchers {
                outboxes.send_error(id, &error);
            }
        }
    }
}

impl Viewer {
    /// True if the client edited or moved its view lately.
    pub(super) fn is_interactive(&self) -> bool {
        self.last_interaction.is_some_and(|then| then.elapsed() < INTERACTIVE_FOR)
    }

    /// Starts to send a picture. Unsent tiles of the one before are dropped.
    fn start_sending(&mut self, picture: Arc<EncodedFrame>, now: Instant) {
        self.frame += 1;
        let (frame, is_key_frame) = (self.frame, self.pace.needs_key_frame());
        self.pace.sent(frame, picture.drawn.stamp.content.revision, picture.drawn.stamp.quality, now);
        self.shown_frame = None;
        if picture.base.is_none() {
            self.last_key_frame = frame;
        }
        let is_reused = picture.number <= self.latest_picture;
        self.latest_picture = picture.number;
        self.sending = Some(OutgoingFrame { picture, frame, is_key_frame, is_reused, sent: 0, bytes: 0, sent_at: now });
    }
}
