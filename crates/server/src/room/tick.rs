//! What came in together and is committed together: what was done, and what is to be sent once that is on disk.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::vec;

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

/// What has been done and is not committed yet.
#[derive(Default)]
pub(super) struct Tick {
    /// The state before the first request for a record, to go back to.
    pub before: Option<Box<(edit::Session, OpenScene)>>,
    pub records: Vec<Arc<Record>>,
    pub rejections: Vec<Rejection>,
    /// What became of this tick's operations in an earlier one, as the store knows it.
    pub earlier_outcomes: EarlierOutcomes,
    /// What became of operations in this one.
    pub outcomes: HashMap<OperationKey, Outcome>,
    /// What is sent once all is on disk, in order.
    pub outgoing: Vec<Outgoing>,
    /// Who wants to know what undo and redo would take back.
    pub history_requests: BTreeSet<ClientId>,
    /// Whether a picture can show any of it.
    pub changes_pictures: bool,
}

/// What is sent once all is on disk.
pub(super) enum Outgoing {
    /// To every client: a record.
    Record(ServerMessage),
    /// To every client: a gesture.
    Gesture(GestureState),
    /// To one client alone: why its gesture is not what it wants.
    GestureRefusal(ClientId, GestureState),
    /// To the client that sent the operation.
    Answer(ClientId, RecordAnswer),
    /// What has been done of a program's request: its answer, or the rest is to be done later.
    Batch(RequestBatch),
}

/// A program's request for records.
pub(super) struct RequestBatch {
    pub principal: Principal,
    /// What is left, in order.
    pub steps: vec::IntoIter<RecordRequest>,
    /// What became of those before this tick.
    pub done: Vec<EditResult>,
    /// What became of those in this tick.
    pub answers: Vec<RecordAnswer>,
    /// Of what in it needs them.
    pub solves: SolveState,
    pub reply: Reply<EditResults>,
    /// Cancelled when nobody waits for the answer any more.
    pub cancellation: CancellationToken,
}

/// An operation: its actor and that one's name for it.
pub(super) type OperationKey = (String, String);

/// What became of operations in earlier ticks. Where the store cannot tell, none is carried out.
pub(super) struct EarlierOutcomes(pub Result<HashMap<OperationKey, Outcome>, ServerError>);

/// The answer to a request for a record.
pub(super) struct RecordAnswer {
    pub result: EditResult,
    /// It rests on what this tick commits; others were given before.
    pub is_new: bool,
}

impl Tick {
    /// Sends something once all is on disk.
    pub fn send(&mut self, outgoing: Outgoing) {
        self.outgoing.push(outgoing);
    }

    /// What became of an operation that came before, and whether that rests on this tick.
    pub fn earlier_outcome(&self, op_id: &str, actor: &Actor) -> Option<(Outcome, bool)> {
        let key = (actor.id.clone(), op_id.to_owned());
        if let Some(outcome) = self.outcomes.get(&key) {
            return Some((outcome.clone(), true));
        }
        match &self.earlier_outcomes.0 {
            Ok(outcomes) => Some((outcomes.get(&key)?.clone(), false)),
            // It may have been carried out before.
            Err(error) => {
                Some((refused(&ServerError::Store(StoreError::UnknownOutcome(error.to_string()))), false))
            }
        }
    }

    /// Whether what it holds is as much as may be in memory at once.
    pub fn is_full(&self) -> bool {
        self.records.iter().map(|record| record.changes.len()).sum::<usize>() >= MAX_TICK_CHANGES
    }
}

impl RequestBatch {
    /// None of it is done yet.
    pub fn new(
        principal: Principal,
        steps: Vec<RecordRequest>,
        (reply, cancellation): (Reply<EditResults>, CancellationToken),
    ) -> Self {
        let (done, answers) = (Vec::with_capacity(steps.len()), Vec::new());
        let solves = SolveState::default();
        Self { principal, steps: steps.into_iter(), done, answers, solves, reply, cancellation }
    }

    /// Leaves out what is left from a step on that has to be solved, where nobody waits for the answer any more.
    pub fn drop_unawaited_solves(&mut self) {
        if self.cancellation.is_cancelled()
            && self.steps.as_slice().first().is_some_and(RecordRequest::needs_scene)
        {
            self.steps = Vec::new().into_iter();
        }
    }

    /// The steps that a tick with room for `share` can come to: up to the next that waits to be solved then.
    pub fn next_steps(&self, share: usize) -> &[RecordRequest] {
        let steps = self.steps.as_slice();
        let next_solve = steps.iter().skip(1).position(RecordRequest::needs_scene);
        let up_to_it = next_solve.map_or(steps.len(), |between| between + 2);
        &steps[..up_to_it.min(share)]
    }
}

impl Default for EarlierOutcomes {
    fn default() -> Self {
        Self(Ok(HashMap::new()))
    }
}

impl RecordAnswer {
    /// What it becomes where the tick is not committed.
    pub fn rolled_back(mut self, error: &ServerError) -> Self {
        if self.is_new {
            self.result.outcome = refused(error);
        }
        self
    }
}

/// What became of a request for a record that was not carried out.
pub(super) fn refused(error: &ServerError) -> Outcome {
    if error.has_unknown_outcome() {
        Outcome::Unknown(error.problem())
    } else {
        Outcome::Rejected(error.problem())
    }
}
