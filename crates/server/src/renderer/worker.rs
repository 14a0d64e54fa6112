//! A worker: a thread that draws the pictures of one session and scene, each for a slice of drawing time (a turn in
//! names) at a time. A worker can pause in the middle of long work while another worker draws. Only one worker draws at
//! a time.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, OnceLock, Weak};
use std::task::Poll;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use render::{PassRun, Pixels, RenderError, Renderer, SceneOnDevice, TiledPicture, ViewSlot, YieldPolicy};
use scene::PosedScene;
use tokio::sync::mpsc;

use super::{Job, PictureFormat, PictureRequest, RenderLease, Urgency, join_thread};
use crate::background;
use crate::limits::{LARGE_PICTURE_PIXELS, MAX_MOVING_TURNS};

/// Capacity of a worker's order queue: one order to draw, and orders to drop the data of viewers, which wait behind it.
const ORDER_QUEUE: usize = 16;
/// Capacity of a worker's report queue: the report of the current slice, and the one that the thread has ended.
const REPORT_QUEUE: usize = 2;

/// End of the current slice of drawing time, shared by all drawing threads. Before the first slice it is infinitely
/// late.
#[derive(Clone, Debug)]
pub(super) struct TurnDeadline {
    start: Instant,
    /// Nanoseconds after `start`.
    deadline_ns: Arc<AtomicU64>,
}

/// Way in which a picture is divided into slices of drawing time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TurnPlan {
    /// Layer by layer, one for each light, to the end of the picture in one slice.
    Whole,
    /// Layer by layer, one for each light, until the slice is over.
    Layers,
    /// Tile by tile, until the slice is over.
    Tiles,
}

impl TurnPlan {
    /// Chooses the plan of a new picture. `is_shared` is true while other clients draw moving pictures too.
    pub fn of(request: &PictureRequest, is_shared: bool, renderer: &Renderer) -> Self {
        let PictureRequest { view, lights, urgency, .. } = request;
        let is_large = view.width * view.height > LARGE_PICTURE_PIXELS;
        match (urgency.is_moving(), is_shared) {
            (false, _) => Self::Tiles,
            // The picture is late already, and cached layers of the one before make it fast.
            (true, false) => Self::Whole,
            (true, true) if is_large || !renderer.keeps_layers(view, lights.len()) => Self::Tiles,
            (true, true) => Self::Layers,
        }
    }

    /// Returns the plan of the picture's next slice, after `turns` slices.
    pub fn after(self, turns: u32, is_shared: bool) -> Self {
        match self {
            Self::Layers if !is_shared || turns >= MAX_MOVING_TURNS => Self::Whole,
            plan => plan,
        }
    }
}

/// Progress of a picture that is being drawn.
#[derive(Debug)]
pub(super) struct PictureProgress {
    pub request: Arc<PictureRequest>,
    pub plan: TurnPlan,
    /// Picture in progress, if it is drawn in tiles.
    pub picture: Option<TiledPicture>,
    /// Passes that have run for the picture.
    pub passes: Vec<PassRun>,
    /// True if a shadow map was drawn for the picture.
    pub drew_map: bool,
}

enum WorkerOrder {
    /// Draw a picture for about this time.
    Draw(Box<PictureProgress>, Duration),
    /// True: continue the paused picture. False: cancel it.
    Resume(bool),
    /// Drop the data of a viewer.
    Forget(ViewSlot),
}

/// Message of a worker at the end of a slice of drawing time.
pub(super) enum TurnReport {
    /// The worker has paused in the middle of a piece of work.
    Paused,
    /// The worker goes on with work that does not use the device, beside other workers. See
    /// [`DrawWorker::is_in_background`].
    InBackground,
    /// The slice is over. The pixels are there if the picture is finished.
    Ended(Box<PictureProgress>, Result<Option<Pixels>, RenderError>),
    /// The worker's thread has ended, and its data is lost.
    Lost,
}

/// Scene on the device, shared by sessions. Empty until a session has uploaded it.
pub(super) type SharedScene = Arc<OnceLock<SceneOnDevice>>;

/// Handle to the thread that draws one scene for one session. The thread owns the session's shadow maps and render
/// targets.
pub(super) struct DrawWorker {
    pub scene: Arc<PosedScene>,
    pub shared: SharedScene,
    /// Lease of the session. The render loop drops the worker after the session has dropped its lease.
    pub session: Weak<RenderLease>,
    /// Numbers and leases of the views and stills that the worker drew.
    pub viewers: Vec<(u64, Weak<RenderLease>)>,
    /// Id of the task in the middle of which the worker has paused.
    pub paused: Option<u64>,
    /// True while the worker goes on with the paused task outside of its slice.
    is_in_background: Arc<AtomicBool>,
    orders: SyncSender<WorkerOrder>,
    reports: Receiver<TurnReport>,
    thread: Option<JoinHandle<()>>,
}

