//! One session: one task that owns its document, its clients and their views.
//!
//! The task takes a message, and what else is waiting; carries it out; commits the records that came of it together; and
//! only then tells anybody (`tick`). A program's long request is carried out in parts, so that others come in between. In
//! between it keeps the views' pictures going (`views`).

mod clients;
mod directory;
mod gestures;
mod message;
mod past;
mod pictures;
mod steps;
mod tick;
mod views;

use std::collections::{BTreeMap, VecDeque};
use std::future::ready;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use document::Document;
use protocol::Bounds;
use scene::Camera;
use store::Opened;
use tokio::sync::{mpsc, watch};
use tokio::task::{JoinHandle, JoinSet, spawn_blocking};
use tokio::time::{Instant, sleep_until};

pub use directory::Rooms;
pub use message::{Ask, ClientId, Join, Message, RoomHandle, Snapshot, Step};
pub(crate) use tick::time_ms;

use crate::ServerError;
use crate::backend::Backend;
use crate::limits::{IDLE_AT_MOST, LEASE_CHECK_EVERY, PRESENCE_EVERY, RETRY_AFTER, STALLED_CHECK_EVERY};
use crate::renderer::Lease;
use crate::scenes::Scenes;
use clients::Client;
use directory::Signs;
use message::Opening;
use pictures::Picture;
use tick::Batch;

/// What the task owns.
struct Room {
    name: Arc<str>,
    /// Names the room among all there ever were.
    number: u64,
    /// Keeps what the renderer has of its scenes.
    lease: Arc<Lease>,
    epoch: String,
    backend: Backend,
    session: edit::Session,
    /// What has been written since the session's checkpoint.
    tail: store::Tail,
    /// Bytes of that checkpoint.
    checkpoint_bytes: u64,
    surroundings: Surroundings,
    clients: BTreeMap<ClientId, Client>,
    last_client: ClientId,
    /// What programs have asked for and is not all carried out, next first.
    batches: VecDeque<Batch>,
    /// For the directory to see.
    signs: Arc<Signs>,
    /// Counts what gestures show; frames carry it.
    live_revision: u32,
    /// Counts what views show.
    content_revision: u64,
    pictures: JoinSet<Picture>,
    /// Somebody came, went, selected or moved since presence was last sent.
    presence_changed: bool,
    presence_due: Instant,
    leases_due: Instant,
    opened: Instant,
    /// When it was last told anything.
    used: Instant,
    draining: bool,
}

/// What is known of a scene besides the document.
#[derive(Clone)]
struct Surroundings {
    bounds: Bounds,
    /// What of its file is not drawn or was changed, a sentence each.
    notes: Arc<[String]>,
    /// A camera that sees everything.
    framing: Camera,
}

/// Opens a session, says in `opening` how that went, and serves it until its inbox is closed. `before` is the task
/// that had the session before.
async fn run(
    mut inbox: mpsc::Receiver<Message>,
    (name, number): (Arc<str>, u64),
    (opening, signs): (watch::Sender<Opening>, Arc<Signs>),
    (backend, rooms): (Backend, Rooms),
    before: Option<JoinHandle<()>>,
) {
    if let Some(before) = before {
        // It may have failed; what it had committed is in the store.
        let _ = before.await;
    }
    match Room::open((&name, number), signs, backend.clone()).await {
        Ok(mut room) => {
            opening.send_replace(Opening::Open);
            backend.metrics.rooms.inc();
            room.keep_checkpoint().await;
            room.serve(&mut inbox, &rooms).await;
            backend.metrics.rooms.dec();
        }
        Err(error) => drop(opening.send_replace(Opening::Failed(Arc::new(error)))),
    }
}

