//! Who is here: coming, going, presence.

use axum::extract::ws::Utf8Bytes;
use edit::Actor;
use protocol::{Document, Presence, Resync, ServerMessage, Settings, State, Welcome};
use stream::Pace;

use super::Room;
use super::message::{ClientId, Join};
use super::tick::Tick;
use super::views::Source;
use crate::ServerError;
use crate::lane::{Lane, complaint, text};
use crate::limits::{MAX_CLIENTS, MAX_TAIL, MAX_VIEW_SIDE};

/// One connection.
pub(super) struct Client {
    pub actor: Actor,
    pub lane: Lane,
    /// The light it has selected.
    pub selection: Option<u64>,
    /// What it looks at.
    pub source: Source,
    /// Whose view it is shown, and how large, as it was last told.
    pub shown: Option<(ClientId, [u32; 2])>,
    /// When it gets its next frame.
    pub pace: Pace,
    /// Number of its latest frame.
    pub frame: u64,
}

impl Room {
    /// Takes in a client, or tells it why not. All that was done before is committed.
    pub(super) async fn join(&mut self, join: Join) {
        let Join { actor, epoch, last_seq, mut lane, joined } = join;
        if self.draining {
            return lane.complain(&ServerError::Draining, true);
        }
        if self.clients.len() >= MAX_CLIENTS {
            let error = ServerError::TooMany { what: "clients in a session", limit: MAX_CLIENTS };
            return lane.complain(&error, true);
        }
        let known = last_seq.filter(|_| epoch.as_ref() == Some(&self.epoch));
        let state = self.state_from(known).await;
        self.last_client += 1;
        let id = self.last_client;
        let client = Client {
            actor,
            lane,
            selection: None,
            source: Source::Nothing,
            shown: None,
            pace: Pace::new(),
            frame: 0,
        };
        self.clients.insert(id, client);
        self.backend.metrics.clients.inc();
        let welcome = self.welcome(id, state);
        self.say_to(id, &ServerMessage::Welcome(Box::new(welcome)));
        self.presence_changed = true;
        self.note_client_count();
        if joined.send(id).is_err() {
            let mut tick = Tick::default();
            self.leave(id, &mut tick);
            self.commit(tick).await;
        }
    }

    fn welcome(&self, client: ClientId, state: State) -> Welcome {
        let document = self.session.document();
        let camera = document.cameras().values().next().unwrap_or(&self.surroundings.framing);
        Welcome {
            protocol: protocol::PROTOCOL,
            session: self.name.to_string(),
            client,
            epoch: self.epoch.clone(),
            seq: self.session.seq(),
            hash: document.hash().to_string(),
            state,
            bounds: self.surroundings.bounds,
            notes: self.surroundings.notes.to_vec(),
            camera: camera.into(),
            clients: self.presence(),
            gestures: self.session.gestures().map(|gesture| self.gesture_state(gesture)).collect(),
            settings: Settings {
                ack_window: stream::WINDOW as u32,
                lease_ms: edit::LEASE_MS,
                max_view_side: MAX_VIEW_SIDE,
            },
        }
    }

    /// The records after the one that the client knows; all of the document where it knows none or too few.
    async fn state_from(&self, known: Option<u64>) -> State {
        let missing = known.and_then(|seq| self.session.seq().checked_sub(seq)).filter(|n| *n <= MAX_TAIL);
        if let Some((known, missing)) = known.zip(missing) {
            let name = self.name.clone();
            let read =
                self.backend.storage.read(move |store| store.records(&name, known + 1, missing as usize));
            match read.await {
                Ok(records) if records.len() as u64 == missing => return State::Tail(records),
                // A page has a limit of bytes.
                Ok(_) => {}
                Err(error) => tracing::error!("the records for a returning client cannot be read: {error}"),
            }
        }
        State::Snapshot(Document::from(self.session.document()))
    }

