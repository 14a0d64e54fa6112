//! A worker: a thread that draws a session's view of a scene in turns. Long work can pause in the middle of a piece
//! while another session is drawn. Only one thread draws at a time.

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

use super::{Job, PictureFormat, PictureRequest, RenderLease, Urgency};
use crate::background;
use crate::limits::{LARGE_PICTURE_PIXELS, MAX_MOVING_TURNS};

/// Orders that can wait for a worker: one to draw, and those to forget viewers, which wait behind it.
const ORDER_QUEUE: usize = 16;
/// Reports that can wait: the latest and the last.
const REPORT_QUEUE: usize = 2;

/// End of the current turn, shared by all drawing threads. Before the first turn it never comes.
#[derive(Clone, Debug)]
pub(super) struct TurnDeadline {
    start: Instant,
    /// Nanoseconds after `start`.
    deadline_ns: Arc<AtomicU64>,
}

/// Course of a picture through its turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TurnPlan {
    /// In layers of its lights, to its end in one turn.
    Whole,
    /// In layers of its lights, until the turn is over.
    Layers,
    /// Tile by tile, until the turn is over.
    Tiles,
}

impl TurnPlan {
    /// Plan of a new picture. `is_shared` is true while other clients draw moving pictures too.
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

    /// Plan of the picture's next turn, after that many turns.
    pub fn after(self, turns: u32, is_shared: bool) -> Self {
        match self {
            Self::Layers if !is_shared || turns >= MAX_MOVING_TURNS => Self::Whole,
            course => course,
        }
    }
}

/// Progress of a picture and results of its turns.
#[derive(Debug)]
pub(super) struct PictureProgress {
    pub request: Arc<PictureRequest>,
    pub plan: TurnPlan,
    /// Set if it is drawn in tiles.
    pub picture: Option<TiledPicture>,
    /// Passes so far.
    pub passes: Vec<PassRun>,
    /// True if a shadow map was drawn for it.
    pub drew_map: bool,
}

enum WorkerOrder {
    /// Draw for about that time.
    Draw(Box<PictureProgress>, Duration),
    /// Continue in the middle of a piece if true, cancel it if false.
    Resume(bool),
    /// Drop the data of a viewer.
    Forget(ViewSlot),
}

/// A worker's message at the end of its turn.
pub(super) enum TurnReport {
    /// It pauses in the middle of a piece.
    Paused,
    /// It does work that needs no turn. See [`DrawWorker::is_in_background`].
    InBackground,
    /// The turn is over. The pixels are there if the picture is finished.
    Ended(Box<PictureProgress>, Result<Option<Pixels>, RenderError>),
    /// The thread has ended, and its data is gone.
    Lost,
}

/// A scene on the device, shared by sessions. Empty until one of them has uploaded it.
pub(super) type SharedScene = Arc<OnceLock<SceneOnDevice>>;

/// A session's view of a scene: shadow maps and render targets, on a thread.
pub(super) struct DrawWorker {
    pub scene: Arc<PosedScene>,
    pub shared: SharedScene,
    /// The worker is dropped after its session.
    pub session: Weak<RenderLease>,
    /// Numbers and leases of the views and stills that it drew.
    pub viewers: Vec<(u64, Weak<RenderLease>)>,
    /// The task in the middle of which it pauses.
    pub paused: Option<u64>,
    /// True while it works on that task without a turn.
    is_in_background: Arc<AtomicBool>,
    orders: SyncSender<WorkerOrder>,
    reports: Receiver<TurnReport>,
    thread: Option<JoinHandle<()>>,
}

