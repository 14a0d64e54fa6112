//! Why something is refused: one closed list of codes, each with its HTTP status, and a code with its sentence.

use std::fmt;

use document::EditError;
use edit::EditRefusal;
use light::LightError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The codes: each with its name in JSON and the status of an HTTP request that is refused with it.
macro_rules! codes {
    ($($(#[$meaning:meta])* $code:ident = $name:literal, $status:literal;)*) => {
        /// Why something is refused, for programs. The sentence beside it is for people.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        pub enum ErrorCode {
            $($(#[$meaning])* #[serde(rename = $name)] $code,)*
        }

        impl ErrorCode {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$code),*];

            /// Its name in JSON.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$code => $name,)*
                }
            }

            /// The status of an HTTP request that is refused with it. Codes that only the socket or results of edits
            /// have would be 400.
            pub fn http_status(self) -> u16 {
                match self {
                    $(Self::$code => $status,)*
                }
            }
        }
    };
}

codes! {
    /// The message, the body or a parameter cannot be read.
    BadMessage = "badMessage", 400;
    /// The name cannot name a session or a scene.
    BadName = "badName", 400;
    /// The scene's file cannot be used.
    BadScene = "badScene", 400;
    /// The feature cannot be dragged there, or the pin cannot be.
    Drag = "drag", 400;
    /// The log was changed or does not fit together.
    BadLog = "badLog", 400;
    /// The record is of a format that this server does not know.
    Format = "format", 400;
    /// The picture cannot be made.
    Render = "render", 400;
    /// The light could not be evaluated, or would be out of reach.
    InvalidLight = "invalidLight", 400;
    /// The camera makes no picture.
    InvalidCamera = "invalidCamera", 400;
    /// The light has no such parameter.
    WrongKind = "wrongKind", 400;
    /// The first control point is the source, which stays where it is.
    Source = "source", 400;
    /// The document is not what the change says it was.
    Conflict = "conflict", 400;
    /// Somebody else is dragging the light.
    Locked = "locked", 400;
    /// The control points have been renumbered since.
    Stale = "stale", 400;
    /// No step to take back.
    NothingToUndo = "nothingToUndo", 400;
    /// No undo to take back.
    NothingToRedo = "nothingToRedo", 400;
    /// Others changed what the drag depends on each time that it was solved.
    KeepsChanging = "keepsChanging", 400;
    /// No such drag of the sender's.
    NoGesture = "noGesture", 400;
    /// The drag was never updated.
    EmptyGesture = "emptyGesture", 400;
    /// The drag's command is not of its light.
    OtherLight = "otherLight", 400;
    /// Another version of the protocol, or no `hello` where one belongs.
    Protocol = "protocol", 400;
    /// No `hello` came in time.
    HelloTooLate = "helloTooLate", 400;
    /// The token is missing or wrong.
    Unauthorized = "unauthorized", 401;
    /// A page of another place may not use this server.
    ForeignOrigin = "foreignOrigin", 403;
    /// The server does not go by the name that the request came to.
    ForeignHost = "foreignHost", 403;
    /// What the request names does not exist.
    NotFound = "notFound", 404;
    /// The server does not have the scene.
    UnknownAsset = "unknownAsset", 404;
    /// The address takes other methods, which the header `Allow` lists.
    MethodNotAllowed = "methodNotAllowed", 405;
    /// The request stopped coming.
    Stalled = "stalled", 408;
    /// The name is taken.
    Exists = "exists", 409;
    /// The session is not archived, and only what is archived can be deleted.
    NotArchived = "notArchived", 409;
    /// People are in the session.
    InUse = "inUse", 409;
    /// The name is that of several, whose ids the sentence says.
    Ambiguous = "ambiguous", 409;
    /// A size over its limit, which the sentence names.
    TooLarge = "tooLarge", 413;
    /// The body is not JSON by its `Content-Type`.
    UnsupportedMediaType = "unsupportedMediaType", 415;
    /// A count over its limit, which the sentence names.
    TooMany = "tooMany", 429;
    /// The server's disk failed; nothing was changed.
    Storage = "storage", 500;
    /// The server's disk failed, and this may have been done or not.
    UnknownOutcome = "unknownOutcome", 500;
    /// The stored file of the scene is damaged.
    DamagedAsset = "damagedAsset", 500;
    /// A fault of the server's own.
    Fault = "fault", 500;
    /// The server holds as many bytes of requests and answers as it may.
    Busy = "busy", 503;
    /// The renderer is not ready yet.
    WarmingUp = "warmingUp", 503;
    /// The renderer could not be made ready.
    NotReady = "notReady", 503;
    /// The server is stopping.
    Draining = "draining", 503;
}

