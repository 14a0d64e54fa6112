//! Requests for records: each is carried out once and answered.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use document::{Change, Command, CommandSolution, SceneContents};
use edit::{Actor, EditRequest, EditSources, Record, Reverted};
use protocol::{EditResult, GestureStatus, Outcome, ServerMessage};
use store::Rejection;

use super::solving::{FoundSolution, into_edit_request};
use super::tick::{EarlierOutcomes, OperationKey, Outgoing, RecordAnswer, Tick, refused};
use super::{OpenScene, Room};
use crate::ServerError;
use crate::access::Principal;
use crate::request::RecordRequest;

impl Room {
    /// Reads the outcomes of these operations from the store.
    pub(super) async fn outcomes(&self, keys: Vec<OperationKey>) -> EarlierOutcomes {
        if keys.is_empty() {
            return EarlierOutcomes::default();
        }
        let name = Arc::clone(&self.name);
        let read = self.services.storage.read(move |store| {
            let outcome = |key: OperationKey| Ok(store.outcome(&name, &key.0, &key.1)?.map(|outcome| (key, outcome)));
            keys.into_iter().filter_map(|key| outcome(key).transpose()).collect()
        });
        EarlierOutcomes(read.await)
    }

    /// Carries out a request for a record, unless the same operation was carried out before. Returns its answer, which
    /// is sent once the tick is committed. `found` is the solution of its command.
    pub(super) async fn run_step(
        &mut self,
        step: RecordRequest,
        found: FoundSolution,
        principal: &Principal,
        tick: &mut Tick,
    ) -> RecordAnswer {
        let RecordRequest { op_id, request } = step;
        let request = request.and_then(|action| into_edit_request(action, found, self.session.document()));
        let (outcome, is_new) = self.outcome_of(&op_id, request, &principal.actor, tick).await;
        RecordAnswer { result: EditResult { op_id, outcome }, is_new }
    }

    /// Returns the outcome of a request for a record, and true if the outcome depends on the commit of this tick.
    async fn outcome_of(
        &mut self,
        op_id: &str,
        request: Result<(EditRequest, Option<CommandSolution>), ServerError>,
        actor: &Actor,
        tick: &mut Tick,
    ) -> (Outcome, bool) {
        if let Some(earlier) = tick.earlier_outcome(op_id, actor) {
            return earlier;
        }
        let key = (actor.id.clone(), op_id.to_owned());
        let carried_out = match request {
            Ok((request, solved)) => self.apply_request(request, solved, actor, op_id, tick).await,
            Err(error) => Err(error),
        };
        let outcome = match carried_out {
            Ok(record) => Outcome::Committed((&record).into()),
            Err(error) if error.is_transient() => return (refused(&error), true),
            Err(error) => {
                let (actor_id, op_id) = key.clone();
                tick.rejections.push(Rejection { actor_id, op_id, problem: error.problem() });
                refused(&error)
            }
        };
        tick.outcomes.insert(key, outcome.clone());
        (outcome, true)
    }

    async fn apply_request(
        &mut self,
        request: EditRequest,
        solved: Option<CommandSolution>,
        actor: &Actor,
        op_id: &str,
        tick: &mut Tick,
    ) -> Result<Record, ServerError> {
        let (loaded, reverted) = self.sources_of(&request, actor, tick).await?;
        let gesture = if let EditRequest::Commit(id) = &request { self.gesture_of(id, actor) } else { None };
        tick.before.get_or_insert_with(|| Box::new((self.session.clone(), self.scene.clone())));
        let context = self.scene.decoded.context(loaded.as_deref(), solved.as_ref());
        let sources = EditSources { context, reverted };
        let committed = self.session.execute_request(request, actor, op_id, time_ms(), sources);
        // A gesture ends even if its commit is refused.
        let ended = gesture.filter(|gesture| self.gesture_of(&gesture.id, actor).is_none());
        let committed = committed.map_err(ServerError::from);
        if let Ok(record) = &committed {
            self.add_to_tick(record, tick).await;
        }
        if let Some(gesture) = ended {
            let status = match &committed {
                Ok(_) => GestureStatus::Committed,
                // The gesture showed nothing, so there is nothing to refuse.
                Err(error) if gesture.command.is_none() => GestureStatus::Cancelled { refused: Some(error.problem()) },
                Err(error) => GestureStatus::Rejected(error.problem()),
            };
            self.end_gesture(gesture, status, tick);
        }
        committed
    }

    /// Adds a new record to the tick.
    async fn add_to_tick(&mut self, record: &Record, tick: &mut Tick) {
        let document = self.session.document();
        let hash = document.hash().to_string();
        let (mut bounds, mut notes) = (None, None);
        if record.changes.iter().any(|change| matches!(change, Change::Scene { .. })) {
            match OpenScene::of(document, &self.services.scenes).await {
                Ok(scene) => self.scene = scene,
                Err(error) => tracing::error!("the bounds and notes of a scene are not known: {error}"),
            }
            bounds = Some(self.scene.bounds);
            notes = Some(self.scene.decoded.notes.to_vec());
        }
        tick.changes_pictures |= record.changes.iter().any(Change::changes_picture);
        let record_message = ServerMessage::Log { record: Box::new(record.into()), hash, bounds, notes };
        tick.send(Outgoing::Record(record_message));
        tick.records.push(Arc::new(record.clone()));
    }

    /// Reads the scene that a request loads and the record that it reverts.
    async fn sources_of(
        &self,
        request: &EditRequest,
        actor: &Actor,
        tick: &Tick,
    ) -> Result<(Option<Arc<SceneContents>>, Option<Reverted>), ServerError> {
        let (mut loaded, mut reverted) = (None, None);
        if matches!(request, EditRequest::Undo(_) | EditRequest::Redo(_)) {
            reverted = self.find_reverted(request, &actor.id, &tick.records).await?;
            for change in reverted.iter().flat_map(|reverted: &Reverted| &reverted.changes) {
                if let Change::Scene { new: Some(scene), .. } = change {
                    // An undo is refused here if the scene cannot be loaded.
                    self.services.scenes.load(scene.asset).await?;
                }
            }
        }
        if let EditRequest::Edit { command: Command::LoadScene { asset, .. }, .. } = request {
            loaded = Some(self.services.scenes.load(*asset).await?.contents);
        }
        Ok((loaded, reverted))
    }
}

/// Returns the current time in milliseconds since 1970.
pub fn time_ms() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_millis() as u64)
}
