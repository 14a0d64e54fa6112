//! A session: one task that owns its document, its clients and their views.
//!
//! The task takes a message and all others that wait, carries them out, commits the resulting records together, and
//! only then publishes them (`commit`). A program's long request is carried out in parts, so other clients come in
//! between. A client that drags a feature waits for the solver without delaying others (`queues`). Between messages the
//! task keeps the views' pictures up to date (`crate::views`).

mod checkpoint;
mod clients;
mod commit;
mod directory;
mod gestures;
mod grouping;
mod history;
mod inbox;
mod message;
mod probes;
mod queues;
mod solving;
mod steps;
mod tick;

use std::collections::{BTreeMap, VecDeque};
use std::future::ready;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Weak};

use axum::body::Bytes;
use document::{Document, DocumentHash};
use protocol::{Bounds, ServerMessage};
use scene::Camera;
use store::OpenedSession;
use tokio::sync::{mpsc, watch};
use tokio::task::{JoinHandle, JoinSet, spawn_blocking};
use tokio::time::{Instant, sleep_until};

pub use directory::Rooms;
pub use grouping::in_group_error;
pub use message::{JoinRequest, RoomHandle, RoomMessage, SessionSnapshot};
pub use steps::time_ms;

use crate::ServerError;
use crate::document_text::DocumentText;
use crate::limits::{LEASE_CHECK_EVERY, PRESENCE_EVERY, RETRY_AFTER, SESSION_IDLE_TIMEOUT, STALLED_CHECK_EVERY};
use crate::outbox::Outbox;
use crate::outboxes::{ClientId, Outboxes};
use crate::renderer::RenderLease;
use crate::scenes::{DecodedScene, SceneCache};
use crate::services::Services;
use crate::views::{LiveSession, Views};
use clients::ConnectedClient;
use directory::RoomStatus;
use message::RoomOpening;
use probes::Probes;
use solving::SolvedCommand;
use tick::RequestBatch;

/// State that the task owns.
struct Room {
    name: Arc<str>,
    /// Number of the room, never used again.
    number: u64,
    /// Keeps the session's data in the renderer.
    lease: Arc<RenderLease>,
    epoch: String,
    services: Services,
    session: edit::Session,
    /// JSON of the document, while any request still uses it.
    text: Weak<DocumentText>,
    /// Sequence number and document hash of that JSON.
    text_version: Option<(u64, DocumentHash)>,
    /// Number and size of the records since the session's latest checkpoint.
    tail: store::RecordTail,
    /// Size in bytes of the session's latest checkpoint.
    checkpoint_bytes: u64,
    scene: OpenScene,
    clients: BTreeMap<ClientId, ConnectedClient>,
    outboxes: Outboxes,
    views: Views,
    probes: Probes,
    /// Running solves.
    solving: JoinSet<Result<Vec<SolvedCommand>, ServerError>>,
    last_client: ClientId,
    /// Unfinished requests of programs, next first.
    batches: VecDeque<RequestBatch>,
    /// State that the directory reads.
    status: Arc<RoomStatus>,
    /// Number of changes of gestures in progress. Frames carry it.
    live_revision: u32,
    /// True if a client joined, left, selected or moved since presence was last sent.
    presence_changed: bool,
    presence_due: Instant,
    leases_due: Instant,
    opened: Instant,
    /// Time of the latest message.
    last_used: Instant,
    is_draining: bool,
}

/// The scene of the current document.
#[derive(Clone)]
struct OpenScene {
    /// The scene as decoded from its bytes.
    decoded: DecodedScene,
    bounds: Bounds,
    /// Camera that frames the whole scene.
    framing: Camera,
}

/// Session to open, and what its task shares with others.
struct RoomStart {
    name: Arc<str>,
    number: u64,
    status: Arc<RoomStatus>,
    services: Services,
    rooms: Rooms,
}

/// Opens a session, reports the result in `opening`, and serves the session until its inbox is closed. `before` is the
/// task that had the session before.
async fn run(
    start: RoomStart,
    mut inbox: mpsc::Receiver<RoomMessage>,
    opening: watch::Sender<RoomOpening>,
    before: Option<JoinHandle<()>>,
) {
    if let Some(before) = before {
        // That task may have failed. Its committed records are in the store.
        let _ = before.await;
    }
    let (rooms, metrics) = (start.rooms.clone(), Arc::clone(&start.services.metrics));
    match Room::open(start).await {
        Ok(mut room) => {
            opening.send_replace(RoomOpening::Open);
            metrics.rooms.inc();
            room.keep_checkpoint().await;
            room.serve(&mut inbox, &rooms).await;
            metrics.rooms.dec();
        }
        Err(error) => drop(opening.send_replace(RoomOpening::Failed(Arc::new(error)))),
    }
}

