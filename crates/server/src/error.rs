//! What can go wrong. Users get a code and a sentence that says what to do; what lies behind it goes to the log.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use edit::EditRefusal;
use protocol::{ErrorCode, FileError, PROTOCOL, Problem, Refused, RenderRefusal};
use reference::ReferenceError;
use render::RenderError;
use store::StoreError;
use thiserror::Error;

use crate::limits::{BODY_IDLE_TIMEOUT, HELLO_TIMEOUT, LARGE_BODY_TIMEOUT, MAX_MOVING_PIXELS, SMALL_BYTES};

/// Why the server does not start, or why a request is refused.
#[derive(Debug, Error)]
pub enum ServerError {
    /// A file of the data folder that the system would not read or write.
    #[error("{}: cannot be used ({reason}); check the folder and that you may write there", path.display())]
    Data {
        /// Which.
        path: PathBuf,
        /// Why not.
        reason: io::Error,
    },
    /// The file for the trace cannot be written.
    #[error("{}: no trace can be written there ({reason}); check the folder and that you may write there", path.display())]
    Trace {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The data folder has another server.
    #[error("{}: another server is using this folder; stop it, or name another folder with --data", .0.display())]
    Locked(PathBuf),
    /// The token's file holds something else.
    #[error("{}: is not a token of 32 hexadecimal digits; remove the file to get a new one", .0.display())]
    BadToken(PathBuf),
    /// The listening socket failed.
    #[error("the server can no longer accept connections ({0}): start it again")]
    Listen(io::Error),
    /// A scene that cannot be used.
    #[error(transparent)]
    Scene(#[from] assets::AssetError),
    /// No demo scene of that name.
    #[error("there is no demo scene `{0}`: `bendylights scenes` lists them")]
    NoDemo(String),
    /// A scene whose session can get no name.
    #[error("the folder has too many sessions called `{0}` and the like: name the scene's file otherwise")]
    NoSessionName(String),
    /// A picture that cannot be made.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture that is not asked for as it can be.
    #[error(transparent)]
    InvalidRenderRequest(#[from] RenderRefusal),
    /// A point of a picture that cannot be looked at.
    #[error(transparent)]
    Probe(#[from] ReferenceError),
    /// A picture that cannot be encoded.
    #[error(transparent)]
    Encode(#[from] stream::StreamError),
    /// The store refused, or its disk did, when something was to be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The store, or its disk, did not give what was to be read.
    #[error(transparent)]
    StoreRead(StoreError),
    /// Why a session could not be opened, for each who asked.
    #[error(transparent)]
    Opening(Arc<ServerError>),

    /// No token, or another server's.
    #[error("the token is missing or wrong: open the address that the server printed when it started")]
    Unauthorized,
    /// A page of somewhere else.
    #[error("pages of {0} may not use this server: open the server's own address")]
    ForeignOrigin(String),
    /// A name that may lead here by a stranger's doing.
    #[error(
        "this server does not go by the name `{0}`: open the address that it printed when it started, or start it with \
         --public-url http://{0}"
    )]
    ForeignHost(String),
    /// Another version of the protocol.
    #[error(
        "this server speaks protocol {PROTOCOL}, not {0}: reload the page, or use a client of that version"
    )]
    Protocol(u32),
    /// Something else before `hello`, or a second one.
    #[error("a connection begins with exactly one `hello`: send that first")]
    Hello,
    /// No `hello` at all.
    #[error("no `hello` came within {} seconds: connect again", HELLO_TIMEOUT.as_secs())]
    HelloTooLate,
    /// A message or a body that cannot be read.
    #[error("{0}")]
    BadMessage(String),
    /// A command that means nothing.
    #[error(transparent)]
    BadCommand(#[from] Refused),
    /// What the session refuses.
    #[error(transparent)]
    Refused(#[from] EditRefusal),
    /// An edit of a group that cannot be read.
    #[error("edit {number} of the group: {reason}; nothing of the group was done")]
    InGroup {
        /// Which, counted from 1.
        number: usize,
        /// What is wrong with it.
        reason: Box<ServerError>,
    },
    /// Views that are drawn smaller while they move. Said, and nothing is refused.
    #[error(
        "your views have more than {MAX_MOVING_PIXELS} pixels that move at once, so they are drawn smaller until they rest: \
         close one, or make it smaller"
    )]
    ViewsMoveTooMuch,
    /// Something that does not exist.
    #[error("there is no {what} `{name}`: {remedy}")]
    NotFound {
        /// Of which kind.
        what: &'static str,
        /// What was asked for.
        name: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A session that is to go, and has people in it.
    #[error(
        "{} in session `{session}`, which cannot be deleted while anybody is: ask them to leave it",
        names_in_sentence(people)
    )]
    InUse {
        /// Its name.
        session: String,
        /// What its clients are called.
        people: Vec<String>,
    },
    /// No such page.
    #[error("{0} is not an address of this server: /openapi.json lists them")]
    NoRoute(String),
    /// An address that takes other methods.
    #[error("{path} does not take {method}: the header `Allow` of this answer says what it takes")]
    MethodNotAllowed {
        /// The address.
        path: String,
        /// What came.
        method: String,
    },
    /// A body that is something else than JSON.
    #[error(
        "the body is `{0}` by its Content-Type, and JSON is needed here: send it with `Content-Type: application/json` \
         (curl: --json in place of -d)"
    )]
    NotJson(String),
    /// A size over its limit.
    #[error("{what} may have at most {limit} {unit}: make it smaller")]
    TooLarge {
        /// Of what.
        what: &'static str,
        /// How large it may be.
        limit: usize,
        /// Counted in what.
        unit: &'static str,
    },
    /// A body that does not come.
    #[error("nothing of the request came for {} s: send it again", BODY_IDLE_TIMEOUT.as_secs())]
    BodyTimedOut,
    /// A large body that comes too slowly.
    #[error("a request of more than {SMALL_BYTES} bytes has to come within {} s: send it in parts", LARGE_BODY_TIMEOUT.as_secs())]
    TooSlow,
    /// As many bytes in flight as there may be.
    #[error("the server holds as many bytes of requests and answers as it may: try again in a moment")]
    Busy,
    /// A body that ends before its end.
    #[error("the request was cut off: send it again")]
    CutOff,
    /// A count over its limit.
    #[error("this server takes at most {limit} {what} at once: try again later")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        limit: usize,
    },
    /// A count that one session has of what all share.
    #[error(
        "the session has {count} {what} under way, and leaves the rest to others: try again when one of them is done"
    )]
    SessionLimitReached {
        /// As people call them: requests, pictures.
        what: &'static str,
        /// Those under way.
        count: usize,
    },
    /// The pipelines are not ready yet.
    #[error("the renderer is warming up: try again in a few seconds")]
    WarmingUp,
    /// They never will be.
    #[error("the renderer could not be warmed up ({0}): restart the server")]
    NotReady(RenderError),
    /// The server is asked to stop.
    #[error("the server is stopping: try again in a moment")]
    Draining,
    /// Others changed what a drag depends on each time that it was solved.
    #[error(
        "the light, its pins or the scene changed {0} times while this was solved: try again when others are done"
    )]
    TooManySolveRetries(u32),
    /// A task of the server is gone.
    #[error("the server has a fault of its own: try again, and send its log to its makers")]
    Internal,
}

