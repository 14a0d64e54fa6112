//! Bodies of the HTTP interface (SPEC, section 9).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Actor, Camera, Command, Document, EditResult, Problem, Scope, Vec3};

/// Body of `POST /sessions`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct NewSession {
    /// Name of 1 to 64 characters of `a-z A-Z 0-9 - _ .`, the first a letter or a digit.
    pub name: String,
    /// Title for people, one line of 1 to 256 bytes. Default: the name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Scene to load: `"demo:NAME"` or `"sha256:HEX"`. Default: an empty document.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Actor that loads the scene. Default: `{"id": "api", "name": "API"}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<Actor>,
}

/// Body of `PATCH /sessions/S`. Fields that are left out stay as they are.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionChange {
    /// Title for people, one line of 1 to 256 bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// `true` archives the session, `false` restores it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub archived: Option<bool>,
}

/// Body of `POST /sessions/S/duplicate`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Duplicate {
    /// Name of the new session, as in [`NewSession`].
    pub name: String,
    /// Title of the new session. Default: its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
}

/// Entry of `GET /sessions`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionEntry {
    /// Name in addresses and in the log. It never changes.
    pub name: String,
    /// Title for people. Default: the name.
    pub title: String,
    /// Id of the history that `seq` counts in. Epoch and `seq` together identify a state of the document.
    pub epoch: String,
    /// Sequence number of the latest record.
    pub seq: u64,
    /// Number of connected clients.
    pub clients: usize,
    /// Names of the connected actors, each actor once, in order of arrival.
    pub people: Vec<String>,
    /// True if the session is archived. `GET /sessions` leaves it out by default, and it can be deleted.
    pub archived: bool,
    /// Time of creation on this server, in milliseconds since 1970; `null` if unknown.
    pub made_ms: Option<u64>,
    /// Latest record; `null` before the first.
    pub changed: Option<LastChange>,
}

/// Latest record of a session.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LastChange {
    /// Time of the record, in milliseconds since 1970.
    pub time_ms: u64,
    /// Name of the actor.
    pub actor: String,
}

/// Answer to `GET /sessions`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionList {
    /// Sessions, sorted by name.
    pub sessions: Vec<SessionEntry>,
}

/// Answer to `GET /scenes`: the demo scenes of the server.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DemoScenes {
    /// Demo scenes, in the order of presentation.
    pub demos: Vec<DemoScene>,
}

/// Entry of [`DemoScenes`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DemoScene {
    /// Name as [`NewSession`] and `loadScene` take it: `"demo:NAME"`.
    pub scene: String,
    /// Name for people.
    pub name: String,
    /// Description of the scene's content.
    pub shows: String,
}

/// Answer to `GET /sessions/S` and `POST /sessions`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionState {
    /// Name of the session.
    pub name: String,
    /// Id of the history that `seq` counts in.
    pub epoch: String,
    /// Sequence number of the latest record.
    pub seq: u64,
    /// Hash of the document after that record.
    pub hash: String,
    /// Document after that record.
    pub document: Document,
    /// Notes on the scene's file, one sentence each: content that is not drawn or was changed.
    pub notes: Vec<String>,
}

/// Answer to `GET /sessions/S/nodes`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SceneNodes {
    /// Paths of nodes, for links, in the order of the scene.
    pub paths: Vec<String>,
    /// Number of further nodes that `paths` leaves out.
    pub left_out: usize,
}

/// Body of `POST /sessions/S/edits`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Edits {
    /// Actor of the edits. Default: `{"id": "api", "name": "API"}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<Actor>,
    /// Edits, in the order of execution.
    pub edits: Vec<Edit>,
    /// True if all edits are one step, which is committed as a whole or not at all. Then each edit has a
    /// command and no `opId`, and none loads a scene.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub atomic: bool,
    /// Operation id of the step if `atomic` is true. Otherwise each edit has an operation id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub op_id: Option<String>,
}

/// Edit of [`Edits`]: exactly one of `command`, `undo` and `redo`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Edit {
    /// Operation id, chosen by the sender. The server does not repeat an operation with the same id. Default: a
    /// random id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub op_id: Option<String>,
    /// Sequence number of the latest record that the sender knew. Default: the latest record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_seq: Option<u64>,
    /// Command to execute.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<Command>,
    /// Undoes the latest step of this scope.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undo: Option<Scope>,
    /// Redoes the latest undo of this scope.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub redo: Option<Scope>,
}

/// Answer to [`Edits`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct EditResults {
    /// Results, one for each edit in order, or one for the whole step if `atomic` is true.
    pub results: Vec<EditResult>,
    /// Sequence number of the latest record.
    pub seq: u64,
    /// Hash of the document after that record.
    pub hash: String,
}

/// Body of `POST /sessions/S/pick`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Pick {
    /// Camera of the picture. It need not belong to the document.
    pub camera: Camera,
}

/// Answer to [`Pick`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Picked {
    /// World position of the surface in the middle of the camera's picture; `null` if there is none.
    pub point: Option<Vec3>,
}

/// Answer to `POST /assets`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Asset {
    /// `sha256:` and 64 hexadecimal digits.
    pub asset: String,
    /// Name of the scene for people. Documents that load the scene from now on have it.
    pub name: String,
    /// Notes on the file, one sentence each: content that is not drawn or was changed.
    pub notes: Vec<String>,
}

/// Answer to every refused request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ErrorBody {
    pub error: Problem,
}
