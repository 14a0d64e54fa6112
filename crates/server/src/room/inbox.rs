//! Messages of a tick: taken from the inbox and carried out in order.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::task::Poll;

use document::Document;
use protocol::ServerMessage;
use tokio::sync::{OwnedSemaphorePermit, mpsc};

use super::Room;
use super::message::{RoomMessage, SessionSnapshot};
use super::queues::Asker;
use super::solving::{SolveState, with_solution};
use super::tick::{EarlierOutcomes, Outgoing, RequestBatch, Tick};
use crate::ServerError;
use crate::limits::MAX_TICK_MESSAGES;
use crate::outboxes::ClientId;
use crate::request::ClientRequest;

/// Removes updates of drags that are solved and that the client's next editing message supersedes. A solve takes longer
/// than the time between updates, so the picture would fall behind the cursor.
fn drop_superseded_drags(messages: &mut Vec<RoomMessage>, document: &Document) {
    let mut latest: BTreeMap<ClientId, usize> = BTreeMap::new();
    let mut superseded = vec![false; messages.len()];
    for (number, message) in messages.iter().enumerate() {
        let before = message.editing_client().and_then(|client| latest.insert(client, number));
        if let Some(before) = before {
            superseded[before] = message.supersedes(&messages[before], document);
        }
    }
    let mut superseded = superseded.into_iter();
    messages.retain(|_| !superseded.next().unwrap_or_default());
}

impl Room {
    /// Carries out a message, the messages waiting in the inbox, those whose solves have ended, and some steps of
    /// programs' requests.
    pub(super) async fn tick(&mut self, first: Option<RoomMessage>, inbox: &mut mpsc::Receiver<RoomMessage>) {
        self.mark_used();
        let (mut now, mut behind) = self.take_resumable();
        let room_for = (MAX_TICK_MESSAGES - 1).saturating_sub(now.len() + behind.len());
        let waiting = std::iter::from_fn(|| inbox.try_recv().ok());
        let messages: Vec<RoomMessage> = first.into_iter().chain(waiting.take(room_for)).collect();
        // New clients and snapshots get the committed state.
        let mut afterwards = Vec::new();
        for message in messages {
            match message {
                RoomMessage::Edit { principal, steps, reply, cancellation } => {
                    tracing::debug!("{} steps in session {} by {principal}", steps.len(), self.name);
                    let (done, answers) = (Vec::with_capacity(steps.len()), Vec::new());
                    let (steps, solves) = (steps.into_iter(), SolveState::default());
                    let batch = RequestBatch { principal, steps, done, answers, solves, reply, cancellation };
                    self.batches.push_back(batch);
                }
                RoomMessage::Client { .. } | RoomMessage::Leave(_) => behind.push(message),
                _ => afterwards.push(message),
            }
        }
        // A solved update is shown even if a newer one has come. Otherwise a slow drag would never be shown.
        drop_superseded_drags(&mut behind, self.session.document());
        now.append(&mut behind);
        let mut tick = Tick { earlier_outcomes: self.earlier_outcomes(&now).await, ..Tick::default() };
        for message in now {
            let Some(message) = self.take_or_queue(message) else { continue };
            match message {
                RoomMessage::Client { client, request, queue_permit } => {
                    self.handle(client, request, queue_permit, &mut tick).await;
                }
                RoomMessage::Leave(client) => self.leave(client, &mut tick),
                _ => {}
            }
        }
        self.run_batches(&mut tick).await;
        let history_requests = std::mem::take(&mut tick.history_requests);
        self.commit(tick).await;
        for client in history_requests {
            self.send_history(client).await;
        }
        for message in afterwards {
            match message {
                RoomMessage::Join(join) => self.join(*join).await,
                RoomMessage::Snapshot(reply) => drop(reply.send(Ok(self.snapshot()))),
                RoomMessage::Changed { title, archived } => {
                    self.outboxes.broadcast(&ServerMessage::SessionChanged { title, archived }, None);
                }
                RoomMessage::Drain => self.drain(),
                _ => {}
            }
        }
    }

    /// Reads the outcomes of the next operations that came before.
    async fn earlier_outcomes(&self, messages: &[RoomMessage]) -> EarlierOutcomes {
        let share = self.steps_per_batch();
        let of_clients = messages.iter().filter_map(|message| match message {
            RoomMessage::Client { client, request: ClientRequest::Step(step), .. } => {
                Some((&self.clients.get(client)?.principal, step))
            }
            _ => None,
        });
        let runnable = self.batches.iter().filter(|batch| !batch.solves.is_pending());
        let document = self.session.document();
        let of_batches =
            runnable.flat_map(|batch| batch.next_steps(share, document).iter().map(|step| (&batch.principal, step)));
        let operations = of_clients.chain(of_batches);
        let keys = operations.map(|(principal, step)| (principal.actor.id.clone(), step.op_id.clone())).collect();
        self.outcomes(keys).await
    }

    /// Returns the number of steps of each program's request in a tick.
    fn steps_per_batch(&self) -> usize {
        let runnable = self.batches.iter().filter(|batch| !batch.solves.is_pending()).count();
        (MAX_TICK_MESSAGES / runnable.max(1)).max(1)
    }

