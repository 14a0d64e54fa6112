//! Outcomes of requests and of drags.
//!
//! Each outcome is an enum here, and an object with optional fields in JSON.

use schemars::JsonSchema;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::{Change, DragOutcome, ErrorCode, Problem};

/// Answer to a request that ends in a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(into = "EditResultJson", try_from = "EditResultJson")]
pub struct EditResult {
    /// Operation id, chosen by the sender.
    pub op_id: String,
    pub outcome: Outcome,
}

/// Outcome of a request that ends in a record.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The record is in the log.
    Committed(Committed),
    /// The request was not executed.
    Rejected(Problem),
    /// The disk failed during the write, so the record may or may not be in the log. Sent again with the same
    /// operation id, the request is executed at most once.
    Unknown(Problem),
}

/// Result of a committed request, for its sender.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Committed {
    /// Sequence number of the record.
    pub seq: u64,
    /// True if another actor changed the same light in between, which the sender did not know.
    pub rebased: bool,
    /// Parts that undo or redo left unchanged, one sentence each.
    pub skipped: Vec<String>,
    /// Ids of new objects.
    pub added: Added,
    /// Outcome, if the command drags a feature.
    pub outcome: Option<Box<DragOutcome>>,
    /// Outcome of each command of a group; empty if none drags a feature.
    pub outcomes: Vec<Option<DragOutcome>>,
}

/// Ids of new objects in the document: those that a command adds, and those that come with a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Added {
    /// Ids of lights.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<u64>,
    /// Ids of cameras.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<u64>,
    /// Ids of pins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<u64>,
}

impl From<&edit::Record> for Committed {
    fn from(record: &edit::Record) -> Self {
        let action = &record.action;
        let commands = action.commands();
        let mut added = Added::default();
        // An object that an undo or redo restores has its old id.
        for change in record.changes.iter().filter(|_| !commands.is_empty()) {
            match change {
                document::Change::Light { light, old: None, new: Some(_) } => added.lights.push(light.0),
                document::Change::Camera { camera, old: None, new: Some(_) } => added.cameras.push(camera.0),
                document::Change::Pin { pin, old: None, new: Some(_) } => added.pins.push(pin.0),
                _ => {}
            }
        }
        let mut outcomes = commands.into_iter().map(|(_, outcome)| outcome.map(DragOutcome::from));
        let (outcome, outcomes) = match action {
            edit::Action::Group { .. } => (None, keep_if_any_drag(outcomes.collect())),
            _ => (outcomes.next().flatten().map(Box::new), Vec::new()),
        };
        let (rebased, skipped) = (action.rebased(), action.skipped().to_vec());
        Self { seq: record.seq, rebased, skipped, added, outcome, outcomes }
    }
}

impl Committed {
    /// Reads the result from a record's line without resolving its references (SPEC, REC-6). Returns `None` if
    /// one of the needed values is itself a reference.
    pub fn in_line(line: &str) -> Option<Self> {
        let LineAction { seq, action } = serde_json::from_str(line).ok()?;
        let ActionInLine { kind, rebased, skipped, outcome, edits } = action;
        let mut added = Added::default();
        if matches!(kind, ActionKind::Edit | ActionKind::Gesture | ActionKind::Group) {
            let LineChanges { changes } = serde_json::from_str(line).ok()?;
            for change in changes.iter().filter(|change| change.old.is_none() && change.new.is_some()) {
                added.lights.extend(change.light);
                added.cameras.extend(change.camera);
                added.pins.extend(change.pin);
            }
        }
        let outcomes = keep_if_any_drag(edits.into_iter().map(|edit| edit.outcome).collect());
        Some(Self { seq, rebased, skipped, added, outcome, outcomes })
    }
}

/// Returns the outcomes, or an empty list if no command of the group drags a feature.
fn keep_if_any_drag(outcomes: Vec<Option<DragOutcome>>) -> Vec<Option<DragOutcome>> {
    if outcomes.iter().any(Option::is_some) { outcomes } else { Vec::new() }
}

