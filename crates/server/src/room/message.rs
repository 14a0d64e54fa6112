//! Messages to the task of a session.

use std::sync::Arc;

use document::{Document, needs_solution};
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

/// Sender of the answer to a request.
pub type Reply<T> = oneshot::Sender<Result<T, ServerError>>;

/// A message to the task of a session.
#[derive(Debug)]
pub enum RoomMessage {
    /// A client has said hello.
    Join(Box<JoinRequest>),
    /// A request of a client.
    Client {
        client: ClientId,
        request: ClientRequest,
        /// Permit of the client's queue of editing messages, held until the request is carried out.
        queue_permit: Option<OwnedSemaphorePermit>,
    },
    Leave(ClientId),
    /// Edits of a program.
    Edit {
        principal: Principal,
        /// In order.
        steps: Vec<RecordRequest>,
        /// Takes one result per step.
        reply: Reply<EditResults>,
        /// Cancelled when the program no longer waits for the answer.
        cancellation: CancellationToken,
    },
    /// A program asks for the state of the session.
    Snapshot(Reply<SessionSnapshot>),
    /// The title or the archived state of the session was changed.
    Changed {
        title: String,
        archived: bool,
    },
    /// The server stops: finish the waiting work and end.
    Drain,
}

impl RoomMessage {
    /// Returns the client, if the message edits or leaves. Such messages are carried out in the order of arrival.
    pub(super) fn editing_client(&self) -> Option<ClientId> {
        match self {
            Self::Client { client, request, .. } => request.may_edit().then_some(*client),
            Self::Leave(client) => Some(*client),
            _ => None,
        }
    }

    /// True if the message makes `before` useless, the client's previous editing message. That holds for an update of a
    /// feature drag, since a solve takes longer than the time between updates.
    pub(super) fn supersedes(&self, before: &Self, document: &Document) -> bool {
        let Self::Client { request: ClientRequest::UpdateGesture { gesture, command: Ok(command), .. }, .. } = before
        else {
            return false;
        };
        if !needs_solution(document, command) {
            return false;
        }
        match self {
            Self::Client {
                request: ClientRequest::UpdateGesture { gesture: later, .. } | ClientRequest::CancelGesture(later),
                ..
            } => later == gesture,
            Self::Leave(_) => true,
            _ => false,
        }
    }

    /// True if the message ends a gesture without a record.
    pub(super) fn ends_gesture(&self) -> bool {
        matches!(self, Self::Leave(_) | Self::Client { request: ClientRequest::CancelGesture(_), .. })
    }
}

/// A request to join a session. A refused client gets the error, and `joined` is dropped.
#[derive(Debug)]
pub struct JoinRequest {
    pub principal: Principal,
    /// The history that the client knows.
    pub epoch: Option<String>,
    /// Number of the latest record that the client knows.
    pub last_seq: Option<u64>,
    pub outbox: Outbox,
    /// Receives the client's number after its welcome.
    pub joined: oneshot::Sender<ClientId>,
}

/// State of a session after a record.
#[derive(Clone, Debug)]
pub struct SessionSnapshot {
    pub name: String,
    /// Identifies its history.
    pub epoch: String,
    /// Number of the latest record.
    pub seq: u64,
    pub document: Document,
    /// JSON of the document, shared with all readers.
    pub text: Arc<DocumentText>,
    pub scene: DecodedScene,
    /// Keeps the session's data in the renderer.
    pub lease: Arc<RenderLease>,
}

#[derive(Clone, Debug)]
pub(super) enum RoomOpening {
    /// The log is replayed.
    UnderWay,
    Open,
    Failed(Arc<ServerError>),
}

/// Handle to the task of a session. The session stays open while a handle besides the directory's exists.
#[derive(Clone, Debug)]
pub struct RoomHandle {
    pub(super) inbox: mpsc::Sender<RoomMessage>,
    pub(super) opening: watch::Receiver<RoomOpening>,
}

impl RoomHandle {
    /// Waits until the session is open and returns the handle.
    pub(super) async fn opened(mut self) -> Result<Self, ServerError> {
        let opening = self.opening.wait_for(|opening| !matches!(opening, RoomOpening::UnderWay)).await;
        if let RoomOpening::Failed(error) = &*opening.map_err(|_| ServerError::Internal)? {
            return Err(ServerError::Opening(Arc::clone(error)));
        }
        Ok(self)
    }

    /// Sends a message. Waits while the room's queue is full.
    pub async fn send(&self, message: RoomMessage) -> Result<(), ServerError> {
        self.inbox.send(message).await.map_err(|_| ServerError::Draining)
    }

    /// Sends a message and waits for its answer.
    pub async fn request<T>(&self, message: impl FnOnce(Reply<T>) -> RoomMessage) -> Result<T, ServerError> {
        let (reply, answer) = oneshot::channel();
        self.send(message(reply)).await?;
        answer.await.map_err(|_| ServerError::Draining)?
    }

    /// True if no other handle exists.
    pub(super) fn is_unshared(&self) -> bool {
        self.inbox.strong_count() == 1
    }
}
