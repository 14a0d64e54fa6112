//! Control messages of the socket (SPEC, section 6).

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::error::from_json;
use crate::{
    Actor, Bounds, Camera, Command, Document, EditResult, ErrorCode, FileError, FrameStats, GestureState,
    ProbeAnswer, ProbeCamera, Record, Scope,
};

/// The version of the protocol that `hello` and `welcome` name.
pub const PROTOCOL: u32 = 1;

/// What a client sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum ClientMessage {
    /// The first message.
    Hello {
        /// [`PROTOCOL`].
        protocol: u32,
        /// The server's token.
        token: String,
        /// Name of the session.
        session: String,
        /// Who is here.
        actor: Actor,
        /// The history that the client knows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        epoch: Option<String>,
        /// The latest record that the client knows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        last_seq: Option<u64>,
    },
    /// Asks for frames; another one replaces the view before.
    OpenView {
        /// From where.
        source: ViewSource,
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// The client's number for its camera.
        camera_revision: u32,
        /// How the view is from the start; not of one that follows another.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        settings: Option<ViewSettings>,
        /// What of its pictures may be reduced while something moves, shadow maps unless it says otherwise; not of one that
        /// follows another.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        interaction: Option<Interaction>,
        /// Whether `stats` comes after each frame; of one that follows another too.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        stats: bool,
    },
    /// Moves one's own view; never logged.
    SetCamera {
        /// Where to.
        camera: Camera,
        /// The client's number for it.
        camera_revision: u32,
    },
    /// Sets how one's own view is; never logged.
    SetView {
        /// How, all of it.
        settings: ViewSettings,
        /// Whether `stats` comes after each frame from now on; left out, that stays as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stats: Option<bool>,
        /// The client's number for its camera, which is another although the camera stays: frames say by it which settings
        /// they show.
        camera_revision: u32,
    },
    /// The view has another size.
    Viewport {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
    },
    /// A frame has been decoded and shown.
    Ack {
        /// The number in its header.
        frame: u64,
    },
    /// A frame could not be decoded: the next one is a key frame.
    RequestKeyFrame {
        /// The number in its header.
        frame: u64,
    },
    /// One command.
    Edit {
        /// The client's name for it; see REC-4.
        op_id: String,
        /// The latest record that the client knew.
        base_seq: u64,
        /// What to change.
        command: Command,
    },
    /// Begins a drag.
    GestureBegin {
        /// The client's name for it.
        gesture: String,
        /// The light it is on.
        light: u64,
        /// The latest record that the client knew.
        base_seq: u64,
    },
    /// The latest state of a drag.
    GestureUpdate {
        /// The name that it was begun under.
        gesture: String,
        /// The client's number for this state.
        update: u64,
        /// The state.
        command: Command,
    },
    /// Ends a drag as one record.
    GestureCommit {
        /// The name that it was begun under.
        gesture: String,
        /// The client's name for the record.
        op_id: String,
    },
    /// Ends a drag without a trace.
    GestureCancel {
        /// The name that it was begun under.
        gesture: String,
    },
    /// Takes back a step.
    Undo {
        /// The client's name for it.
        op_id: String,
        /// One's own steps, or anybody's.
        scope: Scope,
    },
    /// Takes back an undo.
    Redo {
        /// The client's name for it.
        op_id: String,
        /// One's own steps, or anybody's.
        scope: Scope,
    },
    /// What this person is looking at.
    Presence {
        /// A light's id.
        selection: Option<u64>,
    },
    /// What undo and redo would take back; answered by `history`.
    History {},
    /// Why a pixel is lit or not; answered by `probed`, or by that of a later one.
    Probe {
        /// The client's name for it.
        probe: String,
        /// In pixels from the picture's top left corner; a pixel's centre is at .5.
        pixel: [f64; 2],
        /// Who looks; by default the client's own view, or the one that it follows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        camera: Option<ProbeCamera>,
        /// Width and height of the picture in pixels; by default those of that view.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        size: Option<[u32; 2]>,
        /// Whether it is asked where highlights lie.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        highlights: bool,
    },
    /// Answered by `pong`.
    Ping {
        /// Comes back as it is.
        sent: f64,
    },
}

/// Where a view looks from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ViewSource {
    /// A camera of one's own.
    Own(Camera),
    /// Another client's view, by the client's number.
    Follow(u64),
}

/// What is a viewer's own, besides the camera: it is in no document, and others see their own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ViewSettings {
    /// Stops by which the picture is brightened before it is tone-mapped, -32 to 32.
    pub exposure: f64,
    /// Ids of the lights that shine alone; empty for all. One that is not there counts for nothing, and where none is left
    /// all shine.
    pub solo: Vec<u64>,
}

/// What of a view's pictures may be reduced while something moves, where they would come too slowly in full. At rest
/// they are always full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Interaction {
    /// The texels of shadow maps: to half a side.
    pub shadow_map: Reduction,
    /// The pixels of pictures: to three quarters or half a side.
    pub resolution: Reduction,
}

/// Whether something may be reduced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Reduction {
    /// As far as what pictures take makes it necessary.
    Auto,
    /// Never: it stays full.
    Full,
}

impl Default for Interaction {
    fn default() -> Self {
        Self { shadow_map: Reduction::Auto, resolution: Reduction::Full }
    }
}

