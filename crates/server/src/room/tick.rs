//! What came in together is carried out and committed together; then it is told.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use std::vec;

use edit::{Actor, Record};
use protocol::{EditResult, EditResults, ErrorCode, GestureEnd, Problem, ServerMessage};
use store::Rejection;
use tokio::sync::mpsc;

use super::message::{Ask, ClientId, Message, Reply, Snapshot, Step};
use super::steps::{Answer, OperationKey, Outcomes};
use super::{Room, Surroundings};
use crate::ServerError;
use crate::limits::{MAX_TICK, MAX_TICK_CHANGES};

/// What has been done and is not committed yet.
#[derive(Default)]
pub(super) struct Tick {
    /// The state before the first request for a record, to go back to.
    pub before: Option<Box<(edit::Session, Surroundings)>>,
    pub records: Vec<Arc<Record>>,
    pub rejections: Vec<Rejection>,
    /// What became of this tick's operations in an earlier one, as the store knows it.
    pub earlier: Outcomes,
    /// What became of operations in this one.
    pub answers: HashMap<OperationKey, EditResult>,
    says: Vec<Say>,
    /// Who wants to know what undo and redo would take back.
    pub histories: BTreeSet<ClientId>,
    /// Whether a picture can show any of it.
    pub shows: bool,
}

/// What is told once all is on disk.
pub(super) enum Say {
    /// To every client.
    All(ServerMessage),
    /// To one.
    To(ClientId, ServerMessage),
    /// To every client: a record.
    Log(ServerMessage),
    /// A client's answer.
    Answer(ClientId, Answer),
    /// What has been done of a program's request: its answer, or the rest is to be done later.
    Batch(Batch),
}

/// A program's request for records.
pub(super) struct Batch {
    actor: Actor,
    /// What is left, in order.
    steps: vec::IntoIter<Step>,
    /// What became of those before this tick.
    done: Vec<EditResult>,
    /// What became of those in this tick.
    answers: Vec<Answer>,
    reply: Reply<EditResults>,
}

impl Tick {
    pub fn say(&mut self, say: Say) {
        self.says.push(say);
    }

    /// Whether what it holds is as much as may be in memory at once.
    fn is_full(&self) -> bool {
        self.records.iter().map(|record| record.changes.len()).sum::<usize>() >= MAX_TICK_CHANGES
    }
}

impl Room {
    /// Carries out a message and those that wait behind it, and some of what programs have asked for.
    pub(super) async fn tick(&mut self, first: Option<Message>, inbox: &mut mpsc::Receiver<Message>) {
        self.note_use();
        let waiting = std::iter::from_fn(|| inbox.try_recv().ok());
        let messages: Vec<Message> = first.into_iter().chain(waiting.take(MAX_TICK - 1)).collect();
        // Who comes or looks sees what is committed.
        let (mut now, mut afterwards) = (Vec::with_capacity(messages.len()), Vec::new());
        for message in messages {
            match message {
                Message::Edit { actor, steps, reply } => {
                    let (done, answers) = (Vec::with_capacity(steps.len()), Vec::new());
                    self.batches.push_back(Batch { actor, steps: steps.into_iter(), done, answers, reply });
                }
                Message::Ask { .. } | Message::Leave(_) => now.push(message),
                Message::Join(_) | Message::Look(_) | Message::Drain => afterwards.push(message),
            }
        }
        let mut tick = Tick { earlier: self.earlier_outcomes(&now).await, ..Tick::default() };
        for message in now {
            match message {
                Message::Ask { client, ask } => self.carry_out_ask(client, ask, &mut tick).await,
                Message::Leave(client) => self.leave(client, &mut tick),
                Message::Edit { .. } | Message::Join(_) | Message::Look(_) | Message::Drain => {}
            }
        }
        self.work_off(&mut tick).await;
        let histories = std::mem::take(&mut tick.histories);
        self.commit(tick).await;
        for client in histories {
            self.tell_history(client).await;
        }
        for message in afterwards {
            match message {
                Message::Join(join) => self.join(*join).await,
                Message::Look(reply) => drop(reply.send(Ok(self.snapshot()))),
                Message::Drain => self.drain(),
                Message::Ask { .. } | Message::Edit { .. } | Message::Leave(_) => {}
            }
        }
    }

    /// What became of the operations that are next, where they came before.
    async fn earlier_outcomes(&self, messages: &[Message]) -> Outcomes {
        let share = self.share_of_batch();
        let of_clients = messages.iter().filter_map(|message| match message {
            Message::Ask { client, ask: Ask::Step(step) } => Some((&self.clients.get(client)?.actor, step)),
            _ => None,
        });
        let of_batches = self
            .batches
            .iter()
            .flat_map(|batch| batch.steps.as_slice().iter().take(share).map(|step| (&batch.actor, step)));
        let operations = of_clients.chain(of_batches);
        let keys = operations.map(|(actor, step)| (actor.id.clone(), step.op_id.clone())).collect();
        self.outcomes(keys).await
    }

    /// How many steps of each program's request are carried out in a tick.
    fn share_of_batch(&self) -> usize {
        (MAX_TICK / self.batches.len().max(1)).max(1)
    }

    /// Carries out some of each program's request, as many steps as there is room for in a tick.
    async fn work_off(&mut self, tick: &mut Tick) {
        let share = self.share_of_batch();
        for mut batch in std::mem::take(&mut self.batches) {
            // One of each in any case, so that none waits for the end of another.
            for taken in 0..share {
                if taken > 0 && tick.is_full() {
                    break;
                }
                let Some(step) = batch.steps.next() else { break };
                batch.answers.push(self.take_step(step, &batch.actor, tick).await);
            }
            tick.say(Say::Batch(batch));
        }
    }

