//! The messages of a tick: taken from the inbox, and carried out in order.

use std::collections::BTreeMap;
use std::sync::Arc;

use document::Command;
use protocol::ServerMessage;
use tokio::sync::mpsc;

use super::Room;
use super::message::{Message, Snapshot};
use super::tick::{Batch, EarlierOutcomes, Outgoing, Tick};
use crate::ServerError;
use crate::limits::MAX_TICK;
use crate::outboxes::ClientId;
use crate::request::ClientRequest;

/// Takes out the updates of feature drags after which the client's next message updates the same gesture again: to solve them
/// takes longer than they may come apart, and the picture would fall behind the cursor.
fn pass_over_outrun_drags(messages: &mut Vec<Message>) {
    // From the last to the first: the gesture that each client's next message updates.
    let mut next: BTreeMap<ClientId, Option<String>> = BTreeMap::new();
    messages.reverse();
    messages.retain(|message| {
        let Message::Client { client, request } = message else { return true };
        let ClientRequest::UpdateGesture { gesture, command, .. } = request else {
            next.insert(*client, None);
            return true;
        };
        let following = next.insert(*client, Some(gesture.clone())).flatten();
        !(matches!(command, Ok(Command::DragFeature { .. })) && following.as_ref() == Some(gesture))
    });
    messages.reverse();
}

impl Room {
    /// Carries out a message and those that wait behind it, and some of what programs have asked for.
    pub(super) async fn tick(&mut self, first: Option<Message>, inbox: &mut mpsc::Receiver<Message>) {
        self.note_use();
        let waiting = std::iter::from_fn(|| inbox.try_recv().ok());
        let messages: Vec<Message> = first.into_iter().chain(waiting.take(MAX_TICK - 1)).collect();
        // Who comes, or wants to see the session, sees what is committed.
        let (mut now, mut afterwards) = (Vec::with_capacity(messages.len()), Vec::new());
        for message in messages {
            match message {
                Message::Edit { principal, steps, reply } => {
                    tracing::debug!("{} steps in session {} by {principal}", steps.len(), self.name);
                    self.batches.push_back(Batch::new(principal, steps, reply));
                }
                Message::Client { .. } | Message::Leave(_) => now.push(message),
                Message::Join(_) | Message::Snapshot(_) | Message::Drain => afterwards.push(message),
            }
        }
        pass_over_outrun_drags(&mut now);
        let mut tick = Tick { earlier: self.earlier_outcomes(&now).await, ..Tick::default() };
        for message in now {
            match message {
                Message::Client { client, request } => self.handle(client, request, &mut tick).await,
                Message::Leave(client) => self.leave(client, &mut tick),
                Message::Edit { .. } | Message::Join(_) | Message::Snapshot(_) | Message::Drain => {}
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
                Message::Drain => self.drain(),
                Message::Client { .. } | Message::Edit { .. } | Message::Leave(_) => {}
            }
        }
    }

    /// What became of the operations that are next, where they came before.
    async fn earlier_outcomes(&self, messages: &[Message]) -> EarlierOutcomes {
        let share = self.share_of_batch();
        let of_clients = messages.iter().filter_map(|message| match message {
            Message::Client { client, request: ClientRequest::Step(step) } => {
                Some((&self.clients.get(client)?.principal, step))
            }
            _ => None,
        });
        let of_batches = self
            .batches
            .iter()
            .flat_map(|batch| batch.steps.as_slice().iter().take(share).map(|step| (&batch.principal, step)));
        let operations = of_clients.chain(of_batches);
        let keys =
            operations.map(|(principal, step)| (principal.actor.id.clone(), step.op_id.clone())).collect();
        self.outcomes(keys).await
    }

    /// How many steps of each program's request are carried out in a tick.
    fn share_of_batch(&self) -> usize {
        (MAX_TICK / self.batches.len().max(1)).max(1)
    }

    /// Carries out some of each program's request, as many steps as there is room for in a tick.
    async fn carry_out_batches(&mut self, tick: &mut Tick) {
        let share = self.share_of_batch();
        for mut batch in std::mem::take(&mut self.batches) {
            // One of each in any case, so that none waits for the end of another.
            for taken in 0..share {
                if taken > 0 && tick.is_full() {
                    break;
                }
                let Some(step) = batch.steps.next() else { break };
                batch.answers.push(self.take_step(step, &batch.principal, tick).await);
            }
            tick.send(Outgoing::Batch(batch));
        }
    }

    async fn handle(&mut self, client: ClientId, request: ClientRequest, tick: &mut Tick) {
        // One that was let go may have sent more before it knew.
        let Some(principal) = self.clients.get(&client).map(|client| client.principal.clone()) else {
            return;
        };
        let holder = (client, &principal.actor);
        match request {
            ClientRequest::OpenView { camera, camera_revision, settings, size } => {
                self.views.open(client, (camera, camera_revision), settings, size);
                self.presence_changed = true;
            }
            ClientRequest::Follow(leader) => {
                let followed = self.views.follow(client, leader);
                self.note_view(client, followed);
            }
            ClientRequest::SetCamera { camera, camera_revision } => {
                let moved = self.views.set_camera(client, camera, camera_revision);
                self.note_view(client, moved);
            }
            ClientRequest::SetView { settings, camera_revision } => {
                let changed = self.views.set_settings(client, settings, camera_revision);
                self.note_view(client, changed);
            }
            ClientRequest::Resize(size) => self.views.resize(client, size),
            ClientRequest::Ack(frame) => self.views.acknowledge(client, frame),
            ClientRequest::Step(step) => {
                let answer = self.take_step(step, &principal, tick).await;
                tick.send(Outgoing::Answer(client, answer));
            }
            ClientRequest::BeginGesture { gesture, light, base_seq } => {
                self.begin_gesture(&gesture, light, base_seq, holder, tick);
            }
            ClientRequest::UpdateGesture { gesture, update, command } => {
                self.update_gesture(&gesture, update, command, holder, tick).await;
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

    fn snapshot(&self) -> Snapshot {
        Snapshot {
            name: self.name.to_string(),
            epoch: self.epoch.clone(),
            seq: self.session.seq(),
            document: self.session.document().clone(),
            scene: self.scene.decoded.clone(),
            lease: Arc::clone(&self.lease),
        }
    }
}
