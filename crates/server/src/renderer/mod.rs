//! The one thread that owns the graphics device, and how others have it draw.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use light::LightInstance;
use render::{Backend, FileNeeds, PassRun, Pixels, RenderError, View, ViewSlot};
use scene::PosedScene;
use tokio::sync::{mpsc, oneshot, watch};

use crate::ServerError;
use crate::charges::Payer;
use crate::limits::RENDER_QUEUE;
use crate::metrics::Metrics;

mod schedule;
mod thread;
mod worker;

pub use schedule::Urgency;
use thread::RenderLoop;

/// Whether the pipelines are ready.
#[derive(Clone, Debug)]
pub enum Readiness {
    /// They are drawn for the first time, which compiles them.
    WarmingUp,
    /// Each has drawn once.
    Ready,
    /// One could not: why.
    Failed(RenderError),
}

/// In which form a picture comes back.
#[derive(Clone, Copy, Debug)]
pub enum PictureFormat {
    /// As a screen shows it.
    Display,
    /// What its files need.
    File(FileNeeds),
}

/// Somebody the renderer keeps things for: a session, a view, a still. When the last clone is dropped, those go.
#[derive(Debug)]
pub struct RenderLease {
    number: u64,
    jobs: mpsc::Sender<Job>,
}

impl RenderLease {
    /// Names the viewer for the renderer.
    pub fn slot(&self) -> ViewSlot {
        ViewSlot(self.number)
    }
}

impl Drop for RenderLease {
    fn drop(&mut self) {
        // Wakes it. Where the queue is full it is awake.
        let _ = self.jobs.try_send(Job::Wake);
    }
}

/// A picture to draw.
#[derive(Debug)]
pub struct PictureRequest {
    /// Whose scene it is.
    pub session: Arc<RenderLease>,
    /// Who sees it; the slot of `view` is this one's.
    pub viewer: Arc<RenderLease>,
    /// Who is charged for it.
    pub payer: Payer,
    /// Geometry and materials.
    pub scene: Arc<PosedScene>,
    /// From where, how large, of what.
    pub view: View,
    /// All lights that shine in it.
    pub lights: Vec<LightInstance>,
    /// In which form.
    pub output: PictureFormat,
    /// How soon it is wanted.
    pub urgency: Urgency,
    /// Where it waits: of those of a client that are as urgent the one that has waited longest is first.
    pub ticket: PictureTicket,
}

/// A picture's place in line. Whoever asked can give it up until the picture is begun, and come back with what there is to
/// be seen by then: so what is begun is never stale.
#[derive(Clone, Debug)]
pub struct PictureTicket {
    queued_at: Instant,
    is_claimed: Arc<AtomicBool>,
}

impl PictureTicket {
    /// That of who has waited since then.
    pub fn since(queued_at: Instant) -> Self {
        Self { queued_at, is_claimed: Arc::default() }
    }

    /// Gives it up. Since when it was held; `None` where the picture has been begun, and will be drawn.
    pub fn cancel(&self) -> Option<Instant> {
        self.claim().then_some(self.queued_at)
    }

    /// Begins the picture, or gives it up: whatever comes first. False where the other did.
    fn claim(&self) -> bool {
        !self.is_claimed.swap(true, Ordering::Relaxed)
    }
}

/// A picture.
#[derive(Debug)]
pub struct DrawnPicture {
    /// In the form asked for.
    pub pixels: Pixels,
    /// When drawing began.
    pub started: Instant,
    /// How long it took, without what was drawn in between.
    pub render_time: Duration,
    /// Whether a shadow map was drawn for it.
    pub drew_map: bool,
    /// Which passes it came to, in all of its turns.
    pub passes: Vec<PassRun>,
}

/// Hands pictures to the render thread.
#[derive(Clone, Debug)]
pub struct RenderQueue {
    jobs: mpsc::Sender<Job>,
    readiness: watch::Receiver<Readiness>,
    leases: Arc<AtomicU64>,
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
        let _ = self.jobs.try_send(Job::Wake);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the render thread had panicked");
        }
    }
}

/// Where a picture goes. Whoever asked gives it up by dropping the other end.
type PictureReply = oneshot::Sender<Result<DrawnPicture, RenderError>>;

#[derive(Debug)]
enum Job {
    Draw(Box<PictureRequest>, PictureReply),
    /// Somebody has had so much time of the processor for pictures besides.
    Charge(Payer, Duration),
    /// Somebody is gone, or nothing will be drawn any more.
    Wake,
}

impl RenderQueue {
    /// Opens the device on a thread of its own, which then warms up. Blocks until the device is open.
    pub fn start(
        metrics: Arc<Metrics>,
        backend: Option<Backend>,
    ) -> Result<(Self, RenderThread), ServerError> {
        let (jobs, inbox) = mpsc::channel(RENDER_QUEUE);
        let (noted, readiness) = watch::channel(Readiness::WarmingUp);
        let (opened, is_open) = std::sync::mpsc::sync_channel(1);
        let ending = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&ending);
        let thread = std::thread::spawn(move || match RenderLoop::open((metrics, backend), inbox, ended) {
            Ok(render_loop) => {
                if opened.send(Ok(())).is_ok() {
                    noted.send_replace(render_loop.warm_up());
                    render_loop.run();
                }
            }
            // The other end waits for exactly this.
            Err(error) => drop(opened.send(Err(error))),
        });
        let thread = RenderThread { jobs: jobs.clone(), ending, thread: Some(thread) };
        is_open.recv().map_err(|_| ServerError::Internal)??;
        Ok((Self { jobs, readiness, leases: Arc::default() }, thread))
    }

    /// Whether the pipelines are ready.
    pub fn readiness(&self) -> Readiness {
        self.readiness.borrow().clone()
    }

    /// Ends once they are, or cannot be: whether they are.
    pub fn wait_until_warm(&self) -> impl Future<Output = bool> + Send + 'static {
        let mut readiness = self.readiness.clone();
        async move {
            let over = readiness.wait_for(|readiness| !matches!(readiness, Readiness::WarmingUp)).await;
            over.is_ok_and(|readiness| matches!(*readiness, Readiness::Ready))
        }
    }

    /// Draws a picture. Dropping the future gives it up.
    pub async fn draw(&self, request: PictureRequest) -> Result<DrawnPicture, ServerError> {
        let (done, drawn) = oneshot::channel();
        self.jobs.send(Job::Draw(Box::new(request), done)).await.map_err(|_| ServerError::Internal)?;
        Ok(drawn.await.map_err(|_| ServerError::Internal)??)
    }

    /// Charges who sees a picture for what it took of one core after it was drawn. Where the queue is full it is for nothing.
    pub fn charge(&self, payer: &Payer, took: Duration) {
        let _ = self.jobs.try_send(Job::Charge(payer.clone(), took));
    }

    /// For a new session, view or still.
    pub fn lease(&self) -> Arc<RenderLease> {
        let number = self.leases.fetch_add(1, Ordering::Relaxed);
        Arc::new(RenderLease { number, jobs: self.jobs.clone() })
    }
}
