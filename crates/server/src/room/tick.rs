//! What came in together is carried out and committed together; then it is told.

use std::cell::Cell;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use std::vec;

use edit::{Actor, Committed, Record, Request};
use protocol::{EditResult, EditResults, EditStatus, GestureEnd, ServerMessage};
use scene::{AssetHash, Change, Command, Scene};
use tokio::sync::mpsc;

use super::message::{Ask, ClientId, Message, Reply, Snapshot, Step};
use super::{Room, Surroundings};
use crate::ServerError;
use crate::limits::MAX_TICK;

/// What has been done and is not committed yet.
#[derive(Default)]
pub(super) struct Tick {
    /// The state before the first request for a record, to go back to.
    before: Option<Box<(edit::Session, Surroundings)>>,
    records: Vec<Record>,
    says: Vec<Say>,
    /// Whether a picture can show any of it.
    pub shows: bool,
}

/// What is told once all is on disk.
pub(super) enum Say {
    /// To every client.
    All(ServerMessage),
    /// To one.
    To(ClientId, ServerMessage),
    /// A client's answer.
    Result(ClientId, EditResult),
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
    results: Vec<EditResult>,
    reply: Reply<EditResults>,
}

impl Tick {
    pub fn say(&mut self, say: Say) {
        self.says.push(say);
    }
}

/// What became of a step that was carried out.
struct Outcome {
    status: EditStatus,
    seq: u64,
    skipped: Vec<String>,
}

impl Room {
    /// Carries out a message and those that wait behind it, and some of what programs have asked for.
    pub(super) async fn tick(&mut self, first: Option<Message>, inbox: &mut mpsc::Receiver<Message>) {
        self.note_use();
        let waiting = std::iter::from_fn(|| inbox.try_recv().ok());
        let messages: Vec<Message> = first.into_iter().chain(waiting.take(MAX_TICK - 1)).collect();
        let mut tick = Tick::default();
        // Who comes or looks sees what is committed.
        let mut afterwards = Vec::new();
        for message in messages {
            match message {
                Message::Ask { client, ask } => self.carry_out_ask(client, ask, &mut tick).await,
                Message::Edit { actor, steps, reply } => {
                    let (done, results) = (Vec::with_capacity(steps.len()), Vec::new());
                    self.batches.push_back(Batch { actor, steps: steps.into_iter(), done, results, reply });
                }
                Message::Leave(client) => self.leave(client, &mut tick),
                Message::Join(_) | Message::Look(_) | Message::Drain => afterwards.push(message),
            }
        }
        self.work_off(&mut tick).await;
        self.commit(tick).await;
        for message in afterwards {
            match message {
                Message::Join(join) => self.join(*join).await,
                Message::Look(reply) => drop(reply.send(Ok(self.snapshot()))),
                Message::Drain => self.drain(),
                Message::Ask { .. } | Message::Edit { .. } | Message::Leave(_) => {}
            }
        }
    }

