//! The render thread: all that it holds, and its loop.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::task::Poll;
use std::thread;
use std::time::{Duration, Instant};

use render::{Backend, Gpu, MemoryBudget, PassRun, Pixels, RenderError, Renderer, TiledPicture};
use scene::PosedScene;
use tokio::runtime::{self, Runtime};
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::schedule::{Schedule, Turn, Urgency, Waiting};
use super::{Answer, Drawn, Job, Lease, Output, Readiness, Request};
use crate::limits::{LARGE_PICTURE_PIXELS, MAX_MOVING_TURNS, RENDER_QUEUE, SHARED_FOR};
use crate::metrics::Metrics;
use crate::turns::{Charges, Payer};

/// A request on its way.
#[derive(Debug)]
struct Task {
    request: Request,
    done: Answer,
    started: Option<Instant>,
    took: Duration,
    /// When it was last worked on, or since when it waits.
    touched: Instant,
    /// Whether a shadow map was drawn for it.
    drew_map: bool,
    /// Which passes it has come to.
    passes: Vec<PassRun>,
    /// How often it was worked on.
    turns: u32,
    /// What there is of it, where it is drawn in tiles.
    picture: Option<TiledPicture>,
    /// Whether it is drawn by layers of its lights, where that is decided; else in tiles.
    by_layers: Option<bool>,
}

/// All that the render thread holds.
pub(super) struct RenderLoop {
    /// Never draws; the others share its pipelines.
    base: Renderer,
    /// Counts what is kept, also when the device was lost and is opened again.
    memory: MemoryBudget,
    /// Who draws shadows and lights; as the device is where nobody says.
    backend: Option<Backend>,
    /// The one that drew last at the end.
    scenes: Vec<SceneRenderer>,
    inbox: mpsc::Receiver<Job>,
    /// Nothing is to be drawn any more.
    ended: Arc<AtomicBool>,
    waiting: Vec<Task>,
    schedule: Schedule,
    /// What each client has been charged for drawing.
    charges: Charges,
    /// Who drew moving pictures lately, and when.
    movers: BTreeMap<Payer, Instant>,
    /// What a core is of all of them.
    core_share: f64,
    metrics: Arc<Metrics>,
    /// Waits for jobs and for time.
    clock: Runtime,
}

/// A scene on the device, for all sessions that show it.
struct SceneRenderer {
    scene: Arc<PosedScene>,
    renderer: Renderer,
    /// The sessions that showed it; without them it goes.
    sessions: Vec<Weak<Lease>>,
    /// Whose views and stills it drew.
    viewers: Vec<(u64, Weak<Lease>)>,
}

impl Task {
    fn new(request: Request, done: Answer) -> Self {
        let (started, touched) = (None, request.place.since);
        Self {
            request,
            done,
            started,
            took: Duration::ZERO,
            touched,
            drew_map: false,
            passes: Vec::new(),
            turns: 0,
            picture: None,
            by_layers: None,
        }
    }
}

