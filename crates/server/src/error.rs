//! Errors of the server. Users get a code and a sentence that says what to do. Details go to the log.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use document::EditError;
use edit::EditRefusal;
use protocol::{ErrorCode, FileError, PROTOCOL, Problem, Refused, RenderRefusal};
use reference::ReferenceError;
use render::RenderError;
use store::StoreError;
use thiserror::Error;

use crate::limits::{BODY_IDLE_TIMEOUT, HELLO_TIMEOUT, LARGE_BODY_TIMEOUT, MAX_MOVING_PIXELS, SMALL_BYTES};

/// Reason for which the server does not start or refuses a request.
#[derive(Debug, Error)]
pub enum ServerError {
    /// The system refused to read or write a file of the data folder.
    #[error("{}: cannot be used ({reason}); check the folder and that you may write there", path.display())]
    Data { path: PathBuf, reason: io::Error },
    #[error("{}: no trace can be written there ({reason}); check the folder and that you may write there", path.display())]
    Trace { path: PathBuf, reason: io::Error },
    #[error("{}: another server is using this folder; stop it, or name another folder with --data", .0.display())]
    Locked(PathBuf),
    #[error("{}: is not a token of 32 hexadecimal digits; remove the file to get a new one", .0.display())]
    BadToken(PathBuf),
    #[error("the server can no longer accept connections ({0}): start it again")]
    Listen(io::Error),
    /// The scene cannot be used.
    #[error(transparent)]
    Scene(#[from] assets::AssetError),
    #[error("there is no demo scene `{0}`: `bendylights scenes` lists them")]
    NoDemo(String),
    /// Too many sessions have names derived from the scene's.
    #[error("the folder has too many sessions called `{0}` and the like: name the scene's file otherwise")]
    NoSessionName(String),
    /// A picture cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture request is invalid.
    #[error(transparent)]
    InvalidRenderRequest(#[from] RenderRefusal),
    /// A pixel cannot be probed.
    #[error(transparent)]
    Probe(#[from] ReferenceError),
    /// A picture cannot be encoded.
    #[error(transparent)]
    Encode(#[from] stream::StreamError),
    /// The store or its disk refused a write.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The store or its disk refused a read.
    #[error(transparent)]
    StoreRead(StoreError),
    /// The session could not be opened. All requests that wait for it get the same reason.
    #[error(transparent)]
    Opening(Arc<ServerError>),

    /// The token is missing or wrong.
    #[error("the token is missing or wrong: open the address that the server printed when it started")]
    Unauthorized,
    /// The page of the request has another origin.
    #[error("pages of {0} may not use this server: open the server's own address")]
    ForeignOrigin(String),
    /// The host name in the header `Host` is not one of the server's. DNS rebinding may have led the request here.
    #[error(
        "this server does not go by the name `{0}`: open the address that it printed when it started, or start it with \
         --public-url http://{0}"
    )]
    ForeignHost(String),
    #[error("this server speaks protocol {PROTOCOL}, not {0}: reload the page, or use a client of that version")]
    Protocol(u32),
    /// The first message is no `hello`, or a second one came.
    #[error("a connection begins with exactly one `hello`: send that first")]
    Hello,
    /// No `hello` arrived in time.
    #[error("no `hello` came within {} seconds: connect again", HELLO_TIMEOUT.as_secs())]
    HelloTooLate,
    /// A message or a body cannot be read.
    #[error("{0}")]
    BadMessage(String),
    /// A command has no meaning.
    #[error(transparent)]
    BadCommand(#[from] Refused),
    /// The session refused the edit.
    #[error(transparent)]
    Refused(#[from] EditRefusal),
    /// An edit of a group is invalid.
    #[error("edit {number} of the group: {reason}; nothing of the group was done")]
    InGroup {
        /// Number of the edit, from 1.
        number: usize,
        reason: Box<ServerError>,
    },
    /// The client's moving views are drawn smaller. This is a warning and refuses nothing.
    #[error(
        "your views have more than {MAX_MOVING_PIXELS} pixels that move at once, so they are drawn smaller until they rest: \
         close one, or make it smaller"
    )]
    ViewsMoveTooMuch,
    #[error("there is no {what} `{name}`: {remedy}")]
    NotFound {
        /// Kind of the missing thing.
        what: &'static str,
        /// Name in the request.
        name: String,
        remedy: &'static str,
    },
    /// A session to delete has clients.
    #[error(
        "{} in session `{session}`, which cannot be deleted while anybody is: ask them to leave it",
        names_in_sentence(people)
    )]
    InUse {
        session: String,
        /// Names of the connected actors.
        people: Vec<String>,
    },
    /// No route has that path.
    #[error("{0} is not an address of this server: /openapi.json lists them")]
    NoRoute(String),
    /// The path takes other methods.
    #[error("{path} does not take {method}: the header `Allow` of this answer says what it takes")]
    MethodNotAllowed { path: String, method: String },
    /// The body is not JSON.
    #[error(
        "the body is `{0}` by its Content-Type, and JSON is needed here: send it with `Content-Type: application/json` \
         (curl: --json in place of -d)"
    )]
    NotJson(String),
    /// A size is over its limit.
    #[error("{what} may have at most {limit} {unit}: make it smaller")]
    TooLarge {
        what: &'static str,
        limit: usize,
        /// Unit of the limit.
        unit: &'static str,
    },
    /// The body stopped arriving.
    #[error("nothing of the request came for {} s: send it again", BODY_IDLE_TIMEOUT.as_secs())]
    BodyTimedOut,
    /// A large body arrives too slowly.
    #[error("a request of more than {SMALL_BYTES} bytes has to come within {} s: send it in parts", LARGE_BODY_TIMEOUT.as_secs())]
    TooSlow,
    /// The budget of bytes in flight is used up.
    #[error("the server holds as many bytes of requests and answers as it may: try again in a moment")]
    Busy,
    /// The body ended early.
    #[error("the request was cut off: send it again")]
    CutOff,
    /// A count is over its limit.
    #[error("this server takes at most {limit} {what} at once: try again later")]
    TooMany { what: &'static str, limit: usize },
    /// The session already uses its share of a limit that all sessions share.
    #[error(
        "the session has {count} {what} under way, and leaves the rest to others: try again when one of them is done"
    )]
    SessionLimitReached {
        /// Plural name of the limited things: requests, pictures.
        what: &'static str,
        /// Number of those things that the session has in progress.
        count: usize,
    },
    #[error("the renderer is warming up: try again in a few seconds")]
    WarmingUp,
    /// The pipelines could not be warmed up.
    #[error("the renderer could not be warmed up ({0}): restart the server")]
    NotReady(RenderError),
    #[error("the server is stopping: try again in a moment")]
    Draining,
    /// Others changed the inputs of a drag during each of its solves.
    #[error("the light, its pins or the scene changed {0} times while this was solved: try again when others are done")]
    TooManySolveRetries(u32),
    /// A task of the server has ended unexpectedly.
    #[error("the server has a fault of its own: try again, and send its log to its makers")]
    Internal,
}

