//! The one thread that owns the graphics device, and the way to it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use render::{Gpu, PictureFormat, RenderError, Renderer, View};
use scene::{Light, Scene};
use tokio::sync::{mpsc, oneshot, watch};

use crate::ServerError;
use crate::limits::{MAX_STAGES, PATIENCE, RENDER_QUEUE};

/// How the pipelines stand.
#[derive(Clone, Debug)]
pub enum Warmth {
    /// They are drawn for the first time, which compiles them.
    Warming,
    /// Each has drawn once.
    Warm,
    /// One could not: why.
    Failed(RenderError),
}

/// What is more urgent is drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// A view in which something moves.
    Moving,
    /// A view at rest.
    Settling,
    /// Nobody sees it grow.
    Still,
}

/// In which form a picture comes back.
#[derive(Clone, Copy, Debug)]
pub enum Output {
    /// RGBA, 8 bits a channel, as a screen shows it.
    Display,
    /// The bytes of a file.
    File(PictureFormat),
}

/// A picture to draw.
#[derive(Debug)]
pub struct Request {
    /// Whose scene it is; what the renderer keeps of a scene it keeps by this number.
    pub stage: u64,
    /// Geometry and materials.
    pub scene: Arc<Scene>,
    /// From where, how large, of what.
    pub view: View,
    /// All lights that shine in it.
    pub lights: Vec<Light>,
    /// In which form.
    pub output: Output,
    /// When.
    pub urgency: Urgency,
}

/// A picture.
#[derive(Debug)]
pub struct Drawn {
    /// In the form asked for.
    pub bytes: Vec<u8>,
    /// When drawing began.
    pub started: Instant,
    /// How long it took, without what was drawn in between.
    pub took: Duration,
}

/// The way to the render thread.
#[derive(Clone, Debug)]
pub struct Renders {
    jobs: mpsc::Sender<Job>,
    warmth: watch::Receiver<Warmth>,
}

/// The render thread itself. Dropping this ends it and waits: a process must not end while its driver compiles, which
/// crashes with what it works on gone.
#[derive(Debug)]
pub struct RenderThread {
    jobs: mpsc::Sender<Job>,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Relaxed);
        // Wakes it. Where the queue is full it is awake.
        let _ = self.jobs.try_send(Job::End);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the render thread had panicked");
        }
    }
}

enum Job {
    Draw(Box<Task>),
    /// Nothing of this stage will be drawn any more.
    Forget(u64),
    /// Nothing will be drawn any more.
    End,
}

/// A request on its way. Whoever asked gives it up by dropping the other end of `done`.
struct Task {
    request: Request,
    done: oneshot::Sender<Result<Drawn, RenderError>>,
    started: Option<Instant>,
    took: Duration,
    /// When it was last worked on, or when it came.
    touched: Instant,
}

impl Renders {
    /// Opens the device on a thread of its own, which then warms up. Blocks until the device is open.
    pub fn start() -> Result<(Self, RenderThread), ServerError> {
        let (jobs, inbox) = mpsc::channel(RENDER_QUEUE);
        let (warm, warmth) = watch::channel(Warmth::Warming);
        let (opened, is_open) = std::sync::mpsc::sync_channel(1);
        let ending = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&ending);
        let thread = thread::spawn(move || match Gpu::new().and_then(open) {
            Ok(renderer) => {
                if opened.send(Ok(())).is_ok() {
                    warm.send_replace(warm_up(&renderer, &ended));
                    Studio { base: renderer, stages: Vec::new(), inbox, ended, waiting: Vec::new() }.run();
                }
            }
            // The other end waits for exactly this.
            Err(error) => drop(opened.send(Err(error))),
        });
        let thread = RenderThread { jobs: jobs.clone(), ending, thread: Some(thread) };
        is_open.recv().map_err(|_| ServerError::Fault)??;
        Ok((Self { jobs, warmth }, thread))
    }

    /// How the pipelines stand.
    pub fn warmth(&self) -> Warmth {
        self.warmth.borrow().clone()
    }

    /// Draws a picture. Dropping the future gives it up.
    pub async fn draw(&self, request: Request) -> Result<Drawn, ServerError> {
        let (done, drawn) = oneshot::channel();
        let now = Instant::now();
        let task = Task { request, done, started: None, took: Duration::ZERO, touched: now };
        self.jobs.send(Job::Draw(Box::new(task))).await.map_err(|_| ServerError::Fault)?;
        Ok(drawn.await.map_err(|_| ServerError::Fault)??)
    }

    /// Frees what is kept of a stage. Where the queue is full it is left to age.
    pub fn forget(&self, stage: u64) {
        let _ = self.jobs.try_send(Job::Forget(stage));
    }
}

fn open(gpu: Gpu) -> Result<Renderer, RenderError> {
    tracing::info!("rendering with {}", gpu.adapter_name());
    Renderer::new(Arc::new(gpu))
}