/// What the server sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum ServerMessage {
    /// The answer to `hello`.
    Welcome(Box<Welcome>),
    /// A committed record.
    Log {
        /// In full, without references.
        record: Box<Record>,
        /// The document's hash after it.
        hash: String,
        /// Of the scene, where the record loads one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bounds: Option<Bounds>,
        /// What of the scene's file is not drawn or was changed, a sentence each, where the record loads one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        notes: Option<Vec<String>>,
    },
    /// All that the session is, for a client that took its messages slower than they came.
    Resync(Box<Resync>),
    /// The answer to `edit`, `gestureCommit`, `undo` and `redo`.
    EditResult(EditResult),
    /// A drag, one's own or another's.
    GestureState(GestureState),
    /// Everybody who is here.
    Presence {
        /// In the order in which they came.
        clients: Vec<Presence>,
    },
    /// The answer to `history`.
    History(Box<History>),
    /// The answer to `probe`.
    Probed(Box<ProbeAnswer>),
    /// How the view is served from now on.
    ViewConfig {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
        /// From where.
        source: ViewSource,
    },
    /// What the frame before it came to, for a client that asked.
    Stats(Box<FrameStats>),
    /// The answer to `ping`.
    Pong {
        /// As it came.
        sent: f64,
        /// The server's clock, in microseconds since it started.
        server_time_us: u64,
    },
    /// What the list says of the session was changed.
    SessionChanged {
        /// What people call it.
        title: String,
        /// Whether it is archived.
        archived: bool,
    },
    /// The server stops.
    Draining {
        /// When to try again.
        retry_after_ms: u64,
    },
    /// Something that no other answer says.
    Error {
        /// For programs.
        code: ErrorCode,
        /// For people.
        message: String,
        /// Whether the connection ends.
        fatal: bool,
    },
}

/// The state of the session at a client's arrival.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Welcome {
    /// [`PROTOCOL`].
    pub protocol: u32,
    /// Name of the session.
    pub session: String,
    /// This client's number.
    pub client: u64,
    /// Names the history that `seq` counts in.
    pub epoch: String,
    /// The latest record.
    pub seq: u64,
    /// The document's hash after it.
    pub hash: String,
    /// How to get there.
    pub state: State,
    /// Of the scene.
    pub bounds: Bounds,
    /// What of the scene's file is not drawn or was changed, a sentence each.
    pub notes: Vec<String>,
    /// Where a new view may start.
    pub camera: Camera,
    /// Everybody who is here, this client included.
    pub clients: Vec<Presence>,
    /// The drags under way.
    pub gestures: Vec<GestureState>,
    /// Numbers that clients need.
    pub settings: Settings,
}

/// The state of the session for a client that has missed some of it: in place of all records, gestures and presence
/// since the latest that it was sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Resync {
    /// The latest record.
    pub seq: u64,
    /// The document's hash after it.
    pub hash: String,
    /// The document after it.
    pub document: Document,
    /// Of the scene.
    pub bounds: Bounds,
    /// What of the scene's file is not drawn or was changed, a sentence each.
    pub notes: Vec<String>,
    /// Everybody who is here, this client included.
    pub clients: Vec<Presence>,
    /// The drags under way.
    pub gestures: Vec<GestureState>,
}

/// The document, whole or from where the client stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum State {
    /// All of it.
    Snapshot(Document),
    /// The records after the client's `lastSeq`.
    Tail(Vec<Record>),
}

/// Numbers that clients need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Settings {
    /// Frames under way at most.
    pub ack_window: u32,
    /// How long a gesture is held without an update.
    pub lease_ms: u64,
    /// Largest width and height of a view.
    pub max_view_side: u32,
}

/// What undo and redo would take back.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct History {
    /// The latest record.
    pub seq: u64,
    /// By undo.
    pub undo: HistorySteps,
    /// By redo.
    pub redo: HistorySteps,
}

/// A step for each scope; `null` where there is nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct HistorySteps {
    /// Of one's own steps.
    pub mine: Option<HistoryStep>,
    /// Of everybody's.
    pub session: Option<HistoryStep>,
}

/// A step that can be taken back.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct HistoryStep {
    /// The record that is taken back: the step's, or of an undo.
    pub seq: u64,
    /// Who made the step, also where an undo of it is taken back.
    pub actor: Actor,
    /// What it did, for people: `the radius of control point 2 of “key”`.
    pub what: String,
    /// Why later steps stay, which are passed over for it, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passed: Vec<String>,
}

/// One client of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Presence {
    /// The number that the server gave it.
    pub client: u64,
    /// Who edits with it.
    pub actor: Actor,
    /// The light that is selected.
    pub selection: Option<u64>,
    /// The client whose view it follows.
    pub following: Option<u64>,
    /// Where its own view is; `null` without a view.
    pub camera: Option<Camera>,
    /// How its own view is; `null` without a view.
    pub settings: Option<ViewSettings>,
}

impl ClientMessage {
    /// Reads a text message.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        from_json(text)
    }
}

impl ServerMessage {
    /// Reads a text message.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        from_json(text)
    }
}

/// Reads the body of a request.
pub fn parse_body<T: DeserializeOwned>(text: &str) -> Result<T, FileError> {
    from_json(text)
}