/// Fields of a record's line from which the sender's result follows, except for the ids of new objects.
#[derive(Deserialize)]
struct LineAction {
    seq: u64,
    action: ActionInLine,
}

#[derive(Deserialize)]
struct ActionInLine {
    // Required, because a reference has no such field.
    #[serde(rename = "type")]
    kind: ActionKind,
    #[serde(default)]
    rebased: bool,
    #[serde(default)]
    skipped: Vec<String>,
    #[serde(default)]
    outcome: Option<Box<DragOutcome>>,
    #[serde(default)]
    edits: Vec<CommandInLine>,
}

#[derive(Deserialize)]
struct CommandInLine {
    // Required, because a reference has no such field.
    #[serde(rename = "command")]
    _command: IgnoredAny,
    #[serde(default)]
    outcome: Option<DragOutcome>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
enum ActionKind {
    Edit,
    Gesture,
    Group,
    Undo,
    Redo,
}

/// Fields of a record's line from which the ids of new objects follow.
#[derive(Deserialize)]
struct LineChanges {
    changes: Vec<ChangeInLine>,
}

/// Object that a change is about, and the presence of an old and of a new value. The values themselves are not kept.
#[derive(Deserialize)]
struct ChangeInLine {
    // Required, because a reference has no such field.
    #[serde(rename = "type")]
    _type: IgnoredAny,
    light: Option<u64>,
    camera: Option<u64>,
    pin: Option<u64>,
    old: Option<IgnoredAny>,
    new: Option<IgnoredAny>,
}

impl Outcome {
    /// Returns the sequence number of the record, if it was committed.
    pub fn seq(&self) -> Option<u64> {
        match self {
            Self::Committed(committed) => Some(committed.seq),
            Self::Rejected(_) | Self::Unknown(_) => None,
        }
    }

    /// Returns the code for programs, if the request was not committed.
    pub fn code(&self) -> Option<ErrorCode> {
        self.problem().map(|problem| problem.code)
    }

    /// Returns the error, if the request was not committed.
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Committed(_) => None,
            Self::Rejected(problem) | Self::Unknown(problem) => Some(problem),
        }
    }
}

/// State of a drag, for all clients.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(into = "GestureStateJson", try_from = "GestureStateJson")]
pub struct GestureState {
    /// Name of the gesture, chosen by its holder.
    pub gesture: String,
    /// Number of the client that holds the gesture.
    pub client: u64,
    /// Id of the dragged light.
    pub light: u64,
    /// Number of the latest update, accepted or refused. `changes` come from the latest accepted one.
    pub update: u64,
    /// Number of gesture changes in the session. Frames carry it.
    pub live_revision: u32,
    /// Changes of the document by the drag.
    pub changes: Vec<Change>,
    /// Outcome so far, if the drag moves a feature.
    pub outcome: Option<Box<DragOutcome>>,
    pub status: GestureStatus,
}

/// Status of a drag: in progress, or the way in which it ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GestureStatus {
    /// The drag is in progress.
    Held {
        /// Reason that the update was refused. Only the holder receives it.
        refused: Option<Problem>,
    },
    /// The drag ended as a record.
    Committed,
    /// The holder cancelled the drag, or its connection ended.
    Cancelled {
        /// Reason that the commit was refused: the drag never had a valid update.
        refused: Option<Problem>,
    },
    /// The drag had no update for too long.
    Expired,
    /// The begin or the commit was refused.
    Rejected(Problem),
}

impl GestureStatus {
    /// Returns the reason that an update, the begin or the commit was refused.
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Held { refused } | Self::Cancelled { refused } => refused.as_ref(),
            Self::Rejected(problem) => Some(problem),
            Self::Committed | Self::Expired => None,
        }
    }
}

