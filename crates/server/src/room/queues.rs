//! Queues of messages that wait for a solve outside the session's task: the drag of a feature, the range of a light that
//! is bent, or an edit of a light with hard pins.
//!
//! Editing messages of a client are carried out in order, and so are the steps of a program's request. While a step
//! waits for a solve, the client's later edits or the rest of the request wait too. Other clients do not wait, nor do
//! other messages of the same client. After the solve the step is carried out with its result, unless the document has
//! changed in a way that makes the result invalid.

use std::task::Poll;

use document::{Command, needs_solution};
use edit::Actor;
use tokio::sync::OwnedSemaphorePermit;
use tokio::task::{Id, JoinError};
use tokio_util::sync::CancellationToken;

use super::Room;
use super::clients::ConnectedClient;
use super::message::RoomMessage;
use super::solving::{FoundSolution, SolveState, SolveTask, SolvedCommand, solve};
use super::tick::Tick;
use crate::ServerError;
use crate::charges::Payer;
use crate::limits::{MAX_SOLVE_TRIES, MAX_TICK_MESSAGES};
use crate::outboxes::ClientId;
use crate::request::{ClientRequest, RecordAction, RecordRequest, RequestedEdit, needs_scene};

/// Client or program that waits for a solve.
#[derive(Clone, Copy)]
pub(super) struct Asker<'a> {
    pub actor: &'a Actor,
    /// Cancelled when the program no longer waits. `None` for a client.
    pub cancellation: Option<&'a CancellationToken>,
}

impl Room {
    /// Returns the solution of a client's request, like [`Self::solution`].
    pub(super) fn solution_of(
        &mut self,
        request: &ClientRequest,
        actor: &Actor,
        solves: &mut SolveState,
        tick: &Tick,
    ) -> Poll<FoundSolution> {
        let asker = Asker { actor, cancellation: None };
        match request {
            ClientRequest::Step(step) => self.solution_of_step(step, asker, solves, tick),
            ClientRequest::UpdateGesture { gesture, command: Ok(command), .. }
                if self.gesture_of(gesture, actor).is_some() =>
            {
                self.solution(command, asker, solves)
            }
            _ => Poll::Ready(None),
        }
    }

    /// Returns the solution of a step, like [`Self::solution`].
    pub(super) fn solution_of_step(
        &mut self,
        step: &RecordRequest,
        asker: Asker,
        solves: &mut SolveState,
        tick: &Tick,
    ) -> Poll<FoundSolution> {
        let Ok(action) = &step.request else { return Poll::Ready(None) };
        // A repeated operation is not carried out again.
        if tick.earlier_outcome(&step.op_id, asker.actor).is_some() {
            return Poll::Ready(None);
        }
        match action {
            RecordAction::Edit(edit) => match edit.command.if_it_needs_scene(self.session.document()) {
                Some(command) => self.solution(&command, asker, solves),
                None => Poll::Ready(None),
            },
            RecordAction::Group(edits) => self.solution_of_group(edits, asker, solves),
            RecordAction::Commit(id) => match self.gesture_of(id, asker.actor).and_then(|gesture| gesture.command) {
                // A bent light was solved at its update, and its command is complete.
                Some(command) if needs_solution(self.session.document(), &command) => {
                    self.solution(&command, asker, solves)
                }
                Some(_) | None => Poll::Ready(None),
            },
            RecordAction::Undo(_) | RecordAction::Redo(_) => Poll::Ready(None),
        }
    }

    /// Returns the edits of a group, completed from the scene, like [`Self::solution`].
    fn solution_of_group(
        &mut self,
        edits: &[RequestedEdit],
        asker: Asker,
        solves: &mut SolveState,
    ) -> Poll<FoundSolution> {
        match solves.take_group_solution(edits, self.session.document(), &self.scene.decoded) {
            Poll::Pending => self.begin_solve(|| SolveTask::Group(edits.to_vec()), asker, solves),
            found @ Poll::Ready(_) => found,
        }
    }

    /// Returns the solution of a command, or `None` if it needs none. A missing solution is solved outside the
    /// session's task. The result is pending until the solve ends or the asker no longer waits. After too many changes of its
    /// inputs by others it is an error.
    pub(super) fn solution(&mut self, command: &Command, asker: Asker, solves: &mut SolveState) -> Poll<FoundSolution> {
        if !needs_scene(command, self.session.document()) {
            return Poll::Ready(None);
        }
        match solves.take_solution(command, self.session.document()) {
            None => self.begin_solve(|| SolveTask::Command(Box::new(command.clone())), asker, solves),
            found => Poll::Ready(found),
        }
    }

