//! Gestures: everybody sees them live, and the log gets them on commit.

use document::{Change, CommandSolution};
use edit::{Actor, EditRefusal, Gesture};
use light::LightId;
use protocol::{GestureState, GestureStatus};

use super::Room;
use super::grouping::CompletedCommand;
use super::tick::{Outgoing, Tick};
use crate::ServerError;
use crate::outboxes::ClientId;

impl Room {
    pub(super) fn begin_gesture(
        &mut self,
        id: &str,
        light: LightId,
        base_seq: u64,
        client: ClientId,
        actor: &Actor,
        tick: &mut Tick,
    ) {
        let now_ms = self.clock_ms();
        match self.session.begin_gesture(id, light, base_seq, client, actor, now_ms).cloned() {
            Ok(gesture) => tick.send(Outgoing::Gesture(self.held_state(&gesture))),
            Err(refusal) => self.refuse_gesture(id, light.0, 0, client, &refusal.into(), tick),
        }
    }

    pub(super) fn update_gesture(
        &mut self,
        id: &str,
        update: u64,
        command: Result<CompletedCommand, ServerError>,
        client: ClientId,
        actor: &Actor,
        tick: &mut Tick,
    ) {
        let Some(before) = self.gesture_of(id, actor) else {
            let error = EditRefusal::NoGesture(id.to_owned()).into();
            return self.refuse_gesture(id, 0, update, client, &error, tick);
        };
        let now_ms = self.clock_ms();
        let solved = command.as_ref().ok().and_then(|completed| completed.solved.as_ref());
        let outcome = solved.and_then(|solved| match solved {
            CommandSolution::Drag(drag) => Some(Box::new(protocol::DragOutcome::from(&drag.outcome))),
            _ => None,
        });
        let updated = command.and_then(|CompletedCommand { command, solved }| {
            let context = self.scene.decoded.context(None, solved.as_ref());
            Ok(self.session.update_gesture(id, update, command, actor, now_ms, context).cloned()?)
        });
        match updated {
            Ok(gesture) => {
                tick.changes_pictures |= is_visible(&before) || is_visible(&gesture);
                self.live_revision = self.live_revision.wrapping_add(1);
                tick.send(Outgoing::Gesture(self.held_state(&gesture)));
            }
            Err(error) => {
                let status = GestureStatus::Held { refused: Some(error.problem()) };
                // The outcome of a refused drag says how far it would have gone, and what holds it.
                let held = self.gesture_state(&before, status);
                let state = GestureState { update, outcome: outcome.or(held.outcome), ..held };
                tick.send(Outgoing::GestureRefusal(client, state));
            }
        }
    }

    pub(super) fn cancel_gesture(&mut self, id: &str, client: ClientId, actor: &Actor, tick: &mut Tick) {
        match self.session.end_gesture(id, actor) {
            Ok(gesture) => self.end_gesture(gesture, GestureStatus::Cancelled { refused: None }, tick),
            Err(refusal) => self.refuse_gesture(id, 0, 0, client, &refusal.into(), tick),
        }
    }

    /// Ends gestures without an update for too long. A client whose updates wait for a solve keeps its gestures.
    pub(super) fn expire_gestures(&mut self) {
        let mut tick = Tick::default();
        let now_ms = self.clock_ms();
        for client in self.clients.values().filter(|client| !client.queued.is_empty()) {
            self.session.renew_gestures_of(&client.principal.actor, now_ms);
        }
        for gesture in self.session.expire_gestures(now_ms) {
            self.end_gesture(gesture, GestureStatus::Expired, &mut tick);
        }
        self.publish(tick);
    }

    /// Tells all clients that a gesture has ended and no longer changes the document.
    pub(super) fn end_gesture(&mut self, mut gesture: Gesture, status: GestureStatus, tick: &mut Tick) {
        tick.changes_pictures |= is_visible(&gesture);
        self.live_revision = self.live_revision.wrapping_add(1);
        gesture.live = None;
        tick.send(Outgoing::Gesture(self.gesture_state(&gesture, status)));
    }

    /// Tells a client that it does not hold that gesture.
    fn refuse_gesture(
        &self,
        id: &str,
        light: u64,
        update: u64,
        client: ClientId,
        error: &ServerError,
        tick: &mut Tick,
    ) {
        let state = GestureState {
            gesture: id.to_owned(),
            client,
            light,
            update,
            live_revision: self.live_revision,
            changes: Vec::new(),
            outcome: None,
            status: GestureStatus::Rejected(error.problem()),
        };
        tick.send(Outgoing::GestureRefusal(client, state));
    }

    /// Returns the gesture that an actor holds under that id.
    pub(super) fn gesture_of(&self, id: &str, actor: &Actor) -> Option<Gesture> {
        self.session.gestures().find(|gesture| gesture.id == id && gesture.actor.id == actor.id).cloned()
    }

    /// Returns the state of a gesture that goes on.
    pub(super) fn held_state(&self, gesture: &Gesture) -> GestureState {
        self.gesture_state(gesture, GestureStatus::Held { refused: None })
    }

    fn gesture_state(&self, gesture: &Gesture, status: GestureStatus) -> GestureState {
        GestureState {
            gesture: gesture.id.clone(),
            client: gesture.client,
            light: gesture.light.0,
            update: gesture.update,
            live_revision: self.live_revision,
            changes: gesture.changes().iter().map(protocol::Change::from).collect(),
            outcome: gesture.live.as_ref().and_then(|live| live.outcome.as_ref()).map(|o| Box::new(o.into())),
            status,
        }
    }
}

fn is_visible(gesture: &Gesture) -> bool {
    gesture.changes().iter().any(Change::changes_picture)
}
