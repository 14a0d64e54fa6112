//! The render thread, which owns the graphics device, and the queue of pictures to it.

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

/// State of the pipelines.
#[derive(Clone, Debug)]
pub enum Readiness {
    /// Each pipeline draws for the first time, which compiles it.
    WarmingUp,
    /// Each pipeline has drawn once.
    Ready,
    /// A pipeline failed.
    Failed(RenderError),
}

/// Form of a finished picture.
#[derive(Clone, Copy, Debug)]
pub enum PictureFormat {
    /// Pixels for a screen.
    Display,
    /// Pixels for picture files.
    File(FileNeeds),
}

/// A session, view or still for which the renderer keeps data. The renderer frees the data once the last clone is
/// dropped.
#[derive(Debug)]
pub struct RenderLease {
    number: u64,
    jobs: mpsc::Sender<Job>,
}

impl RenderLease {
    /// Returns the slot in which the renderer caches the data of this view or still.
    pub fn slot(&self) -> ViewSlot {
        ViewSlot(self.number)
    }
}

impl Drop for RenderLease {
    fn drop(&mut self) {
        // Wakes the render thread. If the queue is full, the thread is awake.
        let _ = self.jobs.try_send(Job::Wake);
    }
}

#[derive(Debug)]
pub struct PictureRequest {
    /// Lease of the session.
    pub session: Arc<RenderLease>,
    /// Lease of the viewer. `view` has its slot.
    pub viewer: Arc<RenderLease>,
    /// Client that is charged for it.
    pub payer: Payer,
    pub scene: Arc<PosedScene>,
    /// View to draw: camera, size and settings.
    pub view: View,
    pub lights: Vec<LightInstance>,
    pub output: PictureFormat,
    pub urgency: Urgency,
    /// Position in the queue. Of equally urgent pictures of a client, the renderer draws the oldest first.
    pub ticket: PictureTicket,
}

/// Position of a picture in the queue. Until drawing begins, the owner of the ticket can cancel the picture and request
/// a newer one that takes over its position. So drawing never begins with an outdated picture.
#[derive(Clone, Debug)]
pub struct PictureTicket {
    queued_at: Instant,
    is_claimed: Arc<AtomicBool>,
}

impl PictureTicket {
    /// Makes a ticket with the position of a picture that was queued at `queued_at`.
    pub fn since(queued_at: Instant) -> Self {
        Self { queued_at, is_claimed: Arc::default() }
    }

    /// Cancels the picture and returns the time at which it was queued. Returns `None` if drawing has begun, and the
    /// picture will be drawn.
    pub fn cancel(&self) -> Option<Instant> {
        self.claim().then_some(self.queued_at)
    }

    /// Claims the ticket, either to begin drawing or to cancel. Returns false if it was claimed before.
    fn claim(&self) -> bool {
        !self.is_claimed.swap(true, Ordering::Relaxed)
    }
}

/// A finished picture.
#[derive(Debug)]
pub struct DrawnPicture {
    /// In the requested form.
    pub pixels: Pixels,
    /// Start of drawing.
    pub started: Instant,
    /// Time spent on drawing the picture, without the time of other pictures in between.
    pub render_time: Duration,
    /// True if a shadow map was drawn for it.
    pub drew_map: bool,
    /// Passes that ran for the picture.
    pub passes: Vec<PassRun>,
}

/// Handle that sends pictures to the render thread.
#[derive(Clone, Debug)]
pub struct RenderQueue {
    jobs: mpsc::Sender<Job>,
    readiness: watch::Receiver<Readiness>,
    leases: Arc<AtomicU64>,
}

/// The render thread. Dropping this ends the thread and waits for it. A driver that is still compiling crashes if the
/// process ends first.
#[derive(Debug)]
pub struct RenderThread {
    jobs: mpsc::Sender<Job>,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for RenderThread {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Relaxed);
        // Wakes the render thread. If the queue is full, the thread is awake.
        let _ = self.jobs.try_send(Job::Wake);
        join_thread(&mut self.thread, "the render thread");
    }
}

/// Waits for the end of a thread, and logs that it has panicked.
fn join_thread(thread: &mut Option<JoinHandle<()>>, name: &str) {
    if thread.take().is_some_and(|thread| thread.join().is_err()) {
        tracing::error!("{name} had panicked");
    }
}

/// Sender of the finished picture. The asker cancels by dropping the receiver.
type PictureReply = oneshot::Sender<Result<DrawnPicture, RenderError>>;

#[derive(Debug)]
enum Job {
    Draw(Box<PictureRequest>, PictureReply),
    /// Charges a client for processor time that its pictures took outside of drawing.
    Charge(Payer, Duration),
    /// Wakes the render thread, because a lease was dropped or the thread has to end.
    Wake,
}

impl RenderQueue {
    /// Starts the render thread, which opens the device and then warms up. Blocks until the device is open.
    pub fn start(metrics: Arc<Metrics>, backend: Option<Backend>) -> Result<(Self, RenderThread), ServerError> {
        let (jobs, inbox) = mpsc::channel(RENDER_QUEUE);
        let (noted, readiness) = watch::channel(Readiness::WarmingUp);
        let (opened, is_open) = std::sync::mpsc::sync_channel(1);
        let ending = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&ending);
        let thread = std::thread::spawn(move || match RenderLoop::open(metrics, backend, inbox, ended) {
            Ok(render_loop) => {
                if opened.send(Ok(())).is_ok() {
                    noted.send_replace(render_loop.warm_up());
                    render_loop.run();
                }
            }
            // The receiver below waits for this message.
            Err(error) => drop(opened.send(Err(error))),
        });
        let thread = RenderThread { jobs: jobs.clone(), ending, thread: Some(thread) };
        is_open.recv().map_err(|_| ServerError::Internal)??;
        Ok((Self { jobs, readiness, leases: Arc::default() }, thread))
    }

    pub fn readiness(&self) -> Readiness {
        self.readiness.borrow().clone()
    }

    /// Waits until the pipelines are ready or have failed. Resolves to true if they are ready.
    pub fn wait_until_warm(&self) -> impl Future<Output = bool> + Send + 'static {
        let mut readiness = self.readiness.clone();
        async move {
            let over = readiness.wait_for(|readiness| !matches!(readiness, Readiness::WarmingUp)).await;
            over.is_ok_and(|readiness| matches!(*readiness, Readiness::Ready))
        }
    }

    /// Draws a picture and returns its pixels. Dropping the future cancels the picture.
    pub async fn draw(&self, request: PictureRequest) -> Result<DrawnPicture, ServerError> {
        let (done, drawn) = oneshot::channel();
        self.jobs.send(Job::Draw(Box::new(request), done)).await.map_err(|_| ServerError::Internal)?;
        Ok(drawn.await.map_err(|_| ServerError::Internal)??)
    }

    /// Charges a client for time that one core spent on a drawn picture. Charges nothing if the queue is full.
    pub fn charge(&self, payer: &Payer, took: Duration) {
        let _ = self.jobs.try_send(Job::Charge(payer.clone(), took));
    }

    /// Makes a lease for a session, view or still.
    pub fn lease(&self) -> Arc<RenderLease> {
        let number = self.leases.fetch_add(1, Ordering::Relaxed);
        Arc::new(RenderLease { number, jobs: self.jobs.clone() })
    }
}
