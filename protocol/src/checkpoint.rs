//! A session in JSON, as the store keeps it, so that opening one does not replay all of its log.

use std::collections::BTreeMap;

use edit::{Session, SessionHistory};
use light::LightId;
use serde::{Deserialize, Serialize};

use crate::error::from_json;
use crate::{Document, FileError, Refused};

/// A session after one of its records. It holds what the records before it come to, so that replay can go on from it;
/// what it says is proven by the document's hash at that record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionCheckpoint {
    /// The record that it stands after.
    pub seq: u64,
    /// As it is after that record.
    pub document: Document,
    /// The largest number ever given out as an id or a layout.
    pub last_number: u64,
    /// Records of the steps in effect, in order, by who made them.
    pub steps: BTreeMap<String, Vec<u64>>,
    /// Undos that can be redone.
    pub undos: Vec<PastUndo>,
    /// The latest record of each actor on each light.
    pub touched: Vec<LightTouch>,
    /// The latest renumbering of each light's control points.
    pub renumbered: Vec<Renumbering>,
}

/// [`edit::PastUndo`] in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PastUndo {
    /// Sequence of the undo itself.
    pub seq: u64,
    /// Who can redo it; anybody where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<String>,
    /// The step that it took back.
    pub target: u64,
    /// Who had made that.
    pub target_actor: String,
}

/// Who last changed a light.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LightTouch {
    /// Id of the light.
    pub light: u64,
    /// Id of the actor.
    pub actor: String,
    /// That actor's latest record on it.
    pub seq: u64,
}

/// When the control points of a light were last renumbered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Renumbering {
    /// Id of the light.
    pub light: u64,
    /// The record that renumbered them.
    pub seq: u64,
}

impl SessionCheckpoint {
    /// Reads what [`Self::to_json`] wrote.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        from_json(text)
    }

    /// One line of JSON.
    pub fn to_json(&self) -> String {
        crate::log_line::to_line(self)
    }

    /// The session that goes on from here.
    pub fn into_domain(self) -> Result<Session, Refused> {
        let undo = |undo: PastUndo| edit::PastUndo {
            seq: undo.seq,
            actor_id: undo.actor,
            target: undo.target,
            target_actor_id: undo.target_actor,
        };
        let steps_of =
            |(actor, seqs): (String, Vec<u64>)| seqs.into_iter().map(move |seq| (seq, actor.clone()));
        let mut steps: Vec<(u64, String)> = self.steps.into_iter().flat_map(steps_of).collect();
        steps.sort_unstable();
        let past = SessionHistory {
            steps,
            undos: self.undos.into_iter().map(undo).collect(),
            touched: self.touched.into_iter().map(|t| (LightId(t.light), t.actor, t.seq)).collect(),
            renumbered: self.renumbered.into_iter().map(|r| (LightId(r.light), r.seq)).collect(),
        };
        let document = self.document.into_domain(self.last_number)?;
        Ok(Session::restore(document, self.seq, &past))
    }
}

impl From<&Session> for SessionCheckpoint {
    fn from(session: &Session) -> Self {
        let SessionHistory { steps, undos, touched, renumbered } = session.session_history();
        let undo = |undo: edit::PastUndo| PastUndo {
            seq: undo.seq,
            actor: undo.actor_id,
            target: undo.target,
            target_actor: undo.target_actor_id,
        };
        let mut steps_of = BTreeMap::<String, Vec<u64>>::new();
        for (seq, actor) in steps {
            steps_of.entry(actor).or_default().push(seq);
        }
        let touch = |(light, actor, seq): (LightId, String, u64)| LightTouch { light: light.0, actor, seq };
        Self {
            seq: session.seq(),
            document: session.document().into(),
            last_number: session.document().last_number(),
            steps: steps_of,
            undos: undos.into_iter().map(undo).collect(),
            touched: touched.into_iter().map(touch).collect(),
            renumbered: renumbered
                .into_iter()
                .map(|(light, seq)| Renumbering { light: light.0, seq })
                .collect(),
        }
    }
}
