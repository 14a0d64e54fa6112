//! Control messages of the socket (SPEC, section 6).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    Actor, Bounds, Camera, Command, Document, EditResult, ErrorCode, FrameStats, GestureState, ProbeAnswer,
    ProbeCamera, Record, Scope,
};

/// Version of the protocol, as in `hello` and `welcome`.
pub const PROTOCOL: u32 = 1;

/// Message from a client.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum ClientMessage {
    /// Joins a session. It is the first message.
    Hello {
        /// Version of the protocol: [`PROTOCOL`].
        protocol: u32,
        /// Token of the server.
        token: String,
        /// Name of the session.
        session: String,
        /// Actor who uses the client.
        actor: Actor,
        /// Id of the history that the client knows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        epoch: Option<String>,
        /// Sequence number of the latest record that the client knows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        last_seq: Option<u64>,
    },
    /// Opens a view, for which the server sends frames. It replaces the client's earlier view.
    OpenView {
        source: ViewSource,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// Number that the client gives its camera.
        camera_revision: u32,
        /// Initial settings of an own view. A view that follows another has none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        settings: Option<ViewSettings>,
        /// Allowed reduction of the pictures while something moves, for an own view. Default: only the
        /// resolution of shadow maps may be reduced.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        interaction: Option<Interaction>,
        /// True if a `stats` message comes after each frame, also for a view that follows another.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        stats: bool,
    },
    /// Moves the camera of the client's own view. It is never logged.
    SetCamera {
        /// New camera.
        camera: Camera,
        /// Number that the client gives the camera.
        camera_revision: u32,
    },
    /// Changes the settings of the client's own view. It is never logged.
    SetView {
        /// All settings of the view.
        settings: ViewSettings,
        /// True if a `stats` message comes after each frame from now on. Default: no change.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stats: Option<bool>,
        /// New number of the camera, although the camera stays. Frames identify the settings that they show by
        /// it.
        camera_revision: u32,
    },
    /// Changes the size of the view.
    Viewport {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// Acknowledges a frame that the client decoded and showed.
    Ack {
        /// Frame number, as in the frame's header.
        frame: u64,
    },
    /// Reports a frame that the client could not decode. The next frame is a key frame.
    RequestKeyFrame {
        /// Frame number, as in the frame's header.
        frame: u64,
    },
    /// Executes one command.
    Edit {
        /// Operation id, chosen by the client (REC-4).
        op_id: String,
        /// Sequence number of the latest record that the client knew.
        base_seq: u64,
        command: Command,
    },
    /// Begins a drag (a gesture).
    GestureBegin {
        /// Name of the gesture, chosen by the client.
        gesture: String,
        /// Id of the dragged light.
        light: u64,
        /// Sequence number of the latest record that the client knew.
        base_seq: u64,
    },
    /// Replaces the state of a drag.
    GestureUpdate {
        /// Name of the gesture, as in `gestureBegin`.
        gesture: String,
        /// Number that the client gives this update.
        update: u64,
        /// Command with the latest state of the drag.
        command: Command,
    },
    /// Ends a drag and commits it as one record.
    GestureCommit {
        /// Name of the gesture, as in `gestureBegin`.
        gesture: String,
        /// Operation id of the record, chosen by the client.
        op_id: String,
    },
    /// Cancels a drag. The log does not change.
    GestureCancel {
        /// Name of the gesture, as in `gestureBegin`.
        gesture: String,
    },
    /// Undoes a step.
    Undo {
        /// Operation id, chosen by the client.
        op_id: String,
        /// Steps to choose from: the actor's own or all.
        scope: Scope,
    },
    /// Redoes a step that was undone.
    Redo {
        /// Operation id, chosen by the client.
        op_id: String,
        /// Undos to choose from: the actor's own or all.
        scope: Scope,
    },
    /// Publishes the light that the actor has selected.
    Presence {
        /// Id of the selected light; `null` for none.
        selection: Option<u64>,
    },
    /// Asks for the steps that undo and redo would take next. `history` is the answer.
    History {},
    /// Asks why a pixel is lit or not. `probed` is the answer. A probe that a later one supersedes gets no
    /// answer.
    Probe {
        /// Name of the probe, chosen by the client.
        probe: String,
        /// Position in pixels from the picture's top left corner. The centre of a pixel is at .5.
        pixel: [f64; 2],
        /// Camera of the picture. Default: the camera of the client's view, or of the view that it follows.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        camera: Option<ProbeCamera>,
        /// Width and height of the picture in pixels. Default: those of that view.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        size: Option<[u32; 2]>,
        /// True if the answer also has the positions of highlights.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        highlights: bool,
    },
    /// Asks for a `pong`.
    Ping {
        /// Number that the answer repeats.
        sent: f64,
    },
}

/// Camera of a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ViewSource {
    /// Camera of the client.
    Own(Camera),
    /// View of another client, by the client's number.
    Follow(u64),
}

/// Settings of a view besides its camera. They are not part of the document, and each viewer has settings of
/// its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ViewSettings {
    /// Stops by which the picture is brightened before tone-mapping, -32 to 32.
    pub exposure: f64,
    /// Ids of the only lights that shine; empty for all lights. Ids of lights that do not exist are ignored. If
    /// no id of an existing light remains, all lights shine.
    pub solo: Vec<u64>,
}

/// Allowed reduction of a view's pictures while something moves, if full pictures would take too long. At rest
/// the pictures are always full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Interaction {
    /// Texels of shadow maps: half as many a side.
    pub shadow_map: Reduction,
    /// Pixels of pictures: three quarters or half as many a side.
    pub resolution: Reduction,
}