impl RenderLoop {
    /// Opens the device.
    pub fn open(
        (metrics, backend): (Arc<Metrics>, Option<Backend>),
        inbox: mpsc::Receiver<Job>,
        ended: Arc<AtomicBool>,
    ) -> Result<Self, RenderError> {
        let memory = metrics.render_memory().clone();
        let clock = runtime::Builder::new_current_thread().enable_time().build();
        Ok(Self {
            base: open(&memory, backend)?,
            memory,
            backend,
            scenes: Vec::new(),
            inbox,
            ended,
            waiting: Vec::new(),
            schedule: Schedule::new(),
            charges: Charges::default(),
            movers: BTreeMap::new(),
            core_share: 1.0 / thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64),
            metrics,
            clock: clock.expect("a runtime that only tells the time asks nothing of the system"),
        })
    }

    /// Draws every pipeline once.
    pub fn warm_up(&self) -> Readiness {
        let started = Instant::now();
        match self.base.compile_pipelines(|| !self.ended.load(Ordering::Relaxed)) {
            Ok(()) if self.ended.load(Ordering::Relaxed) => Readiness::WarmingUp,
            Ok(()) => {
                tracing::info!("every pipeline has drawn once, in {} ms", started.elapsed().as_millis());
                Readiness::Ready
            }
            Err(error) => {
                tracing::error!("the pipelines cannot be warmed up: {error}");
                Readiness::Failed(error)
            }
        }
    }

    /// Draws until the server ends.
    pub fn run(mut self) {
        while !self.ended.load(Ordering::Relaxed) {
            self.clear_up();
            let waiting: Vec<Waiting> = self
                .waiting
                .iter()
                .map(|task| Waiting {
                    urgency: task.request.urgency,
                    charged: self.charges.of(&task.request.payer),
                    touched: task.touched,
                })
                .collect();
            let goes_on = match self.schedule.next(Instant::now(), &waiting) {
                Turn::Draw(index, turn) => {
                    let task = self.waiting.remove(index);
                    self.work_on(task, turn);
                    true
                }
                Turn::Wait(time) => self.listen(time),
                Turn::Idle => self.listen(Duration::MAX),
            };
            if !goes_on {
                return;
            }
            while self.waiting.len() < RENDER_QUEUE
                && let Ok(job) = self.inbox.try_recv()
            {
                self.take(job);
            }
        }
    }

    /// Waits for a job. False where none can come any more.
    fn listen(&mut self, time: Duration) -> bool {
        let inbox = &mut self.inbox;
        match self.clock.block_on(async { timeout(time, inbox.recv()).await }) {
            Ok(Some(job)) => self.take(job),
            Ok(None) => return false,
            Err(_) => {}
        }
        true
    }

    fn take(&mut self, job: Job) {
        match job {
            Job::Draw(request, done) => self.waiting.push(Task::new(*request, done)),
            // The renderer draws with all cores.
            Job::Charge(payer, took) => self.charges.charge(&payer, took.as_secs_f64() * self.core_share),
            // Who is gone is seen before each turn.
            Job::Wake => {}
        }
    }

    /// Frees what was kept for those who are gone.
    fn clear_up(&mut self) {
        self.waiting.retain(|task| !task.done.is_closed());
        for SceneRenderer { renderer, sessions, viewers, .. } in &mut self.scenes {
            sessions.retain(|session| session.strong_count() > 0);
            viewers.retain(|(number, viewer)| {
                let is_there = viewer.strong_count() > 0;
                if !is_there {
                    renderer.forget(render::ViewSlot(*number));
                }
                is_there
            });
        }
        let before = self.scenes.len();
        self.scenes.retain(|held| !held.sessions.is_empty());
        if self.scenes.len() < before {
            self.base.collect();
        }
        let stills = self.waiting.iter().filter(|task| task.request.urgency == Urgency::Still);
        self.metrics.least_still_turns.set(stills.map(|task| i64::from(task.turns)).min().unwrap_or(0));
    }

    /// Gives a picture its turn, and hands it over where it is finished. One that was given up is not begun.
    fn work_on(&mut self, mut task: Task, turn: Duration) {
        if task.started.is_none() && !task.request.place.take() {
            return;
        }
        let began = Instant::now();
        let started = *task.started.get_or_insert(began);
        let moves = matches!(task.request.urgency, Urgency::Moving | Urgency::Watched);
        if moves {
            self.movers.insert(task.request.payer.clone(), began);
            self.movers.retain(|_, drew| began.saturating_duration_since(*drew) < SHARED_FOR);
        }
        let result = self.draw_or_reopen(&mut task, turn);
        let (ended, urgency) = (Instant::now(), task.request.urgency);
        task.touched = ended;
        task.took += ended - began;
        task.turns += 1;
        self.charges.charge(&task.request.payer, (ended - began).as_secs_f64());
        self.schedule.note(urgency, [began, ended], matches!(result, Ok(Some(_))).then_some(task.took));
        if urgency == Urgency::Still {
            self.metrics.still_turns.inc();
        }
        let (took, drew_map) = (task.took, task.drew_map);
        match result {
            Ok(None) => self.waiting.push(task),
            Ok(Some(pixels)) => {
                let drawn = Drawn { pixels, started, took, drew_map, passes: task.passes };
                drop(task.done.send(Ok(drawn)));
            }
            Err(error) => drop(task.done.send(Err(error))),
        }
    }

    fn draw_or_reopen(&mut self, task: &mut Task, turn: Duration) -> Result<Option<Pixels>, RenderError> {
        let result = self.draw(task, turn);
        if let Err(RenderError::DeviceLost(why)) = &result {
            tracing::error!("the graphics device was lost ({why}) and is opened again");
            // What was on it is gone: pictures under way begin again.
            self.scenes.clear();
            task.picture = None;
            for other in &mut self.waiting {
                other.picture = None;
            }
            self.base = open(&self.memory, self.backend)?;
            return self.draw(task, turn);
        }
        result
    }

    /// A turn of drawing; the picture where it is finished.
    fn draw(&mut self, task: &mut Task, turn: Duration) -> Result<Option<Pixels>, RenderError> {
        let is_shared = self.movers.len() > 1;
        let Task { request, picture, passes, drew_map, by_layers, turns, .. } = task;
        let renderer = self.scene_renderer(request)?;
        let Request { view, lights, output, urgency, .. } = &*request;
        let maps = renderer.counts().shadow;
        let moves = matches!(urgency, Urgency::Moving | Urgency::Watched);
        let is_large =
            view.width * view.height > LARGE_PICTURE_PIXELS || !renderer.keeps_layers(view, lights.len());
        let by_layers = *by_layers.get_or_insert(moves && !(is_shared && is_large));
        let pixels = if by_layers {
            // Late already where it is the only one: then as a whole.
            let is_whole = !is_shared || *turns >= MAX_MOVING_TURNS;
            let drawn = if is_whole {
                Poll::Ready(renderer.render_display(view, lights)?)
            } else {
                renderer.display_some(view, lights, turn)?
            };
            let (width, height) = (view.width, view.height);
            match drawn {
                Poll::Ready(bytes) => Some(Pixels::Display { width, height, bytes }),
                Poll::Pending => None,
            }
        } else {
            let mut begun = match (picture.take(), output) {
                (Some(begun), _) => begun,
                (None, Output::Display) => TiledPicture::for_screen(view, lights)?,
                (None, Output::File(format)) => TiledPicture::for_file(view, lights, *format)?,
            };
            if renderer.draw_some(&mut begun, turn)? {
                Some(begun.into_pixels())
            } else {
                *picture = Some(begun);
                None
            }
        };
        renderer.runs().iter().for_each(|run| run.add_to(passes));
        *drew_map |= renderer.counts().shadow > maps;
        if pixels.is_some() && *urgency == Urgency::Still {
            renderer.rest(view.slot);
        }
        Ok(pixels)
    }

    /// The renderer of a request's scene.
    fn scene_renderer(&mut self, request: &Request) -> Result<&mut Renderer, RenderError> {
        let Request { session, viewer, scene, .. } = request;
        let known = self.scenes.iter().position(|held| Arc::ptr_eq(&held.scene, scene));
        let mut held =
            if let Some(index) = known { self.scenes.remove(index) } else { self.open_scene(scene)? };
        let is_listed =
            |listed: &Weak<Lease>, lease: &Arc<Lease>| std::ptr::eq(listed.as_ptr(), &raw const **lease);
        if !held.sessions.iter().any(|known| is_listed(known, session)) {
            held.sessions.push(Arc::downgrade(session));
        }
        if !held.viewers.iter().any(|(_, known)| is_listed(known, viewer)) {
            // A view shows one scene: what was kept of another one for it goes.
            for SceneRenderer { renderer, viewers, .. } in &mut self.scenes {
                viewers.retain(|(number, _)| *number != viewer.number);
                renderer.forget(viewer.slot());
            }
            held.viewers.push((viewer.number, Arc::downgrade(viewer)));
        }
        self.scenes.push(held);
        Ok(&mut self.scenes.last_mut().expect("one was pushed").renderer)
    }

    /// Puts a scene on the device. Scenes that nobody looks at go where more than half of the budget is taken, and others, the
    /// longest unused first, where all of it is.
    fn open_scene(&mut self, scene: &Arc<PosedScene>) -> Result<SceneRenderer, RenderError> {
        while self.memory.total() > self.memory.budget() / 2
            && let Some(idle) = self.scenes.iter().position(|held| held.viewers.is_empty())
        {
            self.scenes.remove(idle);
        }
        self.base.collect();
        let mut renderer = self.base.with_same_pipelines()?;
        renderer.set_scene(scene)?;
        while self.memory.total() > self.memory.budget() && !self.scenes.is_empty() {
            self.scenes.remove(0);
        }
        self.base.collect();
        Ok(SceneRenderer { scene: Arc::clone(scene), renderer, sessions: Vec::new(), viewers: Vec::new() })
    }
}

fn open(memory: &MemoryBudget, backend: Option<Backend>) -> Result<Renderer, RenderError> {
    let gpu = Gpu::open(memory.clone(), backend)?;
    tracing::info!("rendering with {}, shadows and lights by {}", gpu.adapter_name(), gpu.backend().name());
    if let Some(advice) = gpu.advice() {
        tracing::warn!("{advice}");
    }
    Renderer::new(Arc::new(gpu))
}
