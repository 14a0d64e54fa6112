//! Commits the records of a tick, then publishes them.

use std::sync::Arc;

use protocol::{EditResults, GestureStatus, Outcome, ServerMessage};

use super::Room;
use super::tick::{Outgoing, RecordAnswer, RequestBatch, Tick};
use crate::ServerError;

impl Room {
    /// Commits the tick and publishes it. On an error rolls it back and answers with the reason.
    pub(super) async fn commit(&mut self, mut tick: Tick) {
        let records: Vec<_> = std::mem::take(&mut tick.records).into_iter().map(Arc::unwrap_or_clone).collect();
        let rejections = std::mem::take(&mut tick.rejections);
        if !(records.is_empty() && rejections.is_empty()) {
            let hash = self.session.document().hash();
            let name = Arc::clone(&self.name);
            match self.services.storage.append(name, records, rejections, hash).await {
                Ok(more) => self.tail += more,
                Err(error) => self.roll_back(&mut tick, &error),
            }
        }
        self.publish(tick);
        self.keep_checkpoint().await;
    }

    /// Restores the state before the tick and replaces its answers. Nothing else of the tick has been published.
    ///
    /// Gestures stay as they are. Those that were to be committed have ended, and all clients get the reason.
    fn roll_back(&mut self, tick: &mut Tick, error: &ServerError) {
        if let Some((session, scene)) = tick.before.take().map(|before| *before) {
            self.scene = scene;
            self.session.roll_back_to(session, self.scene.decoded.context(None, None));
        }
        let rolled_back = |outgoing| match outgoing {
            Outgoing::Record(_) => None,
            Outgoing::Gesture(mut state) => {
                if state.status == GestureStatus::Committed {
                    state.status = GestureStatus::Rejected(error.problem());
                }
                Some(Outgoing::Gesture(state))
            }
            Outgoing::Answer(client, answer) => Some(Outgoing::Answer(client, answer.rolled_back(error))),
            Outgoing::Batch(mut batch) => {
                batch.answers = batch.answers.into_iter().map(|answer| answer.rolled_back(error)).collect();
                Some(Outgoing::Batch(batch))
            }
            Outgoing::GestureRefusal(..) => Some(outgoing),
        };
        tick.outgoing = std::mem::take(&mut tick.outgoing).into_iter().filter_map(rolled_back).collect();
        tick.changes_pictures = true;
    }

    /// Sends the messages of a tick that has nothing left to commit.
    pub(super) fn publish(&mut self, tick: Tick) {
        if tick.changes_pictures {
            self.views.invalidate_all();
        }
        for outgoing in tick.outgoing {
            match outgoing {
                Outgoing::Record(message) => self.outboxes.broadcast(&message, None),
                Outgoing::Gesture(state) => {
                    // The holder always gets it, since it answers the holder's request.
                    let holder = Some(state.client);
                    self.outboxes.broadcast(&ServerMessage::GestureState(state), holder);
                }
                Outgoing::GestureRefusal(client, state) => {
                    self.outboxes.send(client, &ServerMessage::GestureState(state));
                }
                Outgoing::Answer(client, RecordAnswer { result, .. }) => {
                    self.count(&result.outcome);
                    self.outboxes.send(client, &ServerMessage::EditResult(result));
                }
                Outgoing::Batch(batch) => self.answer_or_continue(batch),
            }
        }
    }

    /// Answers a program's request, or queues the rest of it again.
    fn answer_or_continue(&mut self, mut batch: RequestBatch) {
        for RecordAnswer { result, .. } in batch.answers.drain(..) {
            self.count(&result.outcome);
            batch.done.push(result);
        }
        if batch.steps.len() > 0 {
            self.batches.push_back(batch);
            return;
        }
        let RequestBatch { done: results, reply, .. } = batch;
        let hash = self.session.document().hash().to_string();
        // The program may be gone. Its edits stay.
        let _ = reply.send(Ok(EditResults { results, seq: self.session.seq(), hash }));
    }

    fn count(&self, outcome: &Outcome) {
        self.services.metrics.count_edit(outcome.code());
    }
}
