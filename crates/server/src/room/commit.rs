//! What a tick came to is committed, and only then published.

use std::sync::Arc;

use document::CommandContext;
use protocol::{EditResults, GestureStatus, Outcome, ServerMessage};

use super::Room;
use super::tick::{Outgoing, RecordAnswer, RequestBatch, Tick};
use crate::ServerError;

impl Room {
    /// Commits what the tick came to and publishes it; or rolls it back and answers why.
    pub(super) async fn commit(&mut self, mut tick: Tick) {
        let records: Vec<_> =
            std::mem::take(&mut tick.records).into_iter().map(Arc::unwrap_or_clone).collect();
        let rejections = std::mem::take(&mut tick.rejections);
        if !(records.is_empty() && rejections.is_empty()) {
            let hash = self.session.document().hash();
            let name = Arc::clone(&self.name);
            match self.backend.storage.append(name, records, rejections, hash).await {
                Ok(more) => self.tail += more,
                Err(error) => self.roll_back(&mut tick, &error),
            }
        }
        self.publish(tick);
        self.keep_checkpoint().await;
    }

    /// The state before the tick, and other answers in place of its own. Nobody has seen the rest.
    ///
    /// Gestures stay as they are: those that were to be committed are over, and everybody is told why.
    fn roll_back(&mut self, tick: &mut Tick, error: &ServerError) {
        if let Some((session, scene)) = tick.before.take().map(|before| *before) {
            self.scene = scene;
            let context = CommandContext {
                scene_bounds: self.scene.decoded.posed.bounds(),
                loaded: None,
                solved: None,
            };
            self.session.roll_back_to(session, context);
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

    /// Sends what a tick has to send. It has nothing to commit any more.
    pub(super) fn publish(&mut self, tick: Tick) {
        if tick.changes_pictures {
            self.views.invalidate_all();
        }
        for outgoing in tick.outgoing {
            match outgoing {
                Outgoing::Record(message) => self.outboxes.broadcast(&message, None),
                Outgoing::Gesture(state) => {
                    // Its holder is told in any case: it is an answer.
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

    /// Answers a program, or puts what is left of its request back in line.
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
        // Whoever asked may have gone; it is done all the same.
        let _ = reply.send(Ok(EditResults { results, seq: self.session.seq(), hash }));
    }

    fn count(&self, outcome: &Outcome) {
        self.backend.metrics.count_edit(outcome.code());
    }
}