thread_local! {
    /// Channels of a worker's thread. Through them it reports a pause and waits for its next slice of drawing time.
    static CHANNELS: RefCell<Option<WorkerChannels>> = const { RefCell::new(None) };
}

struct WorkerChannels {
    orders: Receiver<WorkerOrder>,
    reports: SyncSender<TurnReport>,
    is_in_background: Arc<AtomicBool>,
    /// Wakes the render loop.
    jobs: mpsc::Sender<Job>,
}

/// Reports the end of a worker's thread on drop, even after a panic.
struct ReportLostOnDrop(SyncSender<TurnReport>);

impl Drop for ReportLostOnDrop {
    fn drop(&mut self) {
        // The render loop may have ended before. Then nobody listens.
        let _ = self.0.send(TurnReport::Lost);
    }
}

impl TurnDeadline {
    pub fn new() -> Self {
        Self { start: Instant::now(), deadline_ns: Arc::new(AtomicU64::new(u64::MAX)) }
    }

    /// Starts a slice of length `turn`.
    fn set(&self, turn: Duration) {
        let at = self.start.elapsed().saturating_add(turn);
        self.deadline_ns.store(u64::try_from(at.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    fn is_over(&self) -> bool {
        self.start.elapsed().as_nanos() >= u128::from(self.deadline_ns.load(Ordering::Relaxed))
    }

    /// Returns the policy by which the devices of workers yield at the end of a slice.
    pub fn yield_policy(&self) -> YieldPolicy {
        let end = self.clone();
        YieldPolicy::new(move || end.is_over(), yield_turn, run_in_background)
    }
}

/// Reports a pause and waits for the next slice of drawing time. Returns false if the picture is cancelled.
fn yield_turn() -> bool {
    CHANNELS.with_borrow(|channels| {
        // Other threads have no slices of drawing time.
        let Some(WorkerChannels { orders, reports, .. }) = channels else { return true };
        let is_heard = reports.send(TurnReport::Paused).is_ok();
        is_heard && matches!(orders.recv(), Ok(WorkerOrder::Resume(true)))
    })
}

/// Ends the slice, runs `work` as background work, and waits for the next slice. Returns false if the picture is
/// cancelled.
fn run_in_background(work: &mut (dyn FnMut() + Send)) -> bool {
    CHANNELS.with_borrow(|channels| {
        let Some(WorkerChannels { orders, reports, is_in_background, jobs }) = channels else {
            return (work(), true).1;
        };
        is_in_background.store(true, Ordering::Release);
        let is_heard = reports.send(TurnReport::InBackground).is_ok();
        let done = if is_heard { background::run_blocking(work) } else { Ok(false) };
        is_in_background.store(false, Ordering::Release);
        // If the queue is full, the loop is awake.
        let _ = jobs.try_send(Job::Wake);
        // A panic of the work ends this thread, which reports its end.
        let is_done = done.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        is_done && matches!(orders.recv(), Ok(WorkerOrder::Resume(true)))
    })
}

impl DrawWorker {
    /// Starts a thread that draws with `renderer`. The thread uploads the scene before it first draws.
    pub fn start(session: &Arc<RenderLease>, scene: &Arc<PosedScene>, shared: SharedScene, renderer: Renderer) -> Self {
        let (orders, inbox) = sync_channel(ORDER_QUEUE);
        let (outbox, reports) = sync_channel(REPORT_QUEUE);
        let (posed, uploaded) = (Arc::clone(scene), Arc::clone(&shared));
        let is_in_background = Arc::default();
        let channels = WorkerChannels {
            orders: inbox,
            reports: outbox.clone(),
            is_in_background: Arc::clone(&is_in_background),
            jobs: session.jobs.clone(),
        };
        let named = thread::Builder::new().name("draw".into());
        let thread = named.spawn(move || {
            let _last_word = ReportLostOnDrop(outbox.clone());
            CHANNELS.set(Some(channels));
            draw_in_turns(renderer, &posed, &uploaded, &outbox);
        });
        // Without a thread the reports end at once, and so does each request.
        let thread = thread.inspect_err(|error| tracing::error!("no thread can be started to draw: {error}")).ok();
        Self {
            scene: Arc::clone(scene),
            shared,
            session: Arc::downgrade(session),
            viewers: Vec::new(),
            paused: None,
            is_in_background,
            orders,
            reports,
            thread,
        }
    }

    /// True while the worker goes on with background work outside of its slice. It wakes the render loop when that work
    /// is done, and only then needs another slice.
    pub fn is_in_background(&self) -> bool {
        self.is_in_background.load(Ordering::Acquire)
    }

    pub fn is_for(&self, session: &Arc<RenderLease>, scene: &Arc<PosedScene>) -> bool {
        std::ptr::eq(self.session.as_ptr(), Arc::as_ptr(session)) && Arc::ptr_eq(&self.scene, scene)
    }

    /// Draws for about `turn`, or continues the paused picture if `drawing` is `None`. Blocks until the slice is over.
    pub fn draw(&mut self, drawing: Option<Box<PictureProgress>>, turn: Duration, end: &TurnDeadline) -> TurnReport {
        end.set(turn);
        let order = drawing.map_or(WorkerOrder::Resume(true), |drawing| WorkerOrder::Draw(drawing, turn));
        // A thread that has ended has reported that.
        let _ = self.orders.send(order);
        self.reports.recv().unwrap_or(TurnReport::Lost)
    }

    /// Cancels the paused picture. If the worker has background work, blocks until that work is done.
    pub fn cancel(&mut self) {
        if self.paused.take().is_some() {
            let _ = self.orders.send(WorkerOrder::Resume(false));
            let _ = self.reports.recv();
        }
    }

    /// Drops the data of a viewer. Does nothing while the worker is paused.
    pub fn forget(&self, slot: ViewSlot) {
        if self.paused.is_none() {
            let _ = self.orders.send(WorkerOrder::Forget(slot));
        }
    }
}

impl Drop for DrawWorker {
    /// Waits until the worker's data is freed.
    fn drop(&mut self) {
        self.cancel();
        let (nobody, _) = sync_channel(0);
        self.orders = nobody;
        join_thread(&mut self.thread, "a thread that draws");
    }
}

/// Carries out a worker's orders until the render loop drops the worker.
fn draw_in_turns(
    mut renderer: Renderer,
    scene: &Arc<PosedScene>,
    shared: &SharedScene,
    reports: &SyncSender<TurnReport>,
) {
    let next = || CHANNELS.with_borrow(|channels| channels.as_ref()?.orders.recv().ok());
    let mut is_there = false;
    while let Some(order) = next() {
        match order {
            WorkerOrder::Draw(mut drawing, turn) => {
                let opened = if is_there { Ok(()) } else { take_over(&mut renderer, scene, shared) };
                is_there |= opened.is_ok();
                let drawn = opened.and_then(|()| draw(&mut renderer, &mut drawing, turn));
                if reports.send(TurnReport::Ended(drawing, drawn)).is_err() {
                    return;
                }
            }
            WorkerOrder::Forget(slot) => renderer.drop_view(slot),
            WorkerOrder::Resume(_) => {}
        }
    }
}

/// Sets the renderer's scene: shares the upload of another session, or uploads the scene if it is the first.
fn take_over(renderer: &mut Renderer, scene: &Arc<PosedScene>, shared: &SharedScene) -> Result<(), RenderError> {
    if let Some(uploaded) = shared.get() {
        return renderer.share_scene(uploaded.clone());
    }
    renderer.set_scene(scene)?;
    // If two sessions upload at once, one copy is freed with its session.
    shared.get_or_init(|| renderer.scene_on_device());
    Ok(())
}

/// Draws for about `turn`. Returns the pixels if the picture is finished.
fn draw(renderer: &mut Renderer, drawing: &mut PictureProgress, turn: Duration) -> Result<Option<Pixels>, RenderError> {
    let PictureProgress { request, plan, picture, passes, drew_map } = drawing;
    let PictureRequest { view, lights, output, urgency, .. } = &**request;
    let maps = renderer.counts().shadow;
    let (width, height) = (view.width, view.height);
    let display = |bytes| Pixels::Display { width, height, bytes };
    let pixels = match plan {
        TurnPlan::Whole => Some(display(renderer.render_display(view, lights)?)),
        TurnPlan::Layers => match renderer.advance_display(view, lights, turn)? {
            Poll::Ready(bytes) => Some(display(bytes)),
            Poll::Pending => None,
        },
        TurnPlan::Tiles => {
            let mut tiled = match (picture.take(), output) {
                (Some(tiled), _) => tiled,
                (None, PictureFormat::Display) => TiledPicture::for_screen(view, lights)?,
                (None, PictureFormat::File(needs)) => TiledPicture::for_files(view, lights, *needs)?,
            };
            if renderer.advance_tiled(&mut tiled, turn)? {
                Some(tiled.into_pixels())
            } else {
                *picture = Some(tiled);
                None
            }
        }
    };
    renderer.runs().iter().for_each(|run| run.add_to(passes));
    *drew_map |= renderer.counts().shadow > maps;
    if pixels.is_some() && *urgency == Urgency::Still {
        renderer.release_view(view.slot);
    }
    Ok(pixels)
}
