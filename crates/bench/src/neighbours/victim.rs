//! The victim: it drags a control point in a view of its own, and now and then a feature of another light.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use protocol::{ClientMessage, GestureState, ServerMessage, ViewSettings, ViewSource};

use super::judge::{Ask, Timeline};
use super::setup::{Draggable, add_light, pin};
use crate::circle::ANIMATION_FRAME;
use crate::dragged::Circle;
use crate::{Address, BenchError, Client, Incoming};

/// Its session and its actor, in which the other client takes no part but in one row.
pub(super) const SESSION: &str = "main";
pub(super) const ACTOR: &str = "victim";
/// Radians that the control point goes around with each update.
const STEP: f64 = 0.05;
/// Pins of the light whose features it drags: with them a drag takes tens of milliseconds.
const PINS: usize = 3;
/// From the answer of a drag of a feature to the next.
const BETWEEN_ASKS: Duration = Duration::from_millis(200);
/// How long it looks for what comes while it rests.
const LOOK: Duration = Duration::from_millis(50);

const RESTS: u8 = 0;
const DRAGS: u8 = 1;
const LEAVES: u8 = 2;

/// What the victim's threads and the bench tell each other.
#[derive(Debug, Default)]
struct Shared {
    does: AtomicU8,
    /// When the latest frame had come.
    latest_frame: Mutex<Option<Instant>>,
    /// Since when a drag of a feature is not answered.
    open_ask: Mutex<Option<Instant>>,
}

impl Shared {
    fn does(&self) -> u8 {
        self.does.load(Ordering::Relaxed)
    }
}

/// A victim at work.
#[derive(Debug)]
pub(super) struct Victim {
    shared: Arc<Shared>,
    hand: JoinHandle<Timeline>,
    asker: JoinHandle<Timeline>,
}

impl Victim {
    /// Adds a light to its session, opens a view of so many pixels over `link`, and rests.
    pub fn arrive(address: &Address, link: &Address, size: [u32; 2]) -> Result<Self, BenchError> {
        let light = add_light(address, SESSION, ACTOR, None)?;
        let draggable = pin(address, SESSION, ACTOR, light, PINS)?;
        let mut hand = Client::connect(link, SESSION, ACTOR, None)?;
        let circle = Circle::of(&hand)?;
        open_view(&mut hand, size, circle.light)?;
        let asker = Client::connect(address, SESSION, ACTOR, None)?;
        let shared = Arc::new(Shared::default());
        let (for_hand, for_asker) = (shared.clone(), shared.clone());
        Ok(Self {
            shared,
            hand: thread::spawn(move || Hand::new(hand, circle).drag(&for_hand)),
            asker: thread::spawn(move || ask(asker, &draggable, &for_asker)),
        })
    }

    pub fn drags(&self) {
        self.shared.does.store(DRAGS, Ordering::Relaxed);
    }

    pub fn rests(&self) {
        self.shared.does.store(RESTS, Ordering::Relaxed);
    }

    /// Waits for a frame later than `to`, and for answers to what was asked before; until when.
    pub fn follow(&self, to: Instant, patience: Duration) -> Instant {
        let get = |of: &Mutex<Option<Instant>>| *of.lock().unwrap_or_else(PoisonError::into_inner);
        while to.elapsed() < patience {
            let has_frame = get(&self.shared.latest_frame).is_some_and(|came| came > to);
            let is_answered = get(&self.shared.open_ask).is_none_or(|asked| asked > to);
            let is_gone = self.hand.is_finished() || self.asker.is_finished();
            if is_gone || has_frame && is_answered {
                break;
            }
            thread::sleep(Duration::from_millis(5));
        }
        Instant::now()
    }

    /// Leaves. What it saw.
    pub fn leave(self) -> Result<Timeline, BenchError> {
        self.shared.does.store(LEAVES, Ordering::Relaxed);
        let panicked = |_| BenchError::Refused("the victim's thread panicked".into());
        let mut timeline = self.hand.join().map_err(panicked)?;
        let asked = self.asker.join().map_err(panicked)?;
        timeline.asks = asked.asks;
        timeline.broke = timeline.broke.or(asked.broke);
        Ok(timeline)
    }
}

/// Of the light that is dragged alone: what happens to others' costs no picture.
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
        matches!(incoming, Incoming::Frame(header, _) if header.flags.settle).then_some(())
    })
}

/// Who drags the control point.
struct Hand {
    client: Client,
    circle: Circle,
    timeline: Timeline,
    gestures: u64,
    update: u64,
}

impl Hand {
    fn new(client: Client, circle: Circle) -> Self {
        Self { client, circle, timeline: Timeline::default(), gestures: 0, update: 0 }
    }

    /// Drags while it is to; an end of the connection ends it too.
    fn drag(mut self, shared: &Shared) -> Timeline {
        while shared.does() != LEAVES {
            let done = if shared.does() == DRAGS { self.one_drag(shared) } else { self.take(shared, LOOK) };
            if let Err(why) = done {
                self.timeline.broke = Some(why.to_string());
                break;
            }
        }
        self.timeline
    }

    /// Drags until it is to rest, and leaves the control point where it was.
    fn one_drag(&mut self, shared: &Shared) -> Result<(), BenchError> {
        self.gestures += 1;
        let (light, base_seq) = (self.circle.light, self.client.welcome.seq);
        let gesture = self.gesture();
        self.client.send(&ClientMessage::GestureBegin { gesture: gesture.clone(), light, base_seq })?;
        let mut next = Instant::now();
        while shared.does() == DRAGS {
            self.update += 1;
            let command = self.circle.command(STEP * self.update as f64);
            let message =
                ClientMessage::GestureUpdate { gesture: gesture.clone(), update: self.update, command };
            self.client.send(&message)?;
            self.timeline.sent.push(Instant::now());
            // Updates that were held up are not made up for: a page sends none then either.
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

    /// Receives for at most `timeout`. Frames are acknowledged as they come, and not decoded.
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

/// Drags features of another light, one after the other, and gives each up once it is answered.
fn ask(mut client: Client, draggable: &Draggable, shared: &Shared) -> Timeline {
    let mut timeline = Timeline::default();
    for n in 1.. {
        if let Err(why) = rest(&mut client, shared) {
            timeline.broke = Some(why.to_string());
        }
        if shared.does() == LEAVES || timeline.broke.is_some() {
            break;
        }
        let sent = Instant::now();
        *shared.open_ask.lock().unwrap_or_else(PoisonError::into_inner) = Some(sent);
        let answered = ask_once(&mut client, draggable, n, shared);
        *shared.open_ask.lock().unwrap_or_else(PoisonError::into_inner) = None;
        match answered {
            Ok(answered) => timeline.asks.push(Ask { sent, answered }),
            Err(why) => timeline.broke = Some(why.to_string()),
        }
    }
    timeline
}

/// Takes what comes, for a while and as long as nothing is dragged.
fn rest(client: &mut Client, shared: &Shared) -> Result<(), BenchError> {
    let until = Instant::now() + BETWEEN_ASKS;
    while Instant::now() < until || shared.does() == RESTS {
        client.receive(LOOK)?;
    }
    Ok(())
}

/// When the answer to a drag had come; `None` where it was left without one.
fn ask_once(
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
    while shared.does() != LEAVES {
        let Some(Incoming::Message(message)) = client.receive(LOOK)? else { continue };
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
