//! The loop of the render thread, and its state.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use render::{Backend, Device, Host, MemoryBudget, RenderError, Renderer};
use scene::PosedScene;
use tokio::runtime::{self, Runtime};
use tokio::sync::mpsc;
use tokio::time::timeout;

use super::schedule::{QueuedPicture, Schedule, ScheduledTurn, Urgency};
use super::worker::{DrawWorker, PictureProgress, SharedScene, TurnDeadline, TurnPlan, TurnReport};
use super::{DrawnPicture, Job, PictureReply, PictureRequest, Readiness, RenderLease};
use crate::charges::{Charges, Payer};
use crate::limits::{MAX_PICTURES, MAX_TURN, SHARED_FOR};
use crate::metrics::Metrics;

/// Requested picture that waits or is being drawn.
#[derive(Debug)]
struct PictureTask {
    id: u64,
    request: Arc<PictureRequest>,
    reply: PictureReply,
    started: Option<Instant>,
    took: Duration,
    /// End of the picture's latest slice of drawing time, or the time at which it was queued.
    last_turn_at: Instant,
    turns: u32,
    /// True if the device was lost while this picture was drawn.
    lost_device: bool,
    /// Progress of the picture. `None` before drawing begins, and while the worker has it.
    drawing: Option<Box<PictureProgress>>,
}

/// State of the render thread.
pub(super) struct RenderLoop {
    /// Renderer that never draws. The workers share its pipelines.
    base: Renderer,
    /// Counts the memory of all renderers, across a lost device.
    memory: MemoryBudget,
    /// Backend of shadows and lights. `None` chooses it by the device.
    backend: Option<Backend>,
    /// Threads that draw, one per session and scene. The one that drew last is at the end.
    workers: Vec<DrawWorker>,
    turn_end: TurnDeadline,
    inbox: mpsc::Receiver<Job>,
    /// True once the thread has to end.
    ended: Arc<AtomicBool>,
    waiting: Vec<PictureTask>,
    last_task: u64,
    schedule: Schedule,
    /// Seconds of drawing charged to each client.
    charges: Charges,
    /// Clients that drew moving pictures lately, each with the time of its latest one.
    moving_payers: BTreeMap<Payer, Instant>,
    /// Factor from seconds of one core to seconds of all cores: 1 over the number of cores.
    core_share: f64,
    metrics: Arc<Metrics>,
    /// Runtime on which the thread waits for jobs, with a timeout.
    clock: Runtime,
}