/// Policy of a reduction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Reduction {
    /// Reduces as far as the render time requires.
    Auto,
    /// Never reduces.
    Full,
}

impl Default for Interaction {
    fn default() -> Self {
        Self { shadow_map: Reduction::Auto, resolution: Reduction::Full }
    }
}

/// Message from the server.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum ServerMessage {
    /// Answers `hello`.
    Welcome(Box<Welcome>),
    /// Announces a committed record.
    Log {
        /// Record in full, without references.
        record: Box<Record>,
        /// Hash of the document after the record.
        hash: String,
        /// Bounds of the scene, if the record loads one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bounds: Option<Bounds>,
        /// Notes on the scene's file, if the record loads one, one sentence each: content that is not drawn or
        /// was changed.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        notes: Option<Vec<String>>,
    },
    /// Sends the whole session state, to a client that read its messages too slowly.
    Resync(Box<Resync>),
    /// Answers `edit`, `gestureCommit`, `undo` and `redo`.
    EditResult(EditResult),
    /// Reports the state of a drag, by this client or another.
    GestureState(GestureState),
    /// Lists all clients of the session.
    Presence {
        /// Clients, in order of arrival.
        clients: Vec<Presence>,
    },
    /// Answers `history`.
    History(Box<History>),
    /// Answers `probe`.
    Probed(Box<ProbeAnswer>),
    /// Announces the configuration of the view from now on.
    ViewConfig {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        source: ViewSource,
    },
    /// Reports the statistics of the frame before, to a client that asked for them.
    Stats(Box<FrameStats>),
    /// Answers `ping`.
    Pong {
        /// Number from the `ping`.
        sent: f64,
        /// Time on the server's clock, in microseconds since the server started.
        server_time_us: u64,
    },
    /// Announces a changed title or archived state of the session.
    SessionChanged {
        /// Title for people.
        title: String,
        /// True if the session is archived.
        archived: bool,
    },
    /// Announces that the server stops.
    Draining {
        /// Milliseconds until the client should reconnect.
        retry_after_ms: u64,
    },
    /// Reports an error that no other message reports.
    Error {
        /// Code for programs.
        code: ErrorCode,
        /// Message for people.
        message: String,
        /// True if the server closes the connection.
        fatal: bool,
    },
}

/// State of the session for a client that joins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Welcome {
    /// Version of the protocol: [`PROTOCOL`].
    pub protocol: u32,
    /// Name of the session.
    pub session: String,
    /// Number of this client.
    pub client: u64,
    /// Id of the history that `seq` counts in.
    pub epoch: String,
    /// Sequence number of the latest record.
    pub seq: u64,
    /// Hash of the document after that record.
    pub hash: String,
    /// Document, or the records that lead to it.
    pub state: State,
    /// Bounds of the scene.
    pub bounds: Bounds,
    /// Notes on the scene's file, one sentence each: content that is not drawn or was changed.
    pub notes: Vec<String>,
    /// Camera from which a new view may start.
    pub camera: Camera,
    /// All clients of the session, including this one.
    pub clients: Vec<Presence>,
    /// Drags in progress.
    pub gestures: Vec<GestureState>,
    pub settings: Settings,
}

/// State of the session for a client that fell behind. It replaces all records, gestures and presence since the
/// last one that the client received.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Resync {
    /// Sequence number of the latest record.
    pub seq: u64,
    /// Hash of the document after that record.
    pub hash: String,
    /// Document after that record.
    pub document: Document,
    /// Bounds of the scene.
    pub bounds: Bounds,
    /// Notes on the scene's file, one sentence each: content that is not drawn or was changed.
    pub notes: Vec<String>,
    /// All clients of the session, including this one.
    pub clients: Vec<Presence>,
    /// Drags in progress.
    pub gestures: Vec<GestureState>,
}

/// Document of the session, in full or as the records that the client lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum State {
    /// Document in full.
    Snapshot(Document),
    /// Records after the client's `lastSeq`.
    Tail(Vec<Record>),
}

/// Constants of the server that clients need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Settings {
    /// Number of frames that may be unacknowledged.
    pub ack_window: u32,
    /// Milliseconds without an update after which a gesture expires.
    pub lease_ms: u64,
    /// Largest width and height of a view in pixels.
    pub max_view_side: u32,
}

/// Steps that undo and redo would take next.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct History {
    /// Sequence number of the latest record.
    pub seq: u64,
    /// Steps that undo would take back.
    pub undo: HistorySteps,
    /// Steps that redo would restore.
    pub redo: HistorySteps,
}

/// Next step of each scope; `null` if there is none.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct HistorySteps {
    /// Next of the actor's own steps.
    pub mine: Option<HistoryStep>,
    /// Next of all actors' steps.
    pub session: Option<HistoryStep>,
}

/// Step that undo or redo would take next.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct HistoryStep {
    /// Sequence number of the record to revert: the step for undo, the undo for redo.
    pub seq: u64,
    /// Actor who made the step, also for a redo.
    pub actor: Actor,
    /// Description of the step for people: `the radius of control point 2 of “key”`.
    pub what: String,
    /// Reasons why later steps are passed over, one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passed: Vec<String>,
}

/// Client of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Presence {
    /// Number that the server gave the client.
    pub client: u64,
    /// Actor who uses the client.
    pub actor: Actor,
    /// Id of the selected light.
    pub selection: Option<u64>,
    /// Number of the client whose view this one follows.
    pub following: Option<u64>,
    /// Camera of the client's own view; `null` without a view.
    pub camera: Option<Camera>,
    /// Settings of the client's own view; `null` without a view.
    pub settings: Option<ViewSettings>,
}
