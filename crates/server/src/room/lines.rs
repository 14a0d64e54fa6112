//! Who waits while a drag of a feature is solved off the session's task, or a light that is bent looks how far it reaches, and who
//! does not.
//!
//! What a client sends to edit is carried out in order, and so is a program's request. One whose next step waits for a solve
//! waits as a whole, a client's messages in its line; nobody else does, nor what the client sends besides. Once the solve has
//! ended the step is carried out with what came of it, if the document still is what that was found for.

use std::task::Poll;

use document::Command;
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
use crate::request::{
    ClientRequest, RecordAction, RecordRequest, RequestedCommand, RequestedEdit, needs_scene,
};

impl Room {
    /// The solution of a client's request; as [`Self::solution`].
    pub(super) fn solution_of(
        &mut self,
        request: &ClientRequest,
        actor: &Actor,
        solves: &mut SolveState,
        tick: &Tick,
    ) -> Poll<FoundSolution> {
        match request {
            ClientRequest::Step(step) => self.solution_of_step(step, (actor, None), solves, tick),
            ClientRequest::UpdateGesture { gesture, command: Ok(command), .. }
                if self.gesture_of(gesture, actor).is_some() =>
            {
                self.solution(command, (actor, None), solves)
            }
            _ => Poll::Ready(None),
        }
    }

    /// The solution of a step; as [`Self::solution`].
    pub(super) fn solution_of_step(
        &mut self,
        step: &RecordRequest,
        (actor, gone): (&Actor, Option<&CancellationToken>),
        solves: &mut SolveState,
        tick: &Tick,
    ) -> Poll<FoundSolution> {
        let Ok(asked) = &step.request else { return Poll::Ready(None) };
        // What came before is not carried out.
        if tick.earlier_outcome(&step.op_id, actor).is_some() {
            return Poll::Ready(None);
        }
        let of_gesture;
        let command = match asked {
            RecordAction::Edit(RequestedEdit { command: RequestedCommand::Command(command), .. }) => {
                Some(command)
            }
            RecordAction::Group(edits) => return self.solution_of_group(edits, (actor, gone), solves),
            RecordAction::Commit(id) => {
                of_gesture = self.gesture_of(id, actor).and_then(|gesture| gesture.command);
                // A light that is bent was solved for when it was: nothing is left out of the command.
                of_gesture.as_ref().filter(|command| !matches!(command, Command::BendLight { .. }))
            }
            RecordAction::Edit(_) | RecordAction::Undo(_) | RecordAction::Redo(_) => None,
        };
        match command {
            Some(command) => self.solution(command, (actor, gone), solves),
            None => Poll::Ready(None),
        }
    }

    /// The edits of a group with what the scene says of them; as [`Self::solution`].
    fn solution_of_group(
        &mut self,
        edits: &[RequestedEdit],
        asker: (&Actor, Option<&CancellationToken>),
        solves: &mut SolveState,
    ) -> Poll<FoundSolution> {
        let reach = self.scene.decoded.posed.bounds();
        match solves.take_group_solution(edits, self.session.document(), reach) {
            Poll::Pending => self.begin_solve(|| SolveTask::Group(edits.to_vec()), asker, solves),
            found @ Poll::Ready(_) => found,
        }
    }

    /// The solution of a command that needs one. Where that is not known it is solved beside the session's task, and pending
    /// until that has ended or the actor is `gone`. Where others keep changing what it depends on, it is refused.
    pub(super) fn solution(
        &mut self,
        command: &Command,
        (actor, gone): (&Actor, Option<&CancellationToken>),
        solves: &mut SolveState,
    ) -> Poll<FoundSolution> {
        if !needs_scene(command) {
            return Poll::Ready(None);
        }
        let document = self.session.document();
        if let Some(found) = solves.take_solution(command, document) {
            return Poll::Ready(Some(found));
        }
        self.begin_solve(|| SolveTask::Command(Box::new(command.clone())), (actor, gone), solves)
    }

    /// Has something solved that is waited for, unless it was too often.
    fn begin_solve(
        &mut self,
        what: impl FnOnce() -> SolveTask,
        (actor, gone): (&Actor, Option<&CancellationToken>),
        solves: &mut SolveState,
    ) -> Poll<FoundSolution> {
        if !solves.can_retry() {
            solves.cancel();
            return Poll::Ready(Some(Err(ServerError::TooManySolveRetries(MAX_SOLVE_TRIES))));
        }
        let (what, document) = (what(), self.session.document().clone());
        let (scene, solver) = (self.scene.decoded.clone(), self.backend.solver.clone());
        let payer = Payer::new(&self.name, &actor.id);
        let gone = gone.cloned().unwrap_or_default();
        solves.begin(self.solving.spawn(async move {
            tokio::select! {
                solved = solve(what, document, scene, (&solver, payer)) => solved,
                () = gone.cancelled() => Err(ServerError::Internal),
            }
        }));
        Poll::Pending
    }

    /// Keeps what a solve has come to for whoever waits for it, who goes on in the next tick.
    pub(super) fn finish_solve(
        &mut self,
        ended: Result<(Id, Result<Vec<SolvedCommand>, ServerError>), JoinError>,
    ) {
        let task = ended.as_ref().map_or_else(JoinError::id, |(id, _)| *id);
        let of_clients = self.clients.values_mut().map(|client| &mut client.solves);
        let mut all = of_clients.chain(self.batches.iter_mut().map(|batch| &mut batch.solves));
        // Who waited may have given it up.
        let Some(solves) = all.find(|solves| solves.is_waiting_for(task)) else { return };
        solves.end(ended.map_or(Err(ServerError::Internal), |(_, solved)| solved));
    }

    /// Gives back a client's message that can be carried out now. One that edits waits while others of that client do.
    pub(super) fn take_or_queue(&mut self, message: RoomMessage) -> Option<RoomMessage> {
        let Some(client) = message.editing_client().and_then(|id| self.clients.get_mut(&id)) else {
            return Some(message);
        };
        if matches!(message, RoomMessage::Leave(_)) {
            client.discard_uncommitted();
        }
        while let Some(last) = client.queued.back()
            && message.supersedes(last)
        {
            if client.queued.len() == 1 {
                // The picture would stand still if no update ever came to its end.
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

    /// A client's message that waits for a solve, and which others of that client now wait for.
    pub(super) fn requeue_first(
        &mut self,
        id: ClientId,
        request: ClientRequest,
        place: Option<OwnedSemaphorePermit>,
    ) {
        if let Some(client) = self.clients.get_mut(&id) {
            client.queued.push_front(RoomMessage::Client { client: id, request, queue_permit: place });
        }
    }

    /// What of the clients' lines goes on, a tick's worth: the messages whose drags were solved, and those behind them.
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

    /// Whether something can be carried out though no message has come.
    pub(super) fn has_runnable_work(&self) -> bool {
        self.batches.iter().any(|batch| !batch.solves.is_pending())
            || self.clients.values().any(ConnectedClient::can_resume)
    }

    /// Whether there is anything to do but what messages may ask for.
    pub(super) fn has_queued_work(&self) -> bool {
        self.clients.values().any(|client| !client.queued.is_empty()) || !self.batches.is_empty()
    }
}