impl Room {
    async fn open(start: RoomStart) -> Result<Self, ServerError> {
        let RoomStart { name, number, status, services, .. } = start;
        let session_name = Arc::clone(&name);
        let opened = services.storage.read(move |store| store.open_session(&session_name));
        let OpenedSession { row, session, tail, checkpoint_bytes, checkpoint_failed } = opened.await?;
        if checkpoint_failed {
            tracing::warn!("session {name} has a checkpoint that its log does not prove; all of the log was replayed");
        }
        tracing::info!("session {name} is open at record {}, {} replayed", session.seq(), tail.records);
        let scene = OpenScene::of(session.document(), &services.scenes).await?;
        let (now, lease) = (Instant::now(), services.renders.lease());
        Ok(Self {
            number,
            epoch: row.epoch,
            outboxes: Outboxes::new(services.in_flight.clone()),
            text: Weak::new(),
            text_version: None,
            views: Views::new(services.clone(), Arc::clone(&name), Arc::clone(&lease)),
            name,
            lease,
            services,
            scene,
            session,
            tail,
            checkpoint_bytes,
            clients: BTreeMap::new(),
            probes: Probes::default(),
            solving: JoinSet::new(),
            last_client: 0,
            batches: VecDeque::new(),
            status,
            live_revision: 0,
            presence_changed: false,
            presence_due: now,
            leases_due: now,
            opened: now,
            last_used: now,
            is_draining: false,
        })
    }

    async fn serve(&mut self, inbox: &mut mpsc::Receiver<RoomMessage>, rooms: &Rooms) {
        let mut more_may_come = true;
        while more_may_come || self.has_queued_work() {
            let wake = self.run_due_work(rooms).await;
            let can_go_on = self.has_runnable_work();
            tokio::select! {
                message = inbox.recv(), if more_may_come && !can_go_on => match message {
                    Some(message) => self.tick(Some(message), inbox).await,
                    None => more_may_come = false,
                },
                () = ready(()), if can_go_on => self.tick(None, inbox).await,
                Some(ended) = self.solving.join_next_with_id() => self.finish_solve(ended),
                Some(step) = self.views.next_step() => self.views.take_steps(step, &mut self.outboxes),
                Some(ended) = self.probes.tasks.join_next_with_id() => self.take_probe(ended),
                () = sleep_until(wake) => {}
            }
            if self.is_draining {
                inbox.close();
            }
        }
        // The room ends, so this is the last chance.
        self.catch_up(Outbox::is_behind).await;
        tracing::info!("session {} is closed at record {}", self.name, self.session.seq());
    }

    /// Does the work that is due and returns the time of the next.
    async fn run_due_work(&mut self, rooms: &Rooms) -> Instant {
        let now = Instant::now();
        self.drop_lost_clients();
        // A client that fell behind gets the current state once it has received everything sent before.
        if !self.services.in_flight.is_full() {
            self.catch_up(Outbox::can_catch_up).await;
        }
        self.views.configure(&mut self.outboxes);
        let live =
            LiveSession { session: &self.session, scene: &self.scene.decoded.posed, revision: self.live_revision };
        let mut wake = Instant::from(self.views.update(now.into_std(), live, &mut self.outboxes));
        if self.outboxes.any(Outbox::is_behind) {
            wake = wake.min(now + STALLED_CHECK_EVERY);
        }
        if self.session.gestures().next().is_some() {
            if self.leases_due <= now {
                self.expire_gestures();
                self.leases_due = now + LEASE_CHECK_EVERY;
            }
            wake = wake.min(self.leases_due);
        }
        if self.presence_changed {
            if self.presence_due <= now {
                self.broadcast_presence();
                self.presence_due = now + PRESENCE_EVERY;
            } else {
                wake = wake.min(self.presence_due);
            }
        }
        if self.clients.is_empty() {
            if self.last_used + SESSION_IDLE_TIMEOUT <= now {
                rooms.idle(&self.name, self.number);
                self.last_used = now;
            }
            wake = wake.min(self.last_used + SESSION_IDLE_TIMEOUT);
        }
        wake
    }

    /// Returns the document's text, shared with earlier askers if it is unchanged.
    fn document_text(&mut self) -> Arc<DocumentText> {
        let document = self.session.document();
        let now = Some((self.session.seq(), document.hash()));
        let known = self.text.upgrade().filter(|_| self.text_version == now);
        known.unwrap_or_else(|| {
            let new = Arc::new(DocumentText::new(document.clone(), self.services.in_flight.clone()));
            (self.text, self.text_version) = (Arc::downgrade(&new), now);
            new
        })
    }

    /// Returns the document's JSON. Making it takes a while, and the session's other work waits.
    async fn document_json(&mut self) -> Result<Bytes, ServerError> {
        let text = self.document_text();
        spawn_blocking(move || text.bytes()).await.map_err(|_| ServerError::Internal)
    }

    fn drain(&mut self) {
        self.is_draining = true;
        let retry_after_ms = RETRY_AFTER.as_millis() as u64;
        self.outboxes.send_all(&ServerMessage::Draining { retry_after_ms });
    }

    /// Returns the milliseconds since the room was opened: the clock of leases.
    fn clock_ms(&self) -> u64 {
        self.opened.elapsed().as_millis() as u64
    }

    /// Notes the time of a message.
    fn mark_used(&mut self) {
        self.last_used = Instant::now();
        let used_ms = self.services.started.elapsed().as_millis() as u64;
        self.status.used_ms.store(used_ms, Ordering::Relaxed);
    }

    fn note_clients(&self) {
        self.status.set_clients(self.clients.values().map(|client| client.principal.actor.clone()).collect());
    }
}

impl OpenScene {
    async fn of(document: &Document, scenes: &SceneCache) -> Result<Self, ServerError> {
        let decoded = scenes.of(document).await?;
        let framing = scene::framing_camera(&decoded.posed.subject_bounds(), scene::DEFAULT_ASPECT);
        Ok(Self { bounds: Bounds::of(&decoded.posed), framing, decoded })
    }
}
