//! What became of a request and of a drag: one of several things. In JSON these are fields that are there or not.

use schemars::JsonSchema;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::{Change, DragOutcome, ErrorCode, Problem};

/// The answer to a request that ends in a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(into = "EditResultJson", try_from = "EditResultJson")]
pub struct EditResult {
    /// The sender's name for it.
    pub op_id: String,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of a request that ends in a record.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It is in the log.
    Committed(Committed),
    /// It was not carried out, and why.
    Rejected(Problem),
    /// The disk failed while it was written down: it may be in the log or not. Sent again under the same name it is
    /// carried out at most once.
    Unknown(Problem),
}

/// What the sender of a record is told of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Committed {
    /// Sequence of the record that it became.
    pub seq: u64,
    /// Whether another's change of the same light, which the sender did not know, lies between.
    pub rebased: bool,
    /// What undo or redo left as it was, a sentence each.
    pub skipped: Vec<String>,
    /// What came into the document.
    pub added: Added,
    /// How it ended where it drags a feature.
    pub outcome: Option<Box<DragOutcome>>,
    /// The same of each command of a group, where one of them drags a feature.
    pub outcomes: Vec<Option<DragOutcome>>,
}

/// Ids of what a command brought into the document: what it adds, and what a scene comes with.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Added {
    /// Of lights.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<u64>,
    /// Of cameras.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<u64>,
    /// Of pins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pins: Vec<u64>,
}

impl From<&edit::Record> for Committed {
    fn from(record: &edit::Record) -> Self {
        let action = &record.action;
        let (mut added, mut dragged, mut outcomes) = (Added::default(), None, Vec::new());
        let commands = action.commands();
        if !commands.is_empty() {
            for change in &record.changes {
                match change {
                    document::Change::Light { light, old: None, new: Some(_) } => added.lights.push(light.0),
                    document::Change::Camera { camera, old: None, new: Some(_) } => {
                        added.cameras.push(camera.0);
                    }
                    document::Change::Pin { pin, old: None, new: Some(_) } => added.pins.push(pin.0),
                    _ => {}
                }
            }
            let ended: Vec<Option<DragOutcome>> =
                commands.into_iter().map(|(_, outcome)| outcome.map(Into::into)).collect();
            if matches!(action, edit::Action::Group { .. }) {
                outcomes = keep_if_any_drag(ended);
            } else {
                dragged = ended.into_iter().next().flatten().map(Box::new);
            }
        }
        let (rebased, skipped) = (action.rebased(), action.skipped().to_vec());
        Self { seq: record.seq, rebased, skipped, added, outcome: dragged, outcomes }
    }
}

impl Committed {
    /// What a record's line says by itself, whatever its long values refer to (SPEC, REC-6). `None` where it refers for one of
    /// these too.
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

/// How the commands of a group ended, or nothing where none drags a feature.
fn keep_if_any_drag(outcomes: Vec<Option<DragOutcome>>) -> Vec<Option<DragOutcome>> {
    if outcomes.iter().any(Option::is_some) { outcomes } else { Vec::new() }
}

/// Of a record's line what its sender is told, but for ids.
#[derive(Deserialize)]
struct LineAction {
    seq: u64,
    action: ActionInLine,
}

#[derive(Deserialize)]
struct ActionInLine {
    // A reference has none.
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
    // A reference has none.
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

/// Of a record's line its changes.
#[derive(Deserialize)]
struct LineChanges {
    changes: Vec<ChangeInLine>,
}

/// A change, by what it is of and whether that was and is there: none of it is kept.
#[derive(Deserialize)]
struct ChangeInLine {
    // A reference has none.
    #[serde(rename = "type")]
    _type: IgnoredAny,
    light: Option<u64>,
    camera: Option<u64>,
    pin: Option<u64>,
    old: Option<IgnoredAny>,
    new: Option<IgnoredAny>,
}

impl Outcome {
    /// Its record, where it was committed.
    pub fn seq(&self) -> Option<u64> {
        match self {
            Self::Committed(committed) => Some(committed.seq),
            Self::Rejected(_) | Self::Unknown(_) => None,
        }
    }

    /// Why it was not committed, for programs.
    pub fn code(&self) -> Option<ErrorCode> {
        self.problem().map(|problem| problem.code)
    }