/// [`EditResult`] in JSON.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct EditResultJson {
    /// Operation id, chosen by the sender.
    op_id: String,
    /// Status of the request.
    status: EditStatus,
    /// Sequence number of the record, if it was committed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seq: Option<u64>,
    /// Parts that undo or redo left unchanged, one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    skipped: Vec<String>,
    /// Ids of new objects in the document, if there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    added: Option<Added>,
    /// Outcome, if the command drags a feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    outcome: Option<Box<DragOutcome>>,
    /// Outcome of each edit of an atomic request, `null` for one that drags no feature. Left out if none does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    outcomes: Vec<Option<DragOutcome>>,
    /// Code for programs, if the request was rejected or its outcome is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    code: Option<ErrorCode>,
    /// Message for people, if the request was rejected or its outcome is unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    message: Option<String>,
}

/// Status of a request.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
enum EditStatus {
    /// The record is in the log.
    Committed,
    /// The record is in the log. Another actor changed the same light in between, which the sender did not
    /// know.
    Rebased,
    /// The request was not executed, and will not be under this operation id.
    Rejected,
    /// The disk failed during the write, so the record may or may not be in the log. Sent again with the same
    /// operation id, the request is executed at most once.
    Unknown,
}

/// [`GestureState`] in JSON.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct GestureStateJson {
    /// Name of the gesture, chosen by its holder.
    gesture: String,
    /// Number of the client that holds the gesture.
    client: u64,
    /// Id of the dragged light.
    light: u64,
    /// Number of the latest update, accepted or refused. `changes` come from the latest accepted one.
    update: u64,
    /// Number of gesture changes in the session. Frames carry it.
    live_revision: u32,
    /// Changes of the document by the drag.
    changes: Vec<Change>,
    /// Outcome so far, if the drag moves a feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    outcome: Option<Box<DragOutcome>>,
    /// End of the drag; left out while it is in progress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ended: Option<GestureEnd>,
    /// Code for programs, if an update or a commit was refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    code: Option<ErrorCode>,
    /// Message for people, if an update or a commit was refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    message: Option<String>,
}

/// End of a drag.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
enum GestureEnd {
    /// The drag ended as a record.
    Committed,
    /// The holder cancelled the drag, or its connection ended.
    Cancelled,
    /// The drag had no update for too long.
    Expired,
    /// The begin or the commit was refused.
    Rejected,
}

/// Error of a refusal without a code or without a message.
const NO_PROBLEM: &str = "what was refused has both a `code` and a `message`";

/// Returns the problem if both parts are present, `None` if both are absent, and else an error.
fn problem(code: Option<ErrorCode>, message: Option<String>) -> Result<Option<Problem>, &'static str> {
    match (code, message) {
        (Some(code), Some(message)) => Ok(Some(Problem { code, message })),
        (None, None) => Ok(None),
        _ => Err(NO_PROBLEM),
    }
}

fn code_and_message(problem: Option<Problem>) -> (Option<ErrorCode>, Option<String>) {
    problem.map(|problem| (problem.code, problem.message)).unzip()
}

impl From<EditResult> for EditResultJson {
    fn from(EditResult { op_id, outcome }: EditResult) -> Self {
        let (status, committed, problem) = match outcome {
            Outcome::Committed(committed) if committed.rebased => (EditStatus::Rebased, committed, None),
            Outcome::Committed(committed) => (EditStatus::Committed, committed, None),
            Outcome::Rejected(problem) => (EditStatus::Rejected, Committed::default(), Some(problem)),
            Outcome::Unknown(problem) => (EditStatus::Unknown, Committed::default(), Some(problem)),
        };
        let Committed { seq, skipped, added, outcome, outcomes, rebased: _ } = committed;
        let seq = problem.is_none().then_some(seq);
        let added = (added != Added::default()).then_some(added);
        let (code, message) = code_and_message(problem);
        Self { op_id, status, seq, skipped, added, outcome, outcomes, code, message }
    }
}

