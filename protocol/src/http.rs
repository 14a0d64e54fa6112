//! Bodies of the HTTP interface (SPEC, section 9).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Actor, Camera, Command, Document, EditResult, Problem, Scope, Vec3};

/// `POST /sessions`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct NewSession {
    /// 1 to 64 of `a-z A-Z 0-9 - _ .`, the first a letter or a digit.
    pub name: String,
    /// What people call it: 1 to 256 bytes of a line of text; its name by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Scene to load: `"demo:NAME"` or `"sha256:HEX"`; an empty document by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Who loads it; by default `{"id": "api", "name": "API"}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<Actor>,
}

/// `PATCH /sessions/S`. What is left out stays.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionChange {
    /// What people call it: 1 to 256 bytes of a line of text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// `true` archives it, `false` brings it back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub archived: Option<bool>,
}

/// `POST /sessions/S/duplicate`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Duplicate {
    /// The new session's name, as in [`NewSession`].
    pub name: String,
    /// What people call the new one; its name by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
}

/// An entry of `GET /sessions`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionEntry {
    /// What addresses and its log call it; it stays.
    pub name: String,
    /// What people call it, by default its name.
    pub title: String,
    /// Names the history that `seq` counts in. Both together name a picture of it.
    pub epoch: String,
    /// The latest record.
    pub seq: u64,
    /// How many clients are connected.
    pub clients: usize,
    /// What those who are connected are called, each person once, in the order in which they came.
    pub people: Vec<String>,
    /// It is left out of the list that does not ask for those, and can be deleted.
    pub archived: bool,
    /// When it was made on this server, in milliseconds since 1970; `null` where that is not known.
    pub made_ms: Option<u64>,
    /// Its latest record; `null` before the first.
    pub changed: Option<LastChange>,
}

/// The latest record of a session.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LastChange {
    /// When it was made, in milliseconds since 1970.
    pub time_ms: u64,
    /// What who made it is called.
    pub actor: String,
}

/// `GET /sessions`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionList {
    /// In the order of names.
    pub sessions: Vec<SessionEntry>,
}

/// `GET /scenes`: the scenes that come with the server.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DemoScenes {
    /// In the order in which they are offered.
    pub demos: Vec<DemoScene>,
}

/// One of [`DemoScenes`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DemoScene {
    /// What [`NewSession`] and `loadScene` take: `"demo:NAME"`.
    pub scene: String,
    /// For people.
    pub name: String,
    /// What is to be seen in it.
    pub shows: String,
}

/// `GET /sessions/S` and the answer to `POST /sessions`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionState {
    /// The session's name.
    pub name: String,
    /// Names the history that `seq` counts in.
    pub epoch: String,
    /// The latest record.
    pub seq: u64,
    /// The document's hash after it.
    pub hash: String,
    /// As it is after that record.
    pub document: Document,
    /// What of its scene's file is not drawn or was changed, a sentence each.
    pub notes: Vec<String>,
}

/// `GET /sessions/S/nodes`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SceneNodes {
    /// Paths of nodes, for links, in the order of the scene.
    pub paths: Vec<String>,
    /// How many more there are.
    pub left_out: usize,
}

/// `POST /sessions/S/edits`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Edits {
    /// Who; by default `{"id": "api", "name": "API"}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<Actor>,
    /// What to do, in order.
    pub edits: Vec<Edit>,
    /// Whether all of it is one step, done as a whole or not at all. Then each edit has a command and no `opId`, and none loads a
    /// scene.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub atomic: bool,
    /// The sender's name for such a step, as an edit has one otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub op_id: Option<String>,
}

/// One of [`Edits`]: exactly one of `command`, `undo` and `redo`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Edit {
    /// The sender's name for it, so that a repeated request does no harm; made up by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub op_id: Option<String>,
    /// The latest record that the sender knew; by default the latest there is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_seq: Option<u64>,
    /// A command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<Command>,
    /// Take back a step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undo: Option<Scope>,
    /// Take back an undo.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub redo: Option<Scope>,
}

/// The answer to [`Edits`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct EditResults {
    /// One an edit, in order; one of all where they are one step.
    pub results: Vec<EditResult>,
    /// The latest record.
    pub seq: u64,
    /// The document's hash after it.
    pub hash: String,
}

/// The body of `POST /sessions/S/pick`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Pick {
    /// Who looks; it need not be one of the document's.
    pub camera: Camera,
}

/// The answer to [`Pick`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Picked {
    /// The point of the scene in the middle of the camera's picture, in the world; `null` where there is none.
    pub point: Option<Vec3>,
}

/// The answer to `POST /assets`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Asset {
    /// `sha256:` and 64 hexadecimal digits.
    pub asset: String,
    /// What people call the scene, and documents that load it from now on.
    pub name: String,
    /// What of the file is not drawn or was changed, a sentence each.
    pub notes: Vec<String>,
}

/// Every refused request's answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ErrorBody {
    /// What is wrong.
    pub error: Problem,
}