fn warm_up(renderer: &Renderer, ended: &AtomicBool) -> Warmth {
    let started = Instant::now();
    match renderer.warm(|| !ended.load(Ordering::Relaxed)) {
        Ok(()) if ended.load(Ordering::Relaxed) => Warmth::Warming,
        Ok(()) => {
            tracing::info!("every pipeline has drawn once, in {} ms", started.elapsed().as_millis());
            Warmth::Warm
        }
        Err(error) => {
            tracing::error!("the pipelines cannot be warmed up: {error}");
            Warmth::Failed(error)
        }
    }
}

/// All that the render thread holds.
struct Studio {
    /// Never draws; the others share its pipelines.
    base: Renderer,
    /// The one that drew last at the end.
    stages: Vec<Stage>,
    inbox: mpsc::Receiver<Job>,
    /// Nothing is to be drawn any more.
    ended: Arc<AtomicBool>,
    waiting: Vec<Task>,
}

/// A renderer with the scene it is set to.
struct Stage {
    key: u64,
    scene: Arc<Scene>,
    renderer: Renderer,
}

impl Studio {
    fn run(mut self) {
        while self.listen() {
            let now = Instant::now();
            let place = |task: &Task| place_in_line(task.request.urgency, now - task.touched);
            let first = (0..self.waiting.len()).min_by_key(|&index| place(&self.waiting[index]));
            let Some(mut task) = first.map(|index| self.waiting.remove(index)) else { continue };
            let started = *task.started.get_or_insert(now);
            let result = self.work_on(&task);
            task.touched = Instant::now();
            task.took += now.elapsed();
            match result {
                Ok(None) => self.waiting.push(task),
                result => {
                    let took = task.took;
                    let drawn = result.map(|bytes| Drawn { bytes: bytes.unwrap_or_default(), started, took });
                    let _ = task.done.send(drawn);
                }
            }
        }
    }

    /// Waits until there is something to do. False at the end.
    fn listen(&mut self) -> bool {
        self.take_in() && !self.ended.load(Ordering::Relaxed)
    }

    /// Takes in what has come, and waits where there is nothing to do. False where nothing can come any more.
    fn take_in(&mut self) -> bool {
        self.waiting.retain(|task| !task.done.is_closed());
        if self.waiting.is_empty() {
            let Some(job) = self.inbox.blocking_recv() else { return false };
            self.take(job);
        }
        while self.waiting.len() < RENDER_QUEUE
            && let Ok(job) = self.inbox.try_recv()
        {
            self.take(job);
        }
        true
    }

    fn take(&mut self, job: Job) {
        match job {
            Job::Draw(task) => self.waiting.push(*task),
            Job::Forget(key) => self.stages.retain(|stage| stage.key != key),
            // The flag says so too.
            Job::End => {}
        }
    }

    /// Draws until the picture is there, or `None` where it was given up or something more urgent came.
    fn work_on(&mut self, task: &Task) -> Result<Option<Vec<u8>>, RenderError> {
        let result = self.draw(task);
        if let Err(RenderError::DeviceLost(why)) = &result {
            tracing::error!("the graphics device was lost ({why}) and is opened again");
            self.stages.clear();
            self.base = Gpu::new().and_then(open)?;
            return self.draw(task);
        }
        result
    }

    fn draw(&mut self, task: &Task) -> Result<Option<Vec<u8>>, RenderError> {
        let Request { stage, scene, view, lights, output, urgency } = &task.request;
        let index = self.stage(*stage, scene)?;
        let Self { stages, inbox, ended, .. } = self;
        let renderer = &mut stages[index].renderer;
        // Something new may be anything: it is looked at before more is drawn, but for a moving view.
        let undisturbed = || *urgency == Urgency::Moving || (!task.done.is_closed() && inbox.is_empty());
        let keep_going = || undisturbed() && !ended.load(Ordering::Relaxed);
        if !renderer.advance(view, lights, keep_going)? {
            return Ok(None);
        }
        match output {
            Output::Display => renderer.render_display(view, lights).map(Some),
            Output::File(format) => {
                let file = renderer.render_file(view, lights, *format)?;
                // Nobody goes on from there.
                renderer.forget(view.slot);
                Ok(Some(file))
            }
        }
    }

    /// The renderer of a stage, set to its scene: its index.
    fn stage(&mut self, key: u64, scene: &Arc<Scene>) -> Result<usize, RenderError> {
        let known = self.stages.iter().position(|stage| stage.key == key);
        let mut stage = match known {
            Some(index) => self.stages.remove(index),
            None => Stage { key, scene: Arc::default(), renderer: self.base.another()? },
        };
        if !Arc::ptr_eq(&stage.scene, scene) {
            stage.renderer.set_scene(scene)?;
            stage.scene = Arc::clone(scene);
        }
        if self.stages.len() == MAX_STAGES {
            self.stages.remove(0);
        }
        self.stages.push(stage);
        Ok(self.stages.len() - 1)
    }
}

/// The order in which tasks are worked on: by urgency and age, but one that was left for long gets a turn.
fn place_in_line(urgency: Urgency, untouched: Duration) -> (bool, Urgency, std::cmp::Reverse<Duration>) {
    (untouched < PATIENCE, urgency, std::cmp::Reverse(untouched))
}
