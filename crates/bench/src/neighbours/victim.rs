//! The victim. It drags a control point in a view of its own, and at intervals a feature of another light.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use protocol::{ClientMessage, GestureState, ServerMessage, ViewSettings, ViewSource};

use super::judge::{TimedDrag, Timeline};
use super::setup::{Draggable, add_light, pin};
use crate::circle::ANIMATION_FRAME;
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
        let mut hand = Client::connect(link, SESSION, ACTOR, None)?;
        let circle = DragCircle::of(&hand)?;
        open_view(&mut hand, size, circle.light)?;
        let asker = Client::connect(address, SESSION, ACTOR, None)?;
        let shared = Arc::new(Shared::default());
        let (for_hand, for_asker) = (shared.clone(), shared.clone());
        Ok(Self {
            shared,
            drag_thread: thread::spawn(move || DragThread::new(hand, circle).drag(&for_hand)),
            feature_thread: thread::spawn(move || drag_features(asker, &draggable, &for_asker)),
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
        let get = |of: &Mutex<Option<Instant>>| *of.lock().unwrap_or_else(PoisonError::into_inner);
        while to.elapsed() < patience {
            let has_frame = get(&self.shared.latest_frame).is_some_and(|came| came > to);
            let is_answered = get(&self.shared.unanswered_since).is_none_or(|asked| asked > to);
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
        let asked = self.feature_thread.join().map_err(panicked)?;
        timeline.timed_drags = asked.timed_drags;
        timeline.disconnect_reason = timeline.disconnect_reason.or(asked.disconnect_reason);
        Ok(timeline)
    }
}

/// Opens a view that shows only the dragged light, so that other lights cause no renders.
fn open_view(client: &mut Client, [width, height]: [u32; 2], light: u64) -> Result<(), BenchError> {
    client.send(&ClientMessage::OpenView {
        source: ViewSource::Own(client.welcome.camera.clone()),
        width,
        height,
        camera_revision: 1,
        settings: Some(ViewSettings { exposure: 0.0, solo: vec![light] }),
        interaction: None,
        stats: false,
    })?;
    client.wait_for("a first lossless picture", |incoming| {
        matches!(incoming, Incoming::Frame(header, _) if header.flags.is_settled).then_some(())
    })
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
    fn new(client: Client, circle: DragCircle) -> Self {
        Self { client, circle, timeline: Timeline::default(), gestures: 0, update: 0 }
    }

    /// Drags while the activity is `DRAGGING`, until the victim leaves or the connection ends.
    fn drag(mut self, shared: &Shared) -> Timeline {
        while shared.activity() != LEAVING {
            let done = if shared.activity() == DRAGGING {
                self.one_drag(shared)
            } else {
                self.take(shared, POLL_INTERVAL)
            };
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
        let (light, base_seq) = (self.circle.light, self.client.welcome.seq);
        let gesture = self.gesture();
        self.client.send(&ClientMessage::GestureBegin { gesture: gesture.clone(), light, base_seq })?;
        let mut next = Instant::now();
        while shared.activity() == DRAGGING {
            self.update += 1;
            let command = self.circle.command(STEP * self.update as f64);
            let message =
                ClientMessage::GestureUpdate { gesture: gesture.clone(), update: self.update, command };
            self.client.send(&message)?;
            self.timeline.sent.push(Instant::now());
            // Updates that were delayed are not sent later: a page does not send them either.
            next = (next + ANIMATION_FRAME).max(Instant::now());
            while let Some(left) = next.checked_duration_since(Instant::now()).filter(|left| !left.is_zero())
            {
                self.take(shared, left)?;
            }
        }
        self.client.send(&ClientMessage::GestureCancel { gesture })
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
                *shared.latest_frame.lock().unwrap_or_else(PoisonError::into_inner) = Some(came);
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
    let mut timeline = Timeline::default();
    for n in 1.. {
        if let Err(why) = rest(&mut client, shared) {
            timeline.disconnect_reason = Some(why.to_string());
        }
        if shared.activity() == LEAVING || timeline.disconnect_reason.is_some() {
            break;
        }
        let sent = Instant::now();
        *shared.unanswered_since.lock().unwrap_or_else(PoisonError::into_inner) = Some(sent);
        let answered = drag_feature_once(&mut client, draggable, n, shared);
        *shared.unanswered_since.lock().unwrap_or_else(PoisonError::into_inner) = None;
        match answered {
            Ok(answered) => timeline.timed_drags.push(TimedDrag { sent, answered }),
            Err(why) => timeline.disconnect_reason = Some(why.to_string()),
        }
    }
    timeline
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
    let (gesture, base_seq) = (format!("ask-{n}"), client.welcome.seq);
    let command = draggable.command(n as usize)?;
    client.send(&ClientMessage::GestureBegin {
        gesture: gesture.clone(),
        light: draggable.light,
        base_seq,
    })?;
    client.send(&ClientMessage::GestureUpdate { gesture: gesture.clone(), update: n, command })?;
    while shared.activity() != LEAVING {
        let Some(Incoming::Message(message)) = client.receive(POLL_INTERVAL)? else { continue };
        let ServerMessage::GestureState(state) = *message else { continue };
        if !is_of(&state, client, &gesture) || state.update != n {
            continue;
        }
        let answered = Instant::now();
        if let Some(problem) = state.status.problem() {
            return Err(BenchError::Refused(problem.message.clone()));
        }
        client.send(&ClientMessage::GestureCancel { gesture })?;
        return Ok(Some(answered));
    }
    Ok(None)
}
