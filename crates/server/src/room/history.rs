//! Records that undo and redo revert. They are in the store, so a thread that may wait for the disk reads them.

use std::cell::RefCell;
use std::sync::Arc;

use document::{Change, describe_changes};
use edit::{Action, EditRequest, FindRecord, Record, Reverted, Session, UndoScope};
use protocol::{History, HistoryStep, HistorySteps, ServerMessage};

use super::Room;
use crate::ServerError;
use crate::outboxes::ClientId;

impl Room {
    /// Finds the changes that `request` of that actor reverts. `new` are the records that are not in the store yet.
    pub(super) async fn find_reverted(
        &self,
        request: &EditRequest,
        actor_id: &str,
        new: &[Arc<Record>],
    ) -> Result<Option<Reverted>, ServerError> {
        let (request, actor_id) = (request.clone(), actor_id.to_owned());
        let found = self.with_records(new.to_vec(), move |session, find_record| {
            session.find_revert(&request, &actor_id, find_record)
        });
        Ok(found.await??)
    }

    /// Sends a client the steps that its undo and redo would revert. Everything done before is committed.
    pub(super) async fn send_history(&mut self, id: ClientId) {
        let Some(client) = self.clients.get(&id) else { return };
        let actor_id = client.principal.actor.id.clone();
        let history = self.with_records(Vec::new(), move |session, find_record| {
            let step = |request| history_step(session, &request, &actor_id, find_record);
            let steps = |request: fn(UndoScope) -> EditRequest| HistorySteps {
                mine: step(request(UndoScope::Mine)),
                session: step(request(UndoScope::Session)),
            };
            History { seq: session.seq(), undo: steps(EditRequest::Undo), redo: steps(EditRequest::Redo) }
        });
        match history.await {
            Ok(history) => self.outboxes.send(id, &ServerMessage::History(Box::new(history))),
            Err(error) => self.outboxes.send_error(id, &error),
        }
    }

    /// Runs a question that needs records of the log. If a record cannot be read, returns that error.
    async fn with_records<T: Send + 'static>(
        &self,
        new: Vec<Arc<Record>>,
        question: impl FnOnce(&Session, FindRecord) -> T + Send + 'static,
    ) -> Result<T, ServerError> {
        let (session, name) = (self.session.clone(), Arc::clone(&self.name));
        let answer = self.services.storage.read(move |store| {
            let failed = RefCell::new(None);
            let find_record = |seq| {
                if let Some(record) = new.iter().find(|record| record.seq == seq) {
                    return Some(Record::clone(record));
                }
                match store.records(&name, seq, 1) {
                    Ok(records) => records.into_iter().next().and_then(|record| record.try_into().ok()),
                    Err(error) => {
                        failed.borrow_mut().get_or_insert(error);
                        None
                    }
                }
            };
            let answer = question(&session, &find_record);
            failed.into_inner().map_or(Ok(answer), Err)
        });
        answer.await
    }
}

fn history_step(
    session: &Session,
    request: &EditRequest,
    actor_id: &str,
    find_record: FindRecord,
) -> Option<HistoryStep> {
    let reverted = session.find_revert(request, actor_id, find_record).ok().flatten()?;
    let Reverted { target, changes, passed, .. } = reverted;
    let done: Vec<Change> = match request {
        EditRequest::Undo(_) => changes.iter().rev().map(Change::inverse).collect(),
        _ => changes,
    };
    let record = find_record(target)?;
    let by = match record.action {
        Action::Undo { target: step, .. } => find_record(step)?.actor,
        _ => record.actor,
    };
    Some(HistoryStep { seq: target, actor: (&by).into(), what: describe_changes(&done, session.document()), passed })
}