impl RenderLoop {
    pub fn open(
        metrics: Arc<Metrics>,
        backend: Option<Backend>,
        inbox: mpsc::Receiver<Job>,
        ended: Arc<AtomicBool>,
    ) -> Result<Self, RenderError> {
        let memory = metrics.render_memory().clone();
        let clock = runtime::Builder::new_current_thread().enable_time().build();
        let turn_end = TurnDeadline::new();
        Ok(Self {
            base: open(&memory, backend, &turn_end)?,
            memory,
            backend,
            workers: Vec::new(),
            turn_end,
            inbox,
            ended,
            waiting: Vec::new(),
            last_task: 0,
            schedule: Schedule::default(),
            charges: Charges::default(),
            moving_payers: BTreeMap::new(),
            core_share: 1.0 / thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64),
            metrics,
            clock: clock.expect("a runtime that only tells the time asks nothing of the system"),
        })
    }

    /// Draws once with every pipeline, which compiles it.
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

    pub fn run(mut self) {
        while !self.ended.load(Ordering::Relaxed) {
            self.release_unused();
            let (indices, waiting) = self.queued_tasks();
            let more_may_come = match self.schedule.next(Instant::now(), &waiting) {
                ScheduledTurn::Draw(index, turn) => {
                    self.run_turn(indices[index], turn);
                    true
                }
                ScheduledTurn::Wait(time) => self.wait_for_job(time),
                ScheduledTurn::Idle => self.wait_for_job(Duration::MAX),
            };
            if !more_may_come {
                return;
            }
            while has_room(&mut self.waiting, |task| task.reply.is_closed())
                && let Ok(job) = self.inbox.try_recv()
            {
                self.handle_job(job);
            }
        }
    }

    /// Returns the indices of the tasks that wait for drawing time, and the data about each that the schedule needs.
    fn queued_tasks(&self) -> (Vec<usize>, Vec<QueuedPicture>) {
        let background: Vec<&DrawWorker> = self.workers.iter().filter(|worker| worker.is_in_background()).collect();
        let is_in_background = |task: &PictureTask| {
            let PictureRequest { session, scene, .. } = &*task.request;
            background.iter().any(|worker| worker.is_for(session, scene))
        };
        let waiting = self.waiting.iter().enumerate().filter(|(_, task)| !is_in_background(task));
        let queued = waiting.map(|(index, task)| {
            let PictureRequest { urgency, payer, ticket, .. } = &*task.request;
            let (urgency, charged) = (*urgency, self.charges.of(payer));
            let (last_turn_at, queued_at) = (task.last_turn_at, ticket.queued_at);
            (index, QueuedPicture { urgency, charged, last_turn_at, queued_at })
        });
        queued.unzip()
    }

    /// Waits for a job, for at most `time`. Returns false if no more jobs can come.
    fn wait_for_job(&mut self, time: Duration) -> bool {
        let inbox = &mut self.inbox;
        match self.clock.block_on(async { timeout(time, inbox.recv()).await }) {
            Ok(Some(job)) => self.handle_job(job),
            Ok(None) => return false,
            Err(_) => {}
        }
        true
    }

    fn handle_job(&mut self, job: Job) {
        match job {
            // Cancelled in the queue: each change of a document cancels a picture of each view.
            Job::Draw(_, done) if done.is_closed() => {}
            Job::Draw(request, done) => {
                self.last_task += 1;
                self.waiting.push(PictureTask {
                    id: self.last_task,
                    last_turn_at: request.ticket.queued_at,
                    request: request.into(),
                    reply: done,
                    started: None,
                    took: Duration::ZERO,
                    turns: 0,
                    lost_device: false,
                    drawing: None,
                });
            }
            // The renderer draws with all cores.
            Job::Charge(payer, took) => self.charges.charge(&payer, took.as_secs_f64() * self.core_share),
            // Nothing to do: dropped leases are released before each slice of drawing time.
            Job::Wake => {}
        }
    }

    /// Frees the data of dropped leases.
    fn release_unused(&mut self) {
        self.waiting.retain(|task| !task.reply.is_closed());
        let before = self.workers.len();
        for worker in self.workers.iter_mut().filter(|worker| !worker.is_in_background()) {
            if worker.paused.is_some_and(|id| self.waiting.iter().all(|task| task.id != id)) {
                worker.cancel();
            }
            if worker.paused.is_some() {
                continue;
            }
            let gone = worker.viewers.extract_if(.., |(_, viewer)| viewer.strong_count() == 0);
            for (number, _) in gone.collect::<Vec<_>>() {
                worker.forget(render::ViewSlot(number));
            }
        }
        self.workers.retain(|worker| worker.is_in_background() || worker.session.strong_count() > 0);
        if self.workers.len() < before {
            self.base.free_dropped_memory();
        }
        let of = |urgency| self.waiting.iter().filter(move |task| task.request.urgency == urgency);
        for urgency in Urgency::ALL {
            self.metrics.note_queue(urgency.name(), of(urgency).count());
        }
        self.metrics.least_still_turns.set(of(Urgency::Still).map(|task| i64::from(task.turns)).min().unwrap_or(0));
    }

    /// Draws the waiting picture `index` for about `turn`, and sends it if it is finished. A cancelled picture is not
    /// begun. If the worker of the picture's scene has paused in another picture, that one is continued instead.
    fn run_turn(&mut self, index: usize, turn: Duration) {
        let request = Arc::clone(&self.waiting[index].request);
        let mut worker = match self.worker(&request) {
            Ok(worker) => worker,
            Err(error) => {
                drop(self.waiting.swap_remove(index).reply.send(Err(error)));
                return;
            }
        };
        let index = self.waiting.iter().position(|task| Some(task.id) == worker.paused).unwrap_or(index);
        let task = &mut self.waiting[index];
        if task.started.is_none() && !task.request.ticket.claim() {
            self.waiting.swap_remove(index);
            self.workers.push(worker);
            return;
        }
        let began = Instant::now();
        if task.request.urgency.is_moving() {
            self.moving_payers.insert(task.request.payer.clone(), began);
            self.moving_payers.retain(|_, drew| began.saturating_duration_since(*drew) < SHARED_FOR);
        }
        let is_shared = self.moving_payers.len() > 1;
        task.started.get_or_insert(began);
        let drawing = worker.paused.is_none().then(|| match task.drawing.take() {
            Some(mut drawing) => {
                drawing.plan = drawing.plan.after(task.turns, is_shared);
                drawing
            }
            None => Box::new(PictureProgress {
                plan: TurnPlan::of(&task.request, is_shared, &self.base),
                request: Arc::clone(&task.request),
                picture: None,
                passes: Vec::new(),
                drew_map: false,
            }),
        });
        let is_new = worker.viewers.len() == 1 && task.turns == 0;
        let report = worker.draw(drawing, turn, &self.turn_end);
        let ended = Instant::now();
        let took = ended - began;
        task.last_turn_at = ended;
        task.took += took;
        task.turns += 1;
        let urgency = task.request.urgency;
        self.charges.charge(&task.request.payer, took.as_secs_f64());
        self.schedule.record_turn(urgency, [began, ended]);
        self.metrics.render_turn_seconds.observe(took.as_secs_f64());
        if urgency == Urgency::Still {
            self.metrics.still_turns.inc();
        }
        if took > MAX_TURN {
            let render::View { width, height, .. } = task.request.view;
            let took = took.as_millis();
            tracing::debug!("a turn took {took} ms: {urgency:?}, {width}x{height}, turn {}", task.turns);
        }
        worker.paused = matches!(report, TurnReport::Paused | TurnReport::InBackground).then_some(task.id);
        match report {
            TurnReport::Paused | TurnReport::InBackground => self.workers.push(worker),
            TurnReport::Ended(drawing, Ok(None)) => {
                task.drawing = Some(drawing);
                self.workers.push(worker);
            }
            TurnReport::Ended(drawing, Ok(Some(pixels))) => {
                self.workers.push(worker);
                let task = self.waiting.swap_remove(index);
                let (started, render_time) = (task.started.unwrap_or(began), task.took);
                let PictureProgress { passes, drew_map, .. } = *drawing;
                drop(task.reply.send(Ok(DrawnPicture { pixels, started, render_time, drew_map, passes })));
            }
            TurnReport::Ended(_, Err(RenderError::DeviceLost(why))) if !task.lost_device => {
                task.lost_device = true;
                drop(worker);
                self.reopen(&why);
            }
            TurnReport::Ended(_, Err(error)) => {
                // The next request tries to load the scene again.
                self.workers.push(worker);
                drop(self.waiting.swap_remove(index).reply.send(Err(error)));
            }
            // The asker sees that the reply is dropped.
            TurnReport::Lost => drop(self.waiting.swap_remove(index)),
        }
        if is_new {
            self.drop_scenes_over_budget();
        }
    }

    /// Drops scenes while memory is over budget, the least recently used first. Keeps the one that drew last.
    fn drop_scenes_over_budget(&mut self) {
        while self.memory.total() > self.memory.budget()
            && let Some(rests) = self.workers.iter().position(|worker| worker.paused.is_none())
            && rests + 1 < self.workers.len()
        {
            self.workers.remove(rests);
        }
        self.base.free_dropped_memory();
    }

    /// Opens the device again after it was lost. Its data is lost too, so pictures in progress start again.
    fn reopen(&mut self, why: &str) {
        tracing::error!("the graphics device was lost ({why}) and is opened again");
        self.workers.clear();
        for task in &mut self.waiting {
            task.drawing = None;
        }
        match open(&self.memory, self.backend, &self.turn_end) {
            Ok(base) => self.base = base,
            Err(error) => {
                for task in self.waiting.drain(..) {
                    drop(task.reply.send(Err(error.clone())));
                }
            }
        }
    }

    /// Takes the worker of the request's session and scene out of the list, or makes it.
    fn worker(&mut self, request: &PictureRequest) -> Result<DrawWorker, RenderError> {
        let PictureRequest { session, viewer, scene, .. } = request;
        let known = self.workers.iter().position(|worker| worker.is_for(session, scene));
        let mut worker = match known {
            Some(index) => self.workers.remove(index),
            None => self.open_scene(session, scene)?,
        };
        if !worker.viewers.iter().any(|(_, known)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(viewer))) {
            // A view shows one scene, so its data in other workers is freed.
            for other in self.workers.iter_mut().filter(|other| other.paused.is_none()) {
                other.viewers.retain(|(number, _)| *number != viewer.number);
                other.forget(viewer.slot());
            }
            worker.viewers.push((viewer.number, Arc::downgrade(viewer)));
        }
        Ok(worker)
    }

    /// Makes a worker for a session and a scene. Before that, drops workers without viewers while more than half of the
    /// memory budget is taken.
    fn open_scene(&mut self, session: &Arc<RenderLease>, scene: &Arc<PosedScene>) -> Result<DrawWorker, RenderError> {
        let half = self.memory.budget() / 2;
        while self.memory.total() > half
            && let Some(idle) = self.workers.iter().position(|worker| worker.viewers.is_empty())
        {
            self.workers.remove(idle);
        }
        self.base.free_dropped_memory();
        let known = self.workers.iter().find(|worker| Arc::ptr_eq(&worker.scene, scene));
        let shared = known.map_or_else(SharedScene::default, |worker| Arc::clone(&worker.shared));
        Ok(DrawWorker::start(session, scene, shared, self.base.with_same_pipelines()?))
    }
}

