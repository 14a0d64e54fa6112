//! Requests for records: carried out once each, and answered.

use std::collections::HashMap;
use std::sync::Arc;

use document::{AssetHash, Change, Command};
use edit::{Actor, Record, Request, Sources, TakenBack};
use protocol::{EditResult, EditStatus, GestureEnd, Problem, ServerMessage, SessionCheckpoint};
use scene::Scene;
use store::{Outcome, Rejection, StoreError};
use tokio::task::spawn_blocking;

use super::message::Step;
use super::tick::{Say, Tick, time_ms};
use super::{Room, Surroundings};
use crate::ServerError;
use crate::limits::{CHECKPOINT_AFTER_BYTES, CHECKPOINT_AFTER_RECORDS};

/// An operation: its actor and that one's name for it.
pub(super) type OperationKey = (String, String);

/// What became of operations in earlier ticks. Where the store cannot tell, none is carried out.
pub(super) struct Outcomes(Result<HashMap<OperationKey, Outcome>, ServerError>);

impl Default for Outcomes {
    fn default() -> Self {
        Self(Ok(HashMap::new()))
    }
}

/// The answer to a request for a record.
pub(super) struct Answer {
    pub result: EditResult,
    /// It rests on what this tick commits; others were given before.
    is_new: bool,
}

impl Answer {
    /// What it becomes where the tick is not committed.
    pub fn taken_back(self, error: &ServerError) -> Self {
        if self.is_new { Self { result: refused(self.result.op_id, error), ..self } } else { self }
    }
}

/// What a request needs of other places, found before it is carried out.
#[derive(Default)]
struct Found {
    scenes: Vec<(AssetHash, Arc<Scene>)>,
    taken_back: Option<TakenBack>,
}

impl Room {
    /// What became of these operations, as the store knows it.
    pub(super) async fn outcomes(&self, keys: Vec<OperationKey>) -> Outcomes {
        if keys.is_empty() {
            return Outcomes::default();
        }
        let name = Arc::clone(&self.name);
        let read = self.backend.storage.read(move |store| {
            let mut outcomes = HashMap::new();
            for (actor_id, op_id) in keys {
                if let Some(outcome) = store.outcome(&name, &actor_id, &op_id)? {
                    outcomes.insert((actor_id, op_id), outcome);
                }
            }
            Ok(outcomes)
        });
        Outcomes(read.await)
    }

    /// Carries out a request for a record, unless it came before; its answer, to be told once the tick is committed.
    pub(super) async fn take_step(&mut self, step: Step, actor: &Actor, tick: &mut Tick) -> Answer {
        let Step { op_id, request } = step;
        let key = (actor.id.clone(), op_id.clone());
        if let Some(result) = tick.answers.get(&key) {
            return Answer { result: result.clone(), is_new: true };
        }
        match &tick.earlier.0 {
            Ok(outcomes) => {
                if let Some(outcome) = outcomes.get(&key) {
                    return Answer { result: result_of(op_id, outcome.clone()), is_new: false };
                }
            }
            // It may have been carried out before.
            Err(error) => {
                let error = ServerError::Store(StoreError::Unknown(error.to_string()));
                return Answer { result: refused(op_id, &error), is_new: false };
            }
        }
        let outcome = match request {
            Ok(request) => self.carry_out(request, actor, &op_id, tick).await,
            Err(error) => Err(error),
        };
        let result = match outcome {
            Ok(record) => committed(&record),
            Err(error) => {
                let result = refused(op_id.clone(), &error);
                if error.is_of_the_moment() {
                    return Answer { result, is_new: true };
                }
                let Problem { code, message } = error.problem();
                tick.rejections.push(Rejection { actor_id: actor.id.clone(), op_id, code, message });
                result
            }
        };
        tick.answers.insert(key, result.clone());
        Answer { result, is_new: true }
    }

    async fn carry_out(
        &mut self,
        request: Request,
        actor: &Actor,
        op_id: &str,
        tick: &mut Tick,
    ) -> Result<Record, ServerError> {
        let found = self.find_for(&request, &actor.id, tick).await?;
        let held = match &request {
            Request::Commit(id) => self.gesture_of(id, actor),
            Request::Edit { .. } | Request::Undo(_) | Request::Redo(_) => None,
        };
        tick.before.get_or_insert_with(|| Box::new((self.session.clone(), self.surroundings.clone())));
        let Found { scenes, taken_back } = found;
        let scene = |asset: &AssetHash| {
            scenes.iter().find(|(known, _)| known == asset).map(|(_, scene)| Arc::clone(scene))
        };
        let sources = Sources { scene: &scene, taken_back };
        let committed = self.session.request(request, actor, op_id, time_ms(), sources);
        // A gesture whose commit is refused has ended all the same.
        let ended = held.filter(|held| self.gesture_of(&held.id, actor).is_none());
        let committed = committed.map_err(ServerError::from);
        if let Ok(record) = &committed {
            self.log(record, tick).await;
        }
        if let Some(gesture) = ended {
            let (end, problem) = match &committed {
                Ok(_) => (GestureEnd::Committed, None),
                // There was never anything to see of it, so nothing is refused.
                Err(error) if gesture.command.is_none() => (GestureEnd::Cancelled, Some(error.problem())),
                Err(error) => (GestureEnd::Rejected, Some(error.problem())),
            };
            self.end_gesture(gesture, end, problem, tick);
        }
        committed
    }