impl TryFrom<EditResultJson> for EditResult {
    type Error = &'static str;

    fn try_from(json: EditResultJson) -> Result<Self, &'static str> {
        let EditResultJson { op_id, status, seq, skipped, added, outcome, outcomes, code, message } = json;
        let problem = problem(code, message)?;
        let outcome = match (status, seq, problem) {
            (EditStatus::Committed | EditStatus::Rebased, Some(seq), None) => {
                let (rebased, added) = (status == EditStatus::Rebased, added.unwrap_or_default());
                Outcome::Committed(Committed { seq, rebased, skipped, added, outcome, outcomes })
            }
            (EditStatus::Committed | EditStatus::Rebased, ..) => {
                return Err("what was committed has a `seq` and neither `code` nor `message`");
            }
            (EditStatus::Rejected, None, Some(problem)) => Outcome::Rejected(problem),
            (EditStatus::Unknown, None, Some(problem)) => Outcome::Unknown(problem),
            (_, Some(_), _) => return Err("what was not committed has no `seq`"),
            (_, None, None) => return Err(NO_PROBLEM),
        };
        Ok(Self { op_id, outcome })
    }
}

impl From<GestureState> for GestureStateJson {
    fn from(state: GestureState) -> Self {
        let GestureState { gesture, client, light, update, live_revision, changes, outcome, status } = state;
        let (ended, problem) = match status {
            GestureStatus::Held { refused } => (None, refused),
            GestureStatus::Committed => (Some(GestureEnd::Committed), None),
            GestureStatus::Cancelled { refused } => (Some(GestureEnd::Cancelled), refused),
            GestureStatus::Expired => (Some(GestureEnd::Expired), None),
            GestureStatus::Rejected(problem) => (Some(GestureEnd::Rejected), Some(problem)),
        };
        let (code, message) = code_and_message(problem);
        Self { gesture, client, light, update, live_revision, changes, outcome, ended, code, message }
    }
}

impl TryFrom<GestureStateJson> for GestureState {
    type Error = &'static str;