/// True if the queue has room for another picture. Removes cancelled pictures to make room. Otherwise, after a change
/// to many views, each client's next picture would wait behind cancelled pictures of all views.
fn has_room<T>(waiting: &mut Vec<T>, is_cancelled: impl Fn(&T) -> bool) -> bool {
    if waiting.len() >= MAX_PICTURES {
        waiting.retain(|task| !is_cancelled(task));
    }
    waiting.len() < MAX_PICTURES
}

fn open(memory: &MemoryBudget, backend: Option<Backend>, turn_end: &TurnDeadline) -> Result<Renderer, RenderError> {
    let host = Host::new(memory.clone()).with_yield_policy(turn_end.yield_policy());
    let device = Device::open(host, backend)?;
    tracing::info!("rendering with {}, backend {}", device.name(), device.backend().name());
    if let Some(advice) = device.advice() {
        tracing::warn!("{advice}");
    }
    Renderer::new(&device)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deliberate fault that the test must detect: a picture leaves the queue only when it is drawn.
    #[test]
    fn cancelled_pictures_make_room() {
        let mut waiting: Vec<usize> = (0..MAX_PICTURES).collect();
        assert!(!has_room(&mut waiting, |_| false) && waiting.len() == MAX_PICTURES);
        assert!(has_room(&mut waiting, |number| number % 2 == 0));
        assert!(waiting.len() == MAX_PICTURES / 2 && waiting.iter().all(|number| number % 2 == 1));
    }
}