    /// What is wrong, where it was not committed.
    pub fn problem(&self) -> Option<&Problem> {
        match self {
            Self::Committed(_) => None,
            Self::Rejected(problem) | Self::Unknown(problem) => Some(problem),
        }
    }
}

/// A drag as all clients see it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(into = "GestureStateJson", try_from = "GestureStateJson")]
pub struct GestureState {
    /// Its holder's name for it.
    pub gesture: String,
    /// Its holder.
    pub client: u64,
    /// The light it is on.
    pub light: u64,
    /// The latest update, taken or refused; `changes` are of the latest that was taken.
    pub update: u64,
    /// The session's count of gesture changes; frames carry it.
    pub live_revision: u32,
    /// What it changes in the document now.
    pub changes: Vec<Change>,
    /// How it stands where it drags a feature.
    pub outcome: Option<Box<DragOutcome>>,
    /// Whether it goes on, and how it ended where it does not.
    pub status: GestureStatus,
}

/// Whether a drag goes on, and how it ended where it does not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GestureStatus {
    /// It goes on.
    Held {
        /// Why the update was not taken. Its holder alone is told.
        refused: Option<Problem>,
    },
    /// It ended as a record.
    Committed,
    /// It was ended by its holder, or with the connection.
    Cancelled {
        /// Why its commit could not be: it never had a valid update.
        refused: Option<Problem>,
    },
    /// It was not updated for too long.
    Expired,
    /// Its begin or its commit was refused.
    Rejected(Problem),
}

impl GestureStatus {
    /// Why an update, the begin or the commit was refused.
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
    /// The sender's name for it.
    op_id: String,
    /// What became of it.
    status: EditStatus,
    /// Its record, where it was committed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seq: Option<u64>,
    /// What undo or redo left as it was, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    skipped: Vec<String>,
    /// Ids of what it brought into the document, where there is any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    added: Option<Added>,
    /// How it ended where it drags a feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    outcome: Option<Box<DragOutcome>>,
    /// The same of each edit of an atomic request, `null` of one that drags no feature; left out where none does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    outcomes: Vec<Option<DragOutcome>>,
    /// Why it was rejected or is unknown, for programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    code: Option<ErrorCode>,
    /// Why it was rejected or is unknown, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    message: Option<String>,
}

/// What became of a request.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
enum EditStatus {
    /// In the log.
    Committed,
    /// In the log, after another's change of the same light that the sender did not know.
    Rebased,
    /// Not carried out, however often it is sent again under this name.
    Rejected,
    /// The disk failed while it was written down: it may be in the log or not. Sent again under the same name it is
    /// carried out at most once.
    Unknown,
}

/// [`GestureState`] in JSON.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct GestureStateJson {
    /// Its holder's name for it.
    gesture: String,
    /// Its holder.
    client: u64,
    /// The light it is on.
    light: u64,
    /// The latest update, taken or refused; `changes` are of the latest that was taken.
    update: u64,
    /// The session's count of gesture changes; frames carry it.
    live_revision: u32,
    /// What it changes in the document now.
    changes: Vec<Change>,
    /// How it stands where it drags a feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    outcome: Option<Box<DragOutcome>>,
    /// How it ended; missing while it is under way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ended: Option<GestureEnd>,
    /// Why an update or a commit was refused, for programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    code: Option<ErrorCode>,
    /// Why an update or a commit was refused, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    message: Option<String>,
}

/// How a drag ended.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
enum GestureEnd {
    /// As a record.
    Committed,
    /// By its holder, or with the connection.
    Cancelled,
    /// Without an update for too long.
    Expired,
    /// The begin or the commit was refused.
    Rejected,
}

/// What a refusal lacks.
const NO_PROBLEM: &str = "what was refused has both a `code` and a `message`";

/// Both parts of a problem, or none.
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

    /// A line says by itself what its record as a whole does, though its values are references.
    #[test]
    fn what_is_told_of_a_record_is_in_its_line() {
        let line = |action: &str, changes: &str| {
            let who = r#""timeMs":0,"actor":{"id":"a","name":"A"},"opId":"x""#;
            let text = format!(r#"{{"format":5,"seq":7,{who},"action":{action},"changes":{changes}}}"#);
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
        // What comes back by an undo has the id that it had.
        let undo = r#"{"type":"undo","scope":"mine","target":1,"skipped":["it stays"]}"#;
        let undone = Committed { seq: 7, skipped: vec!["it stays".into()], ..Committed::default() };
        assert_eq!(line(undo, held), Some(undone));
    }

    /// The text, to the last byte, is that of the version before outcomes were one of several things.
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
            let text = format!(
                r#"{{"gesture":"g","client":1,"light":2,"update":3,"liveRevision":4,"changes":[]{end}}}"#
            );
            let state: GestureState = serde_json::from_str(&text).expect(&text);
            assert_eq!(to_string(&state).expect("JSON"), text);
        }
    }

    #[test]
    fn what_is_neither_one_nor_the_other_is_refused() {
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