/// What is wrong with a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Problem {
    /// For programs.
    pub code: ErrorCode,
    /// For people: what to do.
    pub message: String,
}

impl ErrorCode {
    /// The code of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// Whether another try may go otherwise: such a refusal is no answer to an operation for good (SPEC, REC-4).
    pub fn is_transient(self) -> bool {
        let of_the_moment = [
            Self::Storage,
            Self::UnknownOutcome,
            Self::DamagedAsset,
            Self::Fault,
            Self::TooMany,
            Self::TooLarge,
            Self::KeepsChanging,
            Self::Busy,
            Self::Draining,
        ];
        of_the_moment.contains(&self)
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<&LightError> for ErrorCode {
    fn from(error: &LightError) -> Self {
        if matches!(error, LightError::TooLong { .. }) { Self::TooMany } else { Self::InvalidLight }
    }
}

impl From<&EditError> for ErrorCode {
    fn from(error: &EditError) -> Self {
        match error {
            EditError::NoLight(_)
            | EditError::NoCamera(_)
            | EditError::NoPoint { .. }
            | EditError::UnknownName { .. }
            | EditError::NoPin(_) => Self::NotFound,
            EditError::AmbiguousName { .. } => Self::Ambiguous,
            EditError::WrongKind { .. } | EditError::NoPointParameter(_) => Self::WrongKind,
            EditError::Source => Self::Source,
            EditError::DragRefused { .. }
            | EditError::PinDoesNotHold { .. }
            | EditError::InvalidPin
            | EditError::EmptyViewport => Self::Drag,
            EditError::DragNotSolved(_) => Self::Fault,
            EditError::InvalidLight { reason, .. } => reason.into(),
            EditError::Undrawable(_) => Self::InvalidLight,
            EditError::InvalidCamera(_) => Self::InvalidCamera,
            EditError::UnknownAsset(_) => Self::UnknownAsset,
            EditError::TooMany { .. } | EditError::TooManyChosen { .. } | EditError::TooLong { .. } => {
                Self::TooMany
            }
            EditError::Conflict(_) => Self::Conflict,
        }
    }
}

impl From<&EditRefusal> for ErrorCode {
    fn from(refusal: &EditRefusal) -> Self {
        match refusal {
            EditRefusal::Edit(error) => error.into(),
            EditRefusal::InGroup { reason, .. } => (&**reason).into(),
            EditRefusal::Locked { .. } => Self::Locked,
            EditRefusal::Stale { .. } => Self::Stale,
            EditRefusal::NothingToUndo { .. } => Self::NothingToUndo,
            EditRefusal::NothingToRedo { .. } => Self::NothingToRedo,
            EditRefusal::MissingRecord(_) => Self::Storage,
            EditRefusal::NoGesture(_) => Self::NoGesture,
            EditRefusal::EmptyGesture(_) => Self::EmptyGesture,
            EditRefusal::GestureExists(_) => Self::Exists,
            EditRefusal::OtherLight(_) => Self::OtherLight,
            EditRefusal::TooMany { .. } => Self::TooMany,
        }
    }
}