    /// Starts a solve, unless the step has used up its tries.
    fn begin_solve(
        &mut self,
        task: impl FnOnce() -> SolveTask,
        asker: Asker,
        solves: &mut SolveState,
    ) -> Poll<FoundSolution> {
        if !solves.can_retry() {
            solves.cancel();
            return Poll::Ready(Some(Err(ServerError::TooManySolveRetries(MAX_SOLVE_TRIES))));
        }
        let (task, document) = (task(), self.session.document().clone());
        let (scene, solver) = (self.scene.decoded.clone(), self.services.solver.clone());
        let payer = Payer::new(&self.name, &asker.actor.id);
        let cancellation = asker.cancellation.cloned().unwrap_or_default();
        solves.begin(self.solving.spawn(async move {
            tokio::select! {
                solved = solve(task, document, scene, &solver, payer) => solved,
                () = cancellation.cancelled() => Err(ServerError::Internal),
            }
        }));
        Poll::Pending
    }

    /// Stores the result of a solve for the step that waits for it. The step continues in the next tick.
    pub(super) fn finish_solve(&mut self, ended: Result<(Id, Result<Vec<SolvedCommand>, ServerError>), JoinError>) {
        let task = ended.as_ref().map_or_else(JoinError::id, |(id, _)| *id);
        let of_clients = self.clients.values_mut().map(|client| &mut client.solves);
        let mut all = of_clients.chain(self.batches.iter_mut().map(|batch| &mut batch.solves));
        // The step may have been dropped meanwhile.
        let Some(solves) = all.find(|solves| solves.is_waiting_for(task)) else { return };
        solves.end(ended.map_or(Err(ServerError::Internal), |(_, solved)| solved));
    }

    /// Returns the message if it can be carried out now. Otherwise queues it behind other editing messages of its
    /// client.
    pub(super) fn take_or_queue(&mut self, message: RoomMessage) -> Option<RoomMessage> {
        let Some(client) = message.editing_client().and_then(|id| self.clients.get_mut(&id)) else {
            return Some(message);
        };
        if matches!(message, RoomMessage::Leave(_)) {
            client.discard_uncommitted();
        }
        while let Some(last) = client.queued.back()
            && message.supersedes(last, self.session.document())
        {
            if client.queued.len() == 1 {
                // Without this exception the picture would stand still, since no update would ever be solved to its
                // end.
                if !message.ends_gesture() {
                    break;
                }
                client.solves.cancel();
            }
            client.queued.pop_back();
        }
        if client.queued.is_empty() {
            return Some(message);
        }
        client.queued.push_back(message);
        None
    }

    /// Puts a client's message that waits for a solve at the front of its queue.
    pub(super) fn requeue_first(
        &mut self,
        id: ClientId,
        request: ClientRequest,
        queue_permit: Option<OwnedSemaphorePermit>,
    ) {
        if let Some(client) = self.clients.get_mut(&id) {
            client.queued.push_front(RoomMessage::Client { client: id, request, queue_permit });
        }
    }

    /// Takes up to a tick's worth of the clients' queues: the messages whose solves have ended, and the ones behind
    /// them.
    pub(super) fn take_resumable(&mut self) -> (Vec<RoomMessage>, Vec<RoomMessage>) {
        let (mut first, mut behind) = (Vec::new(), Vec::new());
        for client in self.clients.values_mut().filter(|client| client.can_resume()) {
            first.extend(client.queued.pop_front());
            behind.extend(client.queued.drain(..));
            if first.len() + behind.len() >= MAX_TICK_MESSAGES {
                break;
            }
        }
        (first, behind)
    }

    /// True if queued work can be carried out without a new message.
    pub(super) fn has_runnable_work(&self) -> bool {
        self.batches.iter().any(|batch| !batch.solves.is_pending())
            || self.clients.values().any(ConnectedClient::can_resume)
    }

    /// True if work is queued, whether it can be carried out or not.
    pub(super) fn has_queued_work(&self) -> bool {
        self.clients.values().any(|client| !client.queued.is_empty()) || !self.batches.is_empty()
    }
}