    async fn carry_out_ask(&mut self, client: ClientId, ask: Ask, tick: &mut Tick) {
        // One that was let go may have sent more before it knew.
        let Some(actor) = self.clients.get(&client).map(|client| client.actor.clone()) else { return };
        match ask {
            Ask::OpenView { camera, camera_revision, size } => {
                self.open_view(client, camera, camera_revision, size);
            }
            Ask::Follow(leader) => self.follow(client, leader),
            Ask::SetCamera { camera, camera_revision } => self.set_camera(client, camera, camera_revision),
            Ask::Resize(size) => self.resize_view(client, size),
            Ask::Ack(frame) => self.acknowledge(client, frame),
            Ask::Step(step) => {
                let answer = self.take_step(step, &actor, tick).await;
                tick.say(Say::Answer(client, answer));
            }
            Ask::BeginGesture { gesture, light, base_seq } => {
                self.begin_gesture(&gesture, light, base_seq, (client, &actor), tick);
            }
            Ask::UpdateGesture { gesture, update, command } => {
                self.update_gesture(&gesture, update, command, (client, &actor), tick);
            }
            Ask::CancelGesture(gesture) => self.cancel_gesture(&gesture, (client, &actor), tick),
            Ask::Select(light) => {
                if let Some(client) = self.clients.get_mut(&client) {
                    client.selection = light;
                    self.presence_changed = true;
                }
            }
            Ask::History => drop(tick.histories.insert(client)),
            Ask::Ping(sent) => {
                let server_time_us = self.backend.started.elapsed().as_micros() as u64;
                self.say_to(client, &ServerMessage::Pong { sent, server_time_us });
            }
            Ask::Nonsense(error) => self.complain_to(client, &error),
        }
    }

    /// Writes down what the tick came to and tells what it has to tell; or takes it back.
    pub(super) async fn commit(&mut self, mut tick: Tick) {
        let records: Vec<_> =
            std::mem::take(&mut tick.records).into_iter().map(Arc::unwrap_or_clone).collect();
        let rejections = std::mem::take(&mut tick.rejections);
        if !(records.is_empty() && rejections.is_empty()) {
            let hash = self.session.document().hash();
            let name = Arc::clone(&self.name);
            match self.backend.storage.append(name, records, rejections, hash).await {
                Ok(more) => self.tail += more,
                Err(error) => self.take_back(&mut tick, &error),
            }
        }
        self.utter(tick);
        self.keep_checkpoint().await;
    }

    /// The state before the tick, and other answers in place of its own. Nobody has seen the rest.
    ///
    /// Gestures stay as they are: those that were to be committed are over, and everybody is told why.
    fn take_back(&mut self, tick: &mut Tick, error: &ServerError) {
        if let Some((session, surroundings)) = tick.before.take().map(|before| *before) {
            self.session.go_back_to(session, &|_| None);
            self.surroundings = surroundings;
        }
        let says = std::mem::take(&mut tick.says).into_iter();
        tick.says = says
            .filter_map(|say| match say {
                Say::Log(_) => None,
                Say::All(ServerMessage::GestureState(mut state))
                    if state.ended == Some(GestureEnd::Committed) =>
                {
                    let Problem { code, message } = error.problem();
                    state.ended = Some(GestureEnd::Rejected);
                    (state.code, state.message) = (Some(code), Some(message));
                    Some(Say::All(ServerMessage::GestureState(state)))
                }
                Say::Answer(client, answer) => Some(Say::Answer(client, answer.taken_back(error))),
                Say::Batch(mut batch) => {
                    batch.answers =
                        batch.answers.into_iter().map(|answer| answer.taken_back(error)).collect();
                    Some(Say::Batch(batch))
                }
                Say::All(_) | Say::To(..) => Some(say),
            })
            .collect();
        tick.shows = true;
    }

    /// Tells what a tick has to tell. It has nothing to commit any more.
    pub(super) fn utter(&mut self, tick: Tick) {
        if tick.shows {
            self.touch_views();
        }
        for say in tick.says {
            match say {
                Say::Log(message) => self.say_to_all(&message, None),
                Say::All(message) => {
                    // Of a gesture its holder is told in any case: it is an answer.
                    let asker = match &message {
                        ServerMessage::GestureState(state) => Some(state.client),
                        _ => None,
                    };
                    self.say_to_all(&message, asker);
                }
                Say::To(client, message) => self.say_to(client, &message),
                Say::Answer(client, Answer { result, .. }) => {
                    self.count(&result);
                    self.say_to(client, &ServerMessage::EditResult(result));
                }
                Say::Batch(batch) => self.go_on_with(batch),
            }
        }
    }

    /// Answers a program, or puts what is left of its request back in line.
    fn go_on_with(&mut self, mut batch: Batch) {
        for Answer { result, .. } in batch.answers.drain(..) {
            self.count(&result);
            batch.done.push(result);
        }
        if batch.steps.len() > 0 {
            self.batches.push_back(batch);
            return;
        }
        let Batch { done: results, reply, .. } = batch;
        let hash = self.session.document().hash().to_string();
        // Whoever asked may have gone; it is done all the same.
        let _ = reply.send(Ok(EditResults { results, seq: self.session.seq(), hash }));
    }

    fn count(&self, result: &EditResult) {
        self.backend.metrics.count_edit(result.code.map_or("committed", ErrorCode::name));
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot {
            name: self.name.to_string(),
            epoch: self.epoch.clone(),
            seq: self.session.seq(),
            document: self.session.document().clone(),
            notes: Arc::clone(&self.surroundings.notes),
            lease: Arc::clone(&self.lease),
        }
    }
}

/// The time of day, in milliseconds since 1970.
pub(crate) fn time_ms() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_millis() as u64)
}
