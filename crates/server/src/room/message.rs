//! What a session's task is sent.

use std::sync::Arc;

use document::{Command, Document};
use protocol::EditResults;
use tokio::sync::{OwnedSemaphorePermit, mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;

use crate::ServerError;
use crate::access::Principal;
use crate::document_text::DocumentText;
use crate::outbox::Outbox;
use crate::outboxes::ClientId;
use crate::renderer::RenderLease;
use crate::request::{ClientRequest, RecordRequest};
use crate::scenes::DecodedScene;

/// Where the one answer to a request goes.
pub type Reply<T> = oneshot::Sender<Result<T, ServerError>>;

/// What a session's task is sent.
#[derive(Debug)]
pub enum RoomMessage {
    /// A client has said hello.
    Join(Box<JoinRequest>),
    /// A client requests something.
    Client {
        /// Which.
        client: ClientId,
        /// What.
        request: ClientRequest,
        /// Its place among the client's messages by which it edits, until it is carried out.
        queue_permit: Option<OwnedSemaphorePermit>,
    },
    /// A client is gone.
    Leave(ClientId),
    /// A program edits.
    Edit {
        /// On whose behalf.
        principal: Principal,
        /// In order.
        steps: Vec<RecordRequest>,
        /// One result a step.
        reply: Reply<EditResults>,
        /// Cancelled when nobody waits for them any more.
        cancellation: CancellationToken,
    },
    /// A program wants to see the session.
    Snapshot(Reply<SessionSnapshot>),
    /// What the list says of the session was changed.
    Changed {
        /// What people call it.
        title: String,
        /// Whether it is archived.
        archived: bool,
    },
    /// The server is asked to stop: finish what is waiting and end.
    Drain,
}

impl RoomMessage {
    /// The client that edits by it, or goes: those are carried out in the order in which they come.
    pub(super) fn editing_client(&self) -> Option<ClientId> {
        match self {
            Self::Client { client, request, .. } => request.may_edit().then_some(*client),
            Self::Leave(client) => Some(*client),
            Self::Join(_) | Self::Edit { .. } | Self::Snapshot(_) | Self::Changed { .. } | Self::Drain => {
                None
            }
        }
    }

    /// Whether it leaves nothing of `from`, the message by which its client edited last: an update of the drag of a feature,
    /// which takes longer to solve than updates may come apart.
    pub(super) fn supersedes(&self, before: &Self) -> bool {
        let Self::Client { request, .. } = before else { return false };
        let ClientRequest::UpdateGesture { gesture, command: Ok(Command::DragFeature { .. }), .. } = request
        else {
            return false;
        };
        match self {
            Self::Client { request, .. } => matches!(
                request,
                ClientRequest::UpdateGesture { gesture: later, .. } | ClientRequest::CancelGesture(later)
                    if later == gesture
            ),
            Self::Leave(_) => true,
            Self::Join(_) | Self::Edit { .. } | Self::Snapshot(_) | Self::Changed { .. } | Self::Drain => {
                false
            }
        }
    }

    /// Whether it ends a gesture without a record.
    pub(super) fn ends_gesture(&self) -> bool {
        matches!(self, Self::Leave(_) | Self::Client { request: ClientRequest::CancelGesture(_), .. })
    }
}

/// A client that comes. Where it is refused it is told so, and `joined` is dropped.
#[derive(Debug)]
pub struct JoinRequest {
    /// Who.
    pub principal: Principal,
    /// The history that the client knows.
    pub epoch: Option<String>,
    /// The latest record that it knows.
    pub last_seq: Option<u64>,
    /// What is sent to it.
    pub outbox: Outbox,
    /// Told the client's number after its welcome.
    pub joined: oneshot::Sender<ClientId>,
}

/// A session as it stood after a record.
#[derive(Clone, Debug)]
pub struct SessionSnapshot {
    /// Its name.
    pub name: String,
    /// Names its history.
    pub epoch: String,
    /// The record.
    pub seq: u64,
    /// The document after it.
    pub document: Document,
    /// Its JSON, shared with all who want it.
    pub text: Arc<DocumentText>,
    /// Its scene.
    pub scene: DecodedScene,
    /// Keeps what the renderer has of it.
    pub lease: Arc<RenderLease>,
}

/// How the opening of a session goes.
#[derive(Clone, Debug)]
pub(super) enum RoomOpening {
    /// Its log is replayed.
    UnderWay,
    /// It is there.
    Open,
    /// It will never be.
    Failed(Arc<ServerError>),
}

/// Reaches a session's task. The session stays open while there is one besides the directory's.
#[derive(Clone, Debug)]
pub struct RoomHandle {
    inbox: mpsc::Sender<RoomMessage>,
    opening: watch::Receiver<RoomOpening>,
}

impl RoomHandle {
    pub(super) fn new(inbox: mpsc::Sender<RoomMessage>, opening: watch::Receiver<RoomOpening>) -> Self {
        Self { inbox, opening }
    }

    /// The same once the session is open.
    pub(super) async fn opened(mut self) -> Result<Self, ServerError> {
        let opening = self.opening.wait_for(|opening| !matches!(opening, RoomOpening::UnderWay)).await;
        let failed = match &*opening.map_err(|_| ServerError::Internal)? {
            RoomOpening::Failed(error) => Some(Arc::clone(error)),
            RoomOpening::UnderWay | RoomOpening::Open => None,
        };
        failed.map_or(Ok(self), |error| Err(ServerError::Opening(error)))
    }

    /// Sends it a message; waits while its queue is full.
    pub async fn send(&self, message: RoomMessage) -> Result<(), ServerError> {
        self.inbox.send(message).await.map_err(|_| ServerError::Draining)
    }

    /// Sends it a message that is answered, and waits for the answer.
    pub async fn request<T>(&self, message: impl FnOnce(Reply<T>) -> RoomMessage) -> Result<T, ServerError> {
        let (reply, answer) = oneshot::channel();
        self.send(message(reply)).await?;
        answer.await.map_err(|_| ServerError::Draining)?
    }

    /// Whether its task is gone.
    pub(super) fn is_closed(&self) -> bool {
        self.inbox.is_closed()
    }

    /// Whether nobody else can reach it.
    pub(super) fn is_unshared(&self) -> bool {
        self.inbox.strong_count() == 1
    }
}
