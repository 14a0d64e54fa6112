//! The messages of a tick: taken from the inbox, and carried out in order.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::task::Poll;

use protocol::ServerMessage;
use tokio::sync::{OwnedSemaphorePermit, mpsc};

use super::Room;
use super::message::{Message, Snapshot};
use super::tick::{Batch, EarlierOutcomes, Outgoing, Tick};
use crate::ServerError;
use crate::limits::MAX_TICK;
use crate::outboxes::ClientId;
use crate::request::ClientRequest;

/// Takes out the updates of feature drags of which the client's next message that edits leaves nothing: to solve them takes
/// longer than they may come apart, and the picture would fall behind the cursor.
fn pass_over_outrun_drags(messages: &mut Vec<Message>) {
    let mut latest: BTreeMap<ClientId, usize> = BTreeMap::new();
    let mut outrun = vec![false; messages.len()];
    for (number, message) in messages.iter().enumerate() {
        let before = message.editor().and_then(|client| latest.insert(client, number));
        if let Some(before) = before {
            outrun[before] = message.outruns(&messages[before]);
        }
    }
    let mut outrun = outrun.into_iter();
    messages.retain(|_| !outrun.next().unwrap_or_default());
}

impl Room {
    /// Carries out a message and those that wait behind it, what has waited for solves, and some of what programs have asked for.
    pub(super) async fn tick(&mut self, first: Option<Message>, inbox: &mut mpsc::Receiver<Message>) {
        self.note_use();
        let (mut now, mut behind) = self.released();
        let room_for = (MAX_TICK - 1).saturating_sub(now.len() + behind.len());
        let waiting = std::iter::from_fn(|| inbox.try_recv().ok());
        let messages: Vec<Message> = first.into_iter().chain(waiting.take(room_for)).collect();
        // Who comes, or wants to see the session, sees what is committed.
        let mut afterwards = Vec::new();
        for message in messages {
            match message {
                Message::Edit { principal, steps, reply, gone } => {
                    tracing::debug!("{} steps in session {} by {principal}", steps.len(), self.name);
                    self.batches.push_back(Batch::new(principal, steps, (reply, gone)));
                }
                Message::Client { .. } | Message::Leave(_) => behind.push(message),
                Message::Join(_) | Message::Snapshot(_) | Message::Changed { .. } | Message::Drain => {
                    afterwards.push(message);
                }
            }
        }
        // What was solved is shown, even if it is outrun by now: else a slow drag never would be.
        pass_over_outrun_drags(&mut behind);
        now.append(&mut behind);
        let mut tick = Tick { earlier: self.earlier_outcomes(&now).await, ..Tick::default() };
        for message in now {
            let Some(message) = self.next_in_line(message) else { continue };
            match message {
                Message::Client { client, request, place } => {
                    self.handle(client, request, place, &mut tick).await;
                }
                Message::Leave(client) => self.leave(client, &mut tick),
                Message::Edit { .. }
                | Message::Join(_)
                | Message::Snapshot(_)
                | Message::Changed { .. }
                | Message::Drain => {}
            }
        }
        self.carry_out_batches(&mut tick).await;
        let history_requests = std::mem::take(&mut tick.history_requests);
        self.commit(tick).await;
        for client in history_requests {
            self.send_history(client).await;
        }
        for message in afterwards {
            match message {
                Message::Join(join) => self.join(*join).await,
                Message::Snapshot(reply) => drop(reply.send(Ok(self.snapshot()))),
                Message::Changed { title, archived } => {
                    self.outboxes.broadcast(&ServerMessage::SessionChanged { title, archived }, None);
                }
                Message::Drain => self.drain(),
                Message::Client { .. } | Message::Edit { .. } | Message::Leave(_) => {}
            }
        }
    }

    /// What became of the operations that are next, where they came before.
    async fn earlier_outcomes(&self, messages: &[Message]) -> EarlierOutcomes {
        let share = self.share_of_batch();
        let of_clients = messages.iter().filter_map(|message| match message {
            Message::Client { client, request: ClientRequest::Step(step), .. } => {
                Some((&self.clients.get(client)?.principal, step))
            }
            _ => None,
        });
        let going_on = self.batches.iter().filter(|batch| !batch.solves.are_under_way());
        let of_batches =
            going_on.flat_map(|batch| batch.next_steps(share).iter().map(|step| (&batch.principal, step)));
        let operations = of_clients.chain(of_batches);
        let keys =
            operations.map(|(principal, step)| (principal.actor.id.clone(), step.op_id.clone())).collect();
        self.outcomes(keys).await
    }

    /// How many steps of each program's request are carried out in a tick.
    fn share_of_batch(&self) -> usize {
        let going_on = self.batches.iter().filter(|batch| !batch.solves.are_under_way()).count();
        (MAX_TICK / going_on.max(1)).max(1)
    }

