//! Clients of a session: joining, leaving, presence.

use std::collections::{BTreeSet, VecDeque};

use protocol::{Document, GestureState, GestureStatus, Presence, Resync, ServerMessage, Settings, State, Welcome};
use store::Store;

use super::Room;
use super::message::{JoinRequest, RoomMessage};
use super::solving::SolveState;
use super::tick::Tick;
use crate::ServerError;
use crate::access::Principal;
use crate::limits::{MAX_CATCH_UP_BYTES, MAX_CATCH_UP_RECORDS, MAX_CLIENTS, MAX_VIEW_SIDE};
use crate::outbox::{Outbox, SharedText};
use crate::outboxes::ClientId;
use crate::request::{ClientRequest, RecordAction};

pub(super) struct ConnectedClient {
    pub principal: Principal,
    /// The selected light.
    pub selection: Option<u64>,
    /// State of the solves for the client's commands.
    pub solves: SolveState,
    /// The client's waiting messages. The first one waits for its solve.
    pub queued: VecDeque<RoomMessage>,
}

impl ConnectedClient {
    /// True if the client has waiting messages and the first one no longer waits for a solve.
    pub fn can_resume(&self) -> bool {
        !(self.queued.is_empty() || self.solves.is_pending())
    }

    /// Removes queued updates of gestures that end with the connection: all gestures that no queued commit completes.
    pub fn discard_uncommitted(&mut self) {
        let committed = |message: &RoomMessage| match message {
            RoomMessage::Client { request: ClientRequest::Step(step), .. } => match &step.request {
                Ok(RecordAction::Commit(id)) => Some(id.clone()),
                _ => None,
            },
            _ => None,
        };
        let committed: BTreeSet<String> = self.queued.iter().filter_map(committed).collect();
        let is_kept = |message: &RoomMessage| match message {
            RoomMessage::Client { request: ClientRequest::UpdateGesture { gesture, .. }, .. } => {
                committed.contains(gesture)
            }
            _ => true,
        };
        if !self.queued.front().is_none_or(is_kept) {
            self.solves.cancel();
        }
        self.queued.retain(is_kept);
    }
}

impl Room {
    /// Admits a client, or tells it the reason for a refusal. Everything done before is committed.
    pub(super) async fn join(&mut self, join: JoinRequest) {
        let JoinRequest { principal, epoch, last_seq, mut outbox, joined } = join;
        if self.is_draining {
            return outbox.send_error(&ServerError::Draining, true);
        }
        if self.clients.len() >= MAX_CLIENTS {
            let error = ServerError::TooMany { what: "clients in a session", limit: MAX_CLIENTS };
            return outbox.send_error(&error, true);
        }
        let known = last_seq.filter(|_| epoch.as_ref() == Some(&self.epoch));
        let state = self.state_from(known).await;
        let document = match &state {
            State::Tail(_) => Ok(None),
            State::Snapshot(_) => match self.services.in_flight.check() {
                Ok(()) => self.document_json().await.map(Some),
                Err(busy) => Err(busy),
            },
        };
        let document = match document {
            Ok(document) => document,
            Err(error) => return outbox.send_error(&error, true),
        };
        self.last_client += 1;
        let id = self.last_client;
        tracing::debug!("client {id} of session {}: {principal}", self.name);
        self.views.insert(id, &principal.actor.id);
        let (solves, queued) = (SolveState::default(), VecDeque::new());
        self.clients.insert(id, ConnectedClient { principal, selection: None, solves, queued });
        self.outboxes.insert(id, outbox);
        self.services.metrics.clients.inc();
        let welcome = ServerMessage::Welcome(Box::new(self.welcome(id, state)));
        match document {
            None => self.outboxes.send(id, &welcome),
            Some(document) => {
                let text = SharedText::with_document(&welcome, document, &self.services.in_flight);
                self.outboxes.send_text(id, text);
            }
        }
        self.presence_changed = true;
        self.note_clients();
        if joined.send(id).is_err() {
            let mut tick = Tick::default();
            self.leave(id, &mut tick);
            self.commit(tick).await;
        }
    }