thread_local! {
    /// Channels of a worker's thread, with which it gives up its turn and waits for the next.
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

    /// Starts a turn of that length.
    fn set(&self, turn: Duration) {
        let at = self.start.elapsed().saturating_add(turn);
        self.deadline_ns.store(u64::try_from(at.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    fn is_over(&self) -> bool {
        self.start.elapsed().as_nanos() >= u128::from(self.deadline_ns.load(Ordering::Relaxed))
    }

    /// Yield policy for the devices of workers.
    pub fn yield_policy(&self) -> YieldPolicy {
        let end = self.clone();
        YieldPolicy::new(move || end.is_over(), yield_turn, run_in_background)
    }
}

/// Gives up the turn and waits for the next one. Returns false if the picture is cancelled.
fn yield_turn() -> bool {
    CHANNELS.with_borrow(|baton| {
        // Other threads have no turns.
        let Some(WorkerChannels { orders, reports, .. }) = baton else { return true };
        let is_heard = reports.send(TurnReport::Paused).is_ok();
        is_heard && matches!(orders.recv(), Ok(WorkerOrder::Resume(true)))
    })
}

/// Gives up the turn, does `work` as background work, and waits for the next turn. Returns false if the picture is
/// cancelled.
fn run_in_background(work: &mut (dyn FnMut() + Send)) -> bool {
    CHANNELS.with_borrow(|baton| {
        let Some(WorkerChannels { orders, reports, is_in_background: aside, jobs }) = baton else {
            return (work(), true).1;
        };
        aside.store(true, Ordering::Release);
        let is_heard = reports.send(TurnReport::InBackground).is_ok();
        let done = if is_heard { background::run_blocking(work) } else { Ok(false) };
        aside.store(false, Ordering::Release);
        // If the queue is full, the loop is awake.
        let _ = jobs.try_send(Job::Wake);
        // A panic of the work ends this thread, which reports its end.
        let is_done = done.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        is_done && matches!(orders.recv(), Ok(WorkerOrder::Resume(true)))
    })
}

impl DrawWorker {
    /// Starts a thread for `renderer`. It uploads the scene before it first draws.
    pub fn start(
        session: &Arc<RenderLease>,
        (scene, shared): (&Arc<PosedScene>, SharedScene),
        renderer: Renderer,
    ) -> Self {
        let (orders, inbox) = sync_channel(ORDER_QUEUE);
        let (outbox, reports) = sync_channel(REPORT_QUEUE);
        let (posed, uploaded) = (Arc::clone(scene), Arc::clone(&shared));
        let (is_in_background, jobs) = (Arc::default(), session.jobs.clone());
        let baton = WorkerChannels {
            orders: inbox,
            reports: outbox.clone(),
            is_in_background: Arc::clone(&is_in_background),
            jobs,
        };
        let named = thread::Builder::new().name("draw".into());
        let thread = named.spawn(move || {
            let _last_word = ReportLostOnDrop(outbox.clone());
            CHANNELS.set(Some(baton));
            draw_in_turns(renderer, (&posed, &uploaded), &outbox);
        });
        // Without a thread the reports end at once, and so does each request.
        let thread =
            thread.inspect_err(|error| tracing::error!("no thread can be started to draw: {error}")).ok();
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

    /// True while it works without a turn. It needs none until it wakes the loop.
    pub fn is_in_background(&self) -> bool {
        self.is_in_background.load(Ordering::Acquire)
    }

    pub fn is_for(&self, session: &Arc<RenderLease>, scene: &Arc<PosedScene>) -> bool {
        std::ptr::eq(self.session.as_ptr(), Arc::as_ptr(session)) && Arc::ptr_eq(&self.scene, scene)
    }

    /// Draws for about `turn`, or continues the paused picture. Waits until the turn is over.
    pub fn draw(
        &mut self,
        drawing: Option<Box<PictureProgress>>,
        turn: Duration,
        end: &TurnDeadline,
    ) -> TurnReport {
        end.set(turn);
        let order = drawing.map_or(WorkerOrder::Resume(true), |drawing| WorkerOrder::Draw(drawing, turn));
        // A thread that has ended has reported that.
        let _ = self.orders.send(order);
        self.reports.recv().unwrap_or(TurnReport::Lost)
    }

    /// Cancels the paused picture. If the worker is in the background, waits until that work is done.
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
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("a thread that draws had panicked");
        }
    }
}

/// Loop of a worker's thread.
fn draw_in_turns(
    mut renderer: Renderer,
    scene: (&Arc<PosedScene>, &SharedScene),
    reports: &SyncSender<TurnReport>,
) {
    let next = || CHANNELS.with_borrow(|baton| baton.as_ref()?.orders.recv().ok());
    let mut is_there = false;
    while let Some(order) = next() {
        match order {
            WorkerOrder::Draw(mut drawing, turn) => {
                let opened = if is_there { Ok(()) } else { take_over(&mut renderer, scene) };
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

/// Uploads a scene, or shares the upload of another session.
fn take_over(
    renderer: &mut Renderer,
    (scene, shared): (&Arc<PosedScene>, &SharedScene),
) -> Result<(), RenderError> {
    if let Some(uploaded) = shared.get() {
        return renderer.share_scene(uploaded.clone());
    }
    renderer.set_scene(scene)?;
    // If two sessions upload at once, one copy is freed with its session.
    shared.get_or_init(|| renderer.scene_on_device());
    Ok(())
}

/// Draws for a turn. Returns the picture once it is finished.
fn draw(
    renderer: &mut Renderer,
    drawing: &mut PictureProgress,
    turn: Duration,
) -> Result<Option<Pixels>, RenderError> {
    let PictureProgress { request, plan: course, picture, passes, drew_map } = drawing;
    let PictureRequest { view, lights, output, urgency, .. } = &**request;
    let maps = renderer.counts().shadow;
    let (width, height) = (view.width, view.height);
    let display = |bytes| Pixels::Display { width, height, bytes };
    let pixels = match course {
        TurnPlan::Whole => Some(display(renderer.render_display(view, lights)?)),
        TurnPlan::Layers => match renderer.advance_display(view, lights, turn)? {
            Poll::Ready(bytes) => Some(display(bytes)),
            Poll::Pending => None,
        },
        TurnPlan::Tiles => {
            let mut begun = match (picture.take(), output) {
                (Some(begun), _) => begun,
                (None, PictureFormat::Display) => TiledPicture::for_screen(view, lights)?,
                (None, PictureFormat::File(needs)) => TiledPicture::for_files(view, lights, *needs)?,
            };
            if renderer.advance_tiled(&mut begun, turn)? {
                Some(begun.into_pixels())
            } else {
                *picture = Some(begun);
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
