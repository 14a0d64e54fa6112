//! A tick: requests that are committed together, and the messages to send once they are on disk.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::vec;

use document::Document;
use edit::{Actor, Record};
use protocol::{EditResult, EditResults, GestureState, Outcome, ServerMessage};
use store::{Rejection, StoreError};
use tokio_util::sync::CancellationToken;

use super::OpenScene;
use super::message::Reply;
use super::solving::SolveState;
use crate::ServerError;
use crate::access::Principal;
use crate::limits::MAX_TICK_CHANGES;
use crate::outboxes::ClientId;
use crate::request::RecordRequest;

/// Finished work that is not committed yet.
#[derive(Default)]
pub(super) struct Tick {
    /// Copies of the session and scene as they were before the first request for a record in this tick. A rollback
    /// restores them.
    pub before: Option<Box<(edit::Session, OpenScene)>>,
    pub records: Vec<Arc<Record>>,
    pub rejections: Vec<Rejection>,
    /// Outcomes of this tick's operations in earlier ticks, from the store.
    pub earlier_outcomes: EarlierOutcomes,
    /// Outcomes of operations in this tick.
    pub outcomes: HashMap<OperationKey, Outcome>,
    /// Messages to send after the commit, in order.
    pub outgoing: Vec<Outgoing>,
    /// Clients that ask for the steps that undo and redo would revert.
    pub history_requests: BTreeSet<ClientId>,
    /// True if a record or gesture of this tick can change a picture.
    pub changes_pictures: bool,
}

/// A message to send after the commit.
pub(super) enum Outgoing {
    /// A record, to every client.
    Record(ServerMessage),
    /// A gesture, to every client.
    Gesture(GestureState),
    /// The refusal of a gesture's request, to its client alone.
    GestureRefusal(ClientId, GestureState),
    /// An answer, to the client that sent the operation.
    Answer(ClientId, RecordAnswer),
    /// A program's request. It is answered if it is complete, and else continued later.
    Batch(RequestBatch),
}

/// A program's request for records.
pub(super) struct RequestBatch {
    pub principal: Principal,
    /// Remaining steps, in order.
    pub steps: vec::IntoIter<RecordRequest>,
    /// Outcomes of the steps before this tick.
    pub done: Vec<EditResult>,
    /// Outcomes of the steps in this tick.
    pub answers: Vec<RecordAnswer>,
    pub solves: SolveState,
    pub reply: Reply<EditResults>,
    /// Cancelled when the program no longer waits for the answer.
    pub cancellation: CancellationToken,
}

/// An operation: the id of its actor and the actor's id for it.
pub(super) type OperationKey = (String, String);

/// Outcomes of operations in earlier ticks. If the store cannot be read, no operation is carried out.
pub(super) struct EarlierOutcomes(pub Result<HashMap<OperationKey, Outcome>, ServerError>);

pub(super) struct RecordAnswer {
    pub result: EditResult,
    /// True if the answer depends on this tick's commit.
    pub is_new: bool,
}

impl Tick {
    /// Queues a message that is sent after the commit.
    pub fn send(&mut self, outgoing: Outgoing) {
        self.outgoing.push(outgoing);
    }

    /// Returns the outcome of an operation that came before, and true if it depends on this tick's commit.
    pub fn earlier_outcome(&self, op_id: &str, actor: &Actor) -> Option<(Outcome, bool)> {
        let key = (actor.id.clone(), op_id.to_owned());
        if let Some(outcome) = self.outcomes.get(&key) {
            return Some((outcome.clone(), true));
        }
        match &self.earlier_outcomes.0 {
            Ok(outcomes) => Some((outcomes.get(&key)?.clone(), false)),
            // The operation may have been carried out before.
            Err(error) => Some((refused(&ServerError::Store(StoreError::UnknownOutcome(error.to_string()))), false)),
        }
    }

    /// True if the tick holds as many changes as may be in memory at once.
    pub fn is_full(&self) -> bool {
        self.records.iter().map(|record| record.changes.len()).sum::<usize>() >= MAX_TICK_CHANGES
    }
}

impl RequestBatch {
    /// Drops the remaining steps of a request if the next one needs a solve and the program no longer waits for the
    /// answer.
    pub fn drop_unawaited_solves(&mut self, document: &Document) {
        let needs_scene = |step: &RecordRequest| step.needs_scene(document);
        if self.cancellation.is_cancelled() && self.steps.as_slice().first().is_some_and(needs_scene) {
            self.steps = Vec::new().into_iter();
        }
    }

    /// Returns the steps that a tick with room for `share` steps can reach: if one needs a solve, only up to the step
    /// after it.
    pub fn next_steps(&self, share: usize, document: &Document) -> &[RecordRequest] {
        let steps = self.steps.as_slice();
        let steps = &steps[..share.min(steps.len())];
        let next_solve = steps.iter().skip(1).position(|step| step.needs_scene(document));
        let up_to_it = next_solve.map_or(steps.len(), |between| between + 2);
        &steps[..up_to_it.min(steps.len())]
    }
}

impl Default for EarlierOutcomes {
    fn default() -> Self {
        Self(Ok(HashMap::new()))
    }
}

impl RecordAnswer {
    /// Returns the answer to send if the commit of the tick fails.
    pub fn rolled_back(mut self, error: &ServerError) -> Self {
        if self.is_new {
            self.result.outcome = refused(error);
        }
        self
    }
}

/// Returns the outcome of a request for a record that was refused.
pub(super) fn refused(error: &ServerError) -> Outcome {
    if error.has_unknown_outcome() { Outcome::Unknown(error.problem()) } else { Outcome::Rejected(error.problem()) }
}
