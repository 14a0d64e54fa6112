//! Error codes: one closed list with an HTTP status for each, and the pair of a code and its message.

use std::fmt;

use document::EditError;
use edit::EditRefusal;
use light::LightError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Defines the error codes, each with its name in JSON and its HTTP status.
macro_rules! codes {
    ($($(#[$meaning:meta])* $code:ident = $name:literal, $status:literal;)*) => {
        /// Reason of a refusal, for programs. The message beside it is for people.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
        pub enum ErrorCode {
            $($(#[$meaning])* #[serde(rename = $name)] $code,)*
        }

        impl ErrorCode {
            /// All codes.
            pub const ALL: &[Self] = &[$(Self::$code),*];

            /// Returns the name in JSON.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$code => $name,)*
                }
            }

            /// Returns the status of an HTTP response with this code. It is 400 for codes that only the socket
            /// and results of edits use.
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
    /// The scene's file cannot be imported.
    BadScene = "badScene", 400;
    /// The feature cannot be dragged from or to that point, or the pin cannot be added.
    Drag = "drag", 400;
    /// The log was changed, or its lines contradict one another.
    BadLog = "badLog", 400;
    /// The record has a format that this server does not know.
    Format = "format", 400;
    /// The picture cannot be rendered.
    Render = "render", 400;
    /// The light cannot be evaluated, or lies too far from the scene.
    InvalidLight = "invalidLight", 400;
    /// The camera makes no picture.
    InvalidCamera = "invalidCamera", 400;
    /// The light has no such parameter.
    WrongKind = "wrongKind", 400;
    /// The first control point is the source, which stays where it is.
    Source = "source", 400;
    /// The document does not hold the old value of the change.
    Conflict = "conflict", 400;
    /// Another actor is dragging the light.
    Locked = "locked", 400;
    /// The light's control points have been renumbered since.
    Stale = "stale", 400;
    /// There is no step to undo.
    NothingToUndo = "nothingToUndo", 400;
    /// There is no undo to redo.
    NothingToRedo = "nothingToRedo", 400;
    /// The light, its pins or the scene changed during each attempt to solve the drag.
    KeepsChanging = "keepsChanging", 400;
    /// The sender has no drag of that name.
    NoGesture = "noGesture", 400;
    /// The drag was committed without any update.
    EmptyGesture = "emptyGesture", 400;
    /// The command of the drag belongs to another light.
    OtherLight = "otherLight", 400;
    /// The protocol version differs, or the first message is not `hello`.
    Protocol = "protocol", 400;
    /// The client did not send `hello` in time.
    HelloTooLate = "helloTooLate", 400;
    /// The token is missing or wrong.
    Unauthorized = "unauthorized", 401;
    /// The `Origin` of the request may not use this server.
    ForeignOrigin = "foreignOrigin", 403;
    /// The server does not serve the host name of the request.
    ForeignHost = "foreignHost", 403;
    /// The object, session or address in the request does not exist.
    NotFound = "notFound", 404;
    /// The server does not have the scene.
    UnknownAsset = "unknownAsset", 404;
    /// The address does not accept this method. The header `Allow` lists those that it accepts.
    MethodNotAllowed = "methodNotAllowed", 405;
    /// The rest of the request did not arrive in time.
    Stalled = "stalled", 408;
    /// The name is already in use.
    Exists = "exists", 409;
    /// The session is not archived. Only an archived session can be deleted.
    NotArchived = "notArchived", 409;
    /// Clients are connected to the session.
    InUse = "inUse", 409;
    /// Several objects have that name. The message lists their ids.
    Ambiguous = "ambiguous", 409;
    /// A size exceeds its limit. The message names the limit.
    TooLarge = "tooLarge", 413;
    /// The `Content-Type` of the body is not JSON.
    UnsupportedMediaType = "unsupportedMediaType", 415;
    /// A count exceeds its limit. The message names the limit.
    TooMany = "tooMany", 429;
    /// The server's disk failed. Nothing was changed.
    Storage = "storage", 500;
    /// The server's disk failed. The operation may or may not have been committed.
    UnknownOutcome = "unknownOutcome", 500;
    /// The stored file of the scene is damaged.
    DamagedAsset = "damagedAsset", 500;
    /// The server has an internal fault.
    Fault = "fault", 500;
    /// Requests and answers fill the server's memory limit.
    Busy = "busy", 503;
    /// The renderer is not ready yet.
    WarmingUp = "warmingUp", 503;
    /// The renderer failed to start.
    NotReady = "notReady", 503;
    /// The server is stopping.
    Draining = "draining", 503;
}

/// Error of a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Problem {
    /// Code for programs.
    pub code: ErrorCode,
    /// Message for people: what is wrong, and what to do.
    pub message: String,
}

impl ErrorCode {
    /// Returns the code of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name() == name)
    }

    /// Returns true if a retry may succeed. Such a refusal is not stored as the result of the operation (SPEC,
    /// REC-4).
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
            | EditError::PinLimits { .. }
            | EditError::PinBreaks { .. }
            | EditError::InvalidPin
            | EditError::EmptyViewport => Self::Drag,
            EditError::NotSolved(_) => Self::Fault,
            EditError::InvalidLight { reason, .. } => reason.into(),
            EditError::Undrawable(_) => Self::InvalidLight,
            EditError::InvalidCamera(_) => Self::InvalidCamera,
            EditError::UnknownAsset(_) => Self::UnknownAsset,
            EditError::TooMany { .. } | EditError::TooManyChosen { .. } | EditError::TooLong { .. } => Self::TooMany,
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