    /// Carries out steps of each program's request, as many as the tick has room for.
    async fn run_batches(&mut self, tick: &mut Tick) {
        let share = self.steps_per_batch();
        for mut batch in std::mem::take(&mut self.batches) {
            if batch.solves.is_pending() {
                self.batches.push_back(batch);
                continue;
            }
            batch.drop_unawaited_solves(self.session.document());
            // At least one step of each, so no request waits for the end of another.
            for taken in 0..batch.next_steps(share, self.session.document()).len() {
                if taken > 0 && tick.is_full() {
                    break;
                }
                // The step stays in the queue until it can be carried out.
                let Some(step) = batch.steps.as_slice().first() else { break };
                let asker = Asker { actor: &batch.principal.actor, cancellation: Some(&batch.cancellation) };
                let solution = self.solution_of_step(step, asker, &mut batch.solves, tick);
                let Poll::Ready(found) = solution else { break };
                let Some(step) = batch.steps.next() else { break };
                batch.answers.push(self.run_step(step, found, &batch.principal, tick).await);
            }
            tick.send(Outgoing::Batch(batch));
        }
    }

    async fn handle(
        &mut self,
        client: ClientId,
        request: ClientRequest,
        queue_permit: Option<OwnedSemaphorePermit>,
        tick: &mut Tick,
    ) {
        // A removed client may have sent more messages before it learned of its removal.
        let Some(sender) = self.clients.get_mut(&client) else { return };
        let (principal, mut solves) = (sender.principal.clone(), std::mem::take(&mut sender.solves));
        let solution = self.solution_of(&request, &principal.actor, &mut solves, tick);
        if let Some(sender) = self.clients.get_mut(&client) {
            sender.solves = solves;
        }
        let Poll::Ready(found) = solution else { return self.requeue_first(client, request, queue_permit) };
        let actor = &principal.actor;
        if request.is_interactive() {
            self.views.mark_interactive(client);
        }
        match request {
            ClientRequest::OpenView { parameters, stats } => {
                self.views.open(client, parameters);
                self.views.set_stats(client, stats);
                self.presence_changed = true;
            }
            ClientRequest::Follow { leader, stats } => {
                let followed = self.views.follow(client, leader);
                if followed.is_ok() {
                    self.views.set_stats(client, stats);
                }
                self.note_view(client, followed);
            }
            ClientRequest::SetCamera { camera, camera_revision } => {
                let changed = self.views.change(client, |view| {
                    (view.camera, view.camera_revision) = (camera, camera_revision);
                });
                self.note_view(client, changed);
            }
            ClientRequest::SetView { settings, stats, camera_revision } => {
                let changed = self.views.change(client, |view| {
                    (view.settings, view.camera_revision) = (settings, camera_revision);
                });
                if let (Ok(()), Some(stats)) = (&changed, stats) {
                    self.views.set_stats(client, stats);
                }
                self.note_view(client, changed);
            }
            ClientRequest::Resize(size) => self.views.resize(client, size),
            ClientRequest::Ack(frame) => self.views.acknowledge(client, frame),
            ClientRequest::RequestKeyFrame(frame) => self.views.request_key_frame(client, frame),
            ClientRequest::Step(step) => {
                let answer = self.run_step(step, found, &principal, tick).await;
                tick.send(Outgoing::Answer(client, answer));
            }
            ClientRequest::BeginGesture { gesture, light, base_seq } => {
                self.begin_gesture(&gesture, light, base_seq, client, actor, tick);
            }
            ClientRequest::UpdateGesture { gesture, update, command } => {
                let command = command.and_then(|command| with_solution(command, found));
                self.update_gesture(&gesture, update, command, client, actor, tick);
            }
            ClientRequest::CancelGesture(gesture) => self.cancel_gesture(&gesture, client, actor, tick),
            ClientRequest::Select(light) => {
                if let Some(client) = self.clients.get_mut(&client) {
                    client.selection = light;
                    self.presence_changed = true;
                }
            }
            ClientRequest::History => drop(tick.history_requests.insert(client)),
            ClientRequest::Probe(question) => self.ask(client, question),
            ClientRequest::Ping(sent) => {
                let server_time_us = self.services.started.elapsed().as_micros() as u64;
                self.outboxes.send(client, &ServerMessage::Pong { sent, server_time_us });
            }
            ClientRequest::Invalid(error) => self.outboxes.send_error(client, &error),
        }
    }

    /// Notes a changed view, or sends its client the error.
    fn note_view(&mut self, client: ClientId, changed: Result<(), ServerError>) {
        match changed {
            Ok(()) => self.presence_changed = true,
            Err(error) => self.outboxes.send_error(client, &error),
        }
    }

    fn snapshot(&mut self) -> SessionSnapshot {
        SessionSnapshot {
            name: self.name.to_string(),
            epoch: self.epoch.clone(),
            seq: self.session.seq(),
            document: self.session.document().clone(),
            text: self.document_text(),
            scene: self.scene.decoded.clone(),
            lease: Arc::clone(&self.lease),
        }
    }
}