    /// A client goes, and its gestures with it. Who looked at its view goes on from there.
    pub(super) fn leave(&mut self, id: ClientId, tick: &mut Tick) {
        let Some(client) = self.clients.remove(&id) else { return };
        self.backend.metrics.clients.dec();
        self.hand_over(id, &client.source);
        for gesture in self.session.end_gestures_of(id) {
            self.end_gesture(gesture, protocol::GestureEnd::Cancelled, None, tick);
        }
        self.presence_changed = true;
        self.note_client_count();
    }

    /// Lets go of clients whose connection is over, though they have not said so.
    pub(super) fn drop_lost_clients(&mut self) {
        let lost: Vec<ClientId> =
            self.clients.iter().filter(|(_, client)| client.lane.is_over()).map(|(id, _)| *id).collect();
        for id in lost {
            let mut tick = Tick::default();
            self.leave(id, &mut tick);
            self.utter(tick);
        }
    }

    pub(super) fn say_presence(&mut self) {
        self.presence_changed = false;
        let clients = self.presence();
        self.say_to_all(&ServerMessage::Presence { clients }, None);
    }

    fn presence(&self) -> Vec<Presence> {
        let presence = |(&id, client): (&ClientId, &Client)| Presence {
            client: id,
            actor: (&client.actor).into(),
            selection: client.selection,
            following: match client.source {
                Source::Follow(leader) => Some(leader),
                Source::Nothing | Source::Own(_) => None,
            },
            camera: match &client.source {
                Source::Own(view) => Some((&view.camera).into()),
                Source::Nothing | Source::Follow(_) => None,
            },
        };
        self.clients.iter().map(presence).collect()
    }

    /// Tells clients that were behind, and have taken what they were sent, how things are.
    pub(super) fn catch_up_clients(&mut self) {
        self.catch_up(|client| client.lane.can_catch_up());
    }

    /// Tells all clients that are behind how things are: there will be no other time.
    pub(super) fn catch_up_all(&mut self) {
        self.catch_up(|client| client.lane.is_behind());
    }

    fn catch_up(&mut self, chosen: impl Fn(&Client) -> bool) {
        if !self.clients.values().any(&chosen) {
            return;
        }
        let resync = text(&ServerMessage::Resync(Box::new(self.resync())));
        for client in self.clients.values_mut().filter(|client| chosen(client)) {
            client.lane.catch_up(resync.clone());
        }
    }

    fn resync(&self) -> Resync {
        let document = self.session.document();
        Resync {
            seq: self.session.seq(),
            hash: document.hash().to_string(),
            document: document.into(),
            bounds: self.surroundings.bounds,
            notes: self.surroundings.notes.to_vec(),
            clients: self.presence(),
            gestures: self.session.gestures().map(|gesture| self.gesture_state(gesture)).collect(),
        }
    }

    pub(super) fn has_clients_behind(&self) -> bool {
        self.clients.values().any(|client| client.lane.is_behind())
    }

    /// Tells a client what it has asked for, or alone is to know.
    pub(super) fn say_to(&mut self, client: ClientId, message: &ServerMessage) {
        if let Some(client) = self.clients.get_mut(&client) {
            client.lane.say(message);
        }
    }

    /// Tells all clients but those that are behind; they are told the outcome. `asker` is told in any case.
    pub(super) fn say_to_all(&mut self, message: &ServerMessage, asker: Option<ClientId>) {
        let text: Utf8Bytes = text(message);
        for (id, client) in &mut self.clients {
            if Some(*id) == asker {
                client.lane.say_text(text.clone());
            } else {
                client.lane.spread(text.clone());
            }
        }
    }

    /// Tells a client what was wrong with what it has asked for.
    pub(super) fn complain_to(&mut self, client: ClientId, error: &ServerError) {
        self.say_to(client, &complaint(error, false));
    }

    /// Tells a client, unless it is behind, what is wrong without its doing.
    pub(super) fn warn(&mut self, client: ClientId, error: &ServerError) {
        if let Some(client) = self.clients.get_mut(&client) {
            client.lane.spread(text(&complaint(error, false)));
        }
    }
}
