//! Gestures: everybody sees them live, and the log gets them on commit.

use document::{Change, Command, CommandContext};
use edit::{Actor, EditRefusal, Gesture};
use light::LightId;
use protocol::{GestureState, GestureStatus};

use super::Room;
use super::solving::{FoundSolution, with_solution};
use super::tick::{Outgoing, Tick};
use crate::ServerError;
use crate::outboxes::ClientId;

impl Room {
    pub(super) fn begin_gesture(
        &mut self,
        id: &str,
        light: LightId,
        base_seq: u64,
        holder: (ClientId, &Actor),
        tick: &mut Tick,
    ) {
        let now_ms = self.clock_ms();
        match self.session.begin_gesture(id, light, base_seq, holder, now_ms).cloned() {
            Ok(gesture) => tick
                .send(Outgoing::Gesture(self.gesture_state(&gesture, GestureStatus::Held { refused: None }))),
            Err(refusal) => self.refuse_gesture((id, light.0, 0), holder.0, &refusal.into(), tick),
        }
    }

    pub(super) fn update_gesture(
        &mut self,
        id: &str,
        update: u64,
        (command, found): (Result<Command, ServerError>, FoundSolution),
        (client, actor): (ClientId, &Actor),
        tick: &mut Tick,
    ) {
        let Some(before) = self.gesture_of(id, actor) else {
            let error = EditRefusal::NoGesture(id.to_owned()).into();
            return self.refuse_gesture((id, 0, update), client, &error, tick);
        };
        match self.updated_gesture(id, update, (command, found), actor) {
            Ok(gesture) => {
                tick.changes_pictures |= is_visible(&before) || is_visible(&gesture);
                self.live_revision = self.live_revision.wrapping_add(1);
                tick.send(Outgoing::Gesture(
                    self.gesture_state(&gesture, GestureStatus::Held { refused: None }),
                ));
            }
            Err(error) => {
                let status = GestureStatus::Held { refused: Some(error.problem()) };
                let state = GestureState { update, ..self.gesture_state(&before, status) };
                tick.send(Outgoing::GestureRefusal(client, state));
            }
        }
    }

    fn updated_gesture(
        &mut self,
        id: &str,
        update: u64,
        (command, found): (Result<Command, ServerError>, FoundSolution),
        actor: &Actor,
    ) -> Result<Gesture, ServerError> {
        let (command, solved) = with_solution(command?, found)?;
        let reach = self.scene.decoded.posed.bounds();
        let context = CommandContext { scene_bounds: reach, loaded: None, solved: solved.as_ref() };
        let now_ms = self.clock_ms();
        Ok(self.session.update_gesture(id, update, command, actor, now_ms, context).cloned()?)
    }

    pub(super) fn cancel_gesture(&mut self, id: &str, (client, actor): (ClientId, &Actor), tick: &mut Tick) {
        match self.session.end_gesture(id, actor) {
            Ok(gesture) => self.end_gesture(gesture, GestureStatus::Cancelled { refused: None }, tick),
            Err(refusal) => self.refuse_gesture((id, 0, 0), client, &refusal.into(), tick),
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
        (id, light, update): (&str, u64, u64),
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
        self.session.gestures().find(|held| held.id == id && held.actor.id == actor.id).cloned()
    }

    pub(super) fn gesture_state(&self, gesture: &Gesture, status: GestureStatus) -> GestureState {
        GestureState {
            gesture: gesture.id.clone(),
            client: gesture.client,
            light: gesture.light.0,
            update: gesture.update,
            live_revision: self.live_revision,
            changes: gesture.changes().iter().map(protocol::Change::from).collect(),
            outcome: gesture
                .live
                .as_ref()
                .and_then(|shown| shown.outcome.as_ref())
                .map(|o| Box::new(o.into())),
            status,
        }
    }
}

fn is_visible(gesture: &Gesture) -> bool {
    gesture.changes().iter().any(Change::changes_picture)
}