    fn try_from(json: GestureStateJson) -> Result<Self, &'static str> {
        let GestureStateJson { gesture, client, light, update, live_revision, changes, outcome, .. } = json;
        let refused = problem(json.code, json.message)?;
        let status = match (json.ended, refused) {
            (None, refused) => GestureStatus::Held { refused },
            (Some(GestureEnd::Cancelled), refused) => GestureStatus::Cancelled { refused },
            (Some(GestureEnd::Committed), None) => GestureStatus::Committed,
            (Some(GestureEnd::Expired), None) => GestureStatus::Expired,
            (Some(GestureEnd::Committed | GestureEnd::Expired), Some(_)) => {
                return Err("a gesture that was committed or has expired was not refused");
            }
            (Some(GestureEnd::Rejected), Some(problem)) => GestureStatus::Rejected(problem),
            (Some(GestureEnd::Rejected), None) => return Err(NO_PROBLEM),
        };
        Ok(Self { gesture, client, light, update, live_revision, changes, outcome, status })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, from_value, json, to_string};

    use super::*;

    fn read<T: serde::de::DeserializeOwned>(fields: &[(&str, Value)]) -> Result<T, String> {
        let object = fields.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        from_value(Value::Object(object)).map_err(|error| error.to_string())
    }

    /// The line of a record gives the result without resolving its references.
    #[test]
    fn a_record_line_gives_the_result() {
        let line = |action: &str, changes: &str| {
            let who = r#""timeMs":0,"actor":{"id":"a","name":"A"},"opId":"x""#;
            let text = format!(r#"{{"format":6,"seq":7,{who},"action":{action},"changes":{changes}}}"#);
            Committed::in_line(&text)
        };
        let held = r#"{"sameAs":{"record":1,"at":2,"hash":"0"}}"#;
        let edit = format!(r#"{{"type":"edit","rebased":true,"command":{held}}}"#);
        let changes = format!(
            r#"[{{"type":"light","light":3,"old":null,"new":{held}}},{{"type":"light","light":2,"old":{held},"new":null}},
            {{"type":"camera","camera":4,"old":null,"new":{held}}},{{"type":"pin","pin":5,"old":null,"new":{held}}},
            {{"type":"pin","pin":6,"old":{held},"new":{held}}},{{"type":"scene","old":null,"new":{held}}},
            {{"type":"lightParameter","light":3,"old":{held},"new":{held}}}]"#
        );
        let added = Added { lights: vec![3], cameras: vec![4], pins: vec![5] };
        let edited = Committed { seq: 7, rebased: true, added, ..Committed::default() };
        assert_eq!(line(&edit, &changes), Some(edited));
        assert_eq!(line(&edit, held), None);
        assert_eq!(line(&edit, &format!("[{held}]")), None);
        assert_eq!(line(held, "[]"), None);
        let group = |edits: &str| line(&format!(r#"{{"type":"group","edits":{edits}}}"#), &changes);
        let grouped = group(&format!(r#"[{{"command":{held}}},{{"command":{{}}}}]"#)).expect("told");
        assert_eq!((grouped.added.lights, grouped.outcomes), (vec![3], vec![]));
        assert_eq!(group(held), None);
        assert_eq!(group(&format!("[{held}]")), None);
        // An object that an undo restores has its old id.
        let undo = r#"{"type":"undo","scope":"mine","target":1,"skipped":["it stays"]}"#;
        let undone = Committed { seq: 7, skipped: vec!["it stays".into()], ..Committed::default() };
        assert_eq!(line(undo, held), Some(undone));
    }

    /// The text equals, byte for byte, that of the version before outcomes became enums.
    #[test]
    fn results_are_the_fields_that_they_always_were() {
        for text in [
            r#"{"opId":"a","status":"committed","seq":7}"#,
            r#"{"opId":"a","status":"rebased","seq":7,"skipped":["it stays"]}"#,
            r#"{"opId":"a","status":"committed","seq":7,"added":{"lights":[3],"pins":[1,2]}}"#,
            r#"{"opId":"a","status":"rejected","code":"locked","message":"Ada holds it"}"#,
            r#"{"opId":"a","status":"unknown","code":"unknownOutcome","message":"look"}"#,
        ] {
            let result: EditResult = serde_json::from_str(text).expect(text);
            assert_eq!(to_string(&result).expect("JSON"), text);
        }
        let states = [
            "",
            r#","code":"invalidLight","message":"it folds""#,
            r#","ended":"committed""#,
            r#","ended":"cancelled""#,
            r#","ended":"cancelled","code":"invalidLight","message":"it folds""#,
            r#","ended":"expired""#,
            r#","ended":"rejected","code":"storage","message":"the disk""#,
        ];
        for end in states {
            let text =
                format!(r#"{{"gesture":"g","client":1,"light":2,"update":3,"liveRevision":4,"changes":[]{end}}}"#);
            let state: GestureState = serde_json::from_str(&text).expect(&text);
            assert_eq!(to_string(&state).expect("JSON"), text);
        }
    }

    #[test]
    fn contradictory_results_are_refused() {
        let status = |status| ("status", json!(status));
        let (op, seq, code) = (("opId", json!("a")), ("seq", json!(7)), ("code", json!("locked")));
        let message = ("message", json!("Ada holds it"));
        for fields in [
            vec![status("committed")],
            vec![status("committed"), seq.clone(), code.clone(), message.clone()],
            vec![status("rejected")],
            vec![status("rejected"), code.clone()],
            vec![status("unknown"), seq, code, message],
        ] {
            let fields = [std::slice::from_ref(&op), &fields].concat();
            read::<EditResult>(&fields).expect_err(&format!("{fields:?}"));
        }
    }
}
