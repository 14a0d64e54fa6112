//! What a session shows of a scene, on a thread of its own, which draws when it has the turn: so a piece of work that takes long
//! can rest in its middle while another session's is drawn. Only one thread draws at a time.

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

/// Orders that wait for a worker: one to draw, and those to forget viewers, which wait for the ones before.
const ORDER_QUEUE: usize = 16;
/// Reports that wait: the latest, and the last.
const REPORT_QUEUE: usize = 2;

/// When the turn under way is over, for all threads that draw. No turn is under way at first, and so it never is.
#[derive(Clone, Debug)]
pub(super) struct TurnDeadline {
    start: Instant,
    /// Nanoseconds after `arrive`.
    deadline_ns: Arc<AtomicU64>,
}

/// How a turn of a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TurnPlan {
    /// By layers of its lights, to its end.
    Whole,
    /// By layers of its lights, until the turn is over.
    Layers,
    /// Tile by tile, until the turn is over.
    Tiles,
}

impl TurnPlan {
    /// That of a picture that is begun, while others draw moving ones where it `is_shared`.
    pub fn of(request: &PictureRequest, is_shared: bool, renderer: &Renderer) -> Self {
        let PictureRequest { view, lights, urgency, .. } = request;
        let is_large = view.width * view.height > LARGE_PICTURE_PIXELS;
        match (urgency.is_moving(), is_shared) {
            (false, _) => Self::Tiles,
            // It is late already, and what is kept of the one before makes it quick.
            (true, false) => Self::Whole,
            (true, true) if is_large || !renderer.keeps_layers(view, lights.len()) => Self::Tiles,
            (true, true) => Self::Layers,
        }
    }

    /// That of its next turn, after so many.
    pub fn after(self, turns: u32, is_shared: bool) -> Self {
        match self {
            Self::Layers if !is_shared || turns >= MAX_MOVING_TURNS => Self::Whole,
            course => course,
        }
    }
}

/// What there is of a picture, and what its latest turn came to.
#[derive(Debug)]
pub(super) struct PictureProgress {
    pub request: Arc<PictureRequest>,
    pub plan: TurnPlan,
    /// Where it is drawn in tiles.
    pub picture: Option<TiledPicture>,
    /// Which passes it has come to.
    pub passes: Vec<PassRun>,
    /// Whether a shadow map was drawn for it.
    pub drew_map: bool,
}

/// What a worker is told.
enum WorkerOrder {
    /// To draw for about so long.
    Draw(Box<PictureProgress>, Duration),
    /// To go on in the middle of what it draws; false to give that up.
    Resume(bool),
    /// To drop what is kept for a viewer.
    Forget(ViewSlot),
}

/// What a worker says when it gives the turn back.
pub(super) enum TurnReport {
    /// It rests in the middle of a piece.
    Paused,
    /// It does work for which it needs no turn; see [`DrawWorker::is_in_background`].
    InBackground,
    /// The turn is over: the pixels where the picture is finished.
    Ended(Box<PictureProgress>, Result<Option<Pixels>, RenderError>),
    /// The thread has ended, and what it held is gone.
    Lost,
}

/// A scene on the device as sessions share it; empty before one of them has taken it over.
pub(super) type SharedScene = Arc<OnceLock<SceneOnDevice>>;

/// What a session shows of a scene: its maps, and what its views are drawn into.
pub(super) struct DrawWorker {
    pub scene: Arc<PosedScene>,
    pub shared: SharedScene,
    /// The session that it is for, without which it goes.
    pub session: Weak<RenderLease>,
    /// Whose views and stills it drew.
    pub viewers: Vec<(u64, Weak<RenderLease>)>,
    /// The task in the middle of which it rests.
    pub paused: Option<u64>,
    /// Whether it works in the middle of that without a turn.
    is_in_background: Arc<AtomicBool>,
    orders: SyncSender<WorkerOrder>,
    reports: Receiver<TurnReport>,
    thread: Option<JoinHandle<()>>,
}

thread_local! {
    /// On a worker's thread: how it gives the turn back in the middle of a piece, and gets it again.
    static CHANNELS: RefCell<Option<WorkerChannels>> = const { RefCell::new(None) };
}

struct WorkerChannels {
    orders: Receiver<WorkerOrder>,
    reports: SyncSender<TurnReport>,
    is_in_background: Arc<AtomicBool>,
    /// Wakes the renderer's loop.
    jobs: mpsc::Sender<Job>,
}

/// Says on its end that a worker's thread has ended, whatever ended it.
struct ReportLostOnDrop(SyncSender<TurnReport>);