    fn welcome(&self, client: ClientId, state: State) -> Welcome {
        let document = self.session.document();
        let camera = document.cameras().values().next().unwrap_or(&self.scene.framing);
        Welcome {
            protocol: protocol::PROTOCOL,
            session: self.name.to_string(),
            client,
            epoch: self.epoch.clone(),
            seq: self.session.seq(),
            hash: document.hash().to_string(),
            state,
            bounds: self.scene.bounds,
            notes: self.scene.decoded.notes.to_vec(),
            camera: camera.into(),
            clients: self.presence(),
            gestures: self.gesture_states(),
            settings: Settings {
                ack_window: stream::MAX_FRAMES_IN_FLIGHT as u32,
                lease_ms: edit::LEASE_MS,
                max_view_side: MAX_VIEW_SIDE,
            },
        }
    }

    fn gesture_states(&self) -> Vec<GestureState> {
        self.session.gestures().map(|gesture| self.held_state(gesture)).collect()
    }

    /// Returns the records after the one that the client knows. If the client knows none, or too many are missing,
    /// returns an empty document, which the caller replaces with the text of the session's document.
    async fn state_from(&self, known: Option<u64>) -> State {
        let missing = known.and_then(|seq| self.session.seq().checked_sub(seq)).filter(|n| *n <= MAX_CATCH_UP_RECORDS);
        if let Some((known, missing)) = known.zip(missing) {
            let name = self.name.clone();
            let page = move |store: &Store| store.page(&name, known + 1, missing as usize, MAX_CATCH_UP_BYTES);
            match self.services.storage.read(page).await {
                Ok(records) if records.len() as u64 == missing => return State::Tail(records),
                // A page is limited in bytes and may lack records.
                Ok(_) => {}
                Err(error) => tracing::error!("the records for a returning client cannot be read: {error}"),
            }
        }
        State::Snapshot(Document::default())
    }

    /// Removes a client and its gestures. Followers of its view keep the view.
    pub(super) fn leave(&mut self, id: ClientId, tick: &mut Tick) {
        if self.clients.remove(&id).is_none() {
            return;
        }
        self.services.metrics.clients.dec();
        self.outboxes.remove(id);
        self.views.remove(id);
        self.probes.waiting.remove(&id);
        for gesture in self.session.end_gestures_of(id) {
            self.end_gesture(gesture, GestureStatus::Cancelled { refused: None }, tick);
        }
        self.presence_changed = true;
        self.note_clients();
    }

    /// Removes clients whose connection closed without a message. Messages that they sent are carried out first.
    pub(super) fn drop_lost_clients(&mut self) {
        for id in self.outboxes.closed() {
            if self.clients.get(&id).is_some_and(|client| !client.queued.is_empty()) {
                continue;
            }
            let mut tick = Tick::default();
            self.leave(id, &mut tick);
            self.publish(tick);
        }
    }

    pub(super) fn broadcast_presence(&mut self) {
        self.presence_changed = false;
        let clients = self.presence();
        self.outboxes.broadcast(&ServerMessage::Presence { clients }, None);
    }

    fn presence(&self) -> Vec<Presence> {
        let presence = |(&id, client): (&ClientId, &ConnectedClient)| {
            let view = self.views.parameters_of(id);
            Presence {
                client: id,
                actor: (&client.principal.actor).into(),
                selection: client.selection,
                following: self.views.leader_of(id),
                camera: view.map(|view| (&view.camera).into()),
                settings: view.map(|view| (&view.settings).into()),
            }
        };
        self.clients.iter().map(presence).collect()
    }

    /// Sends the current state to the clients whose outbox is `chosen`, which must have fallen behind.
    pub(super) async fn catch_up(&mut self, chosen: impl Fn(&Outbox) -> bool) {
        if !self.outboxes.any(&chosen) {
            return;
        }
        match self.document_json().await {
            Ok(document) => {
                let resync = ServerMessage::Resync(Box::new(self.resync()));
                let resync = SharedText::with_document(&resync, document, &self.services.in_flight);
                self.outboxes.catch_up(chosen, &resync);
            }
            Err(error) => tracing::error!("the text of session {} cannot be made: {error}", self.name),
        }
    }

    /// Returns the message with the current state, but with an empty document, which the caller replaces with the
    /// document's text.
    fn resync(&self) -> Resync {
        Resync {
            seq: self.session.seq(),
            hash: self.session.document().hash().to_string(),
            document: Document::default(),
            bounds: self.scene.bounds,
            notes: self.scene.decoded.notes.to_vec(),
            clients: self.presence(),
            gestures: self.gesture_states(),
        }
    }
}
