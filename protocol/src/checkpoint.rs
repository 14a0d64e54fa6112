//! Session checkpoints in JSON. With one in the store, opening a session does not replay its whole log.

use std::collections::BTreeMap;

use edit::{Session, SessionHistory};
use light::LightId;
use serde::{Deserialize, Serialize};

use crate::{Document, Refused};

/// State of a session after one of its records. It replaces all records before, so that replay can start from
/// it. The document's hash at that record proves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SessionCheckpoint {
    /// Sequence number of the record.
    pub seq: u64,
    /// Document after the record.
    pub document: Document,
    /// Largest number ever used as an id or a point numbering.
    pub last_number: u64,
    /// Sequence numbers of the steps in effect, ascending, by the id of the actor.
    pub steps: BTreeMap<String, Vec<u64>>,
    /// Undos that can be redone.
    pub undos: Vec<PastUndo>,
    /// Latest record of each actor on each light.
    pub touched: Vec<LightTouch>,
    /// Latest renumbering of each light's control points.
    pub renumbered: Vec<Renumbering>,
}

/// [`edit::PastUndo`] in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PastUndo {
    /// Sequence number of the undo.
    pub seq: u64,
    /// Id of the actor who can redo it. Any actor can if it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actor: Option<String>,
    /// Sequence number of the step that was undone.
    pub target: u64,
    /// Id of the actor who made that step.
    pub target_actor: String,
}

/// Latest record of an actor on a light.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LightTouch {
    pub light: u64,
    pub actor: String,
    /// Sequence number of the record.
    pub seq: u64,
}

/// Latest renumbering of a light's control points.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Renumbering {
    pub light: u64,
    /// Sequence number of the record that renumbered them.
    pub seq: u64,
}

impl SessionCheckpoint {
    /// Returns one line of JSON.
    pub fn to_json(&self) -> String {
        crate::log_line::to_line(self)
    }

    /// Restores the session.
    pub fn into_domain(self) -> Result<Session, Refused> {
        let undo = |PastUndo { seq, actor: actor_id, target, target_actor: target_actor_id }| edit::PastUndo {
            seq,
            actor_id,
            target,
            target_actor_id,
        };
        let steps_of = |(actor, seqs): (String, Vec<u64>)| seqs.into_iter().map(move |seq| (seq, actor.clone()));
        let mut steps: Vec<(u64, String)> = self.steps.into_iter().flat_map(steps_of).collect();
        steps.sort_unstable();
        let history = SessionHistory {
            steps,
            undos: self.undos.into_iter().map(undo).collect(),
            touched: self.touched.into_iter().map(|t| (LightId(t.light), t.actor, t.seq)).collect(),
            renumbered: self.renumbered.into_iter().map(|r| (LightId(r.light), r.seq)).collect(),
        };
        let document = self.document.into_domain(self.last_number)?;
        Ok(Session::restore(document, self.seq, &history))
    }
}

impl From<&Session> for SessionCheckpoint {
    fn from(session: &Session) -> Self {
        let SessionHistory { steps, undos, touched, renumbered } = session.session_history();
        let undo = |edit::PastUndo { seq, actor_id: actor, target, target_actor_id: target_actor }| PastUndo {
            seq,
            actor,
            target,
            target_actor,
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
            renumbered: renumbered.into_iter().map(|(light, seq)| Renumbering { light: light.0, seq }).collect(),
        }
    }
}
