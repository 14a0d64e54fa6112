//! One session: one task that owns its document, its clients and their views.
//!
//! The task takes a message, and what else is waiting; carries it out; commits the records that came of it together; and
//! only then publishes them (`commit`). A program's long request is carried out in parts, so that others come in between. Who
//! drags a feature waits for the solver, and nobody else (`lines`). In between it keeps the views' pictures going (`crate::views`).

mod checkpoint;
mod clients;
mod commit;
mod directory;
mod gestures;
mod grouping;
mod inbox;
mod lines;
mod message;
mod past;
mod probes;
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
use crate::backend::Services;
use crate::document_text::DocumentText;
use crate::limits::{
    LEASE_CHECK_EVERY, PRESENCE_EVERY, RETRY_AFTER, SESSION_IDLE_TIMEOUT, STALLED_CHECK_EVERY,
};
use crate::outbox::Outbox;
use crate::outboxes::{ClientId, Outboxes};
use crate::renderer::RenderLease;
use crate::scenes::{DecodedScene, SceneCache};
use crate::views::{LiveSession, Views};
use clients::ConnectedClient;
use directory::RoomStatus;
use message::RoomOpening;
use probes::Probes;
use solving::SolvedCommand;
use tick::RequestBatch;

/// What the task owns.
struct Room {
    name: Arc<str>,
    /// Names the room among all there ever were.
    number: u64,
    /// Keeps what the renderer has of its scenes.
    lease: Arc<RenderLease>,
    epoch: String,
    backend: Services,
    session: edit::Session,
    /// The document's JSON, where somebody has it.
    text: Weak<DocumentText>,
    /// After which record that is, and of which document.
    text_version: Option<(u64, DocumentHash)>,
    /// What has been written since the session's checkpoint.
    tail: store::RecordTail,
    /// Bytes of that checkpoint.
    checkpoint_bytes: u64,
    scene: OpenScene,
    clients: BTreeMap<ClientId, ConnectedClient>,
    /// What waits to be sent to them.
    outboxes: Outboxes,
    /// What they look at.
    views: Views,
    /// What they ask of pixels.
    probes: Probes,
    /// Commands of theirs that are being solved.
    solving: JoinSet<Result<Vec<SolvedCommand>, ServerError>>,
    last_client: ClientId,
    /// What programs have asked for and is not all carried out, next first.
    batches: VecDeque<RequestBatch>,
    /// For the directory to see.
    status: Arc<RoomStatus>,
    /// Counts what gestures show; frames carry it.
    live_revision: u32,
    /// Somebody came, went, selected or moved since presence was last sent.
    presence_changed: bool,
    presence_due: Instant,
    leases_due: Instant,
    opened: Instant,
    /// When it was last sent anything.
    last_used: Instant,
    is_draining: bool,
}

/// The scene of the document as it is now, and what is known of it.
#[derive(Clone)]
struct OpenScene {
    /// As its bytes have it.
    decoded: DecodedScene,
    bounds: Bounds,
    /// A camera that sees everything.
    framing: Camera,
}

/// Opens a session, says in `opening` how that went, and serves it until its inbox is closed. `from` is the task
/// that had the session before.
async fn run(
    mut inbox: mpsc::Receiver<RoomMessage>,
    (name, number): (Arc<str>, u64),
    (opening, status): (watch::Sender<RoomOpening>, Arc<RoomStatus>),
    (backend, rooms): (Services, Rooms),
    before: Option<JoinHandle<()>>,
) {
    if let Some(before) = before {
        // It may have failed; what it had committed is in the store.
        let _ = before.await;
    }
    match Room::open((&name, number), status, backend.clone()).await {
        Ok(mut room) => {
            opening.send_replace(RoomOpening::Open);
            backend.metrics.rooms.inc();
            room.keep_checkpoint().await;
            room.serve(&mut inbox, &rooms).await;
            backend.metrics.rooms.dec();
        }
        Err(error) => drop(opening.send_replace(RoomOpening::Failed(Arc::new(error)))),
    }
}

impl Room {
    async fn open(
        (name, number): (&Arc<str>, u64),
        status: Arc<RoomStatus>,
        backend: Services,
    ) -> Result<Self, ServerError> {
        let session_name = Arc::clone(name);
        let opened = backend.storage.read(move |store| store.open_session(&session_name));
        let OpenedSession { row, session, tail, checkpoint_bytes, checkpoint_failed } = opened.await?;
        if checkpoint_failed {
            tracing::warn!(
                "session {name} has a checkpoint that its log does not prove; all of the log was replayed"
            );
        }
        tracing::info!("session {name} is open at record {}, {} replayed", session.seq(), tail.records);
        let scene = OpenScene::of(session.document(), &backend.scenes).await?;
        let (now, lease) = (Instant::now(), backend.renders.lease());
        Ok(Self {
            name: Arc::clone(name),
            number,
            epoch: row.epoch,
            outboxes: Outboxes::new(backend.in_flight.clone()),
            text: Weak::new(),
            text_version: None,
            views: Views::new(backend.clone(), Arc::clone(name), Arc::clone(&lease)),
            lease,
            backend,
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
                Some(ended) = self.probes.next() => self.take_probe(ended),
                () = sleep_until(wake) => {}
            }
            if self.is_draining {
                inbox.close();
            }
        }
        self.catch_up_all().await;
        tracing::info!("session {} is closed at record {}", self.name, self.session.seq());
    }

    /// Does what is due and says when to look again.
    async fn run_due_work(&mut self, rooms: &Rooms) -> Instant {
        let now = Instant::now();
        self.drop_lost_clients();
        self.catch_up_clients().await;
        self.views.configure(&mut self.outboxes);
        let live = LiveSession {
            session: &self.session,
            scene: &self.scene.decoded.posed,
            revision: self.live_revision,
        };
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

    /// The document's text, the one that somebody has already or a new one.
    fn document_text(&mut self) -> Arc<DocumentText> {
        let document = self.session.document();
        let now = Some((self.session.seq(), document.hash()));
        let known = self.text.upgrade().filter(|_| self.text_version == now);
        known.unwrap_or_else(|| {
            let new = Arc::new(DocumentText::new(document.clone(), self.backend.in_flight.clone()));
            (self.text, self.text_version) = (Arc::downgrade(&new), now);
            new
        })
    }

    /// Its JSON. Making that takes a while, in which the session's other work waits.
    async fn document_json(&mut self) -> Result<Bytes, ServerError> {
        let text = self.document_text();
        spawn_blocking(move || text.bytes()).await.map_err(|_| ServerError::Internal)
    }

    fn drain(&mut self) {
        self.is_draining = true;
        let retry_after_ms = RETRY_AFTER.as_millis() as u64;
        self.outboxes.send_all(&ServerMessage::Draining { retry_after_ms });
    }

    /// Milliseconds since the room was opened: the clock of leases.
    fn clock_ms(&self) -> u64 {
        self.opened.elapsed().as_millis() as u64
    }

    /// It was sent something.
    fn mark_used(&mut self) {
        self.last_used = Instant::now();
        let used_ms = self.backend.started.elapsed().as_millis() as u64;
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