    /// Carries out some of each program's request, as many steps as there is room for in a tick.
    async fn work_off(&mut self, tick: &mut Tick) {
        let batches = std::mem::take(&mut self.batches);
        let share = (MAX_TICK / batches.len().max(1)).max(1);
        for mut batch in batches {
            for step in batch.steps.by_ref().take(share) {
                batch.results.push(self.take_step(step, &batch.actor, tick).await);
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
                let result = self.take_step(step, &actor, tick).await;
                tick.say(Say::Result(client, result));
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
            Ask::Ping(sent) => {
                let server_time_us = self.backend.started.elapsed().as_micros() as u64;
                self.say_to(client, &ServerMessage::Pong { sent, server_time_us });
            }
            Ask::Nonsense(error) => self.complain_to(client, &error),
        }
    }

    /// Carries out a request for a record; its answer, to be told once the tick is committed.
    async fn take_step(&mut self, step: Step, actor: &Actor, tick: &mut Tick) -> EditResult {
        let Step { op_id, request } = step;
        let outcome = match request {
            Ok(request) => self.carry_out(request, actor, &op_id, tick).await,
            Err(error) => Err(error),
        };
        match outcome {
            Ok(Outcome { status, seq, skipped }) => {
                EditResult { op_id, status, seq: Some(seq), skipped, code: None, message: None }
            }
            Err(error) => rejected(op_id, &error),
        }
    }

    async fn carry_out(
        &mut self,
        request: Request,
        actor: &Actor,
        op_id: &str,
        tick: &mut Tick,
    ) -> Result<Outcome, ServerError> {
        let scenes = self.scenes_of(&request, actor, op_id).await?;
        let held = match &request {
            Request::Commit(id) => self.gesture_of(id, actor),
            Request::Edit { .. } | Request::Undo(_) | Request::Redo(_) => None,
        };
        tick.before.get_or_insert_with(|| Box::new((self.session.clone(), self.surroundings.clone())));
        let committed = self.session.request(request, actor, op_id, time_ms(), &|asset| find(&scenes, asset));
        // A gesture whose commit is refused has ended all the same.
        let ended = held.filter(|held| self.gesture_of(&held.id, actor).is_none());
        match committed {
            Ok(Committed::Before(seq)) => {
                Ok(Outcome { status: EditStatus::Committed, seq, skipped: Vec::new() })
            }
            Ok(Committed::New { record, rebased }) => {
                let outcome = Outcome {
                    status: if rebased { EditStatus::Rebased } else { EditStatus::Committed },
                    seq: record.seq,
                    skipped: record.action.skipped().to_vec(),
                };
                self.log(*record, tick).await;
                if let Some(gesture) = ended {
                    self.end_gesture(gesture, GestureEnd::Committed, None, tick);
                }
                Ok(outcome)
            }
            Err(refusal) => {
                let error = ServerError::from(refusal);
                if let Some(gesture) = ended {
                    self.end_gesture(gesture, GestureEnd::Rejected, Some(error.problem()), tick);
                }
                Err(error)
            }
        }
    }

    /// Takes a new record into the tick.
    async fn log(&mut self, record: Record, tick: &mut Tick) {
        let document = self.session.document();
        let hash = document.hash().to_string();
        let mut bounds = None;
        if record.changes.iter().any(|change| matches!(change, Change::Scene { .. })) {
            match Surroundings::of(document.scene()).await {
                Ok(surroundings) => self.surroundings = surroundings,
                Err(error) => tracing::error!("the bounds of a scene are not known: {error}"),
            }
            bounds = Some(self.surroundings.bounds);
        }
        tick.shows |= record.changes.iter().any(Change::changes_picture);
        tick.say(Say::All(ServerMessage::Log { record: Box::new((&record).into()), hash, bounds }));
        tick.records.push(record);
    }

    /// The scenes that a request needs, decoded: known by trying it on a copy.
    async fn scenes_of(
        &self,
        request: &Request,
        actor: &Actor,
        op_id: &str,
    ) -> Result<Vec<(AssetHash, Arc<Scene>)>, ServerError> {
        let mut scenes = Vec::new();
        let edits =
            matches!(request, Request::Edit { command, .. } if !matches!(command, Command::LoadScene { .. }));
        if edits || matches!(request, Request::Commit(_)) {
            return Ok(scenes);
        }
        while let Some(asset) = self.missing_scene(&scenes, request, actor, op_id) {
            scenes.push((asset, self.backend.scenes.load(asset).await?));
        }
        Ok(scenes)
    }

    fn missing_scene(
        &self,
        scenes: &[(AssetHash, Arc<Scene>)],
        request: &Request,
        actor: &Actor,
        op_id: &str,
    ) -> Option<AssetHash> {
        let missing = Cell::new(None);
        let find_or_note = |asset: &AssetHash| {
            let found = find(scenes, asset);
            if found.is_none() {
                missing.set(Some(*asset));
            }
            found
        };
        // What comes of it is seen when it is carried out.
        let _ = self.session.clone().request(request.clone(), actor, op_id, 0, &find_or_note);
        missing.get()
    }

    /// Writes the tick's records down and tells what it has to tell; or takes it back.
    pub(super) async fn commit(&mut self, mut tick: Tick) {
        let records = std::mem::take(&mut tick.records);
        if !records.is_empty() {
            let hash = self.session.document().hash();
            let written = self.backend.storage.append(Arc::clone(&self.name), records, hash).await;
            if let Err(error) = written {
                self.take_back(&mut tick, &error);
            }
        }
        self.utter(tick);
    }

    /// The state before the tick, and rejections in place of its answers. Nobody has seen the rest.
    fn take_back(&mut self, tick: &mut Tick, error: &ServerError) {
        if let Some(before) = tick.before.take() {
            (self.session, self.surroundings) = *before;
        }
        let reject = |result: EditResult| rejected(result.op_id, error);
        let says = std::mem::take(&mut tick.says).into_iter();
        tick.says = says
            .filter_map(|say| match say {
                Say::Result(client, result) => Some(Say::Result(client, reject(result))),
                Say::Batch(mut batch) => {
                    batch.results = batch.results.into_iter().map(reject).collect();
                    Some(Say::Batch(batch))
                }
                Say::All(_) | Say::To(..) => None,
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
                Say::All(message) => {
                    // Of a gesture its holder is told in any case: it is an answer.
                    let asker = match &message {
                        ServerMessage::GestureState(state) => Some(state.client),
                        _ => None,
                    };
                    self.say_to_all(&message, asker);
                }
                Say::To(client, message) => self.say_to(client, &message),
                Say::Result(client, result) => {
                    self.count(&result);
                    self.say_to(client, &ServerMessage::EditResult(result));
                }
                Say::Batch(batch) => self.go_on_with(batch),
            }
        }
    }

    /// Answers a program, or puts what is left of its request back in line.
    fn go_on_with(&mut self, mut batch: Batch) {
        for result in batch.results.drain(..) {
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
        self.backend.metrics.count_edit(result.code.as_deref().unwrap_or("committed"));
    }

    fn snapshot(&self) -> Snapshot {
        Snapshot {
            name: self.name.to_string(),
            epoch: self.epoch.clone(),
            seq: self.session.seq(),
            document: self.session.document().clone(),
            stage: self.number,
        }
    }
}

fn rejected(op_id: String, error: &ServerError) -> EditResult {
    let protocol::Problem { code, message } = error.problem();
    EditResult {
        op_id,
        status: EditStatus::Rejected,
        seq: None,
        skipped: Vec::new(),
        code: Some(code),
        message: Some(message),
    }
}

fn find(scenes: &[(AssetHash, Arc<Scene>)], asset: &AssetHash) -> Option<Arc<Scene>> {
    scenes.iter().find(|(known, _)| known == asset).map(|(_, scene)| Arc::clone(scene))
}

/// The time of day, in milliseconds since 1970.
pub(crate) fn time_ms() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_millis() as u64)
}
