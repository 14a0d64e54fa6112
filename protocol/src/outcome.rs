//! What became of a request and of a drag: one of several things. In JSON these are fields that are there or not.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Change, DragOutcome, ErrorCode, Problem};

/// The answer to a request that ends in a record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(into = "EditResultJson", try_from = "EditResultJson")]
pub struct EditResult {
    /// The sender's name for it.
    pub op_id: String,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of a request that ends in a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is in the log.
    Committed {
        /// Its record.
        seq: u64,
        /// Whether another's change of the same light, which the sender did not know, lies between.
        rebased: bool,
        /// What undo or redo left as it was, a sentence each.
        skipped: Vec<String>,
    },
    /// It was not carried out, and why.
    Rejected(Problem),
    /// The disk failed while it was written down: it may be in the log or not. Sent again under the same name it is
    /// carried out at most once.
    Unknown(Problem),
}

impl Outcome {
    /// Its record, where it was committed.
    pub fn seq(&self) -> Option<u64> {
        match self {
            Self::Committed { seq, .. } => Some(*seq),
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
            Self::Committed { .. } => None,
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

fn parts(problem: Option<Problem>) -> (Option<ErrorCode>, Option<String>) {
    problem.map(|problem| (problem.code, problem.message)).unzip()
}

impl From<EditResult> for EditResultJson {
    fn from(EditResult { op_id, outcome }: EditResult) -> Self {
        let (status, seq, skipped, problem) = match outcome {
            Outcome::Committed { seq, rebased: false, skipped } => {
                (EditStatus::Committed, Some(seq), skipped, None)
            }
            Outcome::Committed { seq, rebased: true, skipped } => {
                (EditStatus::Rebased, Some(seq), skipped, None)
            }
            Outcome::Rejected(problem) => (EditStatus::Rejected, None, Vec::new(), Some(problem)),
            Outcome::Unknown(problem) => (EditStatus::Unknown, None, Vec::new(), Some(problem)),
        };
        let (code, message) = parts(problem);
        Self { op_id, status, seq, skipped, code, message }
    }
}

impl TryFrom<EditResultJson> for EditResult {
    type Error = &'static str;

    fn try_from(json: EditResultJson) -> Result<Self, &'static str> {
        let EditResultJson { op_id, status, seq, skipped, code, message } = json;
        let problem = problem(code, message)?;
        let outcome = match (status, seq, problem) {
            (EditStatus::Committed | EditStatus::Rebased, Some(seq), None) => {
                Outcome::Committed { seq, rebased: status == EditStatus::Rebased, skipped }
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
        let (code, message) = parts(problem);
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

    /// The text, to the last byte, is that of the version before outcomes were one of several things.
    #[test]
    fn results_are_the_fields_that_they_always_were() {
        for text in [
            r#"{"opId":"a","status":"committed","seq":7}"#,
            r#"{"opId":"a","status":"rebased","seq":7,"skipped":["it stays"]}"#,
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
