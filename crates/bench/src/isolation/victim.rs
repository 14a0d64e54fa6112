//! The victim. It drags a control point in a view of its own, and at intervals a feature of another light.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use protocol::{GestureState, ServerMessage, ViewSettings};

use super::judge::{TimedDrag, Timeline};
use super::other::locked;
use super::setup::{Draggable, add_light, pin};
use crate::circle::{ANIMATION_FRAME, open_view, time_until};
use crate::dragged::DragCircle;
use crate::{BenchError, Client, Incoming, ServerAddress};

/// Session of the victim. The other client joins this session in one row only. The next constant is the id of the
/// victim's actor.
pub(super) const SESSION: &str = "main";
pub(super) const ACTOR: &str = "victim";
/// Radians by which each update moves the control point along the circle.
const STEP: f64 = 0.05;
/// Number of pins of the light whose features the victim drags. With them a drag takes tens of milliseconds.
const PINS: usize = 3;
/// Pause from the answer to a drag of a feature to the next drag.
const FEATURE_DRAG_INTERVAL: Duration = Duration::from_millis(200);
/// Timeout of each receive while the victim rests.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

const RESTING: u8 = 0;
const DRAGGING: u8 = 1;
const LEAVING: u8 = 2;

/// State shared by the victim's threads and the benchmark.
#[derive(Debug, Default)]
struct Shared {
    activity: AtomicU8,
    /// Time at which the latest frame arrived.
    latest_frame: Mutex<Option<Instant>>,
    /// Time at which the unanswered drag of a feature was sent.
    unanswered_since: Mutex<Option<Instant>>,
}

impl Shared {
    fn activity(&self) -> u8 {
        self.activity.load(Ordering::Relaxed)
    }
}

/// Running victim.
#[derive(Debug)]
pub(super) struct Victim {
    shared: Arc<Shared>,
    drag_thread: JoinHandle<Timeline>,
    feature_thread: JoinHandle<Timeline>,
}

impl Victim {
    /// Adds a light to the victim's session, opens a view of `size` pixels over `link`, and then lets the victim rest.
    pub fn start(address: &ServerAddress, link: &ServerAddress, size: [u32; 2]) -> Result<Self, BenchError> {
        let light = add_light(address, SESSION, ACTOR, None)?;
        let draggable = pin(address, SESSION, ACTOR, light, PINS)?;
        let mut client = Client::connect(link, SESSION, ACTOR, None)?;
        let circle = DragCircle::of(&client)?;
        // The view shows only the dragged light, so that other lights cause no renders.
        open_view(&mut client, size, Some(ViewSettings { exposure: 0.0, solo: vec![circle.light] }))?;
        let feature_client = Client::connect(address, SESSION, ACTOR, None)?;
        let shared = Arc::new(Shared::default());
        let (of_drag, of_features) = (shared.clone(), shared.clone());
        let drag = DragThread { client, circle, timeline: Timeline::default(), gestures: 0, update: 0 };
        Ok(Self {
            shared,
            drag_thread: thread::spawn(move || drag.drag(&of_drag)),
            feature_thread: thread::spawn(move || drag_features(feature_client, &draggable, &of_features)),
        })
    }

    pub fn start_dragging(&self) {
        self.shared.activity.store(DRAGGING, Ordering::Relaxed);
    }

    pub fn stop_dragging(&self) {
        self.shared.activity.store(RESTING, Ordering::Relaxed);
    }

    /// Waits for a frame later than `to` and for answers to drags sent before `to`, for at most `patience`. Returns the
    /// time at which it stopped.
    pub fn follow(&self, to: Instant, patience: Duration) -> Instant {
        while to.elapsed() < patience {
            let has_frame = locked(&self.shared.latest_frame).is_some_and(|came| came > to);
            let is_answered = locked(&self.shared.unanswered_since).is_none_or(|since| since > to);
            let is_gone = self.drag_thread.is_finished() || self.feature_thread.is_finished();
            if is_gone || has_frame && is_answered {
                break;
            }
            thread::sleep(Duration::from_millis(5));
        }
        Instant::now()
    }

    /// Stops the threads and returns the recorded events.
    pub fn leave(self) -> Result<Timeline, BenchError> {
        self.shared.activity.store(LEAVING, Ordering::Relaxed);
        let panicked = |_| BenchError::Refused("the victim's thread panicked".into());
        let mut timeline = self.drag_thread.join().map_err(panicked)?;
        let features = self.feature_thread.join().map_err(panicked)?;
        timeline.timed_drags = features.timed_drags;
        timeline.disconnect_reason = timeline.disconnect_reason.or(features.disconnect_reason);
        Ok(timeline)
    }
}