    /// Carries out some of each program's request, as many steps as there is room for in a tick.
    async fn carry_out_batches(&mut self, tick: &mut Tick) {
        let share = self.share_of_batch();
        for mut batch in std::mem::take(&mut self.batches) {
            if batch.solves.are_under_way() {
                self.batches.push_back(batch);
                continue;
            }
            batch.give_up_solves();
            // One of each in any case, so that none waits for the end of another.
            for taken in 0..batch.next_steps(share).len() {
                if taken > 0 && tick.is_full() {
                    break;
                }
                // Only once it can be carried out is it taken.
                let Some(step) = batch.steps.as_slice().first() else { break };
                let asker = (&batch.principal.actor, Some(&batch.gone));
                let solution = self.solution_of_step(step, asker, &mut batch.solves, tick);
                let Poll::Ready(found) = solution else { break };
                let Some(step) = batch.steps.next() else { break };
                batch.answers.push(self.take_step(step, found, &batch.principal, tick).await);
            }
            tick.send(Outgoing::Batch(batch));
        }
    }

    async fn handle(
        &mut self,
        client: ClientId,
        request: ClientRequest,
        place: Option<OwnedSemaphorePermit>,
        tick: &mut Tick,
    ) {
        // One that was let go may have sent more before it knew.
        let Some(sender) = self.clients.get_mut(&client) else { return };
        let (principal, mut solves) = (sender.principal.clone(), std::mem::take(&mut sender.solves));
        let solution = self.solution_of(&request, &principal.actor, &mut solves, tick);
        if let Some(sender) = self.clients.get_mut(&client) {
            sender.solves = solves;
        }
        let Poll::Ready(found) = solution else { return self.wait_in_line(client, request, place) };
        let holder = (client, &principal.actor);
        if request.is_of_a_hand() {
            self.views.note_hand(client);
        }
        match request {
            ClientRequest::OpenView { camera, camera_revision, settings, interaction, stats, size } => {
                self.views.open(client, (camera, camera_revision), (settings, interaction), size);
                self.views.tell_stats(client, stats);
                self.presence_changed = true;
            }
            ClientRequest::Follow { leader, stats } => {
                let followed = self.views.follow(client, leader);
                if followed.is_ok() {
                    self.views.tell_stats(client, stats);
                }
                self.note_view(client, followed);
            }
            ClientRequest::SetCamera { camera, camera_revision } => {
                let moved = self.views.set_camera(client, camera, camera_revision);
                self.note_view(client, moved);
            }
            ClientRequest::SetView { settings, stats, camera_revision } => {
                let changed = self.views.set_settings(client, settings, camera_revision);
                if let (Ok(()), Some(stats)) = (&changed, stats) {
                    self.views.tell_stats(client, stats);
                }
                self.note_view(client, changed);
            }
            ClientRequest::Resize(size) => self.views.resize(client, size),
            ClientRequest::Ack(frame) => self.views.acknowledge(client, frame),
            ClientRequest::RequestKeyFrame(frame) => self.views.request_key_frame(client, frame),
            ClientRequest::Step(step) => {
                let answer = self.take_step(step, found, &principal, tick).await;
                tick.send(Outgoing::Answer(client, answer));
            }
            ClientRequest::BeginGesture { gesture, light, base_seq } => {
                self.begin_gesture(&gesture, light, base_seq, holder, tick);
            }
            ClientRequest::UpdateGesture { gesture, update, command } => {
                self.update_gesture(&gesture, update, (command, found), holder, tick);
            }
            ClientRequest::CancelGesture(gesture) => self.cancel_gesture(&gesture, holder, tick),
            ClientRequest::Select(light) => {
                if let Some(client) = self.clients.get_mut(&client) {
                    client.selection = light;
                    self.presence_changed = true;
                }
            }
            ClientRequest::History => drop(tick.history_requests.insert(client)),
            ClientRequest::Probe(question) => self.ask(client, question),
            ClientRequest::Ping(sent) => {
                let server_time_us = self.backend.started.elapsed().as_micros() as u64;
                self.outboxes.send(client, &ServerMessage::Pong { sent, server_time_us });
            }
            ClientRequest::Invalid(error) => self.outboxes.send_error(client, &error),
        }
    }

    /// A client's view has changed, or it is told why not.
    fn note_view(&mut self, client: ClientId, changed: Result<(), ServerError>) {
        match changed {
            Ok(()) => self.presence_changed = true,
            Err(error) => self.outboxes.send_error(client, &error),
        }
    }

    fn snapshot(&mut self) -> Snapshot {
        Snapshot {
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