impl ServerError {
    /// The code that programs act on.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Data { .. } | Self::Trace { .. } | Self::Locked(_) | Self::BadToken(_) => {
                ErrorCode::Storage
            }
            Self::Listen(_) | Self::Internal => ErrorCode::Fault,
            Self::Scene(_) => ErrorCode::BadScene,
            Self::NoDemo(_) => ErrorCode::UnknownAsset,
            Self::Render(_) | Self::Encode(_) => ErrorCode::Render,
            Self::Store(error) | Self::StoreRead(error) => error.code(),
            Self::Opening(error) => error.code(),
            Self::Unauthorized => ErrorCode::Unauthorized,
            Self::ForeignOrigin(_) => ErrorCode::ForeignOrigin,
            Self::ForeignHost(_) => ErrorCode::ForeignHost,
            Self::Protocol(_) | Self::Hello => ErrorCode::Protocol,
            Self::HelloTooLate => ErrorCode::HelloTooLate,
            Self::Probe(ReferenceError::Camera(_)) => ErrorCode::InvalidCamera,
            Self::BadMessage(_) | Self::CutOff | Self::Probe(_) => ErrorCode::BadMessage,
            Self::InvalidRenderRequest(refusal) => refusal.code(),
            Self::BadCommand(refused) => refused.code(),
            Self::Refused(refusal) => refusal.into(),
            Self::InGroup { reason, .. } => reason.code(),
            Self::NotFound { .. } | Self::NoRoute(_) => ErrorCode::NotFound,
            Self::InUse { .. } => ErrorCode::InUse,
            Self::MethodNotAllowed { .. } => ErrorCode::MethodNotAllowed,
            Self::NotJson(_) => ErrorCode::UnsupportedMediaType,
            Self::TooLarge { .. } => ErrorCode::TooLarge,
            Self::TooMany { .. }
            | Self::SessionLimitReached { .. }
            | Self::ViewsMoveTooMuch
            | Self::NoSessionName(_) => ErrorCode::TooMany,
            Self::TooManySolveRetries(_) => ErrorCode::KeepsChanging,
            Self::BodyTimedOut | Self::TooSlow => ErrorCode::Stalled,
            Self::Busy => ErrorCode::Busy,
            Self::WarmingUp => ErrorCode::WarmingUp,
            Self::NotReady(_) => ErrorCode::NotReady,
            Self::Draining => ErrorCode::Draining,
        }
    }

    /// Whether another try may go otherwise (SPEC, REC-4).
    pub fn is_transient(&self) -> bool {
        self.code().is_transient()
    }

    /// Whether what was asked for may have been done all the same.
    pub fn has_unknown_outcome(&self) -> bool {
        matches!(self, Self::Store(StoreError::UnknownOutcome(_)))
    }

    /// What a user is told. The disk's own words name folders of this machine: those go to the log only.
    pub fn problem(&self) -> Problem {
        let code = self.code();
        if matches!(code, ErrorCode::Storage | ErrorCode::UnknownOutcome) {
            tracing::error!("the store failed: {self}");
        }
        let message = match (code, self) {
            (ErrorCode::Storage, Self::StoreRead(_)) => READ_FAILED.into(),
            (ErrorCode::Storage, Self::Opening(error)) if matches!(**error, Self::StoreRead(_)) => {
                READ_FAILED.into()
            }
            (ErrorCode::Storage, _) => WRITE_FAILED.into(),
            (ErrorCode::UnknownOutcome, _) => OUTCOME_UNKNOWN.into(),
            _ => self.to_string(),
        };
        Problem { code, message }
    }
}

const READ_FAILED: &str = "the server cannot read its disk: tell whoever runs it, and try again";
const WRITE_FAILED: &str =
    "the server cannot write to its disk, nothing was changed: tell whoever runs it, and try again";
const OUTCOME_UNKNOWN: &str = "the server's disk failed, and this may have been done or not: tell whoever runs it, then look, \
    or send it again under the same name";

/// Who is there, as far as a sentence has the room.
fn names_in_sentence(people: &[String]) -> String {
    match people {
        [] => "somebody is".into(),
        [one] => format!("{one} is"),
        [first, second] => format!("{first} and {second} are"),
        [first, others @ ..] => format!("{first} and {} others are", others.len()),
    }
}

impl From<FileError> for ServerError {
    fn from(error: FileError) -> Self {
        Self::BadMessage(error.to_string())
    }
}