impl Room {
    async fn open(
        (name, number): (&Arc<str>, u64),
        signs: Arc<Signs>,
        backend: Backend,
    ) -> Result<Self, ServerError> {
        let (session_name, scenes) = (Arc::clone(name), Arc::clone(&backend.scenes));
        let opened = backend.storage.read_with_scenes(&scenes, move |store, find_scene| {
            store.open_session(&session_name, find_scene)
        });
        let Opened { row, session, tail, checkpoint_failed } = opened.await?;
        if checkpoint_failed {
            tracing::warn!(
                "session {name} has a checkpoint that its log does not prove; all of the log was replayed"
            );
        }
        tracing::info!("session {name} is open at record {}, {} replayed", session.seq(), tail.records);
        let surroundings = Surroundings::of(session.document(), &scenes).await?;
        let now = Instant::now();
        Ok(Self {
            name: Arc::clone(name),
            number,
            epoch: row.epoch,
            lease: backend.renders.lease(),
            backend,
            surroundings,
            session,
            tail,
            checkpoint_bytes: 0,
            clients: BTreeMap::new(),
            last_client: 0,
            batches: VecDeque::new(),
            signs,
            live_revision: 0,
            content_revision: 0,
            pictures: JoinSet::new(),
            presence_changed: false,
            presence_due: now,
            leases_due: now,
            opened: now,
            used: now,
            draining: false,
        })
    }

    async fn serve(&mut self, inbox: &mut mpsc::Receiver<Message>, rooms: &Rooms) {
        loop {
            let wake = self.attend(rooms);
            tokio::select! {
                message = inbox.recv(), if self.batches.is_empty() => match message {
                    Some(message) => self.tick(Some(message), inbox).await,
                    None => break,
                },
                () = ready(()), if !self.batches.is_empty() => self.tick(None, inbox).await,
                Some(picture) = self.pictures.join_next_with_id() => self.take_picture(picture),
                () = sleep_until(wake) => {}
            }
            if self.draining {
                inbox.close();
            }
        }
        self.catch_up_all();
        tracing::info!("session {} is closed at record {}", self.name, self.session.seq());
    }

    /// Does what is due and says when to look again.
    fn attend(&mut self, rooms: &Rooms) -> Instant {
        let now = Instant::now();
        self.drop_lost_clients();
        self.catch_up_clients();
        self.configure_views();
        let mut wake = self.pump(now);
        if self.has_clients_behind() {
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
                self.say_presence();
                self.presence_due = now + PRESENCE_EVERY;
            } else {
                wake = wake.min(self.presence_due);
            }
        }
        if self.clients.is_empty() {
            if self.used + IDLE_AT_MOST <= now {
                rooms.idle(&self.name, self.number);
                self.used = now;
            }
            wake = wake.min(self.used + IDLE_AT_MOST);
        }
        wake
    }

    fn drain(&mut self) {
        self.draining = true;
        let retry_after_ms = RETRY_AFTER.as_millis() as u64;
        for client in self.clients.values_mut() {
            client.lane.say(&protocol::ServerMessage::Draining { retry_after_ms });
        }
    }

    /// Milliseconds since the room was opened: the clock of leases.
    fn clock_ms(&self) -> u64 {
        self.opened.elapsed().as_millis() as u64
    }

    /// It was told something.
    fn note_use(&mut self) {
        self.used = Instant::now();
        let used_ms = self.backend.started.elapsed().as_millis() as u64;
        self.signs.used_ms.store(used_ms, Ordering::Relaxed);
    }

    fn note_client_count(&self) {
        self.signs.clients.store(self.clients.len(), Ordering::Relaxed);
    }
}

impl Surroundings {
    /// Of a document whose scene has just been decoded, and so is at hand.
    async fn of(document: &Document, scenes: &Scenes) -> Result<Self, ServerError> {
        let notes = match document.scene_ref() {
            Some(scene) => scenes.load(scene.asset).await?.notes,
            None => Arc::default(),
        };
        let scene = Arc::clone(document.scene());
        let looked = spawn_blocking(move || Self {
            bounds: Bounds::of(&scene),
            notes,
            framing: scene::framing_camera(&scene, scene::DEFAULT_ASPECT),
        });
        looked.await.map_err(|_| ServerError::Fault)
    }
}

/// The clock of views, which tests can stop.
fn now() -> std::time::Instant {
    Instant::now().into_std()
}