impl Drop for ReportLostOnDrop {
    fn drop(&mut self) {
        // Nobody is told where the renderer's loop has ended before.
        let _ = self.0.send(TurnReport::Lost);
    }
}

impl TurnDeadline {
    pub fn new() -> Self {
        Self { start: Instant::now(), deadline_ns: Arc::new(AtomicU64::new(u64::MAX)) }
    }

    /// The turn that begins is over after so long.
    fn set(&self, turn: Duration) {
        let at = self.start.elapsed().saturating_add(turn);
        self.deadline_ns.store(u64::try_from(at.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    fn is_over(&self) -> bool {
        self.start.elapsed().as_nanos() >= u128::from(self.deadline_ns.load(Ordering::Relaxed))
    }

    /// What devices are opened with whose renderers are workers'.
    pub fn yield_policy(&self) -> YieldPolicy {
        let end = self.clone();
        YieldPolicy::new(move || end.is_over(), yield_turn, run_in_background)
    }
}

/// Gives the turn back until it comes again. False where what is drawn is given up.
fn yield_turn() -> bool {
    CHANNELS.with_borrow(|baton| {
        // Whoever draws on another thread has no turns.
        let Some(WorkerChannels { orders, reports, .. }) = baton else { return true };
        let is_heard = reports.send(TurnReport::Paused).is_ok();
        is_heard && matches!(orders.recv(), Ok(WorkerOrder::Resume(true)))
    })
}

/// Gives the turn back, does `work` as work in the background is done, and waits for the turn. False where what is drawn is
/// given up.
fn run_in_background(work: &mut (dyn FnMut() + Send)) -> bool {
    CHANNELS.with_borrow(|baton| {
        let Some(WorkerChannels { orders, reports, is_in_background: aside, jobs }) = baton else {
            return (work(), true).1;
        };
        aside.store(true, Ordering::Release);
        let is_heard = reports.send(TurnReport::InBackground).is_ok();
        let done = if is_heard { background::run_blocking(work) } else { Ok(false) };
        aside.store(false, Ordering::Release);
        // Where the queue is full the loop is awake.
        let _ = jobs.try_send(Job::Wake);
        // As if this thread had done it: it ends, and says so.
        let is_done = done.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        is_done && matches!(orders.recv(), Ok(WorkerOrder::Resume(true)))
    })
}

impl DrawWorker {
    /// A thread for `renderer`, which takes over the scene when it first draws.
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
        // Where none can be started the reports end at once, and so does what is asked for.
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

    /// Whether it works without a turn, and needs none until the loop is woken.
    pub fn is_in_background(&self) -> bool {
        self.is_in_background.load(Ordering::Acquire)
    }

    /// Whether it is for this session and scene.
    pub fn is_for(&self, session: &Arc<RenderLease>, scene: &Arc<PosedScene>) -> bool {
        std::ptr::eq(self.session.as_ptr(), Arc::as_ptr(session)) && Arc::ptr_eq(&self.scene, scene)
    }

    /// Draws for about `turn`, or goes on with what it is in the middle of; waits until the turn is given back.
    pub fn draw(
        &mut self,
        drawing: Option<Box<PictureProgress>>,
        turn: Duration,
        end: &TurnDeadline,
    ) -> TurnReport {
        end.set(turn);
        let order = drawing.map_or(WorkerOrder::Resume(true), |drawing| WorkerOrder::Draw(drawing, turn));
        // One that has ended has said so.
        let _ = self.orders.send(order);
        self.reports.recv().unwrap_or(TurnReport::Lost)
    }

    /// Gives up what it is in the middle of; where it is aside, waits until that work is done.
    pub fn cancel(&mut self) {
        if self.paused.take().is_some() {
            let _ = self.orders.send(WorkerOrder::Resume(false));
            let _ = self.reports.recv();
        }
    }

    /// Drops what is kept for a viewer; in the middle of a piece, once that is over.
    pub fn forget(&self, slot: ViewSlot) {
        if self.paused.is_none() {
            let _ = self.orders.send(WorkerOrder::Forget(slot));
        }
    }
}

impl Drop for DrawWorker {
    /// What it holds is gone when this returns.
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

/// What a worker's thread does.
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

/// Takes over a scene, from another session where one has done so.
fn take_over(
    renderer: &mut Renderer,
    (scene, shared): (&Arc<PosedScene>, &SharedScene),
) -> Result<(), RenderError> {
    if let Some(uploaded) = shared.get() {
        return renderer.share_scene(uploaded.clone());
    }
    renderer.set_scene(scene)?;
    // Where two have done it at once, one copy goes with its session.
    shared.get_or_init(|| renderer.scene_on_device());
    Ok(())
}

/// A turn of drawing; the picture where it is finished.
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
