//! Drags: live for everybody, in the log only once they are committed.

use document::{Change, Command};
use edit::{Actor, Gesture, Refusal};
use light::LightId;
use protocol::{GestureEnd, GestureState, Problem, ServerMessage};

use super::Room;
use super::message::ClientId;
use super::tick::{Say, Tick};
use crate::ServerError;

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
            Ok(gesture) => tick.say(Say::All(ServerMessage::GestureState(self.gesture_state(&gesture)))),
            Err(refusal) => self.refuse_gesture((id, light.0), holder.0, &refusal.into(), tick),
        }
    }

    pub(super) fn update_gesture(
        &mut self,
        id: &str,
        update: u64,
        command: Result<Command, ServerError>,
        (client, actor): (ClientId, &Actor),
        tick: &mut Tick,
    ) {
        let Some(before) = self.gesture_of(id, actor) else {
            let error = Refusal::NoGesture(id.to_owned()).into();
            return self.refuse_gesture((id, 0), client, &error, tick);
        };
        let now_ms = self.clock_ms();
        let updated = command.and_then(|command| {
            // A gesture is of a light, and lights need no scene.
            Ok(self.session.update_gesture(id, update, command, actor, now_ms, &|_| None).cloned()?)
        });
        match updated {
            Ok(gesture) => {
                tick.shows |= shows(&before) || shows(&gesture);
                self.live_revision = self.live_revision.wrapping_add(1);
                tick.say(Say::All(ServerMessage::GestureState(self.gesture_state(&gesture))));
            }
            Err(error) => {
                let Problem { code, message } = error.problem();
                let state = self.gesture_state(&before);
                let state = GestureState { code: Some(code), message: Some(message), ..state };
                tick.say(Say::To(client, ServerMessage::GestureState(state)));
            }
        }
    }

    pub(super) fn cancel_gesture(&mut self, id: &str, (client, actor): (ClientId, &Actor), tick: &mut Tick) {
        match self.session.end_gesture(id, actor) {
            Ok(gesture) => self.end_gesture(gesture, GestureEnd::Cancelled, None, tick),
            Err(refusal) => self.refuse_gesture((id, 0), client, &refusal.into(), tick),
        }
    }

    /// Ends those that were not updated for too long.
    pub(super) fn expire_gestures(&mut self) {
        let mut tick = Tick::default();
        let now_ms = self.clock_ms();
        for gesture in self.session.expire_gestures(now_ms) {
            self.end_gesture(gesture, GestureEnd::Expired, None, &mut tick);
        }
        self.utter(tick);
    }

    /// Tells everybody that a gesture is over and changes nothing any more.
    pub(super) fn end_gesture(
        &mut self,
        mut gesture: Gesture,
        end: GestureEnd,
        problem: Option<Problem>,
        tick: &mut Tick,
    ) {
        tick.shows |= shows(&gesture);
        self.live_revision = self.live_revision.wrapping_add(1);
        gesture.changes.clear();
        let (code, message) = problem.map(|problem| (problem.code, problem.message)).unzip();
        let state = GestureState { ended: Some(end), code, message, ..self.gesture_state(&gesture) };
        tick.say(Say::All(ServerMessage::GestureState(state)));
    }

    /// Tells a client that it holds no such gesture.
    fn refuse_gesture(
        &self,
        (id, light): (&str, u64),
        client: ClientId,
        error: &ServerError,
        tick: &mut Tick,
    ) {
        let Problem { code, message } = error.problem();
        let state = GestureState {
            gesture: id.to_owned(),
            client,
            light,
            update: 0,
            live_revision: self.live_revision,
            changes: Vec::new(),
            ended: Some(GestureEnd::Rejected),
            code: Some(code),
            message: Some(message),
        };
        tick.say(Say::To(client, ServerMessage::GestureState(state)));
    }

    /// The gesture that an actor holds under that name.
    pub(super) fn gesture_of(&self, id: &str, actor: &Actor) -> Option<Gesture> {
        self.session.gestures().find(|held| held.id == id && held.actor.id == actor.id).cloned()
    }

    pub(super) fn gesture_state(&self, gesture: &Gesture) -> GestureState {
        GestureState {
            gesture: gesture.id.clone(),
            client: gesture.client,
            light: gesture.light.0,
            update: gesture.update,
            live_revision: self.live_revision,
            changes: gesture.changes.iter().map(protocol::Change::from).collect(),
            ended: None,
            code: None,
            message: None,
        }
    }
}

fn shows(gesture: &Gesture) -> bool {
    gesture.changes.iter().any(Change::changes_picture)
}