    /// Takes a new record into the tick.
    async fn log(&mut self, record: &Record, tick: &mut Tick) {
        let document = self.session.document();
        let hash = document.hash().to_string();
        let (mut bounds, mut notes) = (None, None);
        if record.changes.iter().any(|change| matches!(change, Change::Scene { .. })) {
            match Surroundings::of(document, &self.backend.scenes).await {
                Ok(surroundings) => self.surroundings = surroundings,
                Err(error) => tracing::error!("the bounds and notes of a scene are not known: {error}"),
            }
            bounds = Some(self.surroundings.bounds);
            notes = Some(self.surroundings.notes.to_vec());
        }
        tick.shows |= record.changes.iter().any(Change::changes_picture);
        tick.say(Say::Log(ServerMessage::Log { record: Box::new(record.into()), hash, bounds, notes }));
        tick.records.push(Arc::new(record.clone()));
    }

    /// The scenes that a request loads, decoded, and the record that it takes back.
    async fn find_for(&self, request: &Request, actor_id: &str, tick: &Tick) -> Result<Found, ServerError> {
        let mut found = Found::default();
        if matches!(request, Request::Undo(_) | Request::Redo(_)) {
            found.taken_back = self.taken_back(request, actor_id, &tick.records).await?;
            for change in found.taken_back.iter().flat_map(|taken| &taken.changes) {
                if let Change::Scene { new: Some(scene), .. } = change {
                    found.scenes.push((scene.asset, self.backend.scenes.load(scene.asset).await?.scene));
                }
            }
        }
        if let Request::Edit { command: Command::LoadScene { asset, .. }, .. } = request {
            found.scenes.push((*asset, self.backend.scenes.load(*asset).await?.scene));
        }
        Ok(found)
    }

    /// Writes a checkpoint down once so much has come since the last one that opening the session would take long.
    /// What fails here costs time at the next opening, nothing else.
    pub(super) async fn keep_checkpoint(&mut self) {
        let enough_bytes = CHECKPOINT_AFTER_BYTES.max(4 * self.checkpoint_bytes);
        if self.tail.records < CHECKPOINT_AFTER_RECORDS && self.tail.bytes < enough_bytes {
            return;
        }
        self.tail = store::Tail::default();
        let session = self.session.clone();
        let kept = match spawn_blocking(move || SessionCheckpoint::from(&session)).await {
            Ok(checkpoint) => self.backend.storage.keep_checkpoint(&self.name, checkpoint).await,
            Err(_) => Err(ServerError::Fault),
        };
        match kept {
            Ok(bytes) => self.checkpoint_bytes = bytes,
            Err(error) => tracing::warn!("session {} has no new checkpoint: {error}", self.name),
        }
    }
}

fn committed(record: &Record) -> EditResult {
    let (seq, rebased) = (record.seq, record.action.rebased());
    let skipped = record.action.skipped().to_vec();
    result_of(record.op_id.clone(), Outcome::Committed { seq, rebased, skipped })
}

fn result_of(op_id: String, outcome: Outcome) -> EditResult {
    match outcome {
        Outcome::Committed { seq, rebased, skipped } => {
            let status = if rebased { EditStatus::Rebased } else { EditStatus::Committed };
            EditResult { op_id, status, seq: Some(seq), skipped, code: None, message: None }
        }
        Outcome::Rejected { code, message } => {
            let (code, message) = (Some(code), Some(message));
            EditResult { op_id, status: EditStatus::Rejected, seq: None, skipped: Vec::new(), code, message }
        }
    }
}

fn refused(op_id: String, error: &ServerError) -> EditResult {
    let Problem { code, message } = error.problem();
    let status = if error.is_unknown() { EditStatus::Unknown } else { EditStatus::Rejected };
    let (code, message) = (Some(code), Some(message));
    EditResult { op_id, status, seq: None, skipped: Vec::new(), code, message }
}