/// Gives an error if a size is over its limit.
pub fn check_size(what: &'static str, size: usize, limit: usize, unit: &'static str) -> Result<(), ServerError> {
    if size > limit { Err(ServerError::TooLarge { what, limit, unit }) } else { Ok(()) }
}

impl ServerError {
    /// Makes the error of a message or a body that cannot be carried out. `sentence` says what to do.
    pub fn bad_message(sentence: &str) -> Self {
        Self::BadMessage(sentence.into())
    }

    /// Returns the error code for clients.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::Data { .. } | Self::Trace { .. } | Self::Locked(_) | Self::BadToken(_) => ErrorCode::Storage,
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

    /// True if another try may succeed (SPEC, REC-4).
    pub fn is_transient(&self) -> bool {
        self.code().is_transient()
    }

    /// True if the request may have been carried out although it failed.
    pub fn has_unknown_outcome(&self) -> bool {
        matches!(self, Self::Store(StoreError::UnknownOutcome(_)))
    }

    /// Returns code and message for users. Messages of the store contain folder names of this machine, so they go to
    /// the log only.
    pub fn problem(&self) -> Problem {
        let code = self.code();
        let message = match (code, self) {
            (ErrorCode::Storage, Self::StoreRead(_)) => READ_FAILED,
            (ErrorCode::Storage, Self::Opening(error)) if matches!(**error, Self::StoreRead(_)) => READ_FAILED,
            (ErrorCode::Storage, _) => WRITE_FAILED,
            (ErrorCode::UnknownOutcome, _) => OUTCOME_UNKNOWN,
            _ => return Problem { code, message: self.to_string() },
        };
        tracing::error!("the store failed: {self}");
        Problem { code, message: message.into() }
    }
}

const READ_FAILED: &str = "the server cannot read its disk: tell whoever runs it, and try again";
const WRITE_FAILED: &str =
    "the server cannot write to its disk, nothing was changed: tell whoever runs it, and try again";
const OUTCOME_UNKNOWN: &str = "the server's disk failed, and this may have been done or not: tell whoever runs it, then look, \
    or send it again under the same name";

/// Joins names of people and a verb, as many names as a sentence has room for.
fn names_in_sentence(people: &[String]) -> String {
    match people {
        [] => "somebody is".into(),
        [one] => format!("{one} is"),
        [first, second] => format!("{first} and {second} are"),
        [first, others @ ..] => format!("{first} and {} others are", others.len()),
    }
}

impl From<EditError> for ServerError {
    fn from(error: EditError) -> Self {
        EditRefusal::from(error).into()
    }
}

impl From<FileError> for ServerError {
    fn from(error: FileError) -> Self {
        Self::BadMessage(error.to_string())
    }
}