/// State of the thread that drags the control point.
struct DragThread {
    client: Client,
    circle: DragCircle,
    timeline: Timeline,
    gestures: u64,
    update: u64,
}

impl DragThread {
    /// Drags while the activity is `DRAGGING`, until the victim leaves or the connection ends.
    fn drag(mut self, shared: &Shared) -> Timeline {
        while shared.activity() != LEAVING {
            let done =
                if shared.activity() == DRAGGING { self.one_drag(shared) } else { self.take(shared, POLL_INTERVAL) };
            if let Err(why) = done {
                self.timeline.disconnect_reason = Some(why.to_string());
                break;
            }
        }
        self.timeline
    }

    /// Drags until the activity changes, then cancels the gesture.
    fn one_drag(&mut self, shared: &Shared) -> Result<(), BenchError> {
        self.gestures += 1;
        let gesture = self.gesture();
        self.client.begin_gesture(&gesture, self.circle.light)?;
        let mut next = Instant::now();
        while shared.activity() == DRAGGING {
            self.update += 1;
            let command = self.circle.command(STEP * self.update as f64);
            self.client.update_gesture(&gesture, self.update, command)?;
            self.timeline.sent.push(Instant::now());
            // Updates that were delayed are not sent later: a page does not send them either.
            next = (next + ANIMATION_FRAME).max(Instant::now());
            while let Some(left) = time_until(next) {
                self.take(shared, left)?;
            }
        }
        self.client.cancel_gesture(&gesture)
    }

    fn gesture(&self) -> String {
        format!("hand-{}", self.gestures)
    }

    /// Receives one message or frame, for at most `timeout`. Acknowledges frames and does not decode them.
    fn take(&mut self, shared: &Shared, timeout: Duration) -> Result<(), BenchError> {
        match self.client.receive(timeout)? {
            Some(Incoming::Frame(header, _)) => {
                let came = Instant::now();
                self.client.ack(&header)?;
                self.timeline.frames.push((came, header.live_revision));
                *locked(&shared.latest_frame) = Some(came);
            }
            Some(Incoming::Message(message)) => {
                if let ServerMessage::GestureState(state) = *message
                    && is_of(&state, &self.client, &self.gesture())
                    && state.status.problem().is_none()
                {
                    self.timeline.update_of.insert(state.live_revision, state.update);
                }
            }
            None => {}
        }
        Ok(())
    }
}

fn is_of(state: &GestureState, client: &Client, gesture: &str) -> bool {
    state.client == client.welcome.client && state.gesture == gesture
}

/// Drags features of another light, one after the other, and cancels each after its answer.
fn drag_features(mut client: Client, draggable: &Draggable, shared: &Shared) -> Timeline {
    let mut timed_drags = Vec::new();
    let mut drag_until_left = || -> Result<(), BenchError> {
        for n in 1.. {
            rest(&mut client, shared)?;
            if shared.activity() == LEAVING {
                break;
            }
            let sent = Instant::now();
            *locked(&shared.unanswered_since) = Some(sent);
            let answered = drag_feature_once(&mut client, draggable, n, shared);
            *locked(&shared.unanswered_since) = None;
            timed_drags.push(TimedDrag { sent, answered: answered? });
        }
        Ok(())
    };
    let disconnect_reason = drag_until_left().err().map(|why| why.to_string());
    Timeline { timed_drags, disconnect_reason, ..Timeline::default() }
}

/// Receives messages for the pause between drags, and while the victim rests.
fn rest(client: &mut Client, shared: &Shared) -> Result<(), BenchError> {
    let until = Instant::now() + FEATURE_DRAG_INTERVAL;
    while Instant::now() < until || shared.activity() == RESTING {
        client.receive(POLL_INTERVAL)?;
    }
    Ok(())
}

/// Drags a feature and returns the time of the answer; `None` if the victim left before.
fn drag_feature_once(
    client: &mut Client,
    draggable: &Draggable,
    n: u64,
    shared: &Shared,
) -> Result<Option<Instant>, BenchError> {
    let gesture = format!("ask-{n}");
    let command = draggable.command(n as usize)?;
    client.begin_gesture(&gesture, draggable.light)?;
    client.update_gesture(&gesture, n, command)?;
    while shared.activity() != LEAVING {
        let message = client.receive(POLL_INTERVAL)?.and_then(Incoming::into_message);
        let Some(ServerMessage::GestureState(state)) = message else { continue };
        if !is_of(&state, client, &gesture) || state.update != n {
            continue;
        }
        let answered = Instant::now();
        BenchError::check(state.status.problem())?;
        client.cancel_gesture(&gesture)?;
        return Ok(Some(answered));
    }
    Ok(None)
}
