//! What a session's task can be told.

use std::sync::Arc;

use document::{Command, Document};
use edit::{Actor, Request};
use light::LightId;
use protocol::EditResults;
use scene::Camera;
use tokio::sync::{mpsc, oneshot, watch};

use crate::ServerError;
use crate::lane::Lane;
use crate::renderer::Lease;

/// A client of a session. Counts from 1 while the session is open.
pub type ClientId = u64;

/// One answer to one question.
pub type Reply<T> = oneshot::Sender<Result<T, ServerError>>;

/// What a session's task can be told.
#[derive(Debug)]
pub enum Message {
    /// A client has said hello.
    Join(Box<Join>),
    /// A client asks for something.
    Ask {
        /// Which.
        client: ClientId,
        /// For what.
        ask: Ask,
    },
    /// A client is gone.
    Leave(ClientId),
    /// A program edits.
    Edit {
        /// On whose behalf.
        actor: Actor,
        /// In order.
        steps: Vec<Step>,
        /// One result a step.
        reply: Reply<EditResults>,
    },
    /// A program looks.
    Look(Reply<Snapshot>),
    /// The server is asked to stop: finish what is waiting and end.
    Drain,
}

/// A client that comes. Where it is refused it is told so, and `joined` is dropped.
#[derive(Debug)]
pub struct Join {
    /// Who.
    pub actor: Actor,
    /// The history that the client knows.
    pub epoch: Option<String>,
    /// The latest record that it knows.
    pub last_seq: Option<u64>,
    /// The way to it.
    pub lane: Lane,
    /// Told the client's number after its welcome.
    pub joined: oneshot::Sender<ClientId>,
}

/// What clients ask for.
#[derive(Debug)]
pub enum Ask {
    /// A view of one's own.
    OpenView {
        /// From where.
        camera: Camera,
        /// The client's number for it.
        camera_revision: u32,
        /// Width and height in pixels.
        size: [u32; 2],
    },
    /// To see what another client sees.
    Follow(ClientId),
    /// Another camera of one's own view.
    SetCamera {
        /// Which.
        camera: Camera,
        /// The client's number for it.
        camera_revision: u32,
    },
    /// Another size of one's own view, in pixels.
    Resize([u32; 2]),
    /// A frame is shown.
    Ack(u64),
    /// Something that ends in a record.
    Step(Step),
    /// To drag a light.
    BeginGesture {
        /// The client's name for it.
        gesture: String,
        /// Which light.
        light: LightId,
        /// The latest record that the client knew.
        base_seq: u64,
    },
    /// The latest state of a drag.
    UpdateGesture {
        /// Which.
        gesture: String,
        /// The client's number for it.
        update: u64,
        /// The state, or why it has no meaning.
        command: Result<Command, ServerError>,
    },
    /// To end a drag without a trace.
    CancelGesture(String),
    /// The light that the client looks at.
    Select(Option<u64>),
    /// What undo and redo would take back.
    History,
    /// A sign of life; the number comes back.
    Ping(f64),
    /// What could not be read or is not allowed: why.
    Nonsense(ServerError),
}

/// A request for a record, under its sender's name for it; or why it has no meaning.
#[derive(Debug)]
pub struct Step {
    /// The sender's name.
    pub op_id: String,
    /// What is asked for.
    pub request: Result<Request, ServerError>,
}

/// A session as it stood after a record.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Its name.
    pub name: String,
    /// Names its history.
    pub epoch: String,
    /// The record.
    pub seq: u64,
    /// The document after it.
    pub document: Document,
    /// What of its scene's file is not drawn or was changed, a sentence each.
    pub notes: Arc<[String]>,
    /// Keeps what the renderer has of it.
    pub lease: Arc<Lease>,
}

/// How the opening of a session goes.
#[derive(Clone, Debug)]
pub(super) enum Opening {
    /// Its log is replayed.
    UnderWay,
    /// It is there.
    Open,
    /// It will never be.
    Failed(Arc<ServerError>),
}

/// The way to a session's task. The session stays open while there is one besides the directory's.
#[derive(Clone, Debug)]
pub struct RoomHandle {
    inbox: mpsc::Sender<Message>,
    opening: watch::Receiver<Opening>,
}

impl RoomHandle {
    pub(super) fn new(inbox: mpsc::Sender<Message>, opening: watch::Receiver<Opening>) -> Self {
        Self { inbox, opening }
    }

    /// The same once the session is open.
    pub(super) async fn opened(mut self) -> Result<Self, ServerError> {
        let opening = self.opening.wait_for(|opening| !matches!(opening, Opening::UnderWay)).await;
        let failed = match &*opening.map_err(|_| ServerError::Fault)? {
            Opening::Failed(error) => Some(Arc::clone(error)),
            Opening::UnderWay | Opening::Open => None,
        };
        failed.map_or(Ok(self), |error| Err(ServerError::Opening(error)))
    }

    /// Tells it something; waits while its queue is full.
    pub async fn tell(&self, message: Message) -> Result<(), ServerError> {
        self.inbox.send(message).await.map_err(|_| ServerError::Draining)
    }

    /// Asks it something.
    pub async fn ask<T>(&self, question: impl FnOnce(Reply<T>) -> Message) -> Result<T, ServerError> {
        let (reply, answer) = oneshot::channel();
        self.tell(question(reply)).await?;
        answer.await.map_err(|_| ServerError::Draining)?
    }

    /// Whether its task is gone.
    pub(super) fn is_over(&self) -> bool {
        self.inbox.is_closed()
    }

    /// Whether nobody else has a way to it.
    pub(super) fn is_last(&self) -> bool {
        self.inbox.strong_count() == 1
    }
}
